//! From edges to likelihoods of ranges.

use super::{LEAD, RUNGS};
use crate::base::ladder::{NEAREST_M, RANGE_RUNGS, RUNG, height_rungs};
use crate::base::num::{BINS, CellNats, Nats, ToFloat as _};
use bytemuck::{Pod, Zeroable};

/// Rungs by which the ceiling may lie higher above the camera than the floor below it.
pub(super) const CEILINGS: [i8; 2] = [-16, 28];
/// Least and largest height of a room, metres.
const ROOMS_M: [f32; 2] = [2.0, 4.5];
/// Share of directions in which what is seen says nothing of the plan, in 1/10.
const OUTLIERS_TENTHS: u32 = 3;
/// A range is one of so many, as likely as each other before looking.
const CHOICES: u32 = RANGE_RUNGS as u32;
/// Rungs on either side of the best that still count as agreeing with it.
const AGREEING: usize = 2;

/// Log-likelihood of a range before looking, the bits of [`BinNats`](crate::base::num::BinNats):
/// 1.3 x - 2.87 x^2, x from -1 at the first rung of the ladder to 1 at the last, at the nominal height.
static PRIOR: [i16; RUNGS] = {
    let mut prior = [0; RUNGS];
    let mut rung = 0;
    while rung < RUNGS {
        let x = 2 * (rung as i32 - LEAD as i32) - (RANGE_RUNGS as i32 - 1);
        let span = RANGE_RUNGS as i32 - 1;
        prior[rung] = ((2080 * span * x - 4592 * x * x) / (100 * span * span)) as i16;
        rung += 1;
    }
    prior
};

/// e^(-k/16) in 1/65536, until nothing is left of it.
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

/// Likelihood ratio in 1/256 from which its logarithm rounds to -19/16, -18/16 ... nat.
static RATIOS: [u32; 84] = {
    /// 256 e^(-19.5/16) in Q20 and e^(1/16) in Q32.
    const FIRST: u64 = 79_349_369;
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

/// How many of [`RATIOS`] are not above a ratio of these [leading bits](leading): at the most one more is not above any
/// ratio that begins so.
static PASSED: [u8; 15 << LEADING_BITS] = {
    let mut passed = [0; 15 << LEADING_BITS];
    let mut ratio = 1 << 14;
    let mut count = RATIOS.len();
    // Downwards: the least ratio that begins so has the last word.
    while ratio > 1 {
        ratio -= 1;
        while count > 0 && RATIOS[count - 1] > ratio {
            count -= 1;
        }
        passed[leading(ratio)] = count as u8;
    }
    passed
};
/// Bits after the first that tell ratios 1/32 apart or nearer: logarithms to the sixteenth are farther apart.
const LEADING_BITS: u32 = 5;

/// The exponent of a ratio and the bits after the first.
const fn leading(ratio: u32) -> usize {
    // The exponent of 0 would be a panic.
    let exponent = (ratio | 1).ilog2();
    let bits = if exponent < LEADING_BITS {
        ratio << (LEADING_BITS - exponent)
    } else {
        ratio >> (exponent - LEADING_BITS)
    };
    ((exponent << LEADING_BITS) + (bits - (1 << LEADING_BITS))) as usize
}

/// Per azimuth, how likely the wall stands at each rung of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct RangeLikelihoods {
    /// Log-likelihood ratio against knowing nothing, per rung and bin.
    values: [[CellNats; BINS]; RUNGS],
    /// 1 for bins of which enough floor or ceiling was seen, else 0.
    pub(super) known: [u8; BINS],
    /// The ceiling is so many rungs higher above the camera than the floor is below it.
    pub(super) ceiling: i8,
}

/// The likeliest range of a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Metres.
    pub metres: f32,
    /// Share of the evidence that lies within two rungs of it, 0 to 1: how often it is right to about 10 %.
    pub confidence: f32,
}

impl RangeLikelihoods {
    /// Nothing is known.
    pub const EMPTY: Self = Self { values: [[CellNats::ZERO; BINS]; RUNGS], known: [0; BINS], ceiling: 0 };

    /// Height of the ceiling above the camera in heights of the camera above the floor.
    #[must_use]
    pub fn ceiling_ratio(&self) -> f32 {
        libm::expf(f32::from(self.ceiling) * RUNG)
    }

    /// Heights of the camera, as [`height_rungs`], that make a room of usual height.
    #[must_use]
    pub fn heights(&self) -> core::ops::RangeInclusive<i8> {
        let whole = 1.0 + self.ceiling_ratio();
        let [low, high] = ROOMS_M.map(|room| height_rungs(room / whole));
        low..=high
    }

    /// Whether anything was seen in this bin.
    #[must_use]
    pub fn knows(&self, bin: usize) -> bool {
        self.known.get(bin).is_some_and(|known| *known != 0)
    }

    /// Log-likelihood ratios of a ladder of ranges for a camera height given as [`height_rungs`]: row k for
    /// rung k of the [ladder](crate::base::ladder).
    pub fn row(&self, rung: usize, height: i8) -> &[CellNats; BINS] {
        const NOTHING: [CellNats; BINS] = [CellNats::ZERO; BINS];
        let at = (rung + LEAD).saturating_add_signed(-isize::from(height)).min(RUNGS - 1);
        self.values.get(at).unwrap_or(&NOTHING)
    }

    /// The likeliest range of a bin for a camera height; `None` where nothing was seen.
    #[must_use]
    pub fn range(&self, bin: usize, height: i8) -> Option<Range> {
        if !self.knows(bin) {
            return None;
        }
        let value =
            |rung: usize| self.values.get(rung).and_then(|row| row.get(bin)).copied().unwrap_or(LOWEST);
        let best = (0..RUNGS).rev().max_by_key(|rung| value(*rung))?;
        let (mut mass, mut moment) = (0.0, 0.0);
        for rung in best.saturating_sub(AGREEING)..=(best + AGREEING).min(RUNGS - 1) {
            let share = share(value(rung));
            mass += share;
            moment += share * (rung as f32 - best as f32);
        }
        let rung = best as f32 + if mass > 0.0 { moment / mass } else { 0.0 } + f32::from(height);
        let metres = NEAREST_M * libm::expf((rung - LEAD as f32) * RUNG);
        Some(Range { metres, confidence: mass.clamp(0.0, 1.0) })
    }
}

/// The share of the probability that a log-likelihood ratio stands for.
fn share(value: CellNats) -> f32 {
    let outliers = OUTLIERS_TENTHS as f32 / 10.0;
    ((libm::expf(value.to_float()) - outliers) / (1.0 - outliers) / CHOICES as f32).max(0.0)
}

/// Bounds of the ceiling for a camera at a known height.
pub(super) fn ceilings(height_m: f32) -> [i8; 2] {
    ROOMS_M.map(|room| {
        let ratio = ((room - height_m) / height_m).max(0.1);
        (libm::roundf(libm::logf(ratio) / RUNG) as i8).clamp(CEILINGS[0], CEILINGS[1])
    })
}

/// Every how many-th direction is asked where the ceiling is: those beside see the same walls.
const ASKED: usize = 3;

/// How well the directions see both boundaries at one range, if the ceiling is at a height: the sum of each one's best.
pub(super) fn agreement(floor: &[u8], ceiling: &[u8], offset: i8) -> Nats {
    let mut best = [i16::MIN; BINS / ASKED];
    for (rung, prior) in PRIOR.iter().enumerate() {
        let (floor, ceiling) = rows(floor, ceiling, rung, offset);
        let asked = floor.as_chunks::<ASKED>().0.iter().zip(ceiling.as_chunks::<ASKED>().0);
        for (best, ([floor, ..], [ceiling, ..])) in best.iter_mut().zip(asked) {
            *best = (*best).max(i16::from(*floor) + i16::from(*ceiling) + prior);
        }
    }
    Nats::from_bits(best.iter().map(|best| i32::from(*best)).sum())
}

/// The rows of both surfaces that a wall at a rung shows.
fn rows<'a>(floor: &'a [u8], ceiling: &'a [u8], rung: usize, offset: i8) -> (&'a [u8; BINS], &'a [u8; BINS]) {
    const NOTHING: [u8; BINS] = [0; BINS];
    let row = |of: &'a [u8], rung: isize| {
        usize::try_from(rung).ok().and_then(|rung| of.as_chunks::<BINS>().0.get(rung)).unwrap_or(&NOTHING)
    };
    let rung = rung as isize;
    (row(floor, rung), row(ceiling, rung - isize::from(offset)))
}

/// Fills in the likelihood of every rung, given where the ceiling is.
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

fn decay(below: i16) -> u32 {
    DECAY.get(below.unsigned_abs() as usize).copied().unwrap_or(0)
}

/// Logarithm of (1 - outliers) choices part / sum + outliers.
fn log_ratio(part: u32, sum: u32) -> CellNats {
    // A part is at most 2^16, so that the product stays below 2^31.
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
        assert_eq!(log_ratio(65_536, 65_536), CellNats::from_bits(63), "all of it in one rung");
        assert!(log_ratio(0, 0) < CellNats::ZERO, "no sum is no crash");
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
