//! Thresholds and weights of the window finder.
//!
//! | group | origin |
//! |---|---|
//! | weights of the cues, penalties on shape | rounded weights of a logistic regression over the boxes of eight rendered frame pairs and two real frames of one building |
//! | [`CONTRAST`], [`BIAS`], [`GLARE`] | then chosen among a dozen rounded values on these, one more real pair and 36 simulated pairs of two floors, by correlation of hit type and evidence with the plan and by recall and precision of windows |
//! | all others | set by hand, not fitted |
//!
//! `docs/design.md` describes the fit. Elevations and angles are degrees of the level frame.

use crate::base::num::{LogOdds, LogWeight};

/// Bits of [`LogWeight`] of 1 nat; logarithms of shapes have as many per octave.
pub(super) const NAT: i32 = LogWeight::ONE.to_bits();

// Near-vertical segments and edges.

/// Largest ratio of azimuth range to elevation range of a vertical segment: tangent of 3 degrees.
pub(super) const LEAN: f32 = 0.052_407_78;
/// Azimuth range, degrees, up to which a short segment may exceed [`LEAN`].
pub(super) const LEAN_DEG: f32 = 0.3;
/// Upper bound of the ratio for short segments: tangent of 12 degrees.
pub(super) const MOST_LEAN: f32 = 0.21;
/// Smallest length of a vertical segment, degrees.
pub(super) const SEGMENT_DEG: f32 = 1.5;
/// Elevation, degrees, above which a segment that begins there belongs to the ceiling.
pub(super) const HIGHEST_DEG: f32 = 12.0;
/// Elevation, degrees, below which a segment that ends there belongs to the floor.
pub(super) const LOWEST_DEG: f32 = -8.0;
/// Largest azimuth gap between consecutive segments of an edge, degrees.
pub(super) const GAP_DEG: f32 = 0.5;
/// Largest azimuth range of an edge's segments, degrees.
pub(super) const SPAN_DEG: f32 = 1.0;
/// Smallest total segment length of an edge, degrees.
pub(super) const EDGE_DEG: f32 = 1.5;

// Planes of brightness rank and texture.

/// Elevation above and below the horizon of the rows that ranks and the texture scale are computed from, degrees.
pub(super) const BAND_DEG: i32 = 15;
/// Percentile of the texture that is mapped to 255.
pub(super) const TEXTURE_PERCENT: u32 = 90;
/// Lower bound of the texture mapped to 255, gray levels: less is noise.
pub(super) const LEAST_TEXTURE: usize = 4;
/// Gray level from which a cell counts as over-exposed, with full texture. By day the over-exposed part of a frame is the
/// outdoors, which then shows no texture, while the wall beside it may be nearly as bright and has some.
pub(super) const GLARE: u8 = 245;

// Geometry of boxes.

/// Smallest width of a window, degrees.
pub(super) const NARROWEST_DEG: i32 = 1;
/// Largest width of a window, degrees.
pub(super) const WIDEST_DEG: i32 = 60;
/// Smallest height that the two edges of a box share, degrees; it must be half of the shorter edge too.
pub(super) const SHARED_DEG: i32 = 2;
/// Elevation, degrees, that the top of a window exceeds.
pub(super) const HIGH_DEG: i32 = 1;
/// Elevation, degrees, that the bottom of a window lies below.
pub(super) const LOW_DEG: i32 = 10;
/// Smallest height of a box, rows.
pub(super) const LEAST_ROWS: i32 = 4;
/// Smallest and largest width of a flank, eighths of a degree; between them it is half the width of the box.
pub(super) const FLANK_EIGHTHS: [usize; 2] = [12, 32];
/// Height searched for lintel and sill outside the box, half degrees.
pub(super) const OUTSIDE_HALVES: usize = 6;
/// Height searched for lintel and sill inside the box, half degrees.
pub(super) const INSIDE_HALVES: usize = 3;
/// Smallest share of known cells of a box, tenths.
pub(super) const BOX_KNOWN_TENTHS: u32 = 6;
/// Share of known cells that a flank must exceed, tenths.
pub(super) const FLANK_KNOWN_TENTHS: u32 = 3;

// Score of a box.

/// Nats for full texture of both the strongest row near the top and that near the bottom.
pub(super) const LINTEL: i32 = 4;
/// Nats per full range of brightness rank between box and flanks.
pub(super) const CONTRAST: i32 = 2;
/// Nats per full range of texture between box and the more textured flank.
pub(super) const TEXTURE: i32 = 8;
/// Score of a box without cues.
pub(super) const BIAS: LogWeight = LogWeight::lit("-3.75");
/// Binary logarithm of width / height above which a box is penalized as wide, 1/[`NAT`].
pub(super) const WIDE_LOG2: i32 = -NAT * 4 / 5;
/// Penalty of wide boxes, half nats per octave.
pub(super) const WIDE_HALVES: i32 = 3;
/// Binary logarithm of width / height below which a box is penalized as narrow, 1/[`NAT`].
pub(super) const NARROW_LOG2: i32 = -2 * NAT;
/// Penalty of narrow boxes, half nats per octave.
pub(super) const NARROW_HALVES: i32 = 4;
/// Score up to which boxes are dropped.
pub(super) const LEAST_SCORE: LogOdds = LogOdds::lit("-4");

// Evidence per direction.

/// Bound of the log odds of a direction: evidence is clamped to its negative and positive value.
pub(super) const MOST_EVIDENCE: LogWeight = LogWeight::lit("4");
/// Elevations, degrees, between which half of a column must be known for the direction to be seen.
pub(super) const SEEN_DEG: [i32; 2] = [-3, 5];
/// Elevations, degrees, between which 4/5 of a column must be known to lie inside the view.
pub(super) const RIM_DEG: [i32; 2] = [-4, 6];
/// Smallest difference of mean brightness rank above and below, as a fraction 1/n of the whole range, that tells sky from
/// ground.
pub(super) const SKY_SHARE: u64 = 50;
