//! Masks of a plan, 64 pixels in a word: set operations, opening by a square, growth within a mask.

use super::raster::PlanRaster;
use compass_core::base::raster::BitMask;

/// A mask, 64 pixels in a word, rows padded to whole words with clear bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Bits {
    pub(super) width: u32,
    pub(super) height: u32,
    words: usize,
    /// The bits of a row's last word that are pixels.
    last: u64,
    bits: Vec<u64>,
}

impl Bits {
    /// A mask without a set pixel.
    pub(super) fn empty(width: u32, height: u32) -> Self {
        let words = width.div_ceil(64) as usize;
        let last = u64::MAX >> ((64 - width % 64) % 64);
        Self { width, height, words, last, bits: vec![0; words * height as usize] }
    }

    /// A mask from rows of whole bytes, least significant bit first.
    pub(super) fn new(bytes: &[u8], width: u32, height: u32) -> Self {
        let mut mask = Self::empty(width, height);
        let rows = bytes.chunks_exact(BitMask::row_bytes(width));
        for (row, bytes) in mask.bits.chunks_exact_mut(mask.words).zip(rows) {
            for (word, bytes) in row.iter_mut().zip(bytes.chunks(8)) {
                *word = bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
            }
            row[mask.words - 1] &= mask.last;
        }
        mask
    }

    /// The mask as rows of whole bytes.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let row_bytes = BitMask::row_bytes(self.width);
        let row = |row: &[u64]| row.iter().flat_map(|word| word.to_le_bytes()).take(row_bytes).collect();
        self.bits.chunks_exact(self.words).flat_map(|words| -> Vec<u8> { row(words) }).collect()
    }

    /// Whether a pixel is set; outside the mask it is not.
    pub(super) fn get(&self, x: u32, y: u32) -> bool {
        let word = || self.bits[y as usize * self.words + x as usize / 64];
        x < self.width && y < self.height && word() >> (x % 64) & 1 == 1
    }

    /// Sets the pixels `from..to` of a row.
    pub(super) fn set_run(&mut self, y: u32, from: u32, to: u32) {
        let row = y as usize * self.words;
        (from..to).for_each(|x| self.bits[row + x as usize / 64] |= 1 << (x % 64));
    }

    /// The runs of set pixels of a row, `[from, to)` from left to right.
    pub(super) fn runs(&self, y: u32) -> Vec<[u32; 2]> {
        let words = &self.bits[y as usize * self.words..][..self.words];
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for (start, &word) in (0..).step_by(64).zip(words) {
            let mut rest = word;
            while rest != 0 {
                let from = rest.trailing_zeros();
                let length = (!(rest >> from)).trailing_zeros();
                rest &= u64::MAX.checked_shl(from + length).unwrap_or(0);
                let run = [start + from, start + from + length];
                match runs.last_mut().filter(|last| last[1] == run[0]) {
                    Some(last) => last[1] = run[1],
                    None => runs.push(run),
                }
            }
        }
        runs
    }

    /// How many pixels are set.
    pub(super) fn count(&self) -> u64 {
        self.bits.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// The pixels of either mask.
    pub(super) fn or(&self, other: &Self) -> Self {
        self.with(other, |a, b| a | b)
    }

    /// The pixels of this mask that are not in the other.
    pub(super) fn without(&self, other: &Self) -> Self {
        self.with(other, |a, b| a & !b)
    }

    /// The pixels that are not set.
    pub(super) fn inverted(&self) -> Self {
        let mut all = Self { bits: vec![u64::MAX; self.bits.len()], ..*self };
        all.bits.chunks_exact_mut(self.words).for_each(|row| row[self.words - 1] &= self.last);
        all.without(self)
    }

    fn with(&self, other: &Self, join: impl Fn(u64, u64) -> u64) -> Self {
        let bits = self.bits.iter().zip(&other.bits).map(|(&a, &b)| join(a, b)).collect();
        Self { bits, ..*self }
    }

    /// Adds the pixels of `mask` within `steps` king's moves inside it.
    pub(super) fn grow_within(&mut self, mask: &Self, steps: usize) {
        let words = self.words;
        for _ in 0..steps {
            let beside = |row: &[u64], at: usize| row[at] | from_right(row, at, 1) | from_left(row, at, 1);
            let rows = self.bits.chunks_exact(words);
            let wide: Vec<u64> = rows.flat_map(|row| (0..words).map(move |at| beside(row, at))).collect();
            for (at, word) in self.bits.iter_mut().enumerate() {
                let below = at.checked_sub(words).map_or(0, |at| wide[at]);
                let above = wide.get(at + words).copied().unwrap_or(0);
                *word |= (wide[at] | below | above) & mask.bits[at];
            }
        }
    }

    /// What is wall or glazing.
    pub(super) fn occupied(raster: &PlanRaster) -> Self {
        let [walls, windows] =
            [&raster.walls, &raster.windows].map(|mask| Self::new(mask, raster.width, raster.height));
        walls.or(&windows)
    }

    /// Sides of pixels between in and out.
    pub(super) fn outline(&self) -> u64 {
        let blank = vec![0; self.words];
        let rows = || self.bits.chunks_exact(self.words);
        let upright = rows().map(|row| -> u64 {
            (0..self.words).map(|at| u64::from((row[at] ^ from_left(row, at, 1)).count_ones())).sum()
        });
        // Right sides beyond the last word; padding bits count those of other rows.
        let right = rows().map(|row| row[self.words - 1] >> 63);
        let flat = rows().chain([&blank[..]]).zip([&blank[..]].into_iter().chain(rows()));
        let flat =
            flat.flat_map(|(row, below)| row.iter().zip(below)).map(|(a, b)| u64::from((a ^ b).count_ones()));
        upright.sum::<u64>() + right.sum::<u64>() + flat.sum::<u64>()
    }

    /// Grows the mask within `free`, of the same size and a superset, over all that is connected by sides.
    pub(super) fn flood(&mut self, free: &Self) {
        let rows = self.bits.len() / self.words;
        // Along each row first: a mask of one row has none beside it.
        (0..rows).for_each(|row| _ = self.grow_row(free, row, row));
        loop {
            // Each sweep carries along rows as far as they are free, so few are needed.
            let up = (1..rows).fold(false, |changed, row| self.grow_row(free, row, row - 1) | changed);
            let down = (0..rows.saturating_sub(1))
                .rev()
                .fold(false, |changed, row| self.grow_row(free, row, row + 1) | changed);
            if !(up | down) {
                return;
            }
        }
    }

    /// Grows a row from the one beside it, then along itself; whether it changed.
    fn grow_row(&mut self, free: &Self, row: usize, beside: usize) -> bool {
        let words = self.words;
        let (at, from) = (row * words, beside * words);
        let mut changed = false;
        let mut carry = false;
        for word in 0..words {
            let room = free.bits[at + word];
            let seeds = (self.bits[at + word] | self.bits[from + word] | u64::from(carry)) & room;
            let filled = run_up(room, seeds);
            changed |= filled != self.bits[at + word];
            self.bits[at + word] = filled;
            carry = filled >> 63 == 1;
        }
        carry = false;
        for word in (0..words).rev() {
            let room = free.bits[at + word].reverse_bits();
            let seeds = (self.bits[at + word].reverse_bits() | u64::from(carry)) & room;
            let filled = run_up(room, seeds);
            carry = filled >> 63 == 1;
            changed |= filled.reverse_bits() != self.bits[at + word];
            self.bits[at + word] = filled.reverse_bits();
        }
        changed
    }

    /// Keeps the pixels that some square of `side` pixels covers without leaving the mask.
    pub(super) fn open(&mut self, side: usize) {
        let words = self.words;
        // Erosion: the lower left pixels of the squares that fit.
        for row in self.bits.chunks_exact_mut(words) {
            doubling(side, |by| (0..words).for_each(|at| row[at] &= from_right(row, at, by)));
        }
        doubling(side, |by| {
            let kept = self.bits.len().saturating_sub(by * words);
            (0..kept).for_each(|at| self.bits[at] &= self.bits[at + by * words]);
            self.bits[kept..].fill(0);
        });
        // Dilation: all pixels of those squares.
        for row in self.bits.chunks_exact_mut(words) {
            doubling(side, |by| (0..words).rev().for_each(|at| row[at] |= from_left(row, at, by)));
        }
        doubling(side, |by| {
            (by * words..self.bits.len()).rev().for_each(|at| self.bits[at] |= self.bits[at - by * words]);
        });
    }
}

/// Calls `step` with shifts that extend a run of 1 to a run of `side`.
fn doubling(side: usize, mut step: impl FnMut(usize)) {
    let mut have = 1;
    while have < side {
        let by = have.min(side - have);
        step(by);
        have += by;
    }
}

/// The word whose bit `x` is bit `x + by` of the row.
fn from_right(row: &[u64], at: usize, by: usize) -> u64 {
    let word = |at: usize| row.get(at).copied().unwrap_or(0);
    let (whole, part) = (at + by / 64, by % 64);
    if part == 0 { word(whole) } else { word(whole) >> part | word(whole + 1) << (64 - part) }
}

/// The word whose bit `x` is bit `x - by` of the row.
fn from_left(row: &[u64], at: usize, by: usize) -> u64 {
    let word = |back: usize| at.checked_sub(back).map_or(0, |at| row[at]);
    let (whole, part) = (by / 64, by % 64);
    if part == 0 { word(whole) } else { word(whole) << part | word(whole + 1) >> (64 - part) }
}

/// The bits of `room` from each of `seeds`, which lie in it, up to the end of its run of ones.
const fn run_up(room: u64, seeds: u64) -> u64 {
    // Adding a seed carries through the ones above it and so flips them; a further seed in the run stays and is added.
    ((room.wrapping_add(seeds) ^ room) | seeds) & room
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan_import::PlanRaster;
    use proptest::prelude::*;

    /// The opening by its definition.
    fn opened(raster: &PlanRaster, side: u32) -> Vec<(u32, u32)> {
        let mut kept = std::collections::BTreeSet::new();
        for (x, y) in (0..raster.height).flat_map(|y| (0..raster.width).map(move |x| (x, y))) {
            let square = || (0..side * side).map(move |n| (x + n % side, y + n / side));
            if square().all(|(x, y)| raster.is_wall(x, y)) {
                kept.extend(square());
            }
        }
        kept.into_iter().collect()
    }

    proptest! {
        #[test]
        fn opening_is_that_of_its_definition(
            width in 1_u32..200, height in 1_u32..40, side in 1_usize..7,
            blocks in proptest::collection::vec((0_u32..200, 0_u32..40, 1_u32..90, 1_u32..12), 1..9),
        ) {
            let mut raster = PlanRaster::empty(width, height, 0.1, [0.0; 2]);
            for (x, y, w, h) in blocks {
                (0..w * h).for_each(|n| raster.set_wall(x + n % w, y + n / w));
            }
            let mut bits = Bits::new(&raster.walls, width, height);
            bits.open(side);
            let kept = PlanRaster { walls: bits.to_bytes(), ..raster.clone() };
            prop_assert_eq!(kept.walls.len(), raster.walls.len());
            let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let expected = opened(&raster, side as u32);
            prop_assert!(pixels.all(|(x, y)| kept.is_wall(x, y) == expected.contains(&(x, y))));
        }
    }

    fn drawn(rows: &[&str]) -> Bits {
        let mut bits = Bits::empty(rows[0].len() as u32, rows.len() as u32);
        for (y, row) in (0..).zip(rows) {
            (0..).zip(row.bytes()).filter(|(_, c)| *c == b'#').for_each(|(x, _)| bits.set_run(y, x, x + 1));
        }
        bits
    }

    proptest! {
        #[test]
        fn runs_and_bytes_keep_every_pixel(width in 1_u32..200, cuts in proptest::collection::vec(0_u32..200, 0..9)) {
            let mut bits = Bits::empty(width, 2);
            for cut in cuts.chunks(2) {
                bits.set_run(1, cut[0].min(width), cut[0].saturating_add(cuts.len() as u32 * 9).min(width));
            }
            let mut again = Bits::empty(width, 2);
            let runs = bits.runs(1);
            prop_assert!(runs.windows(2).all(|pair| pair[0][1] < pair[1][0]) && bits.runs(0).is_empty());
            runs.iter().for_each(|&[from, to]| again.set_run(1, from, to));
            prop_assert_eq!(&again, &bits);
            prop_assert_eq!(&Bits::new(&bits.to_bytes(), width, 2), &bits);
            prop_assert_eq!(bits.inverted().count() + bits.count(), 2 * u64::from(width));
            prop_assert_eq!(bits.inverted().inverted(), bits);
        }
    }

    #[test]
    fn growth_stays_within_the_mask() {
        let mask = drawn(&["###.", "..#.", "..##", "#..."]);
        let mut grown = drawn(&["#...", "....", "....", "...."]);
        grown.grow_within(&mask, 2);
        assert_eq!(grown, drawn(&["###.", "..#.", "....", "...."]));
        grown.grow_within(&mask, 9);
        assert_eq!(grown, drawn(&["###.", "..#.", "..##", "...."]));
    }

    proptest! {
        #[test]
        fn a_flood_reaches_what_steps_reach(
            width in 1_u32..150, height in 1_u32..30, start in any::<prop::sample::Index>(),
            free in proptest::collection::vec(prop::bool::weighted(0.7), 150 * 30),
        ) {
            let is_free = |x: u32, y: u32| free[(y * width + x) as usize];
            let mut raster = PlanRaster::empty(width, height, 0.1, [0.0; 2]);
            let pixels = || (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
            pixels().filter(|&(x, y)| !is_free(x, y)).for_each(|(x, y)| raster.set_wall(x, y));
            let room = Bits::occupied(&raster).inverted();
            let seed = pixels().nth(start.index((width * height) as usize)).unwrap();
            let mut seen = Bits::empty(width, height);
            let mut wanted = std::collections::BTreeSet::new();
            let mut stack = Vec::new();
            if is_free(seed.0, seed.1) {
                seen.set_run(seed.1, seed.0, seed.0 + 1);
                stack.push(seed);
            }
            while let Some((x, y)) = stack.pop() {
                if x < width && y < height && is_free(x, y) && wanted.insert((x, y)) {
                    stack.extend([(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)]);
                }
            }
            seen.flood(&room);
            let reached: std::collections::BTreeSet<_> = pixels().filter(|&(x, y)| seen.get(x, y)).collect();
            prop_assert_eq!(reached, wanted);
        }
    }
}
