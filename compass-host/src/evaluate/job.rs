//! What to localize, and with what.

use crate::calibration::Calibration;
use crate::dataset::imu::{Gravity, Readings};
use crate::dataset::trajectory::Trajectory;
use crate::site_file::SiteFloor;
use crate::up::Mount;
use std::path::{Path, PathBuf};

/// Readings of the accelerometer this far from a frame tell gravity, nanoseconds: half a second in all, about a step of
/// somebody who walks, so that the ups and downs of the step cancel.
const GRAVITY_REACH_NS: u64 = 250_000_000;

/// What to localize, and with what.
#[derive(Debug)]
pub struct Job<'a> {
    /// The floors.
    pub floors: &'a [SiteFloor<'a>],
    /// The cameras.
    pub calibration: &'a Calibration,
    /// Which side of cam0's image is up; the accelerometer overrules it.
    pub mount: Mount,
    /// The accelerometer, where there is one.
    pub imu: Option<&'a Readings>,
    /// Height of cam0 above the floor in metres, where it is known.
    pub height_m: Option<f32>,
    /// Where cam0 was.
    pub truth: &'a Trajectory,
    /// The number of the floor that the truth lies on.
    pub floor: usize,
    /// Where evidence is kept.
    pub evidence: &'a Path,
}

impl Job<'_> {
    /// What the accelerometer says of gravity at the time of a frame, in the axes of cam0; `None` without one, where the
    /// calibration does not tell how it lies, and where it moves too much.
    #[must_use]
    pub fn gravity(&self, timestamp_ns: u64) -> Option<Gravity> {
        let shift_s = self.calibration.cameras[0].as_ref()?.timeshift_s;
        let time_ns = timestamp_ns.checked_add_signed((shift_s * 1e9).round() as i64)?;
        self.imu?.gravity_near(time_ns, GRAVITY_REACH_NS).ok()?.in_cam0(self.calibration)
    }

    /// The file that keeps the evidence of a frame.
    #[must_use]
    pub fn evidence_file(&self, timestamp_ns: u64) -> PathBuf {
        self.evidence.join(format!("{timestamp_ns}.png"))
    }
}
