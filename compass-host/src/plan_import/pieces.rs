//! The connected pieces of a mask, as runs of pixels. Cost: linear in the number of runs.

use super::bits::Bits;

/// What counts as connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Touch {
    /// Pixels that share a side.
    Sides,
    /// Pixels that share a side or a corner.
    Corners,
}

/// A run of set pixels, `from..to` in row `y`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) y: u32,
    pub(super) from: u32,
    pub(super) to: u32,
    /// The number of its piece.
    pub(super) piece: usize,
}

impl Run {
    /// Calls `look` with every pixel that shares a side with one of the run, the run's own ends apart; columns and rows
    /// beyond the mask wrap around to large numbers.
    pub(super) fn beside(&self, mut look: impl FnMut(u32, u32)) {
        look(self.from.wrapping_sub(1), self.y);
        look(self.to, self.y);
        for x in self.from..self.to {
            look(x, self.y.wrapping_sub(1));
            look(x, self.y + 1);
        }
    }
}

/// Size and place of a piece, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) area: u64,
    /// Lowest column and one past the highest.
    pub(super) x: [u32; 2],
    /// Lowest row and one past the highest.
    pub(super) y: [u32; 2],
}

impl Piece {
    /// The sides of its bounding box, the longer one first.
    pub(super) fn sides(&self) -> [u32; 2] {
        let (width, height) = (self.x[1] - self.x[0], self.y[1] - self.y[0]);
        [width.max(height), width.min(height)]
    }
}

/// All pieces of a mask, in the order of their first pixels.
#[derive(Debug)]
pub(super) struct Pieces {
    pub(super) runs: Vec<Run>,
    pub(super) pieces: Vec<Piece>,
}

impl Pieces {
    pub(super) fn of(mask: &Bits, touch: Touch) -> Self {
        let reach = u32::from(touch == Touch::Corners);
        let mut runs: Vec<Run> = Vec::new();
        let mut parents: Vec<usize> = Vec::new();
        let mut before = 0..0;
        for y in 0..mask.height {
            let start = runs.len();
            for [from, to] in mask.runs(y) {
                parents.push(runs.len());
                runs.push(Run { y, from, to, piece: 0 });
            }
            let (mut below, mut here) = (before.start, start);
            while below < before.end && here < runs.len() {
                if runs[below].from < runs[here].to + reach && runs[here].from < runs[below].to + reach {
                    join(&mut parents, below, here);
                }
                if runs[below].to < runs[here].to { below += 1 } else { here += 1 }
            }
            before = start..runs.len();
        }
        let mut found = Self { runs, pieces: Vec::new() };
        found.number(&mut parents);
        found
    }

    /// Numbers the pieces and measures them.
    fn number(&mut self, parents: &mut [usize]) {
        // A root is the first run of its piece.
        for at in 0..self.runs.len() {
            let root = root_of(parents, at);
            let Run { y, from, to, .. } = self.runs[at];
            if root == at {
                self.runs[at].piece = self.pieces.len();
                self.pieces.push(Piece { area: 0, x: [from, to], y: [y, y + 1] });
            }
            let number = self.runs[root].piece;
            self.runs[at].piece = number;
            let piece = &mut self.pieces[number];
            piece.area += u64::from(to - from);
            piece.x = [piece.x[0].min(from), piece.x[1].max(to)];
            piece.y[1] = y + 1;
        }
    }

    /// The pixels of the pieces that are selected by number.
    pub(super) fn selected(&self, size: [u32; 2], select: impl Fn(usize) -> bool) -> Bits {
        let mut mask = Bits::empty(size[0], size[1]);
        for run in self.runs.iter().filter(|run| select(run.piece)) {
            mask.set_run(run.y, run.from, run.to);
        }
        mask
    }

    /// How many pixels of each piece are set in a mask.
    pub(super) fn covered(&self, mask: &Bits) -> Vec<u64> {
        let mut covered = vec![0; self.pieces.len()];
        for run in &self.runs {
            covered[run.piece] += (run.from..run.to).filter(|&x| mask.get(x, run.y)).count() as u64;
        }
        covered
    }
}

/// Joins the sets of two runs; the root is the lower one.
fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root_of(parents, a), root_of(parents, b));
    parents[a.max(b)] = a.min(b);
}

fn root_of(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Pieces by flooding, as the sorted areas.
    fn flooded(mask: &Bits, touch: Touch) -> Vec<u64> {
        let mut left = mask.clone();
        let mut areas = Vec::new();
        for (x, y) in (0..mask.height).flat_map(|y| (0..mask.width).map(move |x| (x, y))) {
            if !left.get(x, y) {
                continue;
            }
            let mut piece = Bits::empty(mask.width, mask.height);
            piece.set_run(y, x, x + 1);
            let mut before = 0;
            while piece.count() > before {
                before = piece.count();
                let mut grown = piece.clone();
                grown.grow_within(&left, 1);
                if touch == Touch::Sides {
                    grown = sides_only(&piece, &grown);
                }
                piece = grown;
            }
            areas.push(piece.count());
            left = left.without(&piece);
        }
        areas.sort_unstable();
        areas
    }

    /// Of a grown piece the pixels that share a side with it.
    fn sides_only(piece: &Bits, grown: &Bits) -> Bits {
        let mut kept = piece.clone();
        for (x, y) in (0..piece.height).flat_map(|y| (0..piece.width).map(move |x| (x, y))) {
            let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
            if grown.get(x, y) && beside.iter().any(|&(x, y)| piece.get(x, y)) {
                kept.set_run(y, x, x + 1);
            }
        }
        kept
    }

    proptest! {
        #[test]
        fn pieces_are_those_of_flooding(width in 1_u32..70, seed in proptest::collection::vec(0_u32..3, 300)) {
            let mut mask = Bits::empty(width, 4);
            for (at, _) in seed.iter().enumerate().filter(|(at, cell)| **cell > 0 && *at < 4 * width as usize) {
                let (x, y) = (at as u32 % width, at as u32 / width);
                mask.set_run(y, x, x + 1);
            }
            for touch in [Touch::Sides, Touch::Corners] {
                let found = Pieces::of(&mask, touch);
                let mut areas: Vec<u64> = found.pieces.iter().map(|piece| piece.area).collect();
                areas.sort_unstable();
                prop_assert_eq!(areas, flooded(&mask, touch));
                prop_assert_eq!(found.selected([width, 4], |_| true), mask.clone());
                prop_assert_eq!(found.covered(&mask), found.pieces.iter().map(|piece| piece.area).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_piece_knows_its_box() {
        let mut mask = Bits::empty(100, 9);
        (2..7).for_each(|y| mask.set_run(y, 60, 63));
        mask.set_run(4, 60, 80);
        mask.set_run(8, 0, 1);
        let found = Pieces::of(&mask, Touch::Sides);
        assert_eq!(found.pieces.len(), 2);
        let piece = found.pieces[0];
        assert_eq!((piece.area, piece.x, piece.y, piece.sides()), (32, [60, 80], [2, 7], [20, 5]));
        assert_eq!(found.selected([100, 9], |piece| piece == 1).count(), 1);
    }
}
