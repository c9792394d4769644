//! Log-likelihood ratios of ranges, from boundary evidence and the height of the ceiling.

use super::cells::{NOMINAL_RUNG, RUNGS, rung_of};
use super::evidence::BoundaryEvidence;
use super::tuning::{AGREEING, CEILING_SHIFT, CEILINGS, ROOMS_M, VOTE_STRIDE};
use crate::base::ladder::{NEAREST_M, RUNG, height_m, height_rungs};
use crate::base::num::{BINS, CellNats, Nats, ToFloat as _, count_as_i32, round_to_i8};
use bytemuck::{Pod, Zeroable};

/// Per azimuth, the log-likelihood ratios of a wall at each range rung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct RangeLikelihoods {
    /// Log-likelihood ratio against "nothing known", by rung of the floor and bin.
    values: [[CellNats; BINS]; RUNGS],
    /// 1 for [known](super::BoundaryEvidence::known) bins, else 0.
    known: [u8; BINS],
    /// Height of the ceiling above the camera against the camera height, rungs.
    ceiling: i8,
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
        let at = (rung + NOMINAL_RUNG).saturating_add_signed(-isize::from(height)).min(RUNGS - 1);
        self.values.get(at).unwrap_or(&NOTHING)
    }

    /// The most likely range of a bin for a camera height as [`height_rungs`]; `None` for a bin that is not known.
    ///
    /// # Formats
    /// Metres: the mean over the rungs within two of the most likely one, weighted by posterior probability. Bins are not taken
    /// modulo 360: those from 360 on are not known.
    ///
    /// # Cost
    /// An exponential for each of the 90 rungs.
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
        let value = |rung: usize| {
            self.values.get(rung).and_then(|row| row.get(bin)).copied().unwrap_or(CellNats::MIN).to_float()
        };
        let best = (0..RUNGS).rev().max_by(|a, b| value(*a).total_cmp(&value(*b)))?;
        let whole: f32 = (0..RUNGS).map(|rung| libm::expf(value(rung))).sum();
        let (mut mass, mut moment) = (0.0, 0.0);
        for rung in best.saturating_sub(AGREEING)..=(best + AGREEING).min(RUNGS - 1) {
            let probability = libm::expf(value(rung)) / whole;
            mass += probability;
            moment += probability * (rung as f32 - best as f32);
        }
        let rung = best as f32 + if mass > 0.0 { moment / mass } else { 0.0 } + f32::from(height);
        let metres = NEAREST_M * libm::expf((rung - NOMINAL_RUNG as f32) * RUNG);
        Some(RangeEstimate { metres, confidence: mass.clamp(0.0, 1.0) })
    }
}

impl BoundaryEvidence<'_> {
    /// Computes the log-likelihood ratios of ranges for a height of the ceiling: its shift in rungs above the camera against
    /// the camera height, clamped to -20 to 28 rungs.
    ///
    /// # Formats
    /// Sums of the floor's ratio and half of the ceiling's, in [`CellNats`].
    ///
    /// # Accuracy
    /// [`EVIDENCE_ERROR`](super::EVIDENCE_ERROR), which `compass compare` checks against `f64`.
    ///
    /// # Cost
    /// A pass over the cells.
    ///
    /// ```
    /// use compass_core::base::num::CellNats;
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS, RangeLikelihoods};
    ///
    /// // Floor at rung 30, ceiling at rung 25, in all directions.
    /// let mut cells = vec![-CellNats::ONE / 2; CELLS];
    /// cells[30 * 360..31 * 360].fill(CellNats::ONE * 3);
    /// cells[(RUNGS + 25) * 360..(RUNGS + 26) * 360].fill(CellNats::ONE * 2);
    /// let evidence = BoundaryEvidence::new(&cells).unwrap();
    /// let mut ranges = RangeLikelihoods::EMPTY;
    /// evidence.ranges(5, &mut ranges);
    /// // Rung 30 is rung 21 of the range ladder for the nominal camera height: 1.43 m.
    /// let found = ranges.range(0, 0).unwrap();
    /// assert!((found.metres - 1.43).abs() < 0.02, "{found:?}");
    /// ```
    pub fn ranges(&self, ceiling: i8, ranges: &mut RangeLikelihoods) {
        ranges.known = self.known().map(u8::from);
        ranges.ceiling = ceiling.clamp(CEILINGS[0], CEILINGS[1]);
        fill(ranges, self);
    }

    /// A guess of the ceiling without a plan: the height at which both boundaries agree best on the ranges. `height`, a known
    /// camera height in [rungs](crate::base::ladder::height_rungs), restricts it to ceilings 2.0 to 4.5 m above the floor.
    ///
    /// # Formats
    /// The shift in rungs of the ceiling's height above the camera against the camera height; 0 if nothing was seen.
    ///
    /// # Cost
    /// A pass over a third of the cells for each of at most 49 heights.
    #[must_use]
    pub fn guess_ceiling(&self, height: Option<i8>) -> i8 {
        let [least, most] = height.map_or(CEILINGS, |rungs| ceiling_bounds(height_m(rungs)));
        let likeliest = |ceiling: &i8| (agreement(self, *ceiling), -i16::from(*ceiling).abs());
        let best = (least..=most).max_by_key(likeliest).unwrap_or(0);
        if agreement(self, best) > Nats::ZERO { best } else { 0 }
    }

    /// Computes the log-likelihood ratios of ranges for a [guess](Self::guess_ceiling) of the ceiling.
    pub fn likeliest(&self, height: Option<i8>, ranges: &mut RangeLikelihoods) {
        self.ranges(self.guess_ceiling(height), ranges);
    }
}

/// Smallest and largest shift of the ceiling for a known camera height.
fn ceiling_bounds(height_m: f32) -> [i8; 2] {
    ROOMS_M.map(|room| {
        let ratio = ((room - height_m) / height_m).max(0.1);
        round_to_i8(libm::logf(ratio) / RUNG).clamp(CEILINGS[0], CEILINGS[1])
    })
}

/// How well both boundaries agree for a ceiling: the sum over every third bin of its largest evidence of one range.
fn agreement(evidence: &BoundaryEvidence<'_>, ceiling: i8) -> Nats {
    let mut best = [i16::MIN; BINS / VOTE_STRIDE];
    for rung in 0..RUNGS {
        let [floor, above] = rows(evidence, rung, ceiling);
        let sampled = floor.as_chunks::<VOTE_STRIDE>().0.iter().zip(above.as_chunks::<VOTE_STRIDE>().0);
        for (best, ([floor, ..], [above, ..])) in best.iter_mut().zip(sampled) {
            *best = (*best).max(i16::from(floor.to_bits()) + (i16::from(above.to_bits()) >> CEILING_SHIFT));
        }
    }
    Nats::from_bits(best.iter().map(|best| i32::from(*best)).sum())
}

/// The rows of floor and ceiling evidence of a wall at a rung of the floor.
fn rows<'a>(evidence: &BoundaryEvidence<'a>, rung: usize, ceiling: i8) -> [&'a [CellNats; BINS]; 2] {
    let rung = count_as_i32(rung) - count_as_i32(NOMINAL_RUNG);
    [(0, 0), (1, ceiling.into())].map(|(surface, height)| evidence.rung(surface, rung_of(rung, height)))
}

/// Computes the log-likelihood ratios of all rungs, given the height of the ceiling.
fn fill(ranges: &mut RangeLikelihoods, evidence: &BoundaryEvidence<'_>) {
    for (rung, row) in ranges.values.iter_mut().enumerate() {
        let [floor, above] = rows(evidence, rung, ranges.ceiling);
        for ((value, floor), above) in row.iter_mut().zip(floor).zip(above) {
            *value = floor.saturating_add(CellNats::from_bits(above.to_bits() >> CEILING_SHIFT));
        }
    }
}
