//! The gravity-aligned frame of azimuths and elevations.

use crate::vision::camera::Bearing;
use nalgebra::{Matrix3, Vector3};

/// Range, in metres, at which the parallax of the baseline between the cameras is compensated exactly. At r metres the
/// residual parallax is at most baseline |1/r - 1/6| radians: for 40 mm, 0.8 degrees at 2 m and 0.4 degrees at infinity,
/// at right angles to the baseline, and 0 along it.
pub const NOMINAL_RANGE_M: f32 = 6.0;

/// The level frame of camera 0: forward is its optical axis projected on the horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelFrame {
    /// Rows are the unit vectors forward, left and up in camera 0.
    axes: Matrix3<f32>,
}

impl LevelFrame {
    /// Makes the frame of the up vector in camera 0, of any length; `None` if it is not finite, shorter than 0.001, or
    /// parallel to the optical axis, which leaves the heading undefined.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::level_frame::LevelFrame;
    ///
    /// // Upside down: the y axis of the image points up.
    /// assert!(LevelFrame::new(&Bearing::new(0.0, 2.0, 0.5)).is_some());
    /// assert!(LevelFrame::new(&Bearing::z()).is_none());
    /// ```
    #[must_use]
    pub fn new(up: &Bearing) -> Option<Self> {
        let unit = |v: Vector3<f32>| {
            let length = libm::sqrtf(v.dot(&v));
            (length.is_finite() && length > 1e-3).then(|| v / length)
        };
        let up = unit(*up)?;
        let axis = Vector3::z();
        let forward = unit(axis - up * up.z)?;
        let left = up.cross(&forward);
        Some(Self { axes: Matrix3::from_rows(&[forward.transpose(), left.transpose(), up.transpose()]) })
    }

    /// The up vector in camera 0.
    #[must_use]
    pub fn up(&self) -> Bearing {
        self.axes.row(2).transpose()
    }

    /// The unit vector in camera 0 at an azimuth (counter-clockwise seen from above) and elevation, radians.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::level_frame::LevelFrame;
    ///
    /// let level = LevelFrame::new(&Bearing::new(0.0, -1.0, 0.0)).unwrap();
    /// assert_eq!(level.bearing(0.0, 0.0), Bearing::z());
    /// // Azimuth 90 degrees is to the left.
    /// let left = level.bearing(core::f32::consts::FRAC_PI_2, 0.0);
    /// assert!((left + Bearing::x()).norm() < 1e-6);
    /// ```
    #[must_use]
    pub fn bearing(&self, azimuth: f32, elevation: f32) -> Bearing {
        self.bearing_of(libm::sincosf(azimuth), libm::sincosf(elevation))
    }

    /// [`bearing`](Self::bearing) from sine and cosine of azimuth and of elevation.
    pub(super) fn bearing_of(&self, (sin_a, cos_a): (f32, f32), (sin_e, cos_e): (f32, f32)) -> Bearing {
        self.axes.tr_mul(&Vector3::new(cos_e * cos_a, cos_e * sin_a, sin_e))
    }

    /// Azimuth and elevation, radians, of a unit vector in camera 0.
    ///
    /// # Formats
    /// Azimuth in -pi to pi, counter-clockwise from forward; elevation in -pi / 2 to pi / 2.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::level_frame::LevelFrame;
    ///
    /// let level = LevelFrame::new(&Bearing::new(0.0, -1.0, 0.0)).unwrap();
    /// let (azimuth, elevation) = level.direction(&Bearing::new(-0.8, -0.6, 0.0));
    /// assert!((azimuth.to_degrees() - 90.0).abs() < 1e-4);
    /// assert!((elevation.to_degrees() - 36.87).abs() < 0.01);
    /// ```
    #[must_use]
    pub fn direction(&self, bearing: &Bearing) -> (f32, f32) {
        let level = self.axes * bearing;
        (libm::atan2f(level.y, level.x), libm::asinf(level.z.clamp(-1.0, 1.0)))
    }
}
