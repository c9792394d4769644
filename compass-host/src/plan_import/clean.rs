//! Pictures of plans without their text, dimensions, door arcs, furniture and hatching: what is left is thick.
//!
//! 1. Isolated pieces below [`SMALL_M`] go, such as letters. Columns stay: thick pieces at most twice as long as wide.
//!    Walls that touch glazing are one piece with it.
//! 2. Cavities between the two lines of a wall are filled ([`cavities`]).
//! 3. Strokes stay that are as thick as asked, in any direction: those that hold a square with that diagonal. Whatever
//!    is thinner than 0.7 of it goes; in between it depends on the direction.
//! 4. Corners and ends of these strokes come back: what is connected with them within half of the square's side.
//! 5. Isolated pieces below [`SMALL_M`] go again, and below [`SMALL_FILLED_M`] where all of them is filled: arrows, words.
//!
//! Glazing is drawn with thin lines and stays as it is.

use super::bits::Bits;
use super::cavities;
use super::classify::Masks;
use super::pieces::{Pieces, Touch};

/// Extent below which an isolated piece is no wall, metres.
const SMALL_M: f64 = 0.6;
/// The same of a piece that has nothing thick but filled cavities.
const SMALL_FILLED_M: f64 = 2.0;

/// Thickest bound accepted, metres.
pub(super) const MOST_THICKNESS_M: f64 = 2.0;

/// What was done to a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cleaned {
    /// Wall pixels that were removed, percent of those before.
    pub(super) percent: u64,
    /// In how many pieces.
    pub(super) pieces: usize,
    /// How many cavities were filled that are now wall.
    pub(super) cavities: usize,
}

/// Pixels along a side of the square that a stroke has to hold; `None` for a bound that is no thickness or not above a
/// pixel and a half: it removes nothing.
pub(super) fn square(thickness_m: f64, pixel_m: f64) -> Option<usize> {
    let is_thickness = thickness_m <= MOST_THICKNESS_M && thickness_m >= 1.5 * pixel_m;
    is_thickness.then(|| (thickness_m * core::f64::consts::FRAC_1_SQRT_2 / pixel_m).ceil() as usize)
}

/// Removes from the walls of a plan of `size` pixels what holds no square of `side` pixels and is not part of a stroke
/// that does.
pub(super) fn clean(masks: &mut Masks, size: [u32; 2], side: usize, pixel_m: f64) -> Cleaned {
    let [walls, windows] = [&masks.walls, &masks.windows].map(|mask| Bits::new(mask, size[0], size[1]));
    let mut thick = walls.clone();
    thick.open(side);
    let lines = without_small(&walls, &thick, &windows, [SMALL_M; 2], pixel_m);
    let solid = lines.or(&cavities::of(&lines, &thick, &windows, pixel_m));
    let mut kept = solid.clone();
    kept.open(side);
    kept.grow_within(&solid, side.div_ceil(2));
    let kept = without_small(&kept, &thick, &windows, [SMALL_M, SMALL_FILLED_M], pixel_m);
    masks.walls = kept.to_bytes();
    let removed = walls.without(&kept);
    let filled = kept.without(&walls);
    Cleaned {
        percent: (200 * removed.count() / walls.count().max(1)).div_ceil(2),
        pieces: Pieces::of(&removed, Touch::Corners).pieces.len(),
        cavities: Pieces::of(&filled, Touch::Sides).pieces.len(),
    }
}

/// The walls that are no isolated small piece, or a column.
///
/// `least_m` are the extents in metres of pieces with and without something thick in them.
fn without_small(walls: &Bits, thick: &Bits, windows: &Bits, least_m: [f64; 2], pixel_m: f64) -> Bits {
    let pieces = Pieces::of(&walls.or(windows), Touch::Corners);
    let thick = pieces.covered(thick);
    let stays = |at: usize| {
        let [long, short] = pieces.pieces[at].sides();
        let is_column = long <= 2 * short && 4 * thick[at] >= 3 * u64::from(long) * u64::from(short);
        f64::from(long) * pixel_m >= least_m[usize::from(thick[at] == 0)] || is_column
    };
    pieces.selected([walls.width, walls.height], stays).without(windows)
}

#[cfg(test)]
mod tests;
