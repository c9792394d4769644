//! Thresholds and weights of the boundary finder.
//!
//! The weights are those of a conditional logit over slope and row of a direction. See `docs/design.md` for the data that
//! they were fitted to.

/// Smallest percentile edge that normalizes a surface's edges, gray levels: less is noise.
pub(super) const LEAST_SCALE: f32 = 1.0;
/// Percentile of the edges, of those that are not 0, that normalizes them.
pub(super) const PERCENT: u32 = 90;
/// Variance of a mean of edges that noise alone has, squared gray levels.
pub(super) const NOISE_VARIANCE: f32 = 0.35 * 0.35;
/// Fewest known differences whose mean counts.
pub(super) const FEWEST_TAPS: u8 = 3;

/// Weights of the logarithms of strength and significance at widths of 1 and 4 rows, of the region nearer and farther, and of
/// u and u^2, with u from -1 at the first row to 1 at the last; 1/256.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    pub(super) edges: [i32; 4],
    pub(super) region: [i32; 2],
    pub(super) linear: f32,
    pub(super) square: f32,
}

/// 1/256, rounded.
#[expect(clippy::cast_possible_truncation, reason = "weights are below 2^8")]
const fn weight(value: f32) -> i32 {
    (value * 256.0 + if value < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// Floor, with the region.
pub(super) const FLOOR_BY_REGION: Weights = Weights {
    edges: [weight(2.93), weight(1.69), weight(-1.33), weight(0.54)],
    region: [weight(1.09), weight(1.01)],
    linear: 2.75,
    square: -3.31,
};
/// Floor, by edges alone.
pub(super) const FLOOR: Weights =
    Weights { edges: [weight(3.60), 0, weight(1.61), 0], region: [0; 2], linear: 3.25, square: -4.69 };
/// Ceiling.
pub(super) const CEILING: Weights = Weights {
    edges: [weight(2.64), weight(3.39), weight(-1.65), weight(0.23)],
    region: [0; 2],
    linear: 1.91,
    square: -4.70,
};

/// Probability of the image's boundary by its distance from the plan's, from the first distance on; rungs, positive if the
/// image's is farther: walls are thicker than drawn and have skirting boards.
pub(super) const FLOOR_TOLERANCE: (isize, [f32; 7]) = (-2, [0.015, 0.115, 0.28, 0.29, 0.17, 0.085, 0.045]);
/// The same of a ceiling boundary.
pub(super) const CEILING_TOLERANCE: (isize, [f32; 5]) = (-2, [0.08, 0.24, 0.36, 0.24, 0.08]);

/// Share of directions whose boundary is independent of the plan.
pub(super) const OUTLIERS: f32 = 0.5;
/// Fewest known rungs of a bin with evidence.
pub(super) const FEWEST_RUNGS: u8 = 30;

/// Elevations, degrees: the floor near the camera, and the walls around the horizon, below it and above it.
pub(super) const NEAR_DEG: [f32; 2] = [38.0, 62.0];
pub(super) const BELOW_DEG: [f32; 2] = [1.5, 8.0];
pub(super) const ABOVE_DEG: [f32; 2] = [1.5, 14.0];
/// Density of gray levels that both regions have at least.
pub(super) const BASE_DENSITY: f32 = 0.0014;
/// Largest log-likelihood ratio of the region of a cell, nats.
pub(super) const MOST_REGION: f32 = 1.5;
/// Rows on either side of a boundary whose regions count.
pub(super) const REGION_ROWS: usize = 8;

/// Largest shift of the ceiling against the floor, rungs: logarithm of its height above the camera over the camera height.
pub(super) const CEILINGS: [i8; 2] = [-20, 28];
/// Weight of the ceiling's log-likelihood ratio relative to the floor's: 1/2.
pub(crate) const CEILING_SHIFT: u32 = 1;
/// Rungs on either side of the most likely one whose probability counts as confidence in its range.
pub(super) const AGREEING: usize = 2;
/// Smallest and largest height of a ceiling above the floor, metres, for a guess without a plan.
pub(super) const ROOMS_M: [f32; 2] = [2.0, 4.5];
/// Azimuth stride, bins, of the guess of the ceiling: neighbouring bins see the same walls.
pub(super) const VOTE_STRIDE: usize = 3;
