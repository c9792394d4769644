//! Oriented, signed edges of one block of bins.
//!
//! A boundary is continuous: along a wall at incidence phi the log range changes by tan(phi) per radian of azimuth, and the
//! difference of gray levels across it keeps its sign. The differences of neighbouring bins are therefore averaged, with
//! their signs, along several slopes: texture cancels, a faint but long boundary remains.

use super::cells::ROWS;
use super::polar::OWNER_BYTES;
use crate::base::num::BINS;
use bytemuck::{Pod, Zeroable};

/// Bins of a block.
pub(super) const WIDTH: usize = 40;
/// Bins on either side that an oriented mean takes in.
pub(super) const REACH: usize = 3;
/// Bins that an oriented mean takes in.
pub(super) const TAPS: usize = 2 * REACH + 1;
/// [`TAPS`] as a count of known differences.
#[expect(clippy::cast_possible_truncation, reason = "7")]
pub(super) const ALL_TAPS: u8 = TAPS as u8;
/// Bins of a block with those on either side.
const PADDED: usize = WIDTH + 2 * REACH;
/// Differences are taken over this many rows on either side.
pub(super) const SPANS: [usize; 2] = [1, 4];
/// From the difference of the sums over a span to that of its means in quarters of gray levels.
const SCALES: [i16; 2] = [4, 1];

/// Slopes of a boundary, in rows over the bins from 3 to the right to 3 to the left: 0 and +-0.6 rungs per degree. Steeper ones
/// found no more.
pub(super) const SLOPES: [[isize; TAPS]; 3] = [[0; 7], [-4, -2, -1, 0, 1, 2, 4], [4, 2, 1, 0, -1, -2, -4]];

/// The gray levels of a block of bins, and their differences along the range axis.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Block {
    /// Gray levels, 0 where unknown, by row and padded bin.
    gray: [[u8; PADDED]; ROWS],
    owner: [[u8; PADDED]; ROWS],
    /// Over each of [`SPANS`].
    pub(super) differences: [Differences; 2],
}

/// Differences of gray levels over a span of rows on either side.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Differences {
    /// Quarters of gray levels, 0 where unknown.
    difference: [[i16; PADDED]; ROWS],
    /// 1 where the difference is known, else 0.
    known: [[u8; PADDED]; ROWS],
    /// Whether all differences of a row are known.
    whole: [u8; ROWS + 1],
}

/// Sums over the known of seven differences.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums {
    pub(super) sum: [i16; WIDTH],
    pub(super) squares: [i32; WIDTH],
    /// How many are known; `None` if all are, everywhere.
    pub(super) count: Option<[u8; WIDTH]>,
}

impl Block {
    /// Takes the block that begins at a bin from the raster of one surface.
    #[inline(always)]
    pub(super) fn take(&mut self, gray: &[u8], owner: &[[u8; OWNER_BYTES]], first: usize) {
        let rows = gray.chunks_exact(BINS).zip(owner);
        for ((out, owners), (row, bits)) in self.gray.iter_mut().zip(&mut self.owner).zip(rows) {
            for ((offset, out), owner) in (BINS - REACH..).zip(out).zip(owners) {
                let bin = (first + offset) % BINS;
                *out = row.get(bin).copied().unwrap_or(0);
                *owner = bits.get(bin / 8).copied().unwrap_or(0) >> (bin % 8) & 1;
            }
        }
        for ((span, scale), differences) in SPANS.into_iter().zip(SCALES).zip(&mut self.differences) {
            differences.fill(&self.gray, &self.owner, span, scale);
        }
    }

    /// The gray level of each padded bin at a row, 0 where unknown.
    pub(super) fn gray(&self, row: usize) -> &[u8; PADDED] {
        self.gray.get(row).unwrap_or(&[0; PADDED])
    }
}

impl Differences {
    /// Differences over a span by sums that move from row to row.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "bins are below the length of the arrays")]
    fn fill(&mut self, gray: &[[u8; PADDED]; ROWS], owner: &[[u8; PADDED]; ROWS], span: usize, scale: i16) {
        *self = Self::zeroed();
        // Sums of the rows before and behind, and the number of unknown cells in all of them.
        let (mut near, mut far, mut unknown) = ([0_i16; PADDED], [0_i16; PADDED], [0_u8; PADDED]);
        for (k, gray) in gray.iter().take(2 * span + 1).enumerate() {
            for b in 0..PADDED {
                let level = i16::from(gray[b]);
                near[b] += if k < span { level } else { 0 };
                far[b] += if k > span { level } else { 0 };
                unknown[b] += u8::from(level == 0);
            }
        }
        let rows = self.difference.iter_mut().zip(&mut self.known).zip(&mut self.whole).skip(span);
        let owners = owner.iter().zip(owner.iter().skip(2 * span));
        // The first row of the sums, the one between them, the one behind that, and the one that enters.
        let leaving = gray.iter().zip(gray.iter().skip(span));
        let entering = gray.iter().skip(span + 1).zip(gray.iter().skip(2 * span + 1).chain([&[0; PADDED]]));
        for ((((difference, known), whole), (first, last)), ((left, here), (ahead, entered))) in
            rows.zip(owners).zip(leaving.zip(entering))
        {
            *whole = 1;
            for b in 0..PADDED {
                let is_known = unknown[b] == 0 && first[b] == last[b];
                known[b] = u8::from(is_known);
                difference[b] = if is_known { (far[b] - near[b]) * scale } else { 0 };
                *whole &= known[b];
                near[b] += i16::from(here[b]) - i16::from(left[b]);
                far[b] += i16::from(entered[b]) - i16::from(ahead[b]);
                unknown[b] = unknown[b] + u8::from(entered[b] == 0) - u8::from(left[b] == 0);
            }
        }
    }

    /// Sums along a slope through a row.
    #[inline(always)]
    #[expect(
        clippy::indexing_slicing,
        reason = "a bin with its offset is below the length of the padded arrays"
    )]
    pub(super) fn sums(&self, row: usize, slope: &[isize; TAPS]) -> Sums {
        const NONE: (&[i16; PADDED], &[u8; PADDED]) = (&[0; PADDED], &[0; PADDED]);
        let mut whole = true;
        let rows = slope.map(|offset| {
            let at = row.wrapping_add_signed(offset);
            whole &= self.whole.get(at).is_some_and(|whole| *whole != 0);
            self.difference.get(at).zip(self.known.get(at)).unwrap_or(NONE)
        });
        let mut sums = Sums { sum: [0; WIDTH], squares: [0; WIDTH], count: None };
        for b in 0..WIDTH {
            let (mut sum, mut squares) = (0_i16, 0_i32);
            for (offset, (difference, _)) in rows.iter().enumerate() {
                let d = difference[b + offset];
                sum += d;
                squares += i32::from(d) * i32::from(d);
            }
            (sums.sum[b], sums.squares[b]) = (sum, squares);
        }
        if !whole {
            let known =
                |b: usize| rows.iter().enumerate().map(|(offset, (_, known))| known[b + offset]).sum();
            sums.count = Some(core::array::from_fn(known));
        }
        sums
    }
}
