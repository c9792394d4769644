//! The inputs of an evaluation.

use crate::calibration::Calibration;
use crate::dataset::imu::{Gravity, Readings};
use crate::dataset::trajectory::Trajectory;
use crate::site_file::SiteFloor;
use crate::up::Mount;
use compass_core::HeightPrior;
use std::path::{Path, PathBuf};

/// Accelerometer readings within this time of a frame are averaged for gravity, nanoseconds: half a second in all, about
/// a step of a walking person, so that the accelerations of the step cancel.
const GRAVITY_REACH_NS: u64 = 250_000_000;

/// The inputs of an evaluation.
#[derive(Debug)]
pub struct Job<'a> {
    /// The floors.
    pub floors: &'a [SiteFloor<'a>],
    /// The cameras.
    pub calibration: &'a Calibration,
    /// Which side of cam0's image is up; the accelerometer takes precedence.
    pub mount: Mount,
    /// The accelerometer, if there is one.
    pub imu: Option<&'a Readings>,
    /// What is known of the heights of camera and ceiling.
    pub heights: HeightPrior,
    /// Ground truth: the trajectory of cam0.
    pub truth: &'a Trajectory,
    /// Index of the floor of the ground truth.
    pub floor: usize,
    /// The folder for evidence files.
    pub evidence: &'a Path,
}

impl Job<'_> {
    /// The up vector from the accelerometer at the time of a frame, in the axes of cam0; `None` without an
    /// accelerometer, without IMU extrinsics in the calibration, or under too much acceleration.
    #[must_use]
    pub fn gravity(&self, timestamp_ns: u64) -> Option<Gravity> {
        let shift_s = self.calibration.cameras[0].as_ref()?.timeshift_s;
        let time_ns = timestamp_ns.checked_add_signed((shift_s * 1e9).round() as i64)?;
        self.imu?.gravity_near(time_ns, GRAVITY_REACH_NS).ok()?.in_cam0(self.calibration)
    }

    /// The evidence file of a frame.
    #[must_use]
    pub fn evidence_file(&self, timestamp_ns: u64) -> PathBuf {
        self.evidence.join(format!("{timestamp_ns}.png"))
    }
}
