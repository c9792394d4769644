//! The plan in the renderer's form: one byte per cell, with exact rays from cell border to cell border.

use super::panes::Panes;
use crate::interior::Interior;
use crate::plan_import::PlanRaster;

/// What a cell holds; [`FREE`] and above is free floor, the excess over it the chessboard distance to the nearest cell
/// that is not free.
pub(super) const WALL: u8 = 0;
pub(super) const GLASS: u8 = 1;
pub(super) const OUTSIDE: u8 = 2;
pub(super) const FREE: u8 = 3;

/// Rays end here, in metres.
const REACH_M: f64 = 120.0;

/// Surfaces that a ray may pass before it ends.
const MOST_LAYERS: usize = 12;

/// The kind of surface that a ray hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Surface {
    /// Opaque: the ray ends.
    Wall,
    /// Glazing, with the pane's number and the range at which its far side lies.
    Glass(u32, f32),
    /// The outdoors: the ray ends.
    Outdoors,
}

/// A surface on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layer {
    /// Metres on the floor.
    pub(super) range: f32,
    pub(super) surface: Surface,
}

/// The cells of a plan.
#[derive(Debug)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
    cells: Vec<u8>,
    /// Metres per cell.
    pub(super) resolution: f64,
    /// Map position of the outer corner of cell (0, 0).
    pub(super) origin: [f64; 2],
}

impl Grid {
    /// Cells of a plan, with all distances of free cells still unmeasured: see [`Self::measure`]. Without an interior all
    /// that is free is inside.
    pub(super) fn new(raster: &PlanRaster, inside: Option<&Interior>) -> Self {
        let (width, height) = (raster.width as usize, raster.height as usize);
        let mut cells = Vec::with_capacity(width * height);
        for y in 0..raster.height {
            for x in 0..raster.width {
                let free = || inside.is_none_or(|inside| inside.is_inside_px(x, y));
                cells.push(match (raster.is_wall(x, y), raster.is_window(x, y)) {
                    (true, _) => WALL,
                    (false, true) => GLASS,
                    (false, false) if free() => FREE,
                    (false, false) => OUTSIDE,
                });
            }
        }
        let mut grid = Self { width, height, cells, resolution: raster.resolution_m, origin: raster.origin };
        if let Some(inside) = inside {
            grid.grow(inside);
        }
        grid
    }

    /// Extends the inside up to the walls: cells of the interior that hold some wall are not part of it.
    fn grow(&mut self, inside: &Interior) {
        let mut front: Vec<usize> = (0..self.cells.len()).filter(|&at| self.cells[at] == FREE).collect();
        for _ in 0..2 * inside.cell_px {
            let mut next = Vec::new();
            for at in front {
                for there in self.around(at) {
                    if self.cells[there] == OUTSIDE {
                        self.cells[there] = FREE;
                        next.push(there);
                    }
                }
            }
            front = next;
        }
    }

    /// The cells that share a side with this one.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, width) = (at % self.width, self.width);
        let west = (x > 0).then(|| at - 1);
        let east = (x + 1 < width).then_some(at + 1);
        let south = at.checked_sub(width);
        let north = Some(at + width).filter(|&north| north < self.cells.len());
        [west, east, south, north].into_iter().flatten()
    }

    /// Fills in the distances of free cells, in two passes over the plan.
    pub(super) fn measure(&mut self) {
        let (width, height) = (self.width, self.height);
        let near = |cells: &[u8], at: usize, x: usize, row: Option<usize>, back: Option<usize>| {
            let value = |at: usize| cells[at].max(FREE);
            let (Some(row), Some(back)) = (row, back) else { return FREE + 1 };
            let mut least = value(back);
            for there in row + x.saturating_sub(1)..=row + (x + 1).min(width - 1) {
                least = least.min(value(there));
            }
            // Beyond the western and eastern border lies the outside.
            let least = if x == 0 || x + 1 == width { FREE } else { least };
            cells[at].min(least.saturating_add(1))
        };
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                if self.cells[at] >= FREE {
                    self.cells[at] = u8::MAX;
                    let back = (x > 0).then(|| at - 1);
                    self.cells[at] = near(&self.cells, at, x, y.checked_sub(1).map(|y| y * width), back);
                }
            }
        }
        for y in (0..height).rev() {
            for x in (0..width).rev() {
                let at = y * width + x;
                if self.cells[at] >= FREE {
                    let back = (x + 1 < width).then_some(at + 1);
                    let row = (y + 1 < height).then_some((y + 1) * width);
                    self.cells[at] = near(&self.cells, at, x, row, back);
                }
            }
        }
    }

    /// What a cell holds; beyond the plan it is the outdoors.
    pub(super) fn cell(&self, x: i64, y: i64) -> u8 {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return OUTSIDE };
        if x < self.width && y < self.height { self.cells[y * self.width + x] } else { OUTSIDE }
    }

    /// Makes a wall cell free.
    pub(super) fn clear(&mut self, x: usize, y: usize) {
        self.cells[y * self.width + x] = FREE;
    }

    /// A map position in cells.
    pub(super) fn to_cells(&self, x: f64, y: f64) -> [f64; 2] {
        [(x - self.origin[0]) / self.resolution, (y - self.origin[1]) / self.resolution]
    }

    /// What is at a map position.
    pub(super) fn at(&self, x: f64, y: f64) -> u8 {
        let [x, y] = self.to_cells(x, y);
        self.cell(x.floor() as i64, y.floor() as i64)
    }

    /// Metres, at most, from a map position to what is not free floor; 0 where it is not free itself.
    pub(super) fn room(&self, x: f64, y: f64) -> f64 {
        f64::from(self.at(x, y).saturating_sub(FREE)) * self.resolution
    }

    /// Metres from a position to the first surface towards a direction of length 1.
    pub(super) fn range(&self, from: [f64; 2], direction: [f64; 2], panes: &Panes) -> f64 {
        let mut layers = Vec::new();
        self.cast(from, direction, panes, &mut layers);
        layers.first().map_or(0.0, |layer| f64::from(layer.range))
    }

    /// Appends the surfaces that a ray hits from a position in metres towards a direction of length 1, in order; the
    /// last one ends the ray.
    pub(super) fn cast(&self, from: [f64; 2], direction: [f64; 2], panes: &Panes, layers: &mut Vec<Layer>) {
        let mut walk = Walk::new(self.to_cells(from[0], from[1]), direction);
        let end = layers.len() + MOST_LAYERS;
        let reach = REACH_M / self.resolution;
        let metres = |t: f64| (t * self.resolution) as f32;
        let here = |walk: &Walk| self.cell(walk.cell[0], walk.cell[1]);
        // From within a wall the ray starts behind it; from the outdoors it continues until it has entered the
        // building.
        let mut outdoors = here(&walk) == OUTSIDE;
        while here(&walk) < OUTSIDE && walk.t < reach {
            walk.step();
        }
        while walk.t < reach && layers.len() + 1 < end {
            match here(&walk) {
                WALL => {
                    layers.push(Layer { range: metres(walk.t), surface: Surface::Wall });
                    return;
                }
                GLASS => {
                    let (at, cell) = (walk.t, walk.cell);
                    while here(&walk) == GLASS {
                        walk.step();
                    }
                    let pane = panes.number(cell[0], cell[1], self.width);
                    let surface = Surface::Glass(pane, metres(walk.t));
                    layers.push(Layer { range: metres(at), surface });
                }
                OUTSIDE if outdoors => walk.step(),
                OUTSIDE => break,
                free => {
                    outdoors = false;
                    walk.skip(free - FREE);
                }
            }
        }
        layers.push(Layer { range: metres(walk.t), surface: Surface::Outdoors });
    }
}

/// A ray being marched, in cells.
struct Walk {
    from: [f64; 2],
    direction: [f64; 2],
    cell: [i64; 2],
    t: f64,
}

impl Walk {
    fn new(from: [f64; 2], direction: [f64; 2]) -> Self {
        Self { from, direction, cell: from.map(|v| v.floor() as i64), t: 0.0 }
    }

    /// Steps to the next cell.
    fn step(&mut self) {
        let [x, y] = [0, 1].map(|axis| {
            let (d, from) = (self.direction[axis], self.from[axis]);
            let border = self.cell[axis] + i64::from(d > 0.0);
            if d == 0.0 { f64::INFINITY } else { (border as f64 - from) / d }
        });
        let axis = usize::from(y < x);
        self.t = x.min(y).max(self.t);
        self.cell[axis] += if self.direction[axis] > 0.0 { 1 } else { -1 };
    }

    /// Skips free cells, given the distance to the nearest one that is not free.
    fn skip(&mut self, distance: u8) {
        if distance > 1 {
            let largest = self.direction[0].abs().max(self.direction[1].abs());
            self.t += f64::from(distance - 1) / largest;
            self.cell = [0, 1].map(|axis| (self.from[axis] + self.t * self.direction[axis]).floor() as i64);
        }
        self.step();
    }
}
