//! The up vector: the vanishing point of vertical lines, from the segments of both cameras.
//!
//! Every segment spans a great circle of the unit sphere. The great circles of parallel lines intersect in two opposite
//! points, their vanishing points (paper: roll and pitch). Seeded RANSAC over pairs of segments searches the vertical one
//! near the up direction of the mounting; iteratively reweighted least squares refines it over the inliers of both cameras
//! together, which cover opposite half-spaces. Two horizontal vanishing points at right angles give the building's axes.
//!
//! Floats are `f32` through `libm` alone, without fused operations, as in [`camera`](crate::vision::camera).

mod arc;
mod axes;
mod search;
mod vertical;
mod verticals;

pub use arc::Arc;
pub use axes::{Axes, building_axes};
pub use search::{LEAST_INLIERS, Parameters, UpHint, vertical};
pub use vertical::Vertical;
pub use verticals::{MOST_VERTICALS, verticals};

/// Bound, in degrees, of the angle between the up vector and the one that `f64` arithmetic refines from the same segments.
pub const UP_ERROR_DEG: f32 = 0.02;

#[cfg(test)]
mod tests;
