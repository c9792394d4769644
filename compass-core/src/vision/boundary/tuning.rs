//! Thresholds and weights of the boundary finder.
//!
//! | constants | origin |
//! |---|---|
//! | [`WEIGHTS`], [`PRIOR_LINEAR`], [`PRIOR_SQUARE`] | conditional logit over the rungs of a direction, fitted to 36 simulated frame pairs (two floors, three styles, with clutter, people and up to 40 % of the partitions missing) |
//! | all others | set by hand, not fitted |
//!
//! `docs/design.md` describes the fit.

#[cfg(doc)]
use crate::base::num::{EdgeNats, SupportNats};

/// Percentile of the frame's edges that normalizes them.
pub(super) const PERCENT: u32 = 90;
/// Lower bound of the normalizing edge, gray levels: less is noise.
pub(super) const LEAST_SCALE: u32 = 3;
/// Bins on either side whose edges support an edge; at distance d, rungs up to d away count.
pub(super) const REACH: usize = 3;
/// Per surface (floor, ceiling), weight of a cell's edge and of the sum of its supports, 1/256: bits of [`SupportNats`]
/// per bit of [`EdgeNats`].
pub(super) const WEIGHTS: [[u32; 2]; 2] = [[23, 23], [45, 74]];

/// Coefficient of x in the log prior of a range, 1/1600 nat; x is -1 at the first rung of the range ladder and 1 at the
/// last, for the nominal camera height.
pub(super) const PRIOR_LINEAR: i32 = 2080;
/// Coefficient of -x^2 in the log prior of a range, 1/1600 nat.
pub(super) const PRIOR_SQUARE: i32 = 4592;
/// Outlier rate: probability that the evidence of a direction is independent of the plan, 1/10.
pub(super) const OUTLIERS_TENTHS: u32 = 3;
/// Rungs on either side of the most likely one whose probability counts as confidence in its range.
pub(super) const AGREEING: usize = 2;

/// Smallest and largest shift of the ceiling, rungs: logarithm of its height above the camera over the camera height.
pub(super) const CEILINGS: [i8; 2] = [-16, 28];
/// Smallest and largest height of a ceiling above the floor, metres.
pub(super) const ROOMS_M: [f32; 2] = [2.0, 4.5];
/// Azimuth stride, bins, of the vote for the ceiling: neighbouring bins see the same walls.
pub(super) const VOTE_STRIDE: usize = 3;
