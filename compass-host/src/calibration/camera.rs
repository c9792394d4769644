//! One camera of a calibration.

use super::error::Refusal;
use super::lens::core_camera;
use super::transform::inverse;
use crate::reference::camera::Camera;
use compass_core::vision::camera::CameraError;
use nalgebra::Matrix4;

/// One camera of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedCamera {
    /// Lens and intrinsics for images of the calibrated size.
    pub camera: Camera,
    /// Width and height of the calibrated image, pixels.
    pub resolution: (u32, u32),
    /// `T_cam_imu`: transforms points from the IMU's axes to the camera's, metres.
    pub from_imu: Option<Matrix4<f64>>,
    /// `T_cn_cnm1`: transforms points from the previous camera's axes to this one's, metres.
    pub from_previous: Option<Matrix4<f64>>,
    /// `timeshift_cam_imu`: seconds to add to the image's time to get the IMU's; 0 when absent.
    pub timeshift_s: f64,
    /// `rostopic`: topic of its images in a ROS bag.
    pub topic: Option<String>,
}

impl CalibratedCamera {
    /// The core's camera for an image of this size.
    ///
    /// # Errors
    /// Parameters that the core rejects.
    pub fn core(
        &self,
        (width, height): (u32, u32),
    ) -> Result<compass_core::vision::camera::Camera, CameraError> {
        let (calibrated_width, calibrated_height) = self.resolution;
        let (sx, sy) = (ratio(width, calibrated_width), ratio(height, calibrated_height));
        core_camera(&self.camera.scaled(sx, sy))
    }

    /// Whether an image of this size can be the calibrated one resized, sides rounded to pixels.
    #[must_use]
    pub fn has_shape_of(&self, (width, height): (u32, u32)) -> bool {
        let range = |side: u32, calibrated: u32| {
            let (side, calibrated) = (f64::from(side), f64::from(calibrated));
            ((side - 0.5) / calibrated, (side + 0.5) / calibrated)
        };
        let (x, y) = (range(width, self.resolution.0), range(height, self.resolution.1));
        x.0 <= y.1 && y.0 <= x.1
    }
}

fn ratio(a: u32, b: u32) -> f64 {
    f64::from(a) / f64::from(b)
}

/// A camera of a file, before it is asked for.
pub(super) struct Entry {
    /// Its name, such as `cam0`.
    pub(super) name: String,
    /// What is read of it, or the field at fault.
    pub(super) camera: Result<CalibratedCamera, Refusal>,
    /// Its place in the rig, whatever its lens.
    pub(super) place: Result<Place, Refusal>,
}

/// The place of a camera in the rig.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Place {
    /// From the IMU's axes to the camera's.
    pub(super) from_imu: Option<Matrix4<f64>>,
    /// From the axes of the camera before it in the file.
    pub(super) from_previous: Option<Matrix4<f64>>,
}

/// Largest difference of two sources of one transform, in metres and as elements of a rotation.
pub(super) const AGREEING: f64 = 2e-3;

/// The transform from the axes of a camera to those of the one before it, which is not in the file.
pub(super) fn alone(entry: &Entry) -> Result<Matrix4<f64>, Refusal> {
    entry.place.clone()?.from_previous.map(|t| inverse(&t)).ok_or_else(|| {
        let problem = format!("missing, and without cam0 it remains open where {} is", entry.name);
        Refusal::new(format!("{}.T_cn_cnm1", entry.name), problem)
    })
}

/// The transform from the axes of camera `second` of a file to those of `first`: by the IMU, or along the chain.
pub(super) fn relative(entries: &[Entry], first: usize, second: usize) -> Result<Matrix4<f64>, Refusal> {
    let field = || format!("{}.T_cn_cnm1", entries[second].name);
    let place = |at: usize| entries[at].place.clone();
    let (here, there) = (place(first)?, place(second)?);
    let by_imu = here.from_imu.zip(there.from_imu).map(|(here, there)| here * inverse(&there));
    let (from, to) = (first.min(second), first.max(second));
    let mut along = Some(Matrix4::identity());
    for at in from + 1..=to {
        along = along.zip(place(at)?.from_previous).map(|(before, step)| step * before);
    }
    let along = along.map(|t| if first < second { inverse(&t) } else { t });
    match (by_imu, along) {
        (Some(a), Some(b)) if (a - b).amax() > AGREEING => {
            let [here, there] = [first, second].map(|at| &entries[at].name);
            let problem = format!(
                "disagrees with T_cam_imu of {here} and {there} (by up to {:.4} in an element)",
                (a - b).amax()
            );
            Err(Refusal::new(field(), problem))
        }
        (Some(place), _) | (None, Some(place)) => Ok(place),
        (None, None) => {
            let problem = format!(
                "missing, and T_cam_imu is not given for both cameras: where {} is remains open",
                entries[second].name
            );
            Err(Refusal::new(field(), problem))
        }
    }
}
