//! The enhanced unified camera model.
//!
//! B. Khomutenko, G. Garcia and P. Martinet, "An Enhanced Unified Camera Model", RA-L 2016. With
//! d = sqrt(beta (x^2 + y^2) + z^2), a bearing projects to (x, y) / (alpha d + (1 - alpha) z). Neither direction needs
//! trigonometry.

use super::{
    Bearing, CameraError, Intrinsics, NARROWEST_ANGLE, Pixel, RIM, WIDEST_ANGLE, WIDEST_RADIUS, finite,
    scaled_to_1,
};

/// Enhanced unified camera model; alpha 0 is the pinhole.
///
/// # Formats
/// Radius in focal lengths at the angle theta: `sin / (alpha sqrt(beta sin^2 + cos^2) + (1 - alpha) cos)`, closed form in
/// both directions.
///
/// # References
/// B. Khomutenko, G. Garcia and P. Martinet, "An Enhanced Unified Camera Model", RA-L 2016.
///
/// ```
/// use compass_core::{Bearing, Camera, Eucm, Intrinsics};
///
/// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
/// // Alpha 1/2 and beta 1 is the stereographic lens: 2 tan(theta / 2).
/// let camera = Camera::Eucm(Eucm::new(intrinsics, 0.5, 1.0)?);
/// let pixel = camera.project(&Bearing::new(1.0, 0.0, 0.0)).unwrap();
/// assert!((pixel.x - 299.5).abs() < 1e-3);
/// # Ok::<(), compass_core::CameraError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Eucm {
    pub(super) intrinsics: Intrinsics,
    alpha: f32,
    beta: f32,
    /// A bearing is in the field while z > -`behind` d.
    behind: f32,
    max_radius: f32,
    pub(super) max_angle: f32,
}

impl Eucm {
    /// A lens with `alpha` from 0 to 1 and `beta` above 0.
    ///
    /// # Errors
    /// [`CameraError::NotFinite`], [`CameraError::Focal`], [`CameraError::Alpha`], [`CameraError::Beta`];
    /// [`CameraError::Field`] for a beta so large that the image of the field is a point, or its depth no number.
    pub fn new(intrinsics: Intrinsics, alpha: f32, beta: f32) -> Result<Self, CameraError> {
        let intrinsics = intrinsics.checked()?;
        finite(&[alpha, beta])?;
        if !(0.0..=1.0).contains(&alpha) {
            return Err(CameraError::Alpha);
        }
        if beta <= 0.0 {
            return Err(CameraError::Beta);
        }
        // For alpha up to 1/2 the radius goes to infinity where the denominator vanishes. Above, it has a maximum:
        // beyond it two bearings would share a pixel.
        let (behind, max_radius) = if alpha > 0.5 {
            ((1.0 - alpha) / alpha, 1.0 / libm::sqrtf(beta * (2.0 * alpha - 1.0)))
        } else {
            (alpha / (1.0 - alpha), WIDEST_RADIUS)
        };
        let max_radius = max_radius.min(WIDEST_RADIUS);
        let mut lens = Self { intrinsics, alpha, beta, behind, max_radius, max_angle: 0.0 };
        let depth = lens.depth(max_radius);
        lens.max_angle = libm::atan2f(max_radius, depth).min(WIDEST_ANGLE);
        // A large beta shrinks the image of the field to a point, and one above what numbers hold has no depth.
        let wide_enough =
            depth.is_finite() && lens.max_angle >= NARROWEST_ANGLE && max_radius >= NARROWEST_ANGLE;
        if wide_enough { Ok(lens) } else { Err(CameraError::Field) }
    }

    /// Share of the sphere in the model, 0 to 1.
    #[must_use]
    pub const fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Squared ratio of the ellipsoid's axes, above 0.
    #[must_use]
    pub const fn beta(&self) -> f32 {
        self.beta
    }

    /// Largest radius of the field, in focal lengths.
    pub(super) const fn max_radius(&self) -> f32 {
        self.max_radius
    }

    /// A bearing on the rim of the field.
    pub(super) fn rim(&self) -> Bearing {
        let z = self.depth(self.max_radius);
        let length = libm::sqrtf(self.max_radius * self.max_radius + z * z);
        Bearing::new(self.max_radius / length, 0.0, z / length)
    }

    /// Radius in focal lengths at an angle within the field.
    pub(super) fn radius(&self, theta: f32) -> f32 {
        let (sin, cos) = libm::sincosf(theta);
        sin / (self.alpha * libm::sqrtf(self.beta * sin * sin + cos * cos) + (1.0 - self.alpha) * cos)
    }

    pub(super) fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        self.project_within(bearing, self.max_radius)
    }

    /// The pixel of a bearing, if its radius is at most `max_radius`.
    pub(super) fn project_within(&self, bearing: &Bearing, max_radius: f32) -> Option<Pixel> {
        let b = scaled_to_1(bearing)?;
        let rho2 = b.x * b.x + b.y * b.y;
        let d = libm::sqrtf(self.beta * rho2 + b.z * b.z);
        let denominator = self.alpha * d + (1.0 - self.alpha) * b.z;
        let radius = libm::sqrtf(rho2) / denominator;
        let seen = b.z >= -(self.behind + RIM) * d && denominator > 0.0 && radius <= max_radius * (1.0 + RIM);
        if seen { self.intrinsics.pixel(b.x / denominator, b.y / denominator) } else { None }
    }

    pub(super) fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        self.unproject_within(pixel, self.max_radius)
    }

    /// The bearing of a pixel, if its radius is at most `max_radius`.
    pub(super) fn unproject_within(&self, pixel: Pixel, max_radius: f32) -> Option<Bearing> {
        let plane = self.intrinsics.plane(pixel);
        let z = self.depth(plane.radius_within(max_radius)?);
        let length = libm::sqrtf(plane.radius * plane.radius + z * z);
        Some(Bearing::new(plane.x / length, plane.y / length, z / length))
    }

    /// z of the bearing with x^2 + y^2 = radius^2, for a radius within the field.
    fn depth(&self, radius: f32) -> f32 {
        let r2 = self.beta * (radius * radius);
        // On the rim rounding may make this negative.
        let over = 2.0 * self.alpha - 1.0;
        let root = self.alpha * libm::sqrtf((1.0 - over * r2).max(0.0));
        // The published form is 0 / 0 on the rim for alpha 1; expanded by root - (1 - alpha) it is 0 / 0 for
        // alpha 1/2 instead.
        if self.alpha > 0.75 {
            (root - (1.0 - self.alpha)) / over
        } else {
            (1.0 - self.alpha * self.alpha * r2) / (root + (1.0 - self.alpha))
        }
    }
}
