//! Likelihoods of a surface averaged over the ranges between two candidates.

use crate::base::ladder::{NEAREST_M, NOMINAL_HEIGHT_M, RUNG};
use crate::base::num::{BINS, CellNats, round_to_i8, truncate_to_index};
use crate::vision::boundary::{BoundaryEvidence, CEILING_SHIFT, NOMINAL_RUNG, RUNGS};
use micromath::F32Ext;

/// Share of the spacing of candidates, to either side, over which ranges differ.
const SHARE: f32 = 0.3;
/// Largest number of rungs to either side.
const MOST_RUNGS: usize = 6;
/// Usual height of a ceiling above the camera, metres, for the ranges of its rungs.
const CEILING_M: f32 = 1.3;
/// Fractional bits of likelihoods.
const BITS: u32 = 8;

/// Averages rungs one after the other.
pub(super) struct Blur<'a> {
    evidence: &'a BoundaryEvidence<'a>,
    surface: usize,
    /// Half of the range over which likelihoods are averaged, rungs, at the first rung.
    reach_m: f32,
    /// Likelihood ratios by the bits of their logarithm, from -128 on, Q8.
    likelihoods: [u32; 256],
    /// Sums of likelihoods over `rungs`.
    sums: [u32; BINS],
    rungs: core::ops::Range<usize>,
}

impl<'a> Blur<'a> {
    pub(super) fn new(evidence: &'a BoundaryEvidence<'a>, surface: usize, spacing_m: f32) -> Self {
        let likelihoods = core::array::from_fn(|bits| {
            let nats = (bits as f32 - 128.0) / 16.0;
            crate::base::num::saturate_to_u32(truncate_to_index(F32Ext::exp(nats) * (1 << BITS) as f32 + 0.5))
        });
        let reach_m = spacing_m * SHARE;
        Self { evidence, surface, reach_m, likelihoods, sums: [0; BINS], rungs: 0..0 }
    }

    /// The mean of a rung and those around it, as a log-likelihood ratio; half of it for the ceiling. Rungs are asked for in
    /// ascending order.
    pub(super) fn rung(&mut self, rung: usize) -> [CellNats; BINS] {
        let height = if self.surface == 0 { NOMINAL_HEIGHT_M } else { CEILING_M };
        let range =
            NEAREST_M / NOMINAL_HEIGHT_M * height * libm::expf((rung as f32 - NOMINAL_RUNG as f32) * RUNG);
        let reach = truncate_to_index(self.reach_m / (range * RUNG)).min(MOST_RUNGS);
        let wanted = rung.saturating_sub(reach)..(rung + reach + 1).min(RUNGS);
        // Windows begin and end ever later, because ranges grow.
        while self.rungs.end < wanted.end {
            self.add(self.rungs.end, u32::wrapping_add);
            self.rungs.end += 1;
        }
        while self.rungs.end > wanted.end {
            self.rungs.end -= 1;
            self.add(self.rungs.end, u32::wrapping_sub);
        }
        while self.rungs.start < wanted.start {
            self.add(self.rungs.start, u32::wrapping_sub);
            self.rungs.start += 1;
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

    fn add(&mut self, rung: usize, operation: fn(u32, u32) -> u32) {
        let cells = self.evidence.rung(self.surface, Some(rung));
        for (sum, cell) in self.sums.iter_mut().zip(cells) {
            let likelihood = self.likelihoods.get((i16::from(cell.to_bits()) + 128).unsigned_abs() as usize);
            *sum = operation(*sum, likelihood.copied().unwrap_or(0));
        }
    }
}
