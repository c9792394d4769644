//! Walls drawn as lines become solid: narrow places between lines are filled.
//!
//! A wall of a drawing is two parallel lines with caps, a window a few lines between jambs. Free pixels from which no
//! free square of [`CAVITY_M`] can be reached are such cavities. Lines often end a little before the next wall: where no
//! free square of [`OPEN_CAVITY_M`] fits and lines are around but for [`MOST_OPEN`] of the rim, is a cavity as well.
//! One with much glazing around it is glazing, any other is wall. The lines that close a glazing cavity towards the
//! room (sills, frames) become glazing too.

use super::bits::Bits;
use super::pieces::{Pieces, Run, Touch};
use super::raster::PlanRaster;

/// Widest cavity in metres: the thickest wall that is drawn as two lines.
pub(super) const CAVITY_M: f64 = 0.8;
/// Widest cavity with open ends, in metres: narrower than any passage.
const OPEN_CAVITY_M: f64 = 0.5;
/// Largest share of the rim of a cavity that is open.
const MOST_OPEN: f64 = 0.15;
/// Share of glazing around a cavity from which it is glazing.
const GLAZED: f64 = 0.25;
/// Width of a line that closes a cavity, in metres.
const LINE_M: f64 = 0.03;

/// Fills the cavities of a plan whose walls are lines and which has a free margin of [`CAVITY_M`] around it.
pub(super) fn fill(raster: &mut PlanRaster) {
    let side = |metres: f64| (metres / raster.resolution_m).ceil().max(1.0) as usize;
    let [closed, open] = [side(CAVITY_M), side(OPEN_CAVITY_M)];
    let free = Bits::occupied(raster).inverted();
    let mut roomy = free.clone();
    roomy.open(closed);
    roomy.flood(&free);
    fill_pieces(raster, &free.without(&roomy));
    let free = Bits::occupied(raster).inverted();
    let mut roomy = free.clone();
    roomy.open(open);
    fill_pieces(raster, &free.without(&roomy));
}

/// Fills the connected pieces of a mask of narrow places that are cavities.
fn fill_pieces(raster: &mut PlanRaster, narrow: &Bits) {
    let pieces = Pieces::of(narrow, Touch::Sides);
    let mut rims = vec![Rim::default(); pieces.pieces.len()];
    for run in &pieces.runs {
        rims[run.piece].add(raster, narrow, run);
    }
    for run in pieces.runs.iter().filter(|run| rims[run.piece].is_closed()) {
        for x in run.from..run.to {
            if rims[run.piece].is_glazed() { raster.set_window(x, run.y) } else { raster.set_wall(x, run.y) }
        }
    }
    let glazed = pieces.runs.iter().filter(|run| rims[run.piece].is_closed() && rims[run.piece].is_glazed());
    let cells: Vec<(u32, u32)> = glazed.flat_map(|run| (run.from..run.to).map(|x| (x, run.y))).collect();
    glaze_lines(raster, cells);
}

/// Sides of the pixels of a piece towards what is around it.
#[derive(Debug, Clone, Copy, Default)]
struct Rim {
    walls: u64,
    windows: u64,
    open: u64,
}

impl Rim {
    fn add(&mut self, raster: &PlanRaster, narrow: &Bits, run: &Run) {
        run.beside(|x, y| {
            if raster.is_window(x, y) {
                self.windows += 1;
            } else if raster.is_wall(x, y) {
                self.walls += 1;
            } else if !narrow.get(x, y) {
                self.open += 1;
            }
        });
    }

    fn is_closed(&self) -> bool {
        self.open as f64 <= MOST_OPEN * (self.walls + self.windows + self.open) as f64
    }

    fn is_glazed(&self) -> bool {
        self.windows as f64 >= GLAZED * (self.walls + self.windows) as f64
    }
}

/// Makes the lines around cavities glazing.
fn glaze_lines(raster: &mut PlanRaster, cells: Vec<(u32, u32)>) {
    let steps = (LINE_M / raster.resolution_m).ceil().max(1.0) as usize;
    let mut front = cells;
    for _ in 0..steps {
        let mut next = Vec::new();
        for (x, y) in front {
            for (x, y) in [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)] {
                if raster.is_wall(x, y) {
                    raster.set_window(x, y);
                    next.push((x, y));
                }
            }
        }
        front = next;
    }
}
