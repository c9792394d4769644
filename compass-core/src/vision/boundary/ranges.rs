//! Log-likelihood ratios of ranges, from boundary evidence and the height of the ceiling.

use super::cells::{LEAD, RUNGS};
use super::tuning::{AGREEING, CEILINGS, OUTLIERS_TENTHS, PRIOR_LINEAR, PRIOR_SQUARE, ROOMS_M, VOTE_STRIDE};
use crate::base::ladder::{NEAREST_M, RANGE_RUNGS, RUNG, height_rungs};
use crate::base::num::{BINS, CellNats, Nats, ToFloat as _, count_as_i32, round_to_i8};
use bytemuck::{Pod, Zeroable};

/// Number of ranges, equally likely under "nothing known".
#[expect(clippy::cast_possible_truncation, reason = "`RANGE_RUNGS` is 72")]
const CHOICES: u32 = RANGE_RUNGS as u32;

/// Log prior of a range, bits of [`BinNats`](crate::base::num::BinNats): 1.3 x - 2.87 x^2, with x from -1 at the first rung
/// of the range ladder to 1 at the last, for the nominal camera height.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "rung is below `RUNGS`, and the prior within 100 nats"
)]
static PRIOR: [i16; RUNGS] = {
    let mut prior = [0; RUNGS];
    let mut rung = 0;
    while rung < RUNGS {
        let span = count_as_i32(RANGE_RUNGS) - 1;
        let x = 2 * (count_as_i32(rung) - count_as_i32(LEAD)) - span;
        prior[rung] = ((PRIOR_LINEAR * span * x - PRIOR_SQUARE * x * x) / (100 * span * span)) as i16;
        rung += 1;
    }
    prior
};

/// e^(-k/16) in 1/65536, up to the last k at which it does not round to 0.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "k is below 192, and decays are at most 65536"
)]
static DECAY: [u32; 192] = {
    /// e^(-1/16) in Q62.
    const STEP: u128 = 4_332_278_087_304_955_904;
    let mut table = [0; 192];
    let mut value = 1_u128 << 62;
    let mut k = 0;
    while k < 192 {
        table[k] = ((value + (1 << 45)) >> 46) as u32;
        value = (value * STEP) >> 62;
        k += 1;
    }
    table
};

/// Likelihood ratios, 1/256, from which the logarithm rounds to -19/16, -18/16 and so on, nats.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "k is below 84, and ratios are below 2^14"
)]
static RATIOS: [u32; 84] = {
    /// 256 e^(-19.5/16) in Q20.
    const FIRST: u64 = 79_349_369;
    /// e^(1/16) in Q32.
    const STEP: u64 = 4_571_968_888;
    let mut table = [0; 84];
    let mut value = FIRST as u128;
    let mut k = 0;
    while k < 84 {
        table[k] = (value >> 20) as u32;
        value = (value * STEP as u128) >> 32;
        k += 1;
    }
    table
};
/// The logarithm below the first of [`RATIOS`].
const LOWEST: CellNats = CellNats::lit("-1.25");

/// Number of [`RATIOS`] that do not exceed the smallest ratio with the given [leading bits](leading): for every ratio with
/// these leading bits, at most one more does not exceed it.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "counts are at most 84, and ratios below 2^14 have an exponent of at most 13"
)]
static PASSED: [u8; 15 << LEADING_BITS] = {
    let mut passed = [0; 15 << LEADING_BITS];
    let mut ratio = 1 << 14;
    let mut count = RATIOS.len();
    // Descending: the smallest ratio of the same leading bits is written last.
    while ratio > 1 {
        ratio -= 1;
        while count > 0 && RATIOS[count - 1] > ratio {
            count -= 1;
        }
        passed[leading(ratio)] = count as u8;
    }
    passed
};
/// Bits after the leading 1 in the index. They resolve relative steps of 1/32, finer than the ratio e^(1/16) of
/// neighbouring entries.
const LEADING_BITS: u32 = 5;

/// Table index of a ratio: its exponent and the [`LEADING_BITS`] after the leading 1.
const fn leading(ratio: u32) -> usize {
    // `ilog2` of 0 panics.
    let exponent = (ratio | 1).ilog2();
    let bits = if exponent < LEADING_BITS {
        ratio << (LEADING_BITS - exponent)
    } else {
        ratio >> (exponent - LEADING_BITS)
    };
    ((exponent << LEADING_BITS) + (bits - (1 << LEADING_BITS))) as usize
}

/// Per azimuth, the log-likelihood ratios of a wall at each range rung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct RangeLikelihoods {
    /// Log-likelihood ratio against "nothing known", by rung and bin.
    values: [[CellNats; BINS]; RUNGS],
    /// 1 for [known](super::BoundaryEvidence::known) bins, else 0.
    pub(super) known: [u8; BINS],
    /// Height of the ceiling above the camera against the camera height, rungs.
    pub(super) ceiling: i8,
}

/// The most likely range of a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeEstimate {
    /// Range, metres.
    pub metres: f32,
    /// Posterior probability of the rungs within two of it, 0 to 1.
    pub confidence: f32,
}

impl RangeLikelihoods {
    /// Log-likelihood ratios of 0 and no known bin.
    pub const EMPTY: Self = Self { values: [[CellNats::ZERO; BINS]; RUNGS], known: [0; BINS], ceiling: 0 };

    /// Height of the ceiling above the camera divided by the height of the camera above the floor.
    ///
    /// ```
    /// assert_eq!(compass_core::vision::boundary::RangeLikelihoods::EMPTY.ceiling_ratio(), 1.0);
    /// ```
    #[must_use]
    pub fn ceiling_ratio(&self) -> f32 {
        libm::expf(f32::from(self.ceiling) * RUNG)
    }

    /// Camera heights, as [`height_rungs`], for which the ceiling is 2.0 to 4.5 m above the floor.
    ///
    /// ```
    /// // A ceiling as far above the camera as the floor is below: 1.0 to 2.25 m.
    /// assert_eq!(compass_core::vision::boundary::RangeLikelihoods::EMPTY.heights(), -7..=7);
    /// ```
    #[must_use]
    pub fn heights(&self) -> core::ops::RangeInclusive<i8> {
        let whole = 1.0 + self.ceiling_ratio();
        let [low, high] = ROOMS_M.map(|room| height_rungs(room / whole));
        low..=high
    }

    /// Whether the bin is [known](super::BoundaryEvidence::known).
    #[must_use]
    pub fn knows(&self, bin: usize) -> bool {
        self.known.get(bin).is_some_and(|known| *known != 0)
    }

    /// Log-likelihood ratios of all bins at a rung of the [range ladder](crate::base::ladder), for a camera height as
    /// [`height_rungs`].
    ///
    /// # Formats
    /// A camera height shifts rows; rows beyond the table are clamped to its first and last.
    ///
    /// ```
    /// let ranges = compass_core::vision::boundary::RangeLikelihoods::EMPTY;
    /// assert!(ranges.row(71, 8).iter().all(|ratio| ratio.is_zero()));
    /// ```
    pub fn row(&self, rung: usize, height: i8) -> &[CellNats; BINS] {
        const NOTHING: [CellNats; BINS] = [CellNats::ZERO; BINS];
        let at = (rung + LEAD).saturating_add_signed(-isize::from(height)).min(RUNGS - 1);
        self.values.get(at).unwrap_or(&NOTHING)
    }

    /// The most likely range of a bin for a camera height as [`height_rungs`]; `None` for a bin that is not known.
    ///
    /// # Formats
    /// Metres: the mean over the rungs within two of the most likely one, weighted by posterior probability. Bins are not taken
    /// modulo 360: those from 360 on are not known.
    ///
    /// # Cost
    /// One search over the 90 rungs, and at most six exponentials.
    ///
    /// ```
    /// let ranges = compass_core::vision::boundary::RangeLikelihoods::EMPTY;
    /// assert_eq!(ranges.range(0, 0), None);
    /// ```
    #[must_use]
    pub fn range(&self, bin: usize, height: i8) -> Option<RangeEstimate> {
        if !self.knows(bin) {
            return None;
        }
        let value =
            |rung: usize| self.values.get(rung).and_then(|row| row.get(bin)).copied().unwrap_or(LOWEST);
        let best = (0..RUNGS).rev().max_by_key(|rung| value(*rung))?;
        let (mut mass, mut moment) = (0.0, 0.0);
        for rung in best.saturating_sub(AGREEING)..=(best + AGREEING).min(RUNGS - 1) {
            let probability = probability(value(rung));
            mass += probability;
            moment += probability * (rung as f32 - best as f32);
        }
        let rung = best as f32 + if mass > 0.0 { moment / mass } else { 0.0 } + f32::from(height);
        let metres = NEAREST_M * libm::expf((rung - LEAD as f32) * RUNG);
        Some(RangeEstimate { metres, confidence: mass.clamp(0.0, 1.0) })
    }
}

/// The posterior probability of a rung, from its log-likelihood ratio.
fn probability(value: CellNats) -> f32 {
    let outliers = OUTLIERS_TENTHS as f32 / 10.0;
    ((libm::expf(value.to_float()) - outliers) / (1.0 - outliers) / CHOICES as f32).max(0.0)
}

/// Smallest and largest shift of the ceiling for a known camera height.
pub(super) fn ceiling_bounds(height_m: f32) -> [i8; 2] {
    ROOMS_M.map(|room| {
        let ratio = ((room - height_m) / height_m).max(0.1);
        round_to_i8(libm::logf(ratio) / RUNG).clamp(CEILINGS[0], CEILINGS[1])
    })
}

/// Vote of the directions for a ceiling height: the sum over every third bin of its largest evidence of both boundaries at
/// one range.
pub(super) fn agreement(floor: &[u8], ceiling: &[u8], offset: i8) -> Nats {
    let mut best = [i16::MIN; BINS / VOTE_STRIDE];
    for (rung, prior) in PRIOR.iter().enumerate() {
        let (floor, ceiling) = rows(floor, ceiling, rung, offset);
        let sampled = floor.as_chunks::<VOTE_STRIDE>().0.iter().zip(ceiling.as_chunks::<VOTE_STRIDE>().0);
        for (best, ([floor, ..], [ceiling, ..])) in best.iter_mut().zip(sampled) {
            *best = (*best).max(i16::from(*floor) + i16::from(*ceiling) + prior);
        }
    }
    Nats::from_bits(best.iter().map(|best| i32::from(*best)).sum())
}

/// The rows of floor and ceiling evidence of a wall at a rung.
fn rows<'a>(floor: &'a [u8], ceiling: &'a [u8], rung: usize, offset: i8) -> (&'a [u8; BINS], &'a [u8; BINS]) {
    const NOTHING: [u8; BINS] = [0; BINS];
    let row = |of: &'a [u8], rung: isize| {
        usize::try_from(rung).ok().and_then(|rung| of.as_chunks::<BINS>().0.get(rung)).unwrap_or(&NOTHING)
    };
    let rung = rung.cast_signed();
    (row(floor, rung), row(ceiling, rung - isize::from(offset)))
}

/// Computes the log-likelihood ratios of all rungs, given the height of the ceiling: a softmax over the rungs of each bin.
pub(super) fn fill(ranges: &mut RangeLikelihoods, floor: &[u8], ceiling: &[u8]) {
    let mut best = [i16::MIN; BINS];
    let evidence = |rung: usize, offset: i8| {
        let (floor, ceiling) = rows(floor, ceiling, rung, offset);
        let prior = PRIOR.get(rung).copied().unwrap_or(0);
        floor.iter().zip(ceiling).map(move |(floor, ceiling)| i16::from(*floor) + i16::from(*ceiling) + prior)
    };
    for rung in 0..RUNGS {
        for (best, here) in best.iter_mut().zip(evidence(rung, ranges.ceiling)) {
            *best = (*best).max(here);
        }
    }
    let mut sums = [0_u32; BINS];
    for rung in 0..RUNGS {
        for ((sum, best), here) in sums.iter_mut().zip(&best).zip(evidence(rung, ranges.ceiling)) {
            *sum += decay(best - here);
        }
    }
    for (rung, row) in ranges.values.iter_mut().enumerate() {
        let here = evidence(rung, ranges.ceiling);
        for ((((value, here), best), sum), known) in
            row.iter_mut().zip(here).zip(&best).zip(&sums).zip(&ranges.known)
        {
            *value = if *known != 0 { log_ratio(decay(best - here), *sum) } else { CellNats::ZERO };
        }
    }
}

/// e^(-below/16) in 1/65536.
fn decay(below: i16) -> u32 {
    DECAY.get(below.unsigned_abs() as usize).copied().unwrap_or(0)
}

/// Logarithm of (1 - outliers) choices part / sum + outliers, rounded to 1/16 nat.
#[expect(clippy::cast_possible_truncation, reason = "`RATIOS` has 84 entries")]
fn log_ratio(part: u32, sum: u32) -> CellNats {
    // A part is at most 2^16, so that the product is below 2^31.
    let share = part * ((10 - OUTLIERS_TENTHS) * CHOICES * 256 / 10 / 4) / (sum.max(1) / 4).max(1);
    let ratio = share + OUTLIERS_TENTHS * 256 / 10;
    let passed = PASSED.get(leading(ratio)).map_or(RATIOS.len(), |passed| usize::from(*passed));
    let more = RATIOS.get(passed).is_some_and(|least| *least <= ratio);
    LOWEST + CellNats::from_bits((passed + usize::from(more)) as i8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_ratios_are_rounded_logarithms() {
        let sum = 3 << 16;
        for part in [0, 1, 40, 700, 9_000, 30_000, 65_536] {
            let exact = (0.7 * 72.0 * f64::from(part) / f64::from(sum) + 0.3).ln();
            let found = log_ratio(part, sum).to_num::<f64>();
            assert!((found - exact).abs() <= 0.6 / 16.0, "{part}: {found} for {exact}");
        }
        assert_eq!(log_ratio(65_536, 65_536), CellNats::from_bits(63), "all probability on one rung");
        assert!(log_ratio(0, 0) < CellNats::ZERO, "a sum of 0");
    }

    #[test]
    fn leading_bits_find_the_logarithm() {
        for part in (0..=65_536).step_by(7) {
            for sum in [65_536, 70_001, 300_007, 90 << 16] {
                let share = part * ((10 - OUTLIERS_TENTHS) * CHOICES * 256 / 10 / 4) / (sum / 4);
                let ratio = share + OUTLIERS_TENTHS * 256 / 10;
                let passed = RATIOS.partition_point(|least| *least <= ratio) as i8;
                assert_eq!(log_ratio(part, sum), LOWEST + CellNats::from_bits(passed), "{part} of {sum}");
            }
        }
    }

    #[test]
    fn decay_is_exponential() {
        for (k, &value) in DECAY.iter().enumerate() {
            let exact = 65_536.0 * (-(k as f64) / 16.0).exp();
            assert!((f64::from(value) - exact).abs() <= 0.51, "{k}");
        }
        assert_eq!(decay(i16::MIN), 0);
    }

    #[test]
    fn the_prior_is_the_stated_parabola() {
        for (rung, &prior) in PRIOR.iter().enumerate() {
            let x = (rung as f64 - LEAD as f64) * 2.0 / 71.0 - 1.0;
            assert!((f64::from(prior) - 16.0 * (1.3 * x - 2.87 * x * x)).abs() <= 1.0, "{rung}");
        }
    }
}
