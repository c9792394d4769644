//! Fisheye cameras: bearings to pixels and back, and the rig of two of them.
//!
//! | model | radius in focal lengths at the angle theta from the axis | source |
//! |---|---|---|
//! | [`KannalaBrandt`] | `theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9` | Kannala and Brandt 2006, as in `OpenCV` and Kalibr |
//! | [`Eucm`] | `sin / (alpha sqrt(beta sin^2 + cos^2) + (1 - alpha) cos)` | Khomutenko, Garcia and Martinet 2016 |
//! | [`DoubleSphere`] | `sin / (alpha d + (1 - alpha) (cos + xi))` with `d = sqrt(sin^2 + (cos + xi)^2)` | Usenko, Demmel and Cremers 2018 |
//! | [`Omni`] | `sin / (cos + xi)`, then radial and tangential distortion; xi 0 is the pinhole | Mei and Rives 2007, as in `OpenCV` and Kalibr |
//! | [`Equidistant`] | `theta` | the paper |
//!
//! Axes are `OpenCV`'s: x right, y down, z forward along the optical axis; the centre of the top left
//! pixel is (0, 0). Angles may exceed 90 degrees: a bearing may have negative z.
//!
//! # Field
//! Each model is valid up to an angle, [`Camera::max_angle`], the smallest of: the angle at which the radius
//! stops growing; the angle at which it reaches [`WIDEST_RADIUS`]; and [`WIDEST_ANGLE`]. Beyond it
//! [`Camera::project`] and [`Camera::unproject`] return `None`. This is the field of the formula; the field of the
//! lens and the sensor is smaller, and a mask describes it.
//!
//! # Numbers
//! `f32` through `libm` alone, without fused operations: the same bits on every target. [`ROUND_TRIP_PX`],
//! [`PROJECTION_ERROR_PX`] and [`BEARING_ERROR`] bound the errors.

mod double_sphere;
mod equidistant;
mod eucm;
mod kannala_brandt;
mod omni;
mod rig;

pub use double_sphere::DoubleSphere;
pub use equidistant::Equidistant;
pub use eucm::Eucm;
pub use kannala_brandt::KannalaBrandt;
pub use omni::{Omni, Radtan};
pub use rig::{CAMERAS, PerCamera, Rig, View};

use core::fmt;

/// A direction of length 1: x right, y down, z forward.
pub type Bearing = nalgebra::Vector3<f32>;

/// Largest distance, in pixels, between a pixel in the field and the projection of its bearing.
///
/// This and the other bounds hold for focal lengths up to 2000 pixels and pixel coordinates up to 4096.
pub const ROUND_TRIP_PX: f32 = 0.03;

/// Largest distance, in pixels, between a projection and the exact one.
pub const PROJECTION_ERROR_PX: f32 = 0.02;

/// Largest angle, in radians, between a pixel's bearing and the exact one, up to 98 % of the
/// [largest angle](Camera::max_angle).
///
/// Closer to the rim the radius may hardly grow with the angle, so that an `f32` radius does not determine the
/// angle; the bound of the round trip still holds.
pub const BEARING_ERROR: f32 = 2e-5;

/// Upper bound of the field: angle from the axis in radians (179.8 degrees). At 180 degrees the image of one bearing
/// is a whole circle.
pub const WIDEST_ANGLE: f32 = core::f32::consts::PI - 0.004;

/// Upper bound of the field's image: radius in focal lengths. A pinhole reaches it 76 degrees from its axis.
pub const WIDEST_RADIUS: f32 = 4.0;

/// Lower bound of the field, in radians (6 degrees): coefficients that give less are rejected.
pub const NARROWEST_ANGLE: f32 = 0.1;

/// Relative amount by which rounding may move a point beyond the rim of the field; it is then clamped to the rim.
const RIM: f32 = 2e-6;

/// Largest difference of the squared length of a bearing to 1.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Steps of the scan for the end of the field.
const FIELD_STEPS: u16 = 1024;

/// Bisections that narrow one of those steps down to neighbouring `f32`.
const FIELD_HALVINGS: u8 = 24;

/// A position in an image; the centre of the top left pixel is (0, 0).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pixel {
    /// Pixels to the right.
    pub x: f32,
    /// Pixels down.
    pub y: f32,
}

/// Focal lengths and principal point, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Intrinsics {
    /// Focal length along x.
    pub fx: f32,
    /// Focal length along y.
    pub fy: f32,
    /// Principal point to the right.
    pub cx: f32,
    /// Principal point down.
    pub cy: f32,
}

impl Intrinsics {
    /// Returns the parameters if they are finite and the focal lengths positive.
    fn checked(self) -> Result<Self, CameraError> {
        finite(&[self.fx, self.fy, self.cx, self.cy])?;
        if self.fx > 0.0 && self.fy > 0.0 { Ok(self) } else { Err(CameraError::Focal) }
    }

    /// Converts a position in focal lengths to pixels; `None` if that overflows.
    fn pixel(&self, x: f32, y: f32) -> Option<Pixel> {
        let pixel = Pixel { x: self.fx * x + self.cx, y: self.fy * y + self.cy };
        (pixel.x.is_finite() && pixel.y.is_finite()).then_some(pixel)
    }

    /// Converts pixels to a position in focal lengths, which may be infinite or NaN.
    fn plane(&self, pixel: Pixel) -> Plane {
        let (x, y) = ((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy);
        Plane { x, y, radius: libm::sqrtf(x * x + y * y) }
    }

    /// The intrinsics of the image resized by `sx` and `sy`; NaN for scales that are not positive and finite.
    fn scaled(&self, sx: f32, sy: f32) -> Self {
        let sane = |s: f32| if s > 0.0 && s.is_finite() { s } else { f32::NAN };
        let (sx, sy) = (sane(sx), sane(sy));
        let centre = |c: f32, s: f32| (c + 0.5) * s - 0.5;
        Self { fx: self.fx * sx, fy: self.fy * sy, cx: centre(self.cx, sx), cy: centre(self.cy, sy) }
    }
}

/// A position in the image in focal lengths from the principal point.
struct Plane {
    x: f32,
    y: f32,
    radius: f32,
}

impl Plane {
    /// The radius, clamped to the rim within the tolerance [`RIM`]; `None` beyond it and for NaN.
    fn radius_within(&self, rim: f32) -> Option<f32> {
        (self.radius <= rim * (1.0 + RIM)).then(|| self.radius.min(rim))
    }

    /// The bearing at the angle `theta` from the axis, in this direction around it.
    fn bearing(&self, theta: f32) -> Bearing {
        if self.radius > 0.0 {
            let (sin, cos) = libm::sincosf(theta);
            Bearing::new(sin * (self.x / self.radius), sin * (self.y / self.radius), cos)
        } else {
            Bearing::new(0.0, 0.0, 1.0)
        }
    }
}

/// A bearing as the angle from the axis and the direction around it.
struct Polar {
    theta: f32,
    /// x and y of the direction, of length 1; both 0 on the axis.
    direction: [f32; 2],
}

impl Polar {
    /// `None` for a bearing that is not finite, zero, or opposite to the optical axis.
    fn new(bearing: &Bearing) -> Option<Self> {
        let b = scaled_to_1(bearing)?;
        let rho = libm::sqrtf(b.x * b.x + b.y * b.y);
        if rho > 0.0 {
            return Some(Self { theta: libm::atan2f(rho, b.z), direction: [b.x / rho, b.y / rho] });
        }
        (b.z > 0.0).then_some(Self { theta: 0.0, direction: [0.0; 2] })
    }

    /// The angle, clamped to the rim within the tolerance [`RIM`]; `None` beyond it.
    fn theta_within(&self, rim: f32) -> Option<f32> {
        (self.theta <= rim * (1.0 + RIM)).then(|| self.theta.min(rim))
    }
}

/// The bearing scaled to a largest component of 1, so that squares neither overflow nor underflow; `None` for a
/// bearing that is not finite or zero.
fn scaled_to_1(bearing: &Bearing) -> Option<Bearing> {
    let largest = bearing.x.abs().max(bearing.y.abs()).max(bearing.z.abs());
    // `max` ignores NaN; the sum propagates it.
    let sum = bearing.x + bearing.y + bearing.z;
    if largest > 0.0 && largest.is_finite() && !sum.is_nan() {
        return Some(Bearing::new(bearing.x / largest, bearing.y / largest, bearing.z / largest));
    }
    None
}

/// A camera of one of the models.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Camera {
    /// Polynomial of the angle.
    KannalaBrandt(KannalaBrandt),
    /// Enhanced unified camera model.
    Eucm(Eucm),
    /// Double sphere model.
    DoubleSphere(DoubleSphere),
    /// Unified omnidirectional model with radial and tangential distortion, or a pinhole with it.
    Omni(Omni),
    /// Radius proportional to the angle.
    Equidistant(Equidistant),
}

impl Camera {
    /// Projects a bearing of any length to a pixel, which may lie outside the image.
    ///
    /// `None` if the bearing is not finite, zero, opposite to the optical axis or beyond
    /// [`max_angle`](Self::max_angle).
    ///
    /// # Formats
    /// Bearing in the axes of this camera to pixels; the centre of the top left pixel is (0, 0).
    ///
    /// # Accuracy
    /// [`PROJECTION_ERROR_PX`], which `compass compare` checks against `f64`.
    ///
    /// # Cost
    /// No iteration: at most two square roots, and for the polynomial and equidistant models one arc tangent.
    ///
    /// # References
    /// Those of the [models](self).
    ///
    /// ```
    /// # use compass_core::{Bearing, Camera, CameraError, Intrinsics};
    /// # use compass_core::vision::camera::{Equidistant, Pixel};
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let camera = Camera::Equidistant(Equidistant::new(intrinsics)?);
    /// // 90 degrees to the right of the axis: a radius of pi / 2 focal lengths.
    /// let pixel = camera.project(&Bearing::new(1.0, 0.0, 0.0)).unwrap();
    /// assert!((pixel.x - (99.5 + 157.08)).abs() < 0.01 && pixel.y == 99.5);
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        match self {
            Self::KannalaBrandt(model) => model.project(bearing),
            Self::Eucm(model) => model.project(bearing),
            Self::DoubleSphere(model) => model.project(bearing),
            Self::Omni(model) => model.project(bearing),
            Self::Equidistant(model) => model.project(bearing),
        }
    }

    /// The bearing, of length 1, that projects to a pixel.
    ///
    /// `None` if the pixel is not finite or lies outside the image of the [field](Self::max_angle).
    ///
    /// # Accuracy
    /// [`BEARING_ERROR`], which `compass compare` checks against `f64`; with [`project`](Self::project)
    /// [`ROUND_TRIP_PX`] (test `pixels_round_trip`).
    ///
    /// # Cost
    /// The polynomial model inverts its polynomial by Newton's method with bisection, at most 40 steps; [`Omni`] its
    /// distortion by damped Newton's method, at most 48 steps; the others have no iteration.
    ///
    /// ```
    /// # use compass_core::{Bearing, Camera, CameraError, Intrinsics};
    /// # use compass_core::vision::camera::{Equidistant, Pixel};
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let camera = Camera::Equidistant(Equidistant::new(intrinsics)?);
    /// assert_eq!(camera.unproject(Pixel { x: 99.5, y: 99.5 }), Some(Bearing::new(0.0, 0.0, 1.0)));
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        let bearing = match self {
            Self::KannalaBrandt(model) => model.unproject(pixel),
            Self::Eucm(model) => model.unproject(pixel),
            Self::DoubleSphere(model) => model.unproject(pixel),
            Self::Omni(model) => model.unproject(pixel),
            Self::Equidistant(model) => model.unproject(pixel),
        };
        // Parameters at the limits of what numbers hold leave none.
        bearing.filter(|bearing| (bearing.norm_squared() - 1.0).abs() < UNIT_TOLERANCE)
    }

    /// The camera of an image resized by `sx` along x and `sy` along y: f' = f s, c' = (c + 0.5) s - 0.5.
    ///
    /// If a scale is not positive and finite, the camera projects and unprojects nothing.
    ///
    /// ```
    /// # use compass_core::{Camera, CameraError, Intrinsics};
    /// # use compass_core::vision::camera::Equidistant;
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let camera = Camera::Equidistant(Equidistant::new(intrinsics)?);
    /// let half = camera.scaled(0.5, 0.5).intrinsics();
    /// assert_eq!((half.fx, half.cx), (50.0, 49.5));
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn scaled(&self, sx: f32, sy: f32) -> Self {
        let mut camera = *self;
        let intrinsics = match &mut camera {
            Self::KannalaBrandt(model) => &mut model.intrinsics,
            Self::Eucm(model) => &mut model.intrinsics,
            Self::DoubleSphere(model) => &mut model.second.intrinsics,
            Self::Omni(model) => &mut model.intrinsics,
            Self::Equidistant(model) => &mut model.intrinsics,
        };
        *intrinsics = intrinsics.scaled(sx, sy);
        camera
    }

    /// Focal lengths and principal point.
    #[must_use]
    pub fn intrinsics(&self) -> Intrinsics {
        match self {
            Self::KannalaBrandt(model) => model.intrinsics,
            Self::Eucm(model) => model.intrinsics,
            Self::DoubleSphere(model) => model.second.intrinsics,
            Self::Omni(model) => model.intrinsics,
            Self::Equidistant(model) => model.intrinsics,
        }
    }

    /// Radius of the field: the largest angle from the axis that has an image, in radians, at most [`WIDEST_ANGLE`].
    ///
    /// ```
    /// # use compass_core::{Camera, CameraError, Intrinsics};
    /// # use compass_core::vision::camera::Equidistant;
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let camera = Camera::Equidistant(Equidistant::new(intrinsics)?);
    /// assert_eq!(camera.max_angle(), compass_core::vision::camera::WIDEST_ANGLE);
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn max_angle(&self) -> f32 {
        match self {
            Self::KannalaBrandt(model) => model.max_angle,
            Self::Eucm(model) => model.max_angle,
            Self::DoubleSphere(model) => model.max_angle,
            Self::Omni(model) => model.max_angle,
            Self::Equidistant(_) => WIDEST_ANGLE,
        }
    }
}

/// Error of constructing a camera, a view or a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CameraError {
    /// A parameter is infinite or not a number.
    NotFinite,
    /// A focal length is not positive.
    Focal,
    /// Alpha lies outside 0 to 1.
    Alpha,
    /// Beta is not positive.
    Beta,
    /// Xi is negative, or of a double sphere outside -1 to 1.
    Xi,
    /// The field is narrower than [`NARROWEST_ANGLE`], or the radius of its image smaller than that in focal lengths.
    Field,
    /// Width or height of an image is 0.
    Size,
    /// A rotation matrix is not orthonormal, or its determinant is negative.
    Rotation,
    /// A rig has no camera.
    Empty,
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "camera parameter is infinite or not a number",
            Self::Focal => "focal length is not positive",
            Self::Alpha => "alpha lies outside 0 to 1",
            Self::Beta => "beta is not positive",
            Self::Xi => "xi is negative, or of a double sphere outside -1 to 1",
            Self::Field => "coefficients give a field of less than 6 degrees from the axis",
            Self::Size => "image side is zero",
            Self::Rotation => "matrix is no rotation",
            Self::Empty => "rig has no camera",
        })
    }
}

impl core::error::Error for CameraError {}

/// The largest angle from the axis up to which all angles of a scan are good, at most [`WIDEST_ANGLE`].
fn field_while(good: impl Fn(f32) -> bool) -> f32 {
    let at = |step: u16| WIDEST_ANGLE * (f32::from(step) / f32::from(FIELD_STEPS));
    let Some(first_bad) = (1..=FIELD_STEPS).find(|&step| !good(at(step))) else {
        return WIDEST_ANGLE;
    };
    let (mut low, mut high) = (at(first_bad - 1), at(first_bad));
    for _ in 0..FIELD_HALVINGS {
        let middle = 0.5 * (low + high);
        if good(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

fn finite(values: &[f32]) -> Result<(), CameraError> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(CameraError::NotFinite) }
}

#[cfg(test)]
mod tests;
