//! Walls drawn as lines become solid: narrow places between lines are filled.
//!
//! A wall of a drawing is two parallel lines with caps, a window a few lines between jambs. Free pixels from which no
//! free square of [`CAVITY_M`] can be reached are such cavities. Lines often end a little before the next wall: where no
//! free square of [`OPEN_CAVITY_M`] fits and lines are around but for [`MOST_OPEN`] of the rim, is a cavity as well. One with much
//! glazing around it is glazing, any other is wall. The lines that close a glazing cavity towards the room (sills,
//! frames) become glazing too.

use super::bits::Bits;
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
    let mut free = Bits::free(raster);
    let mut roomy = free.clone();
    roomy.open(closed);
    roomy.flood(&free);
    free.clear(&roomy);
    fill_pieces(raster, free);
    let mut free = Bits::free(raster);
    let mut roomy = free.clone();
    roomy.open(open);
    free.clear(&roomy);
    fill_pieces(raster, free);
}

/// Fills the connected pieces of a mask of narrow places that are cavities.
fn fill_pieces(raster: &mut PlanRaster, narrow: Bits) {
    let (width, height) = (raster.width as usize, raster.height as usize);
    let mut cavities =
        Cavities { left: narrow.clone(), narrow, width, height, stack: Vec::new(), cells: Vec::new() };
    let mut word = 0;
    while let Some((at, start)) = cavities.left.first_from(word) {
        word = at;
        let Rim { walls, windows, open } = cavities.gather(raster, start);
        if open as f64 > MOST_OPEN * (walls + windows + open) as f64 {
            continue;
        }
        let glazed = windows as f64 >= GLAZED * (walls + windows) as f64;
        for &(x, y) in &cavities.cells {
            if glazed { raster.set_window(x, y) } else { raster.set_wall(x, y) }
        }
        if glazed {
            cavities.glaze_lines(raster);
        }
    }
}

/// Sides of the pixels of a piece towards what is around it.
#[derive(Default)]
struct Rim {
    walls: u64,
    windows: u64,
    open: u64,
}

/// Narrow places in pieces.
struct Cavities {
    narrow: Bits,
    /// What no piece has yet.
    left: Bits,
    width: usize,
    height: usize,
    stack: Vec<(u32, u32)>,
    cells: Vec<(u32, u32)>,
}

impl Cavities {
    /// Collects the pixels of the piece at `start` and takes them out.
    fn gather(&mut self, raster: &PlanRaster, start: (u32, u32)) -> Rim {
        self.cells.clear();
        self.stack.clear();
        self.left.take(start);
        self.stack.push(start);
        let mut rim = Rim::default();
        while let Some(at) = self.stack.pop() {
            self.cells.push(at);
            for next in neighbours(at, self.width, self.height) {
                if self.narrow.contains(next) {
                    if self.left.take(next) {
                        self.stack.push(next);
                    }
                } else if raster.is_window(next.0, next.1) {
                    rim.windows += 1;
                } else if raster.is_wall(next.0, next.1) {
                    rim.walls += 1;
                } else {
                    rim.open += 1;
                }
            }
        }
        rim
    }

    /// Makes the lines around the last cavity glazing.
    fn glaze_lines(&mut self, raster: &mut PlanRaster) {
        let steps = (LINE_M / raster.resolution_m).ceil().max(1.0) as usize;
        let mut front = std::mem::take(&mut self.cells);
        for _ in 0..steps {
            let mut next = Vec::new();
            for at in front {
                for (x, y) in neighbours(at, self.width, self.height) {
                    if raster.is_wall(x, y) {
                        raster.set_window(x, y);
                        next.push((x, y));
                    }
                }
            }
            front = next;
        }
    }
}

/// The four neighbours of a pixel on the raster.
fn neighbours((x, y): (u32, u32), width: usize, height: usize) -> impl Iterator<Item = (u32, u32)> {
    let steps = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
    steps.into_iter().filter(move |&(x, y)| (x as usize) < width && (y as usize) < height)
}
