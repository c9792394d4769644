//! The load-bearing part of a plan: what stands on a building site before the fit-out.
//!
//! Plans of a finished building show partitions and interior glazing that do not exist in the shell. This module keeps
//! walls at least as thick as a bound, found by morphological opening with a square of that side, and the glazing of
//! the facade: within [`FACADE_M`] of the outside that [`interior`] finds.
//!
//! A wall at 45 degrees must be 1.4 times as thick to hold the square. Cost: four sweeps over the bits, 64 pixels in a
//! word and log2 of the side steps each, and the interior of the plan.

use super::PlanRaster;
use crate::interior::{self, InteriorError, InteriorOptions, Places};
use compass_core::base::raster::BitMask;
use thiserror::Error;

/// Default thickness of the thinnest load-bearing wall, metres.
pub const DEFAULT_THICKNESS_M: f64 = 0.25;
/// Glazing within this distance of the outside belongs to the facade, metres.
pub const FACADE_M: f64 = 0.8;
/// Thickest bound accepted, in metres.
pub const MOST_THICKNESS_M: f64 = 5.0;

/// Why a plan has no load-bearing part.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum StructureError {
    /// The bound is out of range.
    #[error("structure thicker than {0} m was asked for, expected above 0 and at most {MOST_THICKNESS_M}")]
    Thickness(f64),
    /// No wall is that thick.
    #[error("no wall is {0} m thick")]
    NoWalls(f64),
    /// The facade cannot be determined.
    #[error(transparent)]
    Interior(#[from] InteriorError),
}

/// Keeps walls at least `thickness_m` thick, and the glazing of the facade.
///
/// # Errors
/// [`StructureError`]: a bound out of range, a plan without interior, or no wall as thick as the bound.
pub fn keep_structure(raster: &PlanRaster, thickness_m: f64) -> Result<PlanRaster, StructureError> {
    keep_structure_inside(raster, thickness_m, &Places::default())
}

/// [`keep_structure`] of a plan whose inside is at `places`, if they name any: what else is connected with the edge of
/// the plan is outdoors, and glazing beside it belongs to the facade.
///
/// # Errors
/// As [`keep_structure`], and a place that cannot be inside.
pub fn keep_structure_inside(
    raster: &PlanRaster,
    thickness_m: f64,
    places: &Places,
) -> Result<PlanRaster, StructureError> {
    if !(thickness_m > 0.0 && thickness_m <= MOST_THICKNESS_M) {
        return Err(StructureError::Thickness(thickness_m));
    }
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let options = InteriorOptions::with_places(places.clone(), raster.origin);
    let found = interior::find(&walls, &windows, raster.resolution_m, &options)?;
    let side = (thickness_m / raster.resolution_m).round().max(1.0) as usize;
    let mut bits = Bits::new(&raster.walls, raster.width, raster.height);
    bits.open(side);
    let mut kept = PlanRaster { walls: bits.to_bytes(), ..raster.clone() };
    if kept.walls.iter().all(|&byte| byte == 0) {
        return Err(StructureError::NoWalls(thickness_m));
    }
    let near = found.near_outside(FACADE_M);
    keep_pixels(&mut kept, |x, y| found.cell(x, y).is_some_and(|cell| near[cell]));
    Ok(kept)
}

/// Clears the glazing that is not selected.
fn keep_pixels(raster: &mut PlanRaster, keep: impl Fn(u32, u32) -> bool) {
    let row_bytes = BitMask::row_bytes(raster.width);
    for (y, row) in (0..).zip(raster.windows.chunks_exact_mut(row_bytes)) {
        for (column, byte) in (0..).zip(row).filter(|(_, byte)| **byte != 0) {
            let kept = (0..8).filter(|bit| keep(8 * column + bit, y)).fold(0, |kept, bit| kept | 1_u8 << bit);
            *byte &= kept;
        }
    }
}

/// A mask, 64 pixels in a word, rows padded to whole words with clear bits.
struct Bits {
    words: usize,
    row_bytes: usize,
    last: u64,
    bits: Vec<u64>,
}

impl Bits {
    fn new(bytes: &[u8], width: u32, height: u32) -> Self {
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

    fn to_bytes(&self) -> Vec<u8> {
        let row = |row: &[u64]| row.iter().flat_map(|word| word.to_le_bytes()).take(self.row_bytes).collect();
        self.bits.chunks_exact(self.words).flat_map(|words| -> Vec<u8> { row(words) }).collect()
    }

    /// Keeps the pixels that some square of `side` pixels covers without leaving the mask.
    fn open(&mut self, side: usize) {
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

    /// A room of 10 m x 8 m at 0.1 m a pixel with outer walls of 0.3 m, a partition of 0.1 m, and glazing in both.
    fn shell() -> PlanRaster {
        let mut raster = PlanRaster::empty(120, 100, 0.1, [0.0; 2]);
        for (x, y) in (10..90).flat_map(|y| (10..110).map(move |x| (x, y))) {
            if !(13..107).contains(&x) || !(13..87).contains(&y) || x == 60 {
                raster.set_wall(x, y);
            }
        }
        (30..40).for_each(|y| raster.set_window(60, y));
        (30..50).for_each(|x| (10..13).for_each(|y| raster.set_window(x, y)));
        raster
    }

    #[test]
    fn partitions_and_their_glazing_go() {
        let (plan, kept) = (shell(), keep_structure(&shell(), DEFAULT_THICKNESS_M).unwrap());
        assert!(plan.is_wall(60, 20) && plan.is_window(60, 35));
        assert!((14..86).all(|y| !kept.occupied(60, y)));
        assert!((30..50).all(|x| kept.is_window(x, 11)), "glazing of the facade stays");
        assert!((13..87).all(|y| kept.is_wall(11, y) && kept.is_wall(108, y)));
    }

    #[test]
    fn bounds_out_of_reach_are_refused() {
        for thickness in [0.0, -1.0, f64::NAN, 6.0] {
            let refused = keep_structure(&shell(), thickness).unwrap_err();
            assert!(matches!(refused, StructureError::Thickness(_)), "{refused}");
        }
        assert_eq!(keep_structure(&shell(), 1.0).unwrap_err(), StructureError::NoWalls(1.0));
    }
}
