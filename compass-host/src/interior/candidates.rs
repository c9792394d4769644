//! Candidate positions inside: a regular grid, with extra points where it misses narrow places.

use compass_core::base::raster::BitMask;

use super::{Interior, InteriorError, check_same_size};

/// Points along a side of the finer grid that is tried where the grid point is not usable.
const FINER: u32 = 5;
/// A finer point keeps this many spacings from every other candidate.
const APART: f64 = 0.75;

impl Interior {
    /// Positions inside, as plan pixel `[column, row]` with row 0 southernmost.
    ///
    /// The points `(i + 0.5) * spacing_m` from the south-west corner of the plan that are inside
    /// with no occupied pixel nearer than `clearance_m` (between pixel centres). Where such a
    /// point is not usable, its square of `spacing_m` may hold a usable one further than 0.75
    /// spacings from all others: of 5 x 5 points the one with the largest clearance is added. The
    /// order is row by row of the squares. The default clearance is [`CLEARANCE_M`](super::CLEARANCE_M).
    ///
    /// # Errors
    /// [`InteriorError::Size`] when the masks are not of the size of the plan that the interior
    /// was found on; [`InteriorError::Spacing`] below one pixel, [`InteriorError::Clearance`]
    /// below 0, both also when not finite.
    pub fn candidates(
        &self,
        walls: &BitMask<'_>,
        windows: &BitMask<'_>,
        spacing_m: f64,
        clearance_m: f64,
    ) -> Result<Vec<[u16; 2]>, InteriorError> {
        check_same_size(walls, windows)?;
        if (walls.width(), walls.height()) != (self.width_px, self.height_px) {
            return Err(InteriorError::Size(walls.width(), walls.height(), self.width_px, self.height_px));
        }
        let spacing = spacing_m / self.resolution_m;
        if !(spacing.is_finite() && spacing >= 1.0) {
            return Err(InteriorError::Spacing(spacing_m));
        }
        let clearance = clearance_m / self.resolution_m;
        if !(clearance.is_finite() && clearance >= 0.0) {
            return Err(InteriorError::Clearance(clearance_m));
        }
        Ok(Search { interior: self, walls, windows, spacing, clearance }.run())
    }
}

/// One search for candidates; lengths in pixels.
struct Search<'a> {
    interior: &'a Interior,
    walls: &'a BitMask<'a>,
    windows: &'a BitMask<'a>,
    spacing: f64,
    clearance: f64,
}

impl Search<'_> {
    fn run(&self) -> Vec<[u16; 2]> {
        let squares = |side: u32| (f64::from(side) / self.spacing).ceil() as usize;
        let columns = squares(self.interior.width_px);
        let rows = squares(self.interior.height_px);
        let square = |at: usize| [(at % columns) as f64, (at / columns) as f64];
        let mut points: Vec<Option<[u16; 2]>> = (0..columns * rows)
            .map(|at| self.point(square(at), [0.5, 0.5]).filter(|&point| self.is_usable(point)))
            .collect();
        for at in 0..points.len() {
            if points[at].is_none() {
                let near = neighbours(&points, columns, at);
                points[at] = self.finer_point(square(at), &near);
            }
        }
        points.into_iter().flatten().collect()
    }

    /// The pixel at a fractional position of a square; `None` off the plan.
    fn point(&self, square: [f64; 2], share: [f64; 2]) -> Option<[u16; 2]> {
        let x = ((square[0] + share[0]) * self.spacing) as u16;
        let y = ((square[1] + share[1]) * self.spacing) as u16;
        let on_plan = u32::from(x) < self.interior.width_px && u32::from(y) < self.interior.height_px;
        on_plan.then_some([x, y])
    }

    /// The point of the finer grid with the largest clearance that is usable and far enough from others.
    fn finer_point(&self, square: [f64; 2], others: &[[u16; 2]]) -> Option<[u16; 2]> {
        let share = |step: u32| (f64::from(step) + 0.5) / f64::from(FINER);
        let apart2 = (APART * self.spacing).powi(2);
        let mut best: Option<(f64, [u16; 2])> = None;
        for (row, column) in (0..FINER).flat_map(|row| (0..FINER).map(move |column| (row, column))) {
            let Some(point) = self.point(square, [share(column), share(row)]) else { continue };
            let is_apart = others.iter().all(|&other| between2(point, other) > apart2);
            if !is_apart || !self.is_usable(point) {
                continue;
            }
            let clearance2 = self.clearance2(point);
            if best.is_none_or(|(most, _)| clearance2 > most) {
                best = Some((clearance2, point));
            }
        }
        best.map(|(_, point)| point)
    }

    /// Whether a pixel is inside and has the clearance.
    fn is_usable(&self, point: [u16; 2]) -> bool {
        let [x, y] = point.map(u32::from);
        let Some(cell) = self.interior.cell_of(x, y).filter(|&cell| self.interior.inside[cell]) else {
            return false;
        };
        let (least, most) = self.coarse_clearance(cell);
        least >= self.clearance
            || (most >= self.clearance && self.clearance2(point) >= self.clearance * self.clearance)
    }

    /// Bounds of the clearance of any pixel in a free cell: both pixels may lie in a corner of their cells.
    fn coarse_clearance(&self, cell: usize) -> (f64, f64) {
        let side = f64::from(self.interior.cell_px);
        let between = f64::from(self.interior.distance2[cell]).sqrt();
        let slack = core::f64::consts::SQRT_2;
        ((between - slack) * side, (between + slack) * side)
    }

    /// Squared distance to the nearest occupied pixel, exact up to two cells above the requested clearance.
    fn clearance2(&self, point: [u16; 2]) -> f64 {
        let interior = self.interior;
        let [x, y] = point.map(u32::from);
        let cell = interior.cell_px;
        let reach = (self.clearance / f64::from(cell)).ceil() as u32 + 2;
        let limit = f64::from((reach - 1) * cell).powi(2);
        let range = |at: u32, count: usize| {
            let last = (at / cell + reach).min(count as u32 - 1);
            (at / cell).saturating_sub(reach)..=last
        };
        let mut nearest2 = u64::MAX;
        for row in range(y, interior.rows) {
            for column in range(x, interior.columns) {
                if interior.distance2[row as usize * interior.columns + column as usize] == 0 {
                    nearest2 = nearest2.min(self.nearest_in_cell(point, column, row));
                }
            }
        }
        (nearest2 as f64).min(limit)
    }

    /// Squared distance to the nearest occupied pixel of one cell.
    fn nearest_in_cell(&self, point: [u16; 2], column: u32, row: u32) -> u64 {
        let [x0, y0] = point.map(u64::from);
        let cell = self.interior.cell_px;
        let mut nearest2 = u64::MAX;
        for y in row * cell..(row + 1) * cell {
            for x in column * cell..(column + 1) * cell {
                if self.walls.get(x, y) || self.windows.get(x, y) {
                    let (dx, dy) = (x0.abs_diff(u64::from(x)), y0.abs_diff(u64::from(y)));
                    nearest2 = nearest2.min(dx * dx + dy * dy);
                }
            }
        }
        nearest2
    }
}

/// Squared distance of two pixels.
fn between2(a: [u16; 2], b: [u16; 2]) -> f64 {
    let [dx, dy] = [0, 1].map(|axis| f64::from(a[axis]) - f64::from(b[axis]));
    dx * dx + dy * dy
}

/// The points of the up to eight squares around one.
fn neighbours(points: &[Option<[u16; 2]>], columns: usize, at: usize) -> Vec<[u16; 2]> {
    let (column, row) = (at % columns, at / columns);
    let rows = row.saturating_sub(1)..=(row + 1).min(points.len() / columns - 1);
    rows.flat_map(|row| {
        let from = row * columns + column.saturating_sub(1);
        let to = row * columns + (column + 1).min(columns - 1);
        points[from..=to].iter().flatten().copied()
    })
    .collect()
}
