//! From oriented edges to log-likelihood ratios: a conditional logit over the rows and slopes of each bin.

use super::block::{ALL_TAPS, Block, REACH, SLOPES, Sums, TAPS, WIDTH};
use super::cells::{ROWS, RUNGS, row_of};
use super::logarithms::{Logarithms, to_logit};
use super::polar::OWNER_BYTES;
use super::tuning::{
    FEWEST_RUNGS, FEWEST_TAPS, LEAST_SCALE, NOISE_VARIANCE, OUTLIERS, PERCENT, REGION_ROWS, Weights,
};
use crate::base::num::{BINS, CellNats, count_as_i32};
use bytemuck::{Pod, Zeroable};

/// Quarters of gray levels that a histogram of edges tells apart.
const LEVELS: usize = 1024;

/// Working memory of one block of bins.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Work {
    block: Block,
    pub(super) logarithms: Logarithms,
    histograms: [[u32; LEVELS]; 2],
    /// Probability of a boundary, not normalized, by the weights of each variant, rung and bin.
    mass: [[[f32; WIDTH]; RUNGS]; 2],
    /// Sums of the region's log-likelihood ratios over three bins and the rows before each, 1/768 nat.
    region: [[i32; WIDTH]; ROWS + 1],
}

/// One surface of the raster.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'a> {
    pub(super) gray: &'a [u8],
    pub(super) owner: &'a [[u8; OWNER_BYTES]],
}

/// How a surface is weighed: the mean probability of its variants, spread by the tolerance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighing<'a> {
    pub(super) variants: &'a [Weights],
    /// Log-likelihood ratio of "floor" by gray level, 1/256 nat.
    pub(super) region: &'a [i16; 256],
    pub(super) tolerance: (isize, &'a [f32]),
}

/// Strength and significance of an oriented edge at both spans, as indices of logarithms.
type Features = [[u32; WIDTH]; 4];

impl Work {
    /// Fills `cells` with the log-likelihood ratios of a boundary at each rung and bin.
    #[inline(always)]
    pub(super) fn weigh(&mut self, surface: &Surface<'_>, weighing: &Weighing<'_>, cells: &mut [CellNats]) {
        let scales = self.scales(surface);
        for first in (0..BINS).step_by(WIDTH) {
            self.block.take(surface.gray, surface.owner, first);
            if weighing.variants.iter().any(|weights| weights.region != [0; 2]) {
                self.sum_region(weighing.region);
            }
            self.add_mass(scales, weighing.variants);
            self.normalize(weighing.variants.len());
            self.spread(weighing, first, cells);
        }
    }

    /// Percentile of the level edges at each span, gray levels, of every third block.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "levels are below 1024")]
    fn scales(&mut self, surface: &Surface<'_>) -> [f32; 2] {
        self.histograms = [[0; LEVELS]; 2];
        for first in (0..BINS).step_by(3 * WIDTH) {
            self.block.take(surface.gray, surface.owner, first);
            for (differences, histogram) in self.block.differences.iter().zip(&mut self.histograms) {
                for rung in 0..RUNGS {
                    let Sums { sum, count, .. } = differences.sums(row_of(rung), &SLOPES[0]);
                    let count = count.unwrap_or([ALL_TAPS; WIDTH]);
                    for (sum, count) in sum.iter().zip(count) {
                        let level = u32::from(sum.unsigned_abs()) / u32::from(count.max(1));
                        let counts = count >= FEWEST_TAPS && *sum != 0;
                        histogram[(level as usize).min(LEVELS - 1)] += u32::from(counts);
                    }
                }
            }
        }
        self.histograms.map(|histogram| {
            let wanted = histogram.iter().sum::<u32>() / 100 * PERCENT;
            let mut below = 0;
            let reached = histogram.iter().position(|count| {
                below += count;
                below > wanted
            });
            ((reached.unwrap_or(0) as f32 + 0.5) / 4.0).max(LEAST_SCALE)
        })
    }

    #[expect(clippy::indexing_slicing, reason = "gray levels index 256 ratios")]
    #[inline(always)]
    fn sum_region(&mut self, ratios: &[i16; 256]) {
        self.region[0] = [0; WIDTH];
        for row in 0..ROWS {
            let gray = self.block.gray(row).map(|gray| i32::from(ratios[usize::from(gray)]));
            for b in 0..WIDTH {
                let three: i32 = gray[b + REACH - 1..=b + REACH + 1].iter().sum();
                self.region[row + 1][b] = self.region[row][b] + three;
            }
        }
    }

    /// Sums e^logit over the slopes.
    #[expect(
        clippy::indexing_slicing,
        reason = "rows, bins and variants are below the lengths of the arrays"
    )]
    #[inline(always)]
    fn add_mass(&mut self, scales: [f32; 2], variants: &[Weights]) {
        let tables = &self.logarithms;
        let [first, second] = &mut self.mass;
        for (rung, (first, second)) in first.iter_mut().zip(second).enumerate() {
            let row = row_of(rung);
            let u = 2.0 * row as f32 / (ROWS as f32 - 1.0) - 1.0;
            let [here, near, behind, far] =
                [row, row.saturating_sub(REGION_ROWS), row + 1, (row + 1 + REGION_ROWS).min(ROWS)]
                    .map(|row| self.region.get(row).unwrap_or(&[0; WIDTH]));
            let mut priors = [[0; WIDTH]; 2];
            for (weights, priors) in variants.iter().zip(&mut priors) {
                *priors = [to_logit(weights.linear * u + weights.square * u * u); WIDTH];
                if weights.region != [0; 2] {
                    for (b, prior) in priors.iter_mut().enumerate() {
                        // Sums of three bins and eight rows, 1/256 nat, times 1/256.
                        let [nearer, farther] = [here[b] - near[b], behind[b] - far[b]];
                        *prior += (weights.region[0] * nearer + weights.region[1] * farther)
                            / (3 * count_as_i32(REGION_ROWS));
                    }
                }
            }
            let mut mass = [[0.0_f32; WIDTH]; 2];
            for slope in &SLOPES {
                let features = features(&self.block, row, slope, scales);
                for b in 0..WIDTH {
                    let [g1, t1, g4, t4] = features.each_ref().map(|feature| feature[b]);
                    let logs =
                        [tables.at(g1), tables.significance(t1), tables.at(g4), tables.significance(t4)];
                    for ((weights, priors), mass) in variants.iter().zip(&priors).zip(&mut mass) {
                        let sum: i32 = weights.edges.iter().zip(logs).map(|(weight, log)| weight * log).sum();
                        mass[b] += tables.exp(sum + priors[b]);
                    }
                }
            }
            let gray = self.block.gray(row);
            for (out, mass) in [first, second].into_iter().zip(mass) {
                for b in 0..WIDTH {
                    out[b] = if gray[b + REACH] > 0 { mass[b] } else { 0.0 };
                }
            }
        }
    }

    /// Replaces the mass of the first variant by the probability of each row, the mean of the variants.
    #[expect(
        clippy::indexing_slicing,
        reason = "rows, bins and variants are below the lengths of the arrays"
    )]
    #[inline(always)]
    fn normalize(&mut self, variants: usize) {
        let shares = self.mass.each_ref().map(|mass| {
            let mut whole = [f32::MIN_POSITIVE; WIDTH];
            for row in mass {
                for b in 0..WIDTH {
                    whole[b] += row[b];
                }
            }
            whole.map(|whole| 1.0 / (whole * variants as f32))
        });
        let [first, second] = &mut self.mass;
        for (row, other) in first.iter_mut().zip(second) {
            for b in 0..WIDTH {
                let beside = if variants > 1 { other[b] * shares[1][b] } else { 0.0 };
                row[b] = row[b] * shares[0][b] + beside;
            }
        }
    }

    /// Spreads the probabilities by the tolerance; stores their log-likelihood ratios. What is not seen speaks neither for a
    /// boundary nor against it.
    #[inline(always)]
    #[expect(clippy::indexing_slicing, reason = "rungs and bins are below the lengths of the arrays")]
    fn spread(&self, weighing: &Weighing<'_>, first: usize, cells: &mut [CellNats]) {
        let mut known = [0_u8; WIDTH];
        for rung in 0..RUNGS {
            let gray = self.block.gray(row_of(rung));
            for b in 0..WIDTH {
                known[b] += u8::from(gray[b + REACH] > 0);
            }
        }
        let (least, kernel) = weighing.tolerance;
        for (rung, out) in cells.chunks_exact_mut(BINS).take(RUNGS).enumerate() {
            let mut spread = [0.0_f32; WIDTH];
            let mut unseen = [1.0_f32; WIDTH];
            for (share, distance) in kernel.iter().zip(least..) {
                let rung = rung.wrapping_add_signed(distance);
                let Some(mass) = self.mass[0].get(rung) else { continue };
                let gray = self.block.gray(row_of(rung));
                for b in 0..WIDTH {
                    spread[b] += share * mass[b];
                    unseen[b] -= if gray[b + REACH] > 0 { *share } else { 0.0 };
                }
            }
            for (b, out) in out.iter_mut().skip(first).take(WIDTH).enumerate() {
                if known[b] < FEWEST_RUNGS {
                    *out = CellNats::ZERO;
                    continue;
                }
                // Against a boundary that is equally likely at each rung seen.
                let ratio = f32::from(known[b]) * spread[b] + unseen[b];
                // Twice the ratio, so that its logarithm is not negative: ln 2 is 177/256.
                let nats = self.logarithms.ln(2.0 * ((1.0 - OUTLIERS) * ratio + OUTLIERS)) - 177;
                // 1/256 nat to 1/16 nat, rounded.
                let bits = ((nats + 8) >> 4).clamp(i8::MIN.into(), i8::MAX.into());
                *out = CellNats::from_bits(i8::try_from(bits).unwrap_or_default());
            }
        }
    }
}

/// Features along a slope through a row: strength over the frame's scale, and significance, at both spans.
#[inline(always)]
#[expect(clippy::indexing_slicing, reason = "bins and features are below the lengths of the arrays")]
fn features(block: &Block, row: usize, slope: &[isize; TAPS], scales: [f32; 2]) -> Features {
    let mut features = [[0; WIDTH]; 4];
    let pairs = features.as_chunks_mut::<2>().0.iter_mut();
    for ((differences, scale), [strengths, significances]) in block.differences.iter().zip(scales).zip(pairs)
    {
        let Sums { sum, squares, count } = differences.sums(row, slope);
        // Of quarters of gray levels.
        let strength = 2.0 / (4.0 * scale);
        let mut set = |b: usize, sum: f32, n: f32, inverse: f32| {
            let sum = sum.abs();
            // The sum over the deviation of a sum: n times the mean over n times the deviation of the mean. The squares of
            // whole numbers are exact, so that the difference is not negative.
            let variance = (n * squares[b] as f32 - sum * sum) * inverse + 16.0 * NOISE_VARIANCE * n * n;
            strengths[b] = Logarithms::index(1.0 + strength * inverse * sum);
            significances[b] = Logarithms::square_index(sum * sum / variance);
        };
        match count {
            None => (0..WIDTH).for_each(|b| set(b, f32::from(sum[b]), TAPS as f32, 1.0 / TAPS as f32)),
            Some(count) => (0..WIDTH).for_each(|b| {
                let enough = count[b] >= FEWEST_TAPS;
                let (sum, n) = if enough { (f32::from(sum[b]), f32::from(count[b])) } else { (0.0, 1.0) };
                set(b, sum, n, 1.0 / n);
            }),
        }
    }
    features
}
