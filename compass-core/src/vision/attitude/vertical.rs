//! The up vector, with its inliers and residual.

use super::arc::degrees;
use crate::vision::camera::{Bearing, PerCamera};

/// The up vector, with its support, inliers and residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertical {
    /// Unit vector in camera 0.
    pub up: Bearing,
    /// Number of inlier segments of each camera.
    pub inliers: PerCamera<u16>,
    /// Sum of the inliers' weights, degrees of arc.
    pub support: f32,
    /// Support of the best direction at least 6 degrees away; a ratio to `support` near 1 means an ambiguous vertical.
    pub runner_up: f32,
    /// Weighted root mean square of the inliers' residuals, degrees.
    pub residual_deg: f32,
}

impl Vertical {
    /// Rotation of camera 0 about its optical axis, degrees in -180 to 180: 0 if the top of the image is up, 90 if its
    /// right side is up, 180 for a camera mounted upside down.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::attitude::Vertical;
    ///
    /// let up = Bearing::new(1.0, 0.0, 0.0);
    /// let vertical = Vertical { up, inliers: [20, 0], support: 99.0, runner_up: 9.0, residual_deg: 0.5 };
    /// assert!((vertical.roll_deg() - 90.0).abs() < 1e-3);
    /// ```
    #[must_use]
    pub fn roll_deg(&self) -> f32 {
        degrees(libm::atan2f(self.up.x, -self.up.y))
    }

    /// Elevation of the optical axis of camera 0, degrees in -90 to 90.
    ///
    /// ```
    /// use compass_core::Bearing;
    /// use compass_core::vision::attitude::Vertical;
    ///
    /// let up = Bearing::new(0.0, -0.8, 0.6);
    /// let vertical = Vertical { up, inliers: [20, 0], support: 99.0, runner_up: 9.0, residual_deg: 0.5 };
    /// assert!((vertical.pitch_deg() - 36.87).abs() < 0.01);
    /// ```
    #[must_use]
    pub fn pitch_deg(&self) -> f32 {
        degrees(libm::asinf(self.up.z.clamp(-1.0, 1.0)))
    }
}
