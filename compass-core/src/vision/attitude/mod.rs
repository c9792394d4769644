//! Which way is up: the vanishing point of vertical lines, from the segments of both cameras.
//!
//! Every segment spans a great circle of the unit sphere. Those of parallel lines meet in two opposite points, their
//! vanishing points (paper: roll and pitch). The vertical one is sought by seeded RANSAC over pairs of segments,
//! near the mounting's up, and refined over the inliers of both cameras at once: they look at opposite halves. Two
//! horizontal ones, at right angles, give the building's axes.
//!
//! Floats as in [`camera`](crate::vision::camera): `f32`, through `libm` alone, without fused operations.

mod arc;
mod axes;
mod search;

pub use arc::Arc;
pub use axes::{Axes, building_axes};
pub use search::{LEAST_INLIERS, Parameters, UpHint, vertical};

use crate::vision::camera::{Bearing, PerCamera};

/// Bound of the angle to the direction that real-valued arithmetic refines from the same segments, degrees.
pub const UP_ERROR_DEG: f32 = 0.02;

/// The up vector, with what speaks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertical {
    /// Unit vector in camera 0.
    pub up: Bearing,
    /// Segments of each camera that point to it.
    pub inliers: PerCamera<u16>,
    /// Their weight, degrees of arc.
    pub support: f32,
    /// The same of the next best direction: the larger it is beside `support`, the less sure which is the vertical.
    pub runner_up: f32,
    /// Weighted root mean square of the inliers' residuals, degrees.
    pub residual_deg: f32,
}

impl Vertical {
    /// Rotation of camera 0 about its optical axis, degrees in -180 to 180: 0 if the image's top is up, 90 if its
    /// right side is, 180 for a camera mounted upside down.
    #[must_use]
    pub fn roll_deg(&self) -> f32 {
        degrees(libm::atan2f(self.up.x, -self.up.y))
    }

    /// Elevation of the optical axis of camera 0, degrees in -90 to 90.
    #[must_use]
    pub fn pitch_deg(&self) -> f32 {
        degrees(libm::asinf(self.up.z.clamp(-1.0, 1.0)))
    }
}

fn degrees(radians: f32) -> f32 {
    radians * (180.0 / core::f32::consts::PI)
}

#[cfg(test)]
mod tests;
