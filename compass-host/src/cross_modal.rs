//! Observed hit types against those of a plan (paper: cross-modal check).

use compass_core::base::confidence::Confidence;
use compass_core::base::num::BINS;
use compass_core::base::scan::{Hit, Scan};
use compass_core::descriptor::channels::hit_level;
use compass_core::descriptor::similarity::{Candidate, Query, Similarity, Weights};
use compass_core::descriptor::{Channel, Descriptor};

/// Agreement of the hit types observed from a pose with those cast from the plan there.
#[derive(Debug, Clone)]
pub struct CrossModal {
    /// Observed bins: those with a confidence above 0.
    pub known: [bool; BINS],
    /// Observed bins that have the same hit type in the plan.
    pub agreeing: usize,
    /// Cosine of the hit types at every shift of the heading.
    pub cosine: [f64; BINS],
    /// The same with the means removed.
    pub centred: [f64; BINS],
}

impl CrossModal {
    /// Compares an observation, weighted by `confidence`, with a scan of the plan.
    ///
    /// At shift s the heading of the observation is assumed to be s degrees ahead of the scan's, counter-clockwise.
    /// Bins of confidence 0 have no influence at any shift; all scores are exact.
    #[must_use]
    pub fn new(seen: &[Hit; BINS], confidence: &Confidence, plan: &Scan) -> Self {
        let known = confidence.sixteenths().map(|c| c > 0);
        let same = known.iter().zip(seen).zip(&plan.hit).filter(|((known, a), b)| **known && a == b);
        let agreeing = same.count();
        let mut descriptor = Descriptor::ZERO;
        descriptor.levels[Channel::HitType as usize] = seen.map(hit_level);
        let candidate = Candidate::from(&Descriptor::from(plan));
        let mut query = Box::new(Query::EMPTY);
        let mut scores = |similarity| {
            query.set(&descriptor, confidence, Weights::HIT_TYPE, similarity);
            std::array::from_fn(|shift| query.score(&candidate, shift).to_num())
        };
        let [cosine, centred] = [Similarity::Plain, Similarity::Centred].map(&mut scores);
        Self { known, agreeing, cosine, centred }
    }

    /// Number of observed bins.
    #[must_use]
    pub fn seen(&self) -> usize {
        self.known.iter().filter(|&&known| known).count()
    }

    /// The shift of the best centred score, -179 to 180: the heading of the observation less the scan's, in degrees.
    /// Of equal ones the nearest to 0.
    #[must_use]
    pub fn peak_shift_deg(&self) -> i32 {
        let shifts = (0..=180).flat_map(|turn| [turn, -turn]).filter(|&shift| shift > -180);
        let score = |shift: i32| self.centred[shift.rem_euclid(BINS as i32) as usize];
        shifts.reduce(|best, shift| if score(shift) > score(best) { shift } else { best }).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plan with windows of different widths, and one open bin in ten.
    fn plan() -> Scan {
        let mut scan = Scan::OPEN;
        for (bin, hit) in scan.hit.iter_mut().enumerate() {
            let window = [10..25, 40..52, 150..190, 300..304].iter().any(|w| w.contains(&bin));
            *hit = if window { Hit::Window } else { Hit::Wall };
        }
        scan
    }

    fn seen_ahead(by: usize) -> [Hit; BINS] {
        let mut hit = plan().hit;
        hit.rotate_left(by);
        hit
    }

    /// Two hundred bins: the field of one camera.
    fn half() -> Confidence {
        Confidence::new(&std::array::from_fn(|bin| if (100..260).contains(&bin) { 0 } else { 7 }))
    }

    #[test]
    fn heading_ahead_is_a_positive_shift() {
        for (by, shift) in [(0, 0), (8, 8), (180, 180), (200, -160), (353, -7)] {
            let whole = CrossModal::new(&seen_ahead(by), &Confidence::CERTAIN, &plan());
            assert_eq!(whole.peak_shift_deg(), shift);
            assert!((whole.centred[by] - 1.0).abs() < 1e-6 && (whole.cosine[by] - 1.0).abs() < 1e-6);
            assert_eq!((whole.seen(), whole.agreeing == 360), (360, by == 0));
        }
    }

    #[test]
    fn unseen_bins_count_at_no_shift() {
        let mut seen = seen_ahead(20);
        let before = CrossModal::new(&seen, &half(), &plan());
        seen[100..260].fill(Hit::Open);
        let after = CrossModal::new(&seen, &half(), &plan());
        assert_eq!((before.cosine, before.centred), (after.cosine, after.centred));
        assert_eq!((after.seen(), after.peak_shift_deg()), (200, 20));
        assert!((after.centred[20] - 1.0).abs() < 1e-6);
        let expected = (0..360).filter(|b| !(100..260).contains(b) && seen[*b] == plan().hit[*b]).count();
        assert_eq!(after.agreeing, expected);
    }

    #[test]
    fn scores_are_those_of_the_definition() {
        let (seen, plan) = (seen_ahead(33), plan());
        let result = CrossModal::new(&seen, &half(), &plan);
        let level = |hit: Hit| hit_level(hit).to_num::<f64>();
        let weight = |bin: usize| f64::from(half().sixteenths()[bin]);
        for shift in (0..BINS).step_by(37) {
            // Bin i of the observation meets bin i + shift of the plan.
            let pairs =
                || (0..BINS).map(|i| (weight(i), level(seen[i]), level(plan.hit[(i + shift) % BINS])));
            let sum = |f: &dyn Fn(f64, f64) -> f64| pairs().map(|(m, a, b)| m * f(a, b)).sum::<f64>();
            let cosine = sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
            assert!((result.cosine[shift] - cosine).abs() < 1e-6, "{shift}");
            let total = sum(&|_, _| 1.0);
            let (ma, mb) = (sum(&|a, _| a) / total, sum(&|_, b| b) / total);
            let spread = sum(&|a, _| (a - ma).powi(2)) * sum(&|_, b| (b - mb).powi(2));
            let centred = sum(&|a, b| (a - ma) * (b - mb)) / spread.sqrt();
            assert!((result.centred[shift] - centred).abs() < 1e-6, "{shift}");
        }
    }
}
