//! A belief over a sequence of frames.

use crate::fix::Pose;
use compass_host::compass_core;
use compass_host::compass_core::pose::FloorLayer;
use pyo3::prelude::*;
use std::sync::Mutex;

/// A belief over a sequence of frames: give it to `Locator.locate` with each.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Track(pub(crate) Mutex<Box<compass_core::Track>>);

#[pymethods]
impl Track {
    #[new]
    fn new() -> Self {
        Self(Mutex::new(Box::new(compass_core::Track::new())))
    }

    /// Forgets all frames, as after the robot was carried away.
    fn forget(&self) {
        **self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = compass_core::Track::new();
    }
}

/// What a track believes.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    pose: Pose,
    /// Probability of the pose among those believed possible, 0 to 1.
    #[pyo3(get)]
    probability: f64,
    /// Root mean square distance of the possible poses on its floor from it, metres.
    #[pyo3(get)]
    spread_m: f64,
}

impl Estimate {
    pub(crate) fn new(estimate: &compass_core::Estimate, layers: &[FloorLayer<'_>]) -> Self {
        Self {
            pose: Pose::new(&estimate.pose, None, layers),
            probability: f64::from(estimate.probability),
            spread_m: f64::from(estimate.spread_m),
        }
    }
}

#[pymethods]
impl Estimate {
    /// The likeliest pose.
    #[getter]
    fn pose(&self) -> Pose {
        self.pose.clone()
    }

    fn __repr__(&self) -> String {
        let ([x, y], heading) = self.pose.place();
        format!(
            "Estimate(x={x:.3}, y={y:.3}, heading_deg={heading:.2}, probability={:.2}, spread_m={:.2})",
            self.probability, self.spread_m
        )
    }
}
