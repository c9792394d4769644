//! Choice of windows: the set of boxes without overlap of the largest total score, and log odds per column.

use super::boxes::WindowBox;
use super::tuning::MOST_EVIDENCE;
use crate::base::num::{LogOdds, LogWeight};
use bytemuck::{Pod, Zeroable};

/// Index that stands for no box.
const NO_BOX: u16 = u16::MAX;

/// State of one column of the panorama in the dynamic program. Columns are counted from the cut.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Column {
    /// Largest total score of boxes that end here or before.
    before: LogWeight,
    /// Largest total score of boxes that start here or after.
    after: LogWeight,
    /// Largest total score of a choice with a box over this column; then the log odds.
    evidence: LogWeight,
    /// The box that ends here in the choice of [`before`](Self::before).
    chosen: u16,
    /// First box of this column's list.
    list: u16,
}

impl Column {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self {
        before: LogWeight::ZERO,
        after: LogWeight::ZERO,
        evidence: LogWeight::ZERO,
        chosen: 0,
        list: 0,
    };
}

/// Weighted interval scheduling of `boxes` on the circle of `columns.len() - 1` columns.
///
/// The circle is cut at the column with the smallest sum of positive scores; boxes across the cut are dropped. A dynamic
/// program over the columns then finds the boxes without overlap of the largest total score. Returns the cut; then
/// [`chosen`] iterates over the boxes and [`evidence`] gives the log odds of a window at each column.
pub(super) fn choose(boxes: &mut [WindowBox], columns: &mut [Column]) -> usize {
    let n = columns.len().saturating_sub(1);
    let cut = cut(boxes, columns);
    let place = |b: &WindowBox| {
        let start = (usize::from(b.start) + n - cut) % n.max(1);
        (start, start + b.width())
    };
    enlist(boxes, columns, |b| Some(place(b)).filter(|(_, end)| *end <= n).map(|(_, end)| end));
    for column in 1..=n {
        let (mut best, mut by) = (columns.get(column - 1).map_or(LogWeight::ZERO, |c| c.before), NO_BOX);
        each(boxes, columns.get(column), |index, b| {
            let score =
                columns.get(place(b).0).map_or(LogWeight::ZERO, |c| c.before) + LogWeight::from(b.score);
            if score > best {
                (best, by) = (score, index);
            }
        });
        if let Some(c) = columns.get_mut(column) {
            (c.before, c.chosen) = (best, by);
        }
    }
    enlist(boxes, columns, |b| Some(place(b)).filter(|(_, end)| *end <= n).map(|(start, _)| start));
    for column in (0..n).rev() {
        let mut best = columns.get(column + 1).map_or(LogWeight::ZERO, |c| c.after);
        each(boxes, columns.get(column), |_, b| {
            best = best
                .max(columns.get(place(b).1).map_or(LogWeight::ZERO, |c| c.after) + LogWeight::from(b.score));
        });
        if let Some(c) = columns.get_mut(column) {
            c.after = best;
        }
    }
    weigh(boxes, columns, place);
    cut
}

/// The first column with the smallest sum of positive scores of the boxes over it.
fn cut(boxes: &[WindowBox], columns: &mut [Column]) -> usize {
    let n = columns.len().saturating_sub(1).max(1);
    columns.fill(Column { chosen: NO_BOX, ..Column::default() });
    let mut weight = LogWeight::ZERO;
    for b in boxes.iter().filter(|b| b.score > LogOdds::ZERO) {
        let score = LogWeight::from(b.score);
        let (start, end) = (usize::from(b.start) % n, usize::from(b.start) % n + b.width());
        weight += if end >= n { score } else { LogWeight::ZERO };
        for (column, change) in [(start, score), (end % n, -score)] {
            if let Some(column) = columns.get_mut(column) {
                column.evidence += change;
            }
        }
    }
    let mut least = (LogWeight::MAX, 0);
    for (index, column) in columns.iter_mut().take(n).enumerate() {
        weight += column.evidence;
        column.evidence = LogWeight::ZERO;
        if weight < least.0 {
            least = (weight, index);
        }
    }
    least.1
}

/// Inserts each box into the list of the column `of` gives.
fn enlist(boxes: &mut [WindowBox], columns: &mut [Column], of: impl Fn(&WindowBox) -> Option<usize>) {
    columns.iter_mut().for_each(|column| column.list = NO_BOX);
    for (index, b) in (0_u16..).zip(boxes) {
        if let Some(column) = of(b).and_then(|column| columns.get_mut(column)) {
            b.next = column.list;
            column.list = index;
        }
    }
}

/// Visits the boxes on a column's list.
fn each(boxes: &[WindowBox], column: Option<&Column>, mut visit: impl FnMut(u16, &WindowBox)) {
    let mut index = column.map_or(NO_BOX, |c| c.list);
    while let Some(b) = boxes.get(usize::from(index)) {
        visit(index, b);
        index = b.next;
    }
}

/// Max-marginal log odds: the largest total with a box over the column less the largest without.
fn weigh(boxes: &[WindowBox], columns: &mut [Column], place: impl Fn(&WindowBox) -> (usize, usize)) {
    let n = columns.len().saturating_sub(1);
    columns.iter_mut().for_each(|column| column.evidence = LogWeight::MIN / 2);
    for b in boxes {
        let (start, end) = place(b);
        if end > n {
            continue;
        }
        let (before, after) = (
            columns.get(start).map_or(LogWeight::ZERO, |c| c.before),
            columns.get(end).map_or(LogWeight::ZERO, |c| c.after),
        );
        let total = before + LogWeight::from(b.score) + after;
        for column in columns.get_mut(start..end).unwrap_or(&mut []) {
            column.evidence = column.evidence.max(total);
        }
    }
    for index in 0..n {
        let after = columns.get(index + 1).map_or(LogWeight::ZERO, |c| c.after);
        if let Some(column) = columns.get_mut(index) {
            let without = column.before + after;
            column.evidence = (column.evidence - without).clamp(-MOST_EVIDENCE, MOST_EVIDENCE);
        }
    }
}

/// The chosen boxes, in descending order of columns.
pub(super) fn chosen<'a>(
    boxes: &'a [WindowBox],
    columns: &'a [Column],
) -> impl Iterator<Item = &'a WindowBox> + 'a {
    let mut column = columns.len().saturating_sub(1);
    core::iter::from_fn(move || {
        while column > 0 {
            let found = boxes.get(usize::from(columns.get(column)?.chosen));
            column -= found.map_or(1, WindowBox::width).clamp(1, column);
            if found.is_some() {
                return found;
            }
        }
        None
    })
}

/// The log odds of a window at a column of the panorama.
pub(super) fn evidence(columns: &[Column], cut: usize, column: usize) -> LogWeight {
    let n = columns.len().saturating_sub(1).max(1);
    columns.get((column + n - cut) % n).map_or(-MOST_EVIDENCE, |c| c.evidence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const N: u16 = 12;

    fn boxed(start: u16, width: u16, score: i16) -> WindowBox {
        WindowBox { start, end: start + width, score: LogOdds::from_bits(score), ..WindowBox::default() }
    }

    fn overlap(a: &WindowBox, b: &WindowBox) -> bool {
        let cells = |b: &WindowBox| (b.start..b.end).fold(0_u32, |bits, c| bits | 1 << (c % N));
        cells(a) & cells(b) != 0
    }

    /// The largest total score of boxes without overlap, by exhaustive search.
    fn best(boxes: &[WindowBox]) -> LogWeight {
        (0_u32..1 << boxes.len())
            .filter_map(|set| {
                let some: Vec<_> =
                    boxes.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1).map(|(_, b)| b).collect();
                let apart = some.iter().enumerate().all(|(i, a)| some[..i].iter().all(|b| !overlap(a, b)));
                apart.then(|| some.iter().map(|b| LogWeight::from(b.score)).sum())
            })
            .max()
            .unwrap_or_default()
    }

    proptest! {
        #[test]
        fn finds_the_best_choice(parts in proptest::collection::vec((0..N, 1_u16..6, -900_i16..900), 0..9)) {
            let mut boxes: Vec<_> = parts.iter().map(|(s, w, v)| boxed(*s, *w, *v)).collect();
            let mut columns = [Column::default(); N as usize + 1];
            let cut = choose(&mut boxes, &mut columns) as u16;
            let crosses = |b: &WindowBox| (b.start..b.end).skip(1).any(|c| c % N == cut);
            let allowed: Vec<_> = boxes.iter().copied().filter(|b| !crosses(b)).collect();
            let picked: Vec<_> = chosen(&boxes, &columns).copied().collect();
            prop_assert_eq!(picked.iter().map(|b| LogWeight::from(b.score)).sum::<LogWeight>(), best(&allowed));
            for (i, a) in picked.iter().enumerate() {
                prop_assert!(picked[..i].iter().all(|b| !overlap(a, b)) && !crosses(a));
            }
            for column in 0..usize::from(N) {
                let covers = |b: &&WindowBox| (b.start..b.end).any(|c| usize::from(c % N) == column);
                let covered = picked.iter().any(|b| covers(&b));
                let odds = evidence(&columns, usize::from(cut), column);
                let zero = LogWeight::ZERO;
                prop_assert!(if covered { odds >= zero } else { odds <= zero }, "{} {}", column, odds);
                let without: Vec<_> = allowed.iter().copied().filter(|b| !covers(&b)).collect();
                let with = allowed.iter().filter(covers).map(|b| {
                    let rest: Vec<_> = allowed.iter().copied().filter(|o| !overlap(o, b)).collect();
                    best(&rest) + LogWeight::from(b.score)
                }).max().unwrap_or(LogWeight::MIN / 4);
                prop_assert_eq!(odds, (with - best(&without)).clamp(-MOST_EVIDENCE, MOST_EVIDENCE));
            }
        }
    }
}
