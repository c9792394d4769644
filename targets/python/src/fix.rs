//! Answers: a pose with its covariance, and what else may be.

use crate::arrays::matrix;
use crate::picture;
use crate::track::Estimate;
use compass_host::compass_core::pose::FloorLayer;
use compass_host::compass_core::vision::camera::Bearing;
use compass_host::compass_core::{self, ScoredPose};
use compass_host::output::pose_bits;
use compass_host::{Covariance, SiteFile, doubt};
use numpy::PyArray2;
use pyo3::IntoPyObjectExt as _;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::fmt::Write as _;
use std::sync::Arc;

/// A pose of cam0 on a floor, with its score and covariance.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug, Clone)]
pub(crate) struct Pose {
    /// Metres.
    #[pyo3(get)]
    x: f64,
    /// Metres.
    #[pyo3(get)]
    y: f64,
    /// Degrees counter-clockwise from +x, 0 to 360.
    #[pyo3(get)]
    heading_deg: f64,
    /// Log-likelihood ratio against no information, nats.
    #[pyo3(get)]
    score: f64,
    /// Name of the floor.
    #[pyo3(get)]
    floor: String,
    /// Bits of x, y and heading and of the score in hexadecimal, as the command prints them.
    #[pyo3(get)]
    bits: String,
    covariance: Option<Covariance>,
}

impl Pose {
    pub(crate) fn new(
        scored: &ScoredPose,
        covariance: Option<Covariance>,
        layers: &[FloorLayer<'_>],
    ) -> Self {
        let layer = layers.get(usize::from(scored.layer));
        Self {
            x: scored.at.x.to_num(),
            y: scored.at.y.to_num(),
            heading_deg: f64::from(scored.heading.to_microdegrees()) / 1e6,
            score: scored.score.to_num(),
            floor: layer.map_or_else(String::new, |layer| layer.name.to_owned()),
            bits: pose_bits(scored),
            covariance,
        }
    }

    pub(crate) fn is_on(&self, floor: &str) -> bool {
        self.floor == floor
    }

    pub(crate) fn place(&self) -> ([f64; 2], f64) {
        ([self.x, self.y], self.heading_deg)
    }
}

#[pymethods]
impl Pose {
    /// Covariance of x, y and heading, if the pose is right: float64 of shape (3, 3), m², m rad and rad²; None of an estimate.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let rows = self.covariance.map(|covariance| covariance.rows().map(|row| row.map(f64::from)));
        rows.map(|rows| matrix(py, &rows)).transpose()
    }

    /// The fields as a dict.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("x", self.x)?;
        dict.set_item("y", self.y)?;
        dict.set_item("heading_deg", self.heading_deg)?;
        dict.set_item("score", self.score)?;
        dict.set_item("floor", &self.floor)?;
        if let Some(covariance) = self.covariance {
            dict.set_item("covariance", covariance.rows().map(|row| row.map(f64::from)))?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let Self { x, y, heading_deg, score, floor, .. } = self;
        format!("Pose(x={x:.3}, y={y:.3}, heading_deg={heading_deg:.2}, score={score:.2}, floor={floor:?})")
    }
}

/// Where the cameras are, or why that is not sure.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Fix {
    site: Arc<SiteFile>,
    /// The likeliest poses, best first, at most 10; there also where the answer is not sure.
    poses: Vec<Pose>,
    floor: Option<u8>,
    sure: bool,
    /// Why the answer is not sure; None of a sure one.
    #[pyo3(get)]
    reason: Option<String>,
    /// Probability that the likeliest pose is within 1 m of the true one.
    #[pyo3(get)]
    probability: f64,
    /// Lead of the score over that of the best pose elsewhere, nats.
    #[pyo3(get)]
    margin: f64,
    /// Height of cam0 above the floor, metres: given, or estimated.
    #[pyo3(get)]
    camera_height: f64,
    /// Height of the ceiling above the floor, metres.
    #[pyo3(get)]
    ceiling_height: f64,
    /// Up in the axes of cam0 (x right, y down, z forward), of length 1; None if it could not be told.
    #[pyo3(get)]
    up_in_cam0: Option<[f64; 3]>,
    /// What the track believes after these frames; None without a track.
    estimate: Option<Estimate>,
}

impl Fix {
    pub(crate) fn new(
        site: Arc<SiteFile>,
        fix: &compass_core::Fix<'_>,
        up: Bearing,
        layers: &[FloorLayer<'_>],
        least: f64,
        estimate: Option<Estimate>,
    ) -> Self {
        let probability = f64::from(fix.probability());
        let sure = fix.best().is_some() && probability >= least;
        let poses = fix.poses().iter().zip(fix.covariances());
        Self {
            site,
            poses: poses.map(|(pose, covariance)| Pose::new(pose, Some(*covariance), layers)).collect(),
            floor: fix.pose().map(|pose| pose.floor),
            sure,
            reason: (!sure).then(|| doubt::of_fix(fix, least)),
            probability,
            margin: fix.margin().to_num(),
            camera_height: f64::from(fix.camera_height_m()),
            ceiling_height: f64::from(fix.ceiling_height_m()),
            up_in_cam0: Some([up.x, up.y, up.z].map(f64::from)),
            estimate,
        }
    }

    /// Of frames that do not tell which way is up.
    pub(crate) fn nothing(site: Arc<SiteFile>, reason: String) -> Self {
        Self {
            site,
            poses: Vec::new(),
            floor: None,
            sure: false,
            reason: Some(reason),
            probability: 0.0,
            margin: 0.0,
            camera_height: f64::NAN,
            ceiling_height: f64::NAN,
            up_in_cam0: None,
            estimate: None,
        }
    }

    pub(crate) fn add_reason(&mut self, fault: Option<String>) {
        self.reason = self.reason.take().map(|reason| doubt::with_fault(reason, fault));
    }

    fn best(&self) -> Option<&Pose> {
        self.poses.first().filter(|_| self.sure)
    }
}

#[pymethods]
impl Fix {
    /// The pose; None if it is not sure.
    #[getter]
    fn pose(&self) -> Option<Pose> {
        self.best().cloned()
    }

    /// Metres; None if the pose is not sure.
    #[getter]
    fn x(&self) -> Option<f64> {
        self.best().map(|pose| pose.x)
    }

    /// Metres; None if the pose is not sure.
    #[getter]
    fn y(&self) -> Option<f64> {
        self.best().map(|pose| pose.y)
    }

    /// Degrees counter-clockwise from +x, 0 to 360; None if the pose is not sure.
    #[getter]
    fn heading_deg(&self) -> Option<f64> {
        self.best().map(|pose| pose.heading_deg)
    }

    /// Name of the floor; None if the pose is not sure.
    #[getter]
    fn floor(&self) -> Option<&str> {
        self.best().map(|pose| pose.floor.as_str())
    }

    /// Covariance of x, y and heading, if the pose is right: float64 of shape (3, 3), m², m rad and rad²; None if it is not sure.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.best().map_or(Ok(None), |pose| pose.covariance(py))
    }

    /// The likeliest poses, best first, at least 1 m or 20 degrees apart; there also where the answer is not sure.
    #[getter]
    fn candidates(&self) -> Vec<Pose> {
        self.poses.clone()
    }

    /// What the track believes after these frames; None without a track.
    #[getter]
    fn estimate(&self) -> Option<Estimate> {
        self.estimate.clone()
    }

    /// Whether the probability reaches the one asked for.
    #[getter]
    pub(crate) fn is_sure(&self) -> bool {
        self.sure
    }

    /// The fields as a dict, with the keys of the command's JSON.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = match self.best() {
            Some(pose) => pose.to_dict(py)?,
            None => PyDict::new(py),
        };
        dict.set_item("probability", self.probability)?;
        dict.set_item("reason", self.reason.as_deref())?;
        if let Some(pose) = self.best() {
            dict.set_item("margin", self.margin)?;
            dict.set_item("camera_height_m", self.camera_height)?;
            dict.set_item("up_in_cam0", self.up_in_cam0)?;
            dict.set_item("bits", &pose.bits)?;
        }
        let candidates: Vec<_> = self.poses.iter().map(|pose| pose.to_dict(py)).collect::<PyResult<_>>()?;
        dict.set_item("candidates", PyList::new(py, candidates)?.into_bound_py_any(py)?)?;
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        match (self.best(), &self.reason) {
            (Some(pose), _) => format!(
                "Fix(x={:.3}, y={:.3}, heading_deg={:.2}, probability={:.2}, floor={:?})",
                pose.x, pose.y, pose.heading_deg, self.probability, pose.floor
            ),
            (None, reason) => {
                format!(
                    "Fix(not sure, probability={:.2}: {})",
                    self.probability,
                    reason.as_deref().unwrap_or_default()
                )
            }
        }
    }

    /// A table of the poses and, where there are any, a picture of them on the plan.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let mut html = format!("<p>{}</p>", picture::escaped(&self.__repr__()));
        if let Some(floor) = self.floor.filter(|_| !self.poses.is_empty()) {
            let png = py.detach(|| picture::of_poses(&self.site, floor, &self.poses))?;
            let _ = write!(
                html,
                "<img alt=\"poses on the plan\" style=\"max-width: 100%\" src=\"data:image/png;base64,{png}\">"
            );
        }
        Ok(html)
    }
}
