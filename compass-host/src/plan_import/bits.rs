//! Masks of a plan, 64 pixels at a time.

use super::raster::PlanRaster;
use compass_core::base::raster::BitMask;

/// A mask, 64 pixels in a word, rows padded to whole words with clear bits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bits {
    words: usize,
    row_bytes: usize,
    last: u64,
    bits: Vec<u64>,
}

impl Bits {
    pub(super) fn new(bytes: &[u8], width: u32, height: u32) -> Self {
        let row_bytes = BitMask::row_bytes(width);
        let words = row_bytes.div_ceil(8);
        let mut bits = Vec::with_capacity(words * height as usize);
        for row in bytes.chunks_exact(row_bytes) {
            let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
            bits.extend(row.chunks(8).map(word));
        }
        let last = u64::MAX >> ((64 - width % 64) % 64);
        Self { words, row_bytes, last, bits }
    }

    /// What is wall or glazing.
    pub(super) fn occupied(raster: &PlanRaster) -> Self {
        let mut all = Self::new(&raster.walls, raster.width, raster.height);
        let windows = Self::new(&raster.windows, raster.width, raster.height);
        all.bits.iter_mut().zip(windows.bits).for_each(|(bits, windows)| *bits |= windows);
        all
    }

    /// How many pixels are in.
    pub(super) fn count(&self) -> u64 {
        self.bits.iter().map(|bits| u64::from(bits.count_ones())).sum()
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

    /// What is neither wall nor glazing.
    pub(super) fn free(raster: &PlanRaster) -> Self {
        let mut free = Self::occupied(raster);
        let (words, last) = (free.words, free.last);
        for (at, bits) in free.bits.iter_mut().enumerate() {
            *bits = !*bits;
            // Padding bits must stay clear.
            if at % words == words - 1 {
                *bits &= last;
            }
        }
        free
    }

    /// Takes the pixels of `other`, a mask of the same size, out.
    pub(super) fn clear(&mut self, other: &Self) {
        self.bits.iter_mut().zip(&other.bits).for_each(|(bits, other)| *bits &= !other);
    }

    /// The first pixel from word `word` on, and its word.
    pub(super) fn first_from(&self, word: usize) -> Option<(usize, (u32, u32))> {
        let at = (word..self.bits.len()).find(|&at| self.bits[at] != 0)?;
        let x = at % self.words * 64 + self.bits[at].trailing_zeros() as usize;
        Some((at, (x as u32, (at / self.words) as u32)))
    }

    /// Whether a pixel of the mask's size is in.
    pub(super) fn contains(&self, (x, y): (u32, u32)) -> bool {
        self.bits[y as usize * self.words + x as usize / 64] >> (x % 64) & 1 == 1
    }

    /// Takes a pixel of the mask's size out; whether it was in.
    pub(super) fn take(&mut self, (x, y): (u32, u32)) -> bool {
        let was = self.contains((x, y));
        self.bits[y as usize * self.words + x as usize / 64] &= !(1 << (x % 64));
        was
    }

    /// Grows the mask within `free`, of the same size and a superset, over all that is connected along rows and columns.
    pub(super) fn flood(&mut self, free: &Self) {
        let rows = self.bits.len() / self.words;
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

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let row = |row: &[u64]| row.iter().flat_map(|word| word.to_le_bytes()).take(self.row_bytes).collect();
        self.bits.chunks_exact(self.words).flat_map(|words| -> Vec<u8> { row(words) }).collect()
    }

    /// Keeps the pixels that some square of `side` pixels covers without leaving the mask.
    pub(super) fn open(&mut self, side: usize) {
        let (words, last) = (self.words, self.last);
        // Erosion: the lower left pixels of the squares that fit.
        for row in self.bits.chunks_exact_mut(words) {
            // Padding bits must stay clear.
            row[words - 1] &= last;
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
            let room = Bits::free(&raster);
            let seed = pixels().nth(start.index((width * height) as usize)).unwrap();
            let mut seen = Bits::new(&vec![0; raster.walls.len()], width, height);
            let mut wanted = std::collections::BTreeSet::new();
            let mut stack = Vec::new();
            if is_free(seed.0, seed.1) {
                seen.bits[seed.1 as usize * seen.words + seed.0 as usize / 64] |= 1 << (seed.0 % 64);
                stack.push(seed);
            }
            while let Some((x, y)) = stack.pop() {
                if x < width && y < height && is_free(x, y) && wanted.insert((x, y)) {
                    stack.extend([(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)]);
                }
            }
            seen.flood(&room);
            let mut reached = std::collections::BTreeSet::new();
            let mut left = seen;
            while let Some((_, at)) = left.first_from(0) {
                prop_assert!(left.take(at) && !left.take(at));
                reached.insert(at);
            }
            prop_assert_eq!(reached, wanted);
        }
    }
}
