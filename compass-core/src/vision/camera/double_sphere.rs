//! The double sphere camera model.
//!
//! V. Usenko, N. Demmel and D. Cremers, "The Double Sphere Camera Model", 3DV 2018: `ds` in Kalibr and Basalt. A bearing
//! on the unit sphere is seen from a centre moved back by xi; what is seen there goes through the unified model with
//! alpha, which is [`Eucm`] with beta 1. Neither direction needs trigonometry.

use super::{
    Bearing, CameraError, Eucm, Intrinsics, NARROWEST_ANGLE, Pixel, WIDEST_ANGLE, finite, scaled_to_1,
};

/// Double sphere model: xi 0 is the unified model, xi 0 and alpha 0 the pinhole.
///
/// # Formats
/// Radius in focal lengths at the angle theta, with `d = sqrt(sin^2 + (cos + xi)^2)`:
/// `sin / (alpha d + (1 - alpha) (cos + xi))`, closed form in both directions.
///
/// # References
/// V. Usenko, N. Demmel and D. Cremers, "The Double Sphere Camera Model", 3DV 2018.
///
/// ```
/// use compass_core::{Bearing, Camera, DoubleSphere, Intrinsics};
///
/// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
/// let camera = Camera::DoubleSphere(DoubleSphere::new(intrinsics, -0.2, 0.6)?);
/// // 1 / (0.6 sqrt(1 + 0.04) - 0.4 * 0.2) focal lengths.
/// let pixel = camera.project(&Bearing::new(1.0, 0.0, 0.0)).unwrap();
/// assert!((pixel.x - (99.5 + 188.01)).abs() < 0.01);
/// # Ok::<(), compass_core::CameraError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DoubleSphere {
    /// The lens behind the moved centre, with the intrinsics.
    pub(super) second: Eucm,
    xi: f32,
    max_radius: f32,
    pub(super) max_angle: f32,
}

impl DoubleSphere {
    /// A lens with `xi` above -1 and up to 1, and `alpha` from 0 to 1.
    ///
    /// # Errors
    /// [`CameraError::NotFinite`], [`CameraError::Focal`], [`CameraError::Xi`], [`CameraError::Alpha`],
    /// [`CameraError::Field`].
    pub fn new(intrinsics: Intrinsics, xi: f32, alpha: f32) -> Result<Self, CameraError> {
        finite(&[xi])?;
        if xi <= -1.0 || xi > 1.0 {
            return Err(CameraError::Xi);
        }
        let second = Eucm::new(intrinsics, alpha, 1.0)?;
        let mut lens = Self { second, xi, max_radius: 0.0, max_angle: WIDEST_ANGLE };
        // From the moved centre the widest bearing is seen at this angle, which grows with it.
        let (sin, cos) = libm::sincosf(WIDEST_ANGLE);
        let widest = libm::atan2f(sin, cos + xi);
        if widest < second.max_angle {
            lens.max_radius = second.radius(widest);
        } else {
            lens.max_radius = second.max_radius();
            let rim = lens.moved_back(&second.rim());
            lens.max_angle =
                libm::atan2f(libm::sqrtf(rim.x * rim.x + rim.y * rim.y), rim.z).min(WIDEST_ANGLE);
        }
        let wide_enough = lens.max_angle >= NARROWEST_ANGLE && lens.max_radius >= NARROWEST_ANGLE;
        if wide_enough { Ok(lens) } else { Err(CameraError::Field) }
    }

    /// Distance of the two centres, -1 to 1.
    #[must_use]
    pub const fn xi(&self) -> f32 {
        self.xi
    }

    /// Share of the second sphere in the model, 0 to 1.
    #[must_use]
    pub const fn alpha(&self) -> f32 {
        self.second.alpha()
    }

    pub(super) fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        let b = scaled_to_1(bearing)?;
        let z = b.z + self.xi * libm::sqrtf(b.x * b.x + b.y * b.y + b.z * b.z);
        let straight_behind = b.x == 0.0 && b.y == 0.0 && b.z < 0.0;
        if straight_behind {
            None
        } else {
            self.second.project_within(&Bearing::new(b.x, b.y, z), self.max_radius)
        }
    }

    pub(super) fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        Some(self.moved_back(&self.second.unproject_within(pixel, self.max_radius)?))
    }

    /// The bearing from the first centre of a unit bearing from the moved one.
    fn moved_back(&self, seen: &Bearing) -> Bearing {
        let across2 = seen.x * seen.x + seen.y * seen.y;
        let length = self.xi * seen.z + libm::sqrtf((1.0 - self.xi * self.xi * across2).max(0.0));
        let (x, y, z) = (length * seen.x, length * seen.y, length * seen.z - self.xi);
        let norm = libm::sqrtf(x * x + y * y + z * z);
        Bearing::new(x / norm, y / norm, z / norm)
    }
}
