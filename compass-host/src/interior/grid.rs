//! Cells of a plan with a free margin: occupancy, exact distances, flood fill from the outside.

use compass_core::base::raster::BitMask;

/// Distance of a cell when nothing is marked; its square leaves headroom for a sum.
const FAR: i32 = 20_000;

/// Occupied cells, row by row from the south, with a margin of free cells on all sides.
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) margin: usize,
    pub(super) occupied: Vec<bool>,
}

impl Grid {
    /// Cells of `cell_px` pixels, occupied when any pixel in either mask is.
    pub(super) fn new(walls: &BitMask<'_>, windows: &BitMask<'_>, cell_px: u32, margin: usize) -> Self {
        let columns = walls.width().div_ceil(cell_px) as usize + 2 * margin;
        let rows = walls.height().div_ceil(cell_px) as usize + 2 * margin;
        let mut occupied = vec![false; columns * rows];
        for y in 0..walls.height() {
            let start = ((y / cell_px) as usize + margin) * columns + margin;
            // Whole bytes first: most are empty.
            for column in 0..walls.width().div_ceil(8) {
                if walls.byte(column, y) | windows.byte(column, y) != 0 {
                    for x in (8 * column..8 * column + 8).filter(|&x| walls.get(x, y) || windows.get(x, y)) {
                        occupied[start + (x / cell_px) as usize] = true;
                    }
                }
            }
        }
        Self { columns, rows, margin, occupied }
    }

    /// Columns and rows without the margin.
    pub(super) const fn plan_size(&self) -> (usize, usize) {
        (self.columns - 2 * self.margin, self.rows - 2 * self.margin)
    }

    /// The index of a cell of the plan, counted without the margin.
    pub(super) const fn at(&self, column: usize, row: usize) -> usize {
        (row + self.margin) * self.columns + column + self.margin
    }

    /// The cells of the plan without the margin.
    pub(super) fn without_margin<T: Copy>(&self, cells: &[T]) -> Vec<T> {
        let (columns, rows) = self.plan_size();
        cells
            .chunks(self.columns)
            .skip(self.margin)
            .take(rows)
            .flat_map(|row| &row[self.margin..self.margin + columns])
            .copied()
            .collect()
    }

    /// Squared Euclidean distance from every cell centre to the nearest marked one, in cells.
    /// Exact (Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in linear time",
    /// 2000) up to [`FAR`]; larger distances are only known to exceed it.
    pub(super) fn distance2(&self, marked: &[bool]) -> Vec<i32> {
        let mut distance = self.along_columns(marked);
        let mut parabolas = Vec::with_capacity(self.columns);
        let mut row2 = vec![0; self.columns];
        for row in distance.chunks_mut(self.columns) {
            lower_envelope(row, &mut parabolas, &mut row2);
            row.copy_from_slice(&row2);
        }
        distance
    }

    /// Distance along the column to the nearest marked cell, at most [`FAR`].
    fn along_columns(&self, marked: &[bool]) -> Vec<i32> {
        let columns = self.columns;
        let mut distance: Vec<i32> = marked.iter().map(|&marked| if marked { 0 } else { FAR }).collect();
        for at in columns..distance.len() {
            distance[at] = distance[at].min(distance[at - columns] + 1);
        }
        for at in (columns..distance.len()).rev() {
            distance[at - columns] = distance[at - columns].min(distance[at] + 1);
        }
        distance
    }

    /// The cells that a disc of `radius` cells covers when it rolls in from beyond the plan.
    ///
    /// The centre keeps `radius` from the nearer edge of every occupied cell, so that no opening
    /// up to the diameter lets it pass.
    pub(super) fn outside(&self, distance2: &[i32], radius: f64) -> Vec<bool> {
        let keep2 = (radius + 0.5) * (radius + 0.5);
        let centres = self.flood_from_border(|at| f64::from(distance2[at]) > keep2);
        let cover = self.distance2(&centres);
        cover.iter().map(|&d2| f64::from(d2) <= keep2).collect()
    }

    /// The cells where `open` that are 4-connected with the border of the grid.
    pub(super) fn flood_from_border(&self, open: impl Fn(usize) -> bool) -> Vec<bool> {
        let (columns, cells) = (self.columns, self.occupied.len());
        let ends = (0..columns).chain(cells - columns..cells);
        let sides = (0..self.rows).flat_map(|row| [row * columns, (row + 1) * columns - 1]);
        self.flood(ends.chain(sides), open)
    }

    /// The cells where `open` that are 4-connected with one of `starts`.
    pub(super) fn flood(
        &self,
        starts: impl IntoIterator<Item = usize>,
        open: impl Fn(usize) -> bool,
    ) -> Vec<bool> {
        let mut reached = vec![false; self.occupied.len()];
        let mut stack = Vec::new();
        for at in starts {
            if !reached[at] && open(at) {
                reached[at] = true;
                stack.push(at);
            }
            while let Some(at) = stack.pop() {
                for next in self.neighbours(at) {
                    if !reached[next] && open(next) {
                        reached[next] = true;
                        stack.push(next);
                    }
                }
            }
        }
        reached
    }

    /// Clears every 4-connected piece of fewer than `least` cells or with less than half of them `sure`.
    pub(super) fn drop_pieces(&self, cells: &mut [bool], least: usize, sure: impl Fn(usize) -> bool) {
        let mut seen = vec![false; cells.len()];
        let mut piece = Vec::new();
        for start in 0..cells.len() {
            if !cells[start] || seen[start] {
                continue;
            }
            piece.clear();
            piece.push(start);
            seen[start] = true;
            let mut done = 0;
            while let Some(&at) = piece.get(done) {
                done += 1;
                for next in self.neighbours(at) {
                    if cells[next] && !seen[next] {
                        seen[next] = true;
                        piece.push(next);
                    }
                }
            }
            let half_sure = 2 * piece.iter().filter(|&&at| sure(at)).count() >= piece.len();
            if piece.len() < least || !half_sure {
                piece.iter().for_each(|&at| cells[at] = false);
            }
        }
    }

    /// The 4-neighbours of a cell; at the border a neighbour off the grid is the cell itself.
    fn neighbours(&self, at: usize) -> [usize; 4] {
        let (columns, x) = (self.columns, at % self.columns);
        [
            if x > 0 { at - 1 } else { at },
            if x + 1 < columns { at + 1 } else { at },
            if at >= columns { at - columns } else { at },
            if at + columns < self.occupied.len() { at + columns } else { at },
        ]
    }
}

/// For every `x` of a row, the least `(x - i)^2 + row[i]^2`, into `row2`.
///
/// `parabolas` is scratch: apex and first `x` of the stretch where that parabola is the lowest.
fn lower_envelope(row: &[i32], parabolas: &mut Vec<(i32, i32)>, row2: &mut [i32]) {
    parabolas.clear();
    let count = i32::try_from(row.len()).unwrap_or(FAR);
    let value = |x: i32, apex: i32| (x - apex) * (x - apex) + row[apex as usize] * row[apex as usize];
    for apex in (0..count).filter(|&x| row[x as usize] < FAR) {
        while parabolas.last().is_some_and(|&(top, from)| value(from, top) > value(from, apex)) {
            parabolas.pop();
        }
        // The new parabola is lower from the first integer right of the intersection with the top.
        let from = parabolas.last().map_or(0, |&(top, _)| {
            let rise = value(0, apex) - value(0, top);
            1 + rise.div_euclid(2 * (apex - top))
        });
        if from < count {
            parabolas.push((apex, from));
        }
    }
    row2.fill(FAR * FAR);
    for (at, &(apex, from)) in parabolas.iter().enumerate() {
        let to = parabolas.get(at + 1).map_or(count, |&(_, next)| next);
        for x in from..to {
            row2[x as usize] = value(x, apex);
        }
    }
}
