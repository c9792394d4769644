//! Number of 64 rays from a cell that hit something occupied before they leave the plan.
//!
//! All rays of one direction are parallel digital lines. Swept row by row against the direction,
//! "the ray from here has a hit" of a row is that of the row before, shifted by the step of
//! the line, or'ed with the row itself: 64 cells in one word, so every cell is exact and the cost
//! does not depend on the length of the rays. Flat directions are swept over the transpose.

use super::grid::Grid;

/// Rays from every cell, evenly spread over the turn, none along an axis.
pub(super) const RAYS: u8 = 64;
/// Directions in a quarter turn around an axis.
const SLOPES: u8 = RAYS / 4;
/// Bit planes of a counter up to `RAYS / 2`.
const PLANES: usize = 6;

/// Rays with a hit, of [`RAYS`], for every cell of the grid.
pub(super) fn hits(grid: &Grid) -> Vec<u8> {
    let (columns, rows) = (grid.columns, grid.rows);
    let upright = Bits::new(columns, rows, |x, y| grid.occupied[y * columns + x]).sweep();
    let flat = Bits::new(rows, columns, |x, y| grid.occupied[x * columns + y]).sweep();
    let mut hits = vec![0; columns * rows];
    for (word, row) in upright.chunks(columns.div_ceil(64)).zip(hits.chunks_mut(columns)) {
        for (planes, cells) in word.iter().zip(row.chunks_mut(64)) {
            for (bit, cell) in cells.iter_mut().enumerate() {
                *cell = count(planes, bit);
            }
        }
    }
    // Word by word over all columns: the 64 rows of a word stay in the cache.
    let words = rows.div_ceil(64);
    for word in 0..words {
        for x in 0..columns {
            let planes = &flat[x * words + word];
            for (bit, y) in (64 * word..rows.min(64 * word + 64)).enumerate() {
                hits[y * columns + x] += count(planes, bit);
            }
        }
    }
    hits
}

/// The counter of one cell, gathered from its bit planes.
fn count(planes: &[u64; PLANES], bit: usize) -> u8 {
    planes.iter().rev().fold(0, |sum, plane| 2 * sum + u8::from(plane >> bit & 1 == 1))
}

/// Occupied cells, 64 in a word, rows padded to whole words.
struct Bits {
    words: usize,
    rows: usize,
    bits: Vec<u64>,
}

impl Bits {
    fn new(columns: usize, rows: usize, occupied: impl Fn(usize, usize) -> bool) -> Self {
        let words = columns.div_ceil(64);
        let mut bits = vec![0; words * rows];
        for (y, row) in bits.chunks_mut(words).enumerate() {
            for x in (0..columns).filter(|&x| occupied(x, y)) {
                row[x / 64] |= 1 << (x % 64);
            }
        }
        Self { words, rows, bits }
    }

    /// Counts, per cell, the rays within 45 degrees of the y axis (both ways) that have a hit.
    fn sweep(&self) -> Vec<[u64; PLANES]> {
        let mut counters = vec![[0; PLANES]; self.bits.len()];
        for slope in 0..SLOPES {
            let turn = (f64::from(slope) + 0.5) / f64::from(SLOPES) - 0.5;
            let slope = (turn * core::f64::consts::FRAC_PI_2).tan();
            self.sweep_one(slope, true, &mut counters);
            self.sweep_one(slope, false, &mut counters);
        }
        counters
    }

    /// Adds the rays that go `slope` cells in x per row, to higher rows if `up`, else to lower ones.
    fn sweep_one(&self, slope: f64, up: bool, counters: &mut [[u64; PLANES]]) {
        let words = self.words;
        let blank = vec![0; words];
        let (mut ahead, mut state) = (blank.clone(), blank.clone());
        let mut row_ahead = &blank[..];
        for step in 0..self.rows {
            let y = if up { self.rows - 1 - step } else { step };
            let row = &self.bits[y * words..(y + 1) * words];
            let x_at = |step: usize| (slope * step as f64).round();
            let by = x_at(step + 1) - x_at(step);
            for (word, state) in state.iter_mut().enumerate() {
                let cells = row[word];
                // A diagonal step between two occupied cells that touch at the corner is a hit.
                let corner = if by == 0.0 { 0 } else { shifted(row, word, by) & row_ahead[word] };
                *state = cells | corner | shifted(&ahead, word, by);
                add(&mut counters[y * words + word], *state);
            }
            core::mem::swap(&mut ahead, &mut state);
            row_ahead = row;
        }
    }
}

/// The word whose bit `x` is bit `x + by` of the row, `by` -1, 0 or 1.
fn shifted(row: &[u64], word: usize, by: f64) -> u64 {
    if by > 0.0 {
        row[word] >> 1 | row.get(word + 1).map_or(0, |next| next << 63)
    } else if by < 0.0 {
        row[word] << 1 | word.checked_sub(1).map_or(0, |before| row[before] >> 63)
    } else {
        row[word]
    }
}

/// Adds one to the counters of the set bits.
fn add(planes: &mut [u64; PLANES], bits: u64) {
    let mut carry = bits;
    for plane in planes {
        (*plane, carry) = (*plane ^ carry, *plane & carry);
    }
}
