//! Walls drawn as two lines with a cavity between them, or with hatching in it: which free pixels are such a cavity.
//!
//! A cavity is a connected part of the free pixels where no square of [`MOST_CAVITY_M`] fits, and
//! - hardly any of its border is open: it does not lead into a room, as a narrow passage does;
//! - little of its border is glazing: panes between two lines are windows;
//! - not much of its border is thick: a dimension line beside a wall is no second line of it; and none of it where the
//!   part is short, for the lines across a doorway between thick walls are no wall;
//! - most of it is not *crowded*. Free pieces below [`SMALL_M2`] (treads, tiles, the sector that a door sweeps) and walls
//!   together are crowded where a square of [`MOST_CAVITY_M`] fits: a stair is no thick wall, and the lines across a
//!   doorway with a swinging door are not one either.

use super::bits::Bits;
use super::pieces::{Pieces, Run, Touch};

/// Walls of two lines are thinner than this, metres.
const MOST_CAVITY_M: f64 = 0.5;
/// Free pieces below this are parts of a drawing and no rooms, square metres.
const SMALL_M2: f64 = 1.2;
/// Most of the border of a cavity that may be open, percent: the end of two lines that nothing closes.
const MOST_OPEN_PERCENT: u64 = 15;
/// Most of the border of a cavity that may be glazing, percent.
const MOST_GLAZING_PERCENT: u64 = 25;

/// Most of the border of a cavity that may be thick walls, percent.
const MOST_THICK_PERCENT: u64 = 30;

/// A cavity that ends at a thick wall is at least this long, metres.
const LEAST_LENGTH_M: f64 = 2.5;

/// Sides of a piece's pixels by what is beyond them.
#[derive(Debug, Clone, Copy, Default)]
struct Border {
    line: u64,
    thick: u64,
    glazing: u64,
    open: u64,
}

impl Border {
    /// Whether it can be that of a cavity, which is short or long.
    const fn is_closed(self, is_long: bool) -> bool {
        let all = self.line + self.thick + self.glazing + self.open;
        100 * self.open <= MOST_OPEN_PERCENT * all
            && 100 * self.glazing <= MOST_GLAZING_PERCENT * all
            && 100 * self.thick <= if is_long { MOST_THICK_PERCENT * all } else { 0 }
    }
}

/// What lies beside free pixels.
struct Beside<'a> {
    walls: &'a Bits,
    /// The walls that are thick without a cavity.
    thick: &'a Bits,
    windows: &'a Bits,
    narrow: &'a Bits,
}

/// The pixels of all cavities. `thick` has the walls that are thick without one.
pub(super) fn of(walls: &Bits, thick: &Bits, windows: &Bits, pixel_m: f64) -> Bits {
    let size = [walls.width, walls.height];
    let free = walls.or(windows).inverted();
    let side = (MOST_CAVITY_M / pixel_m).round().max(1.0) as usize;
    let mut wide = free.clone();
    wide.open(side);
    let narrow = free.without(&wide);
    let pieces = Pieces::of(&narrow, Touch::Sides);
    let mut borders = vec![Border::default(); pieces.pieces.len()];
    let beside = Beside { walls, thick, windows, narrow: &narrow };
    for run in &pieces.runs {
        beside.add(run, &mut borders[run.piece]);
    }
    let covered = pieces.covered(&crowded(walls, &free, side, pixel_m));
    pieces.selected(size, |at| {
        let piece = &pieces.pieces[at];
        let is_long = f64::from(piece.sides()[0]) * pixel_m >= LEAST_LENGTH_M;
        borders[at].is_closed(is_long) && 2 * covered[at] < piece.area
    })
}

/// Where walls and small free pieces together hold a square of `side` pixels.
fn crowded(walls: &Bits, free: &Bits, side: usize, pixel_m: f64) -> Bits {
    let [width, height] = [walls.width, walls.height];
    let pieces = Pieces::of(free, Touch::Sides);
    let small = pieces.selected([width, height], |at| {
        let piece = &pieces.pieces[at];
        let is_cut = piece.x[0] == 0 || piece.y[0] == 0 || piece.x[1] == width || piece.y[1] == height;
        !is_cut && piece.area as f64 * pixel_m * pixel_m < SMALL_M2
    });
    let mut crowded = walls.or(&small);
    crowded.open(side);
    crowded
}

impl Beside<'_> {
    /// Adds the sides of a run's pixels. Beyond the plan all is open.
    fn add(&self, run: &Run, border: &mut Border) {
        run.beside(|x, y| {
            if self.thick.get(x, y) {
                border.thick += 1;
            } else if self.walls.get(x, y) {
                border.line += 1;
            } else if self.windows.get(x, y) {
                border.glazing += 1;
            } else if !self.narrow.get(x, y) {
                border.open += 1;
            }
        });
    }
}
