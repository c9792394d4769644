//! The cameras of a robot.

use crate::error::{wrong, wrong_in};
use compass_host::Mount;
use compass_host::calibration::{Calibration, CameraNames};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// One or two calibrated cameras, and which side of cam0's image is up.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Rig {
    pub(crate) calibration: Arc<Calibration>,
    pub(crate) mount: Mount,
}

fn mount(name: &str) -> PyResult<Mount> {
    name.parse().map_err(|error| wrong_in("mount", error))
}

#[pymethods]
impl Rig {
    /// Reads a calibration: a camera chain of Kalibr, or what Basalt and ROS write.
    ///
    /// `mount` is 'upright' or 'inverted' (the top or the bottom of cam0's image is up), or 'auto': both are tried and the plan
    /// decides. `cameras` names the cameras of the file that are cam0 and cam1, as in 'cam0,cam1'.
    #[staticmethod]
    #[pyo3(signature = (path, mount="auto", *, cameras=None))]
    fn from_kalibr(path: PathBuf, mount: &str, cameras: Option<String>) -> PyResult<Self> {
        let names = cameras.map(|names| names.parse::<CameraNames>()).transpose().map_err(wrong)?;
        let calibration = Calibration::load_cameras(&path, &names.unwrap_or_default()).map_err(wrong)?;
        Ok(Self { calibration: Arc::new(calibration), mount: self::mount(mount)? })
    }

    /// The invented rig of the simulator: two fisheye lenses back to back.
    #[staticmethod]
    #[pyo3(signature = (mount="auto"))]
    fn nominal(mount: &str) -> PyResult<Self> {
        Ok(Self { calibration: Arc::new(Calibration::nominal()), mount: self::mount(mount)? })
    }

    /// Which side of cam0's image is up: 'auto', 'upright' or 'inverted'.
    #[getter]
    fn mount(&self) -> &'static str {
        self.mount.name()
    }

    fn __repr__(&self) -> String {
        let cameras: Vec<_> = (0..2).filter(|number| self.calibration.cameras[*number].is_some()).collect();
        format!("Rig({} camera(s), mount={:?})", cameras.len(), self.mount())
    }
}
