//! What a pair of frames shows, as a dict of arrays.

use crate::arrays::matrix;
use compass_host::VisualDescriptor;
use compass_host::compare::float_levels;
use compass_host::compass_core::descriptor::Descriptor;
use compass_host::compass_core::vision::camera::Bearing;
use compass_host::compass_core::vision::windows::WindowEvidence;
use numpy::IntoPyArray as _;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Hit type of a direction that neither camera sees.
const UNKNOWN: u8 = 255;

/// The observation of a pair of frames.
pub(crate) struct Observation {
    pub(crate) up: Bearing,
    pub(crate) evidence: WindowEvidence,
    pub(crate) descriptor: VisualDescriptor,
}

impl Observation {
    pub(crate) fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let VisualDescriptor { height, ranges, hit, scan, confidence } = &self.descriptor;
        let range: Vec<f64> =
            ranges.iter().map(|range| range.map_or(f64::NAN, |range| f64::from(range.metres))).collect();
        let hit: Vec<u8> = hit.iter().map(|hit| hit.map_or(UNKNOWN, |hit| hit as u8)).collect();
        let confidence: Vec<f64> =
            confidence.sixteenths().iter().map(|share| f64::from(*share) / 16.0).collect();
        let evidence: Vec<f64> = self.evidence.evidence.iter().map(|nats| f64::from(*nats)).collect();
        let dict = PyDict::new(py);
        dict.set_item("channels", matrix(py, &float_levels(&Descriptor::from(scan)))?)?;
        dict.set_item("range_m", range.into_pyarray(py))?;
        dict.set_item("hit", hit.into_pyarray(py))?;
        dict.set_item("confidence", confidence.into_pyarray(py))?;
        dict.set_item("evidence", evidence.into_pyarray(py))?;
        dict.set_item(
            "up_in_cam0",
            [self.up.x, self.up.y, self.up.z].map(f64::from).to_vec().into_pyarray(py),
        )?;
        dict.set_item("camera_height_m", f64::from(height.camera_m))?;
        dict.set_item("ceiling_height_m", f64::from(height.ceiling_m))?;
        Ok(dict)
    }
}
