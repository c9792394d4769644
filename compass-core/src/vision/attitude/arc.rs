//! Segments as arcs of great circles.

use crate::vision::camera::{Bearing, Pixel, View};
use crate::vision::segments::Segment;
use bytemuck::{Pod, Zeroable};

/// Largest angle between an arc's ends and the optical axis: cosine of 92 degrees.
const RIM_COS: f32 = -0.034_899_5;
/// Smallest angle between an arc's middle and a direction it can agree with: cosine squared of 20 degrees.
const NEAR: f32 = 0.883_022_2;
/// Upper bound of an arc's weight, degrees.
const MOST_WEIGHT: f32 = 25.0;

/// A segment on the unit sphere, in the axes of camera 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Arc {
    /// Unit normal of its great circle.
    pub normal: Bearing,
    /// Unit vector to its middle.
    pub middle: Bearing,
    /// Its length in degrees, at most 25.
    pub weight: f32,
    /// Number of the camera that saw it.
    pub camera: u32,
}

impl Arc {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self {
        normal: Bearing::new(0.0, 0.0, 0.0),
        middle: Bearing::new(0.0, 0.0, 0.0),
        weight: 0.0,
        camera: 0,
    };

    /// The arc of a segment in a camera's image; `None` if an end lies beyond the camera's field or 92 degrees
    /// from its axis, or the arc is shorter than 0.1 degrees.
    ///
    /// # Formats
    /// Pixels of the segment to unit vectors in camera 0.
    ///
    /// # References
    /// S. T. Barnard, "Interpreting Perspective Images", Artificial Intelligence 21, 1983: lines as great circles of the
    /// Gaussian sphere.
    ///
    /// ```
    /// # use compass_core::vision::camera::Equidistant;
    /// # use compass_core::vision::segments::Segment;
    /// # use compass_core::{Bearing, Camera, CameraError, Intrinsics, View};
    /// use compass_core::vision::attitude::Arc;
    ///
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 200, 200);
    /// // A vertical segment through the optical axis, 0.2 rad long: its great circle is the plane x = 0.
    /// let segment = Segment { x1: 99.5, y1: 89.5, x2: 99.5, y2: 109.5, score: 20 };
    /// let arc = Arc::new(&segment, &view, 0).unwrap();
    /// assert!((arc.normal.x.abs() - 1.0).abs() < 1e-6 && (arc.weight - 11.46).abs() < 0.01);
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn new(segment: &Segment, view: &View, camera: u32) -> Option<Self> {
        let end = |x, y| {
            let bearing = view.camera.unproject(Pixel { x, y }).filter(|b| b.z > RIM_COS)?;
            Some(view.rotation * bearing)
        };
        let (a, b) = (end(segment.x1, segment.y1)?, end(segment.x2, segment.y2)?);
        let (normal, middle) = (a.cross(&b), a + b);
        let (sin, double) = (libm::sqrtf(normal.dot(&normal)), libm::sqrtf(middle.dot(&middle)));
        if sin < 1.7e-3 || double < 1e-3 {
            return None;
        }
        let length = degrees(libm::atan2f(sin, a.dot(&b)));
        Some(Self { normal: normal / sin, middle: middle / double, weight: length.min(MOST_WEIGHT), camera })
    }

    /// Agreement of the arc with a vanishing point (a unit vector): 1 if its great circle contains it, falling to 0 at the
    /// tolerance; 0 within 20 degrees of the arc's middle. The tolerance is clamped to 0.1 to 10 degrees.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::attitude::Arc;
    ///
    /// let arc = Arc { normal: Bearing::x(), middle: Bearing::z(), weight: 10.0, camera: 0 };
    /// assert_eq!(arc.agreement(&Bearing::y(), 2.0), 1.0);
    /// assert_eq!(arc.agreement(&Bearing::z(), 2.0), 0.0, "the middle of the arc");
    /// ```
    #[must_use]
    pub fn agreement(&self, direction: &Bearing, tolerance_deg: f32) -> f32 {
        self.agrees(direction, sharpness(tolerance_deg))
    }

    /// [`agreement`](Self::agreement) by the [`sharpness`] of the tolerance.
    ///
    /// The residual is the smallest rotation of the arc about its middle after which its great circle contains the
    /// direction.
    #[inline(always)]
    pub(super) fn agrees(&self, direction: &Bearing, sharpness: f32) -> f32 {
        let (off, near) = (self.normal.dot(direction), self.middle.dot(direction));
        let sin_squared = 1.0 - near * near;
        let residual = off * off * sharpness;
        if near * near > NEAR || residual >= sin_squared { 0.0 } else { 1.0 - residual / sin_squared }
    }
}

/// `1 / sin^2` of a tolerance.
pub(super) fn sharpness(tolerance_deg: f32) -> f32 {
    let sin = libm::sinf(tolerance_deg.clamp(0.1, 10.0) * (core::f32::consts::PI / 180.0));
    1.0 / (sin * sin)
}

pub(super) fn degrees(radians: f32) -> f32 {
    radians * (180.0 / core::f32::consts::PI)
}
