//! Brightness over the plan: light diffuses from the glazing through the rooms, on a coarse grid.

use super::grid::{FREE, GLASS, Grid, OUTSIDE, WALL};

/// Side of a cell of light, metres.
const CELL_M: f64 = 0.25;

/// Rounds of diffusion; each carries light one cell further.
const ROUNDS: usize = 240;

/// Share of the light that is lost from cell to cell.
const LOSS: f32 = 0.006;

/// Brightness over the plan, 1 near windows.
#[derive(Debug)]
pub(super) struct Light {
    width: usize,
    height: usize,
    /// Map position of the centre of cell (0, 0).
    first: [f64; 2],
    side: f64,
    values: Vec<f32>,
}

/// The role of a coarse cell in the diffusion.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Blocked,
    Free,
    Source,
}

impl Light {
    pub(super) fn new(grid: &Grid) -> Self {
        let step = (CELL_M / grid.resolution).round().max(1.0) as usize;
        let (width, height) = (grid.width.div_ceil(step), grid.height.div_ceil(step));
        let kinds: Vec<Kind> =
            (0..width * height).map(|at| kind(grid, at % width * step, at / width * step, step)).collect();
        let side = step as f64 * grid.resolution;
        let first = grid.origin.map(|v| v + side / 2.0);
        let mut light = Self { width, height, first, side, values: vec![0.0; width * height] };
        light.spread(&kinds);
        light
    }

    fn spread(&mut self, kinds: &[Kind]) {
        let source = |kind: &Kind| if *kind == Kind::Source { 1.0 } else { 0.0 };
        self.values = kinds.iter().map(source).collect();
        for _ in 0..ROUNDS {
            let before = self.values.clone();
            for (at, kind) in kinds.iter().enumerate() {
                if *kind == Kind::Free {
                    // A wall reflects the light that falls on it.
                    let from = |there: usize| match kinds[there] {
                        Kind::Blocked => before[at] * 0.97,
                        Kind::Free | Kind::Source => before[there],
                    };
                    let sum: f32 = self.around(at).map(from).sum();
                    let count = self.around(at).count() as f32;
                    self.values[at] = sum / count.max(1.0) * (1.0 - LOSS);
                }
            }
        }
        // Walls are as bright as the free cells before them.
        for _ in 0..2 {
            let before = self.values.clone();
            for at in (0..kinds.len()).filter(|&at| kinds[at] == Kind::Blocked && before[at] == 0.0) {
                let indoors = |there: &usize| kinds[*there] != Kind::Source && before[*there] > 0.0;
                let lit = || self.around(at).filter(indoors).map(|there| before[there]);
                self.values[at] = lit().sum::<f32>() / (lit().count() as f32).max(1.0);
            }
        }
    }

    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, width, len) = (at % self.width, self.width, self.width * self.height);
        let sides = [
            (x > 0).then(|| at - 1),
            (x + 1 < width).then_some(at + 1),
            at.checked_sub(width),
            Some(at + width).filter(|&v| v < len),
        ];
        sides.into_iter().flatten()
    }

    /// Brightness at a map position.
    pub(super) fn at(&self, x: f32, y: f32) -> f32 {
        let place = |v: f32, first: f64, len: usize| {
            let v = ((f64::from(v) - first) / self.side).clamp(0.0, (len - 1) as f64);
            let low = (v as usize).min(len.saturating_sub(2));
            (low, (v - low as f64) as f32)
        };
        let (column, fx) = place(x, self.first[0], self.width);
        let (row, fy) = place(y, self.first[1], self.height);
        let value = |dx: usize, dy: usize| {
            let (x, y) = ((column + dx).min(self.width - 1), (row + dy).min(self.height - 1));
            self.values[y * self.width + x]
        };
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let v = mix(mix(value(0, 0), value(1, 0), fx), mix(value(0, 1), value(1, 1), fx), fy);
        // Rooms without windows are lit by lamps.
        0.16 + 1.1 * v
    }
}

/// The prevailing role in a coarse cell from (x, y).
fn kind(grid: &Grid, x: usize, y: usize, step: usize) -> Kind {
    let (mut walls, mut glass, mut outside) = (0, 0, 0);
    for y in y..(y + step).min(grid.height) {
        for x in x..(x + step).min(grid.width) {
            match grid.cell(x as i64, y as i64) {
                WALL => walls += 1,
                GLASS => glass += 1,
                OUTSIDE => outside += 1,
                _ => debug_assert!(grid.cell(x as i64, y as i64) >= FREE),
            }
        }
    }
    match (glass, walls, outside) {
        (_, _, outside) if 2 * outside > step * step => Kind::Source,
        // A line through the cell is as long as its side.
        (0, walls, _) if 4 * walls >= 3 * step => Kind::Blocked,
        _ => Kind::Free,
    }
}
