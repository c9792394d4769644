//! The unified omnidirectional model with radial and tangential distortion, and the pinhole as its special case.
//!
//! C. Mei and P. Rives, "Single View Point Omnidirectional Camera Calibration from Planar Grids", ICRA 2007: `omni` with
//! `radtan` or `none` in Kalibr, `cv::omnidir` in `OpenCV`. A bearing of length 1 is seen from a centre moved back by xi
//! by a pinhole, whose image is distorted as `OpenCV` and ROS (`plumb_bob`) do. With xi 0 this is Kalibr's `pinhole` with
//! `radtan`.

use super::{
    Bearing, CameraError, Intrinsics, NARROWEST_ANGLE, Pixel, Plane, RIM, WIDEST_RADIUS, field_while, finite,
    scaled_to_1,
};

/// Largest number of steps of the inverse; 3 to 6 are usual, more near the rim.
const INVERSE_STEPS: u8 = 48;

/// Largest residual of the inverse in focal lengths, for a radius of 1: 0.008 pixels at 2000 pixels of focal length.
const INVERSE_RESIDUAL: f32 = 4e-6;

/// Radial and tangential distortion of a pinhole image, in the order of `OpenCV`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radtan {
    /// Coefficient of the squared radius.
    pub k1: f32,
    /// Coefficient of its fourth power.
    pub k2: f32,
    /// First tangential coefficient.
    pub p1: f32,
    /// Second tangential coefficient.
    pub p2: f32,
    /// Coefficient of the sixth power of the radius; Kalibr has none.
    pub k3: f32,
}

impl Radtan {
    const fn coefficients(&self) -> [f32; 5] {
        [self.k1, self.k2, self.p1, self.p2, self.k3]
    }

    /// Factor of the radius.
    fn radial(&self, r2: f32) -> f32 {
        1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
    }

    /// Derivative of the distorted radius by the radius, without the tangential part.
    fn slope(&self, r2: f32) -> f32 {
        1.0 + r2 * (3.0 * self.k1 + r2 * (5.0 * self.k2 + r2 * (7.0 * self.k3)))
    }

    /// Length of the tangential vector (p2, p1).
    fn tangential(&self) -> f32 {
        libm::sqrtf(self.p1 * self.p1 + self.p2 * self.p2)
    }

    /// Whether the map keeps its orientation, in every direction, at this radius: its derivative is symmetric, and this
    /// bounds its eigenvalues from below. A disc of such points is mapped one to one.
    fn is_regular(&self, radius: f32) -> bool {
        let (across, along) = (self.radial(radius * radius), self.slope(radius * radius));
        let tangential = radius * self.tangential();
        along > 6.0 * tangential && across > 2.0 * tangential && along + 3.0 * across >= 16.0 * tangential
    }

    fn distort(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let r2 = x * x + y * y;
        let radial = self.radial(r2);
        let inner = 2.0 * (self.p2 * x + self.p1 * y);
        [x * radial + (self.p2 * r2 + inner * x), y * radial + (self.p1 * r2 + inner * y)]
    }

    /// The derivative of [`Self::distort`]: the elements (x, x), (x, y) = (y, x) and (y, y).
    fn derivative(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let r2 = x * x + y * y;
        let radial = self.radial(r2);
        let bend = 2.0 * (self.k1 + r2 * (2.0 * self.k2 + r2 * (3.0 * self.k3)));
        let (px, py) = (2.0 * self.p2 * x, 2.0 * self.p1 * y);
        [
            radial + bend * x * x + 3.0 * px + py,
            bend * x * y + 2.0 * (self.p1 * x + self.p2 * y),
            radial + bend * y * y + px + 3.0 * py,
        ]
    }
}

/// Unified omnidirectional model with radial and tangential distortion; xi 0 is the pinhole.
///
/// # Formats
/// Position in focal lengths: `(x, y) / (z + xi sqrt(x^2 + y^2 + z^2))`, then [`Radtan`].
///
/// # Cost
/// [`new`](Self::new) scans the field in at most 1024 steps; [`Camera::unproject`](super::Camera::unproject) takes at most
/// 48 steps of damped Newton's method.
///
/// # References
/// C. Mei and P. Rives, "Single View Point Omnidirectional Camera Calibration from Planar Grids", ICRA 2007.
///
/// ```
/// use compass_core::{Bearing, Camera, Intrinsics, Omni, Radtan};
///
/// let intrinsics = Intrinsics { fx: 200.0, fy: 200.0, cx: 99.5, cy: 99.5 };
/// // Xi 1 is the stereographic lens, tan(theta / 2).
/// let camera = Camera::Omni(Omni::new(intrinsics, 1.0, Radtan { k1: -0.1, ..Radtan::default() })?);
/// let pixel = camera.project(&Bearing::new(1.0, 0.0, 0.0)).unwrap();
/// assert!((pixel.x - (99.5 + 180.0)).abs() < 1e-3);
/// # Ok::<(), compass_core::CameraError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Omni {
    pub(super) intrinsics: Intrinsics,
    xi: f32,
    distortion: Radtan,
    /// A bearing is in the field while z > -`behind` times its length.
    behind: f32,
    /// Radius of the field before distortion.
    max_radius: f32,
    pub(super) max_angle: f32,
}

impl Omni {
    /// A lens with `xi` from 0 up.
    ///
    /// # Errors
    /// [`CameraError::NotFinite`], [`CameraError::Focal`], [`CameraError::Xi`], [`CameraError::Field`].
    pub fn new(intrinsics: Intrinsics, xi: f32, distortion: Radtan) -> Result<Self, CameraError> {
        let intrinsics = intrinsics.checked()?;
        finite(&distortion.coefficients())?;
        finite(&[xi])?;
        if xi < 0.0 {
            return Err(CameraError::Xi);
        }
        // For xi up to 1 the radius goes to infinity at the rim; above, it has a maximum there.
        let behind = if xi > 1.0 { 1.0 / xi } else { xi };
        let mut lens = Self { intrinsics, xi, distortion, behind, max_radius: 0.0, max_angle: 0.0 };
        lens.max_angle = lens.field();
        lens.max_radius = lens.radius(lens.max_angle);
        // These comparisons reject NaN too.
        let wide_enough = lens.max_angle >= NARROWEST_ANGLE
            && lens.max_radius >= NARROWEST_ANGLE / (1.0 + xi)
            && lens.max_radius.is_finite();
        if wide_enough { Ok(lens) } else { Err(CameraError::Field) }
    }

    /// Distance of the sphere's centre from that of the projection, in radii of the sphere.
    #[must_use]
    pub const fn xi(&self) -> f32 {
        self.xi
    }

    /// The distortion.
    #[must_use]
    pub const fn distortion(&self) -> Radtan {
        self.distortion
    }

    pub(super) fn project(&self, bearing: &Bearing) -> Option<Pixel> {
        let b = scaled_to_1(bearing)?;
        let rho2 = b.x * b.x + b.y * b.y;
        let length = libm::sqrtf(rho2 + b.z * b.z);
        let denominator = b.z + self.xi * length;
        let radius = libm::sqrtf(rho2) / denominator;
        let seen = b.z >= -(self.behind + RIM) * length
            && denominator > 0.0
            && radius <= self.max_radius * (1.0 + RIM);
        if !seen {
            return None;
        }
        let [x, y] = self.distortion.distort([b.x / denominator, b.y / denominator]);
        self.intrinsics.pixel(x, y)
    }

    pub(super) fn unproject(&self, pixel: Pixel) -> Option<Bearing> {
        let Plane { x, y, radius } = self.intrinsics.plane(pixel);
        // The image of the field lies within this radius.
        if radius.is_nan() || radius > 2.0 * WIDEST_RADIUS {
            return None;
        }
        let [x, y] = self.undistort([x, y])?;
        let r2 = x * x + y * y;
        let root = libm::sqrtf((1.0 + (1.0 - self.xi * self.xi) * r2).max(0.0));
        let scale = (self.xi + root) / (r2 + 1.0);
        let (x, y, z) = (scale * x, scale * y, scale - self.xi);
        let norm = libm::sqrtf(x * x + y * y + z * z);
        Some(Bearing::new(x / norm, y / norm, z / norm))
    }

    /// Radius before distortion at an angle within the field.
    fn radius(&self, theta: f32) -> f32 {
        let (sin, cos) = libm::sincosf(theta);
        sin / (cos + self.xi)
    }

    /// The angle up to which the radius grows, the distortion is one to one and its image stays within
    /// [`WIDEST_RADIUS`].
    fn field(&self) -> f32 {
        let good = |theta: f32| {
            let (radius, tangential) = (self.radius(theta), 3.0 * self.distortion.tangential());
            libm::cosf(theta) > -self.behind
                && radius >= 0.0
                && self.distortion.is_regular(radius)
                && radius * (self.distortion.radial(radius * radius) + radius * tangential) <= WIDEST_RADIUS
        };
        field_while(good)
    }

    /// The position before distortion within the field; `None` outside its image.
    ///
    /// The distortion is the gradient of a function that is convex in the field, so that Newton's method converges when
    /// its steps are halved until the residual falls.
    fn undistort(&self, target: [f32; 2]) -> Option<[f32; 2]> {
        let mut at = self.within_field(target);
        let mut residual = self.residual(at, target);
        let mut share = 1.0;
        for _ in 0..INVERSE_STEPS {
            let [xx, xy, yy] = self.distortion.derivative(at);
            let determinant = xx * yy - xy * xy;
            let [dx, dy] = residual;
            let step = [(yy * dx - xy * dy) / determinant, (xx * dy - xy * dx) / determinant];
            let next = self.within_field([at[0] + share * step[0], at[1] + share * step[1]]);
            let left = self.residual(next, target);
            if squared(left) < squared(residual) {
                (at, residual, share) = (next, left, 1.0);
            } else {
                share *= 0.5;
                if share < f32::EPSILON {
                    break;
                }
            }
        }
        let tolerance = INVERSE_RESIDUAL * squared(target).max(1.0);
        (squared(residual) <= tolerance * tolerance).then_some(at)
    }

    fn residual(&self, at: [f32; 2], [x, y]: [f32; 2]) -> [f32; 2] {
        let [u, v] = self.distortion.distort(at);
        [x - u, y - v]
    }

    /// The nearest position within the field; its centre for NaN.
    fn within_field(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let radius = libm::sqrtf(x * x + y * y);
        if radius <= self.max_radius {
            return [x, y];
        }
        let scale = self.max_radius / radius;
        if scale > 0.0 { [x * scale, y * scale] } else { [0.0; 2] }
    }
}

fn squared([x, y]: [f32; 2]) -> f32 {
    x * x + y * y
}
