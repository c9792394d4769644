//! Likelihoods of a surface averaged over the ranges between two candidates.

use crate::base::ladder::{NEAREST_M, NOMINAL_HEIGHT_M, RUNG};
use crate::base::num::{BINS, CellNats, round_to_i8, truncate_to_index};
use crate::vision::boundary::{BoundaryEvidence, CEILING_SHIFT, ROWS};
use micromath::F32Ext;

/// Share of the spacing of candidates, to either side, over which ranges differ.
const SHARE: f32 = 0.3;
/// Largest number of rows to either side.
const MOST_ROWS: usize = 12;
/// Usual height of a ceiling above the camera, metres, for the ranges of its rows.
const CEILING_M: f32 = 1.3;
/// Fractional bits of likelihoods.
const BITS: u32 = 8;

/// Averages rows one after the other.
pub(super) struct Blur<'a> {
    evidence: &'a BoundaryEvidence<'a>,
    surface: usize,
    /// Half of the range over which likelihoods are averaged, rows, at the first row.
    reach_m: f32,
    /// Likelihood ratios by the bits of their logarithm, from -128 on, Q8.
    likelihoods: [u32; 256],
    /// Sums of likelihoods over `rows`.
    sums: [u32; BINS],
    rows: core::ops::Range<usize>,
}

impl<'a> Blur<'a> {
    pub(super) fn new(evidence: &'a BoundaryEvidence<'a>, surface: usize, spacing_m: f32) -> Self {
        let likelihoods = core::array::from_fn(|bits| {
            let nats = (bits as f32 - 128.0) / 16.0;
            crate::base::num::saturate_to_u32(truncate_to_index(F32Ext::exp(nats) * (1 << BITS) as f32 + 0.5))
        });
        let reach_m = spacing_m * SHARE;
        Self { evidence, surface, reach_m, likelihoods, sums: [0; BINS], rows: 0..0 }
    }

    /// The mean of a row and those around it, as a log-likelihood ratio; half of it for the ceiling. Rows are asked for in
    /// ascending order.
    pub(super) fn row(&mut self, row: usize) -> [CellNats; BINS] {
        let height = if self.surface == 0 { NOMINAL_HEIGHT_M } else { CEILING_M };
        let range = NEAREST_M / NOMINAL_HEIGHT_M * height * libm::expf((row as f32 / 2.0 - 9.5) * RUNG);
        let reach = truncate_to_index(self.reach_m / (range * RUNG / 2.0)).min(MOST_ROWS);
        let wanted = row.saturating_sub(reach)..(row + reach + 1).min(ROWS);
        // Windows begin and end ever later, because ranges grow.
        while self.rows.end < wanted.end {
            self.add(self.rows.end, u32::wrapping_add);
            self.rows.end += 1;
        }
        while self.rows.end > wanted.end {
            self.rows.end -= 1;
            self.add(self.rows.end, u32::wrapping_sub);
        }
        while self.rows.start < wanted.start {
            self.add(self.rows.start, u32::wrapping_sub);
            self.rows.start += 1;
        }
        let count = wanted.len() as f32 * 3.0 * (1 << BITS) as f32;
        let halved = if self.surface == 0 { 0 } else { CEILING_SHIFT };
        core::array::from_fn(|bin| {
            let at = |bin: usize| self.sums.get(bin % BINS).copied().unwrap_or(0);
            let three = at(bin + BINS - 1) + at(bin) + at(bin + 1);
            let ratio = round_to_i8(16.0 * F32Ext::ln(three as f32 / count));
            CellNats::from_bits(ratio >> halved)
        })
    }

    fn add(&mut self, row: usize, operation: fn(u32, u32) -> u32) {
        let cells = self.evidence.row(self.surface, Some(row));
        for (sum, cell) in self.sums.iter_mut().zip(cells) {
            let likelihood = self.likelihoods.get((i16::from(cell.to_bits()) + 128).unsigned_abs() as usize);
            *sum = operation(*sum, likelihood.copied().unwrap_or(0));
        }
    }
}
