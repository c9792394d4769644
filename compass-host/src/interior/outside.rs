//! Distance to the outside, which distinguishes a facade from an inner wall.

use super::Interior;
use super::grid::Grid;

impl Interior {
    /// For every cell, row by row from the south, whether the outside is within `reach_m` metres of it.
    ///
    /// Outside is every place connected with the border of the plan over free cells that are not inside; an enclosed
    /// shaft is not.
    #[must_use]
    pub fn near_outside(&self, reach_m: f64) -> Vec<bool> {
        let margin = 1;
        let (columns, rows) = (self.columns + 2 * margin, self.rows + 2 * margin);
        let mut closed = vec![false; columns * rows];
        for (y, row) in closed.chunks_mut(columns).skip(margin).take(self.rows).enumerate() {
            let cells = y * self.columns..(y + 1) * self.columns;
            let cells = self.inside[cells.clone()].iter().zip(&self.distance2[cells]);
            for (closed, (&inside, &distance2)) in row[margin..].iter_mut().zip(cells) {
                *closed = inside || distance2 == 0;
            }
        }
        let grid = Grid { columns, rows, margin, occupied: closed };
        let outside = grid.flood_from_border(|at| !grid.occupied[at]);
        let reach = reach_m / (f64::from(self.cell_px) * self.resolution_m);
        let near = |distance2: &i32| f64::from(*distance2) <= reach * reach;
        let near: Vec<bool> = grid.distance2(&outside).iter().map(near).collect();
        grid.without_margin(&near)
    }

    /// The index in [`inside`](Self::inside) of the cell of pixel `x`, `y`; `None` off the plan.
    #[must_use]
    pub fn cell(&self, x: u32, y: u32) -> Option<usize> {
        self.cell_of(x, y)
    }
}
