//! The polynomial fisheye of Kannala and Brandt.
//!
//! J. Kannala and S. Brandt, "A Generic Camera Model and Calibration Method for Conventional,
//! Wide-Angle, and Fish-Eye Lenses", PAMI 2006, in the form of `OpenCV`'s fisheye model and Kalibr's
//! "equidistant" distortion: the linear coefficient is 1, and k1 multiplies the cube.

use super::{
    Bearing, CameraError, Intrinsics, NARROWEST_ANGLE, Pixel, Polar, WIDEST_RADIUS, field_while, finite,
};

/// Largest number of steps of the inverse; 3 to 5 are usual, more near the rim.
const INVERSE_STEPS: u8 = 40;

/// Polynomial fisheye: radius = f (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9).
///
/// # Cost
/// [`new`](Self::new) scans the field in at most 1024 steps; [`Camera::unproject`](super::Camera::unproject) takes at most
/// 40 steps of Newton's method and bisection.
///
/// # References
/// J. Kannala and S. Brandt, "A Generic Camera Model and Calibration Method for Conventional, Wide-Angle, and Fish-Eye
/// Lenses", PAMI 2006.
///
/// ```
/// use compass_core::{Bearing, Camera, Intrinsics, KannalaBrandt};
///
/// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
/// let camera = Camera::KannalaBrandt(KannalaBrandt::new(intrinsics, [0.1, 0.0, 0.0, 0.0])?);
/// // pi / 2 + 0.1 (pi / 2)^3 focal lengths.
/// let pixel = camera.project(&Bearing::new(1.0, 0.0, 0.0)).unwrap();
/// assert!((pixel.x - (99.5 + 195.84)).abs() < 0.01);
/// # Ok::<(), compass_core::CameraError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KannalaBrandt {
    pub(super) intrinsics: Intrinsics,
    coefficients: [f32; 4],
    pub(super) max_angle: f32,
    max_radius: f32,
}

impl KannalaBrandt {
    /// A lens with coefficients k1 to k4 of theta^3, theta^5, theta^7 and theta^9.
    ///
    /// # Errors
    /// [`CameraError::NotFinite`], [`CameraError::Focal`], [`CameraError::Field`].
    pub fn new(intrinsics: Intrinsics, coefficients: [f32; 4]) -> Result<Self, CameraError> {
        finite(&coefficients)?;
        let mut lens =
            Self { intrinsics: intrinsics.checked()?, coefficients, max_angle: 0.0, max_radius: 0.0 };
        lens.max_angle = lens.field();
        lens.max_radius = lens.radius(lens.max_angle);
        // This comparison rejects NaN too.
        if lens.max_angle >= NARROWEST_ANGLE { Ok(lens) } else { Err(CameraError::Field) }
    }

    /// The coefficients k1 to k4.
    #[must_use]
    pub const fn coefficients(&self) -> [f32; 4] {
        self.coefficients
    }

    pub(super) fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        let polar = Polar::new(bearing)?;
        let radius = self.radius(polar.theta_within(self.max_angle)?);
        self.intrinsics.pixel(radius * polar.direction[0], radius * polar.direction[1])
    }

    pub(super) fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        let plane = self.intrinsics.plane(pixel);
        Some(plane.bearing(self.angle(plane.radius_within(self.max_radius)?)))
    }

    /// Radius in focal lengths at an angle.
    fn radius(&self, theta: f32) -> f32 {
        let [k1, k2, k3, k4] = self.coefficients;
        let t2 = theta * theta;
        theta + theta * (t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
    }

    /// Derivative of the radius by the angle: focal lengths per radian.
    fn slope(&self, theta: f32) -> f32 {
        let [k1, k2, k3, k4] = self.coefficients;
        let t2 = theta * theta;
        1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * (9.0 * k4))))
    }

    /// The angle up to which the radius grows and stays below [`WIDEST_RADIUS`].
    fn field(&self) -> f32 {
        let good = |theta: f32| self.slope(theta) > 0.0 && self.radius(theta) <= WIDEST_RADIUS;
        field_while(good)
    }

    /// The angle at a radius within the field: Newton's method while each step is less than half the previous one,
    /// else bisection of the bracket.
    fn angle(&self, radius: f32) -> f32 {
        let (mut low, mut high) = (0.0, self.max_angle);
        let mut theta = radius.min(high);
        let mut moved = high;
        for _ in 0..INVERSE_STEPS {
            let excess = self.radius(theta) - radius;
            if excess > 0.0 {
                high = theta;
            } else {
                low = theta;
            }
            // Near the rim the slope may vanish, so that the step is infinite or NaN.
            let step = -excess / self.slope(theta);
            let newton = theta + step;
            let good = step.abs() < 0.5 * moved && newton >= low && newton <= high;
            let next = if good { newton } else { 0.5 * (low + high) };
            moved = (next - theta).abs();
            theta = next;
            if moved <= f32::EPSILON * theta {
                break;
            }
        }
        theta
    }
}
