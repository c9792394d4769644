//! Walls drawn as lines become solid: narrow places that lines enclose are filled.
//!
//! A wall of a drawing is two parallel lines with caps, a window a few lines between jambs. Free pixels from which no
//! free square of [`CAVITY_M`] can be reached are such cavities. A cavity with much glazing around it is glazing, any
//! other is wall. The lines that close a glazing cavity towards the room (sills, frames) become glazing too.

use super::bits::Bits;
use super::raster::PlanRaster;

/// Widest cavity in metres: the thickest wall that is drawn as two lines.
pub(super) const CAVITY_M: f64 = 0.8;
/// Share of glazing around a cavity from which it is glazing.
const GLAZED: f64 = 0.25;
/// Width of a line that closes a cavity, in metres.
const LINE_M: f64 = 0.03;

/// Fills the cavities of a plan whose walls are lines and which has a free margin of [`CAVITY_M`] around it.
pub(super) fn fill(raster: &mut PlanRaster) {
    let (width, height) = (raster.width as usize, raster.height as usize);
    let mut free = Bits::free(raster);
    let side = (CAVITY_M / raster.resolution_m).ceil().max(1.0) as usize;
    let mut roomy = free.clone();
    roomy.open(side);
    roomy.flood(&free);
    free.clear(&roomy);
    let mut cavities = Cavities { free, width, height, stack: Vec::new(), cells: Vec::new() };
    let mut word = 0;
    while let Some((at, start)) = cavities.free.first_from(word) {
        word = at;
        let glazed = cavities.gather(raster, start) >= GLAZED;
        for &(x, y) in &cavities.cells {
            if glazed { raster.set_window(x, y) } else { raster.set_wall(x, y) }
        }
        if glazed {
            cavities.glaze_lines(raster);
        }
    }
}

/// The cavities still to fill.
struct Cavities {
    free: Bits,
    width: usize,
    height: usize,
    stack: Vec<(u32, u32)>,
    cells: Vec<(u32, u32)>,
}

impl Cavities {
    /// Collects the pixels of the cavity at `start` and takes them out; the share of glazing among what is around it.
    fn gather(&mut self, raster: &PlanRaster, start: (u32, u32)) -> f64 {
        self.cells.clear();
        self.stack.clear();
        self.free.take(start);
        self.stack.push(start);
        let (mut walls, mut windows) = (0_u64, 0_u64);
        while let Some(at) = self.stack.pop() {
            self.cells.push(at);
            for next in neighbours(at, self.width, self.height) {
                if self.free.take(next) {
                    self.stack.push(next);
                } else if raster.is_window(next.0, next.1) {
                    windows += 1;
                } else if raster.is_wall(next.0, next.1) {
                    walls += 1;
                }
            }
        }
        windows as f64 / (walls + windows).max(1) as f64
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
