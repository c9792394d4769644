//! The equidistant fisheye of the paper: the radius is the focal length times the angle from the axis.

use super::{Bearing, CameraError, Intrinsics, Pixel, Polar, WIDEST_ANGLE};

/// Equidistant fisheye: radius = f theta.
///
/// ```
/// use compass_core::vision::camera::Equidistant;
/// use compass_core::{Bearing, Camera, Intrinsics};
///
/// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
/// let camera = Camera::Equidistant(Equidistant::new(intrinsics)?);
/// let pixel = camera.project(&Bearing::new(1.0, 0.0, 1.0)).unwrap();
/// assert!((pixel.x - (99.5 + 78.54)).abs() < 0.01);
/// # Ok::<(), compass_core::CameraError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Equidistant {
    pub(super) intrinsics: Intrinsics,
}

impl Equidistant {
    /// A lens of these focal lengths, in pixels per radian.
    ///
    /// # Errors
    /// [`CameraError::NotFinite`], [`CameraError::Focal`].
    pub fn new(intrinsics: Intrinsics) -> Result<Self, CameraError> {
        Ok(Self { intrinsics: intrinsics.checked()? })
    }

    pub(super) fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        let polar = Polar::new(bearing)?;
        let theta = polar.theta_within(WIDEST_ANGLE)?;
        self.intrinsics.pixel(theta * polar.direction[0], theta * polar.direction[1])
    }

    pub(super) fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        let plane = self.intrinsics.plane(pixel);
        Some(plane.bearing(plane.radius_within(WIDEST_ANGLE)?))
    }
}
