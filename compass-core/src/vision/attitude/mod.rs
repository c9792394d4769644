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
mod vertical;

pub use arc::Arc;
pub use axes::{Axes, building_axes};
pub use search::{LEAST_INLIERS, Parameters, UpHint, vertical};
pub use vertical::Vertical;

/// Bound of the angle to the direction that real-valued arithmetic refines from the same segments, degrees.
pub const UP_ERROR_DEG: f32 = 0.02;

#[cfg(test)]
mod tests;
