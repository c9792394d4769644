//! The transition signature: 16 bytes that are invariant under rotation.
//!
//! It counts the runs of equal hit type around the circle and their bins by length of the run, and adds six quantiles of
//! the range. None of these depends on the position of bin 0. Single wrong bins change little: a circular majority filter
//! of five bins removes up to two wrong hit types in five, and a wrong range moves each quantile by at most one rank.
//!
//! | byte | content |
//! |---|---|
//! | 0 | window bins / 2 |
//! | 1 | runs of equal hit type x 2, at most 254 |
//! | 2..=5 | window bins / 2 in runs of at most 4, at most 12, at most 36 and more bins |
//! | 6..=9 | other bins / 2 in runs of the same classes |
//! | 10..=15 | range at ranks 30, 90, 150, 210, 270, 330 of 360, half the range code of a packed scan |

use crate::base::circle::Circle;
use crate::base::num::BINS;
use crate::base::order;
use crate::base::scan::{Hit, Scan};
use crate::map::site_map::{LayerView, SIGNATURE_BYTES, ladder_code};

/// Upper limits of the classes of run lengths, in bins; the last class has none.
const RUN_CLASSES: [usize; 3] = [4, 12, 36];
/// Ranks of the quantiles.
const RANKS: [usize; 6] = [30, 90, 150, 210, 270, 330];

/// A rotation-invariant digest of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Signature(pub [u8; SIGNATURE_BYTES]);

impl Signature {
    /// The signature of a scan.
    ///
    /// # Formats
    /// A byte each: counts of bins halved, runs doubled and clamped, ranges in codes; the table of this module.
    ///
    /// # Accuracy
    /// Invariant under rotation of the scan by whole bins (test `signatures_are_invariant_under_rotation`).
    ///
    /// # Cost
    /// Two passes over the bins and a heap sort of 360 ranges.
    ///
    /// # References
    /// `docs/design.md`, "Transition signature".
    ///
    /// ```
    /// use compass_core::descriptor::signature::Signature;
    /// use compass_core::{Hit, Scan};
    ///
    /// let mut scan = Scan { steps: [100; 360], hit: [Hit::Wall; 360] };
    /// scan.hit[20..40].fill(Hit::Window);
    /// let signature = Signature::new(&scan);
    /// assert_eq!(signature.0[..2], [10, 4], "20 bins of windows, 2 runs");
    /// scan.hit.rotate_left(77);
    /// assert_eq!(Signature::new(&scan), signature);
    /// ```
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "half of at most 360 bins, and at most 254")]
    pub fn new(scan: &Scan) -> Self {
        let windows = smooth(&scan.hit);
        let bins = windows.bins().iter().filter(|&&g| g).count();
        let mut counts = Counts::default();
        counts.add_runs(&windows);
        let mut sorted = scan.steps;
        order::sort_by_key(&mut sorted, |steps| *steps);
        let quantiles = RANKS.map(|rank| ladder_code(sorted.get(rank).copied().unwrap_or(1)) / 2);

        let half = |bins: usize| (bins / 2) as u8;
        let runs = (2 * counts.runs).min(254) as u8;
        let mut bytes = [0; SIGNATURE_BYTES];
        let values = [half(bins), runs]
            .into_iter()
            .chain(counts.windows.map(half))
            .chain(counts.other.map(half))
            .chain(quantiles);
        for (byte, value) in bytes.iter_mut().zip(values) {
            *byte = value;
        }
        Self(bytes)
    }

    /// The signature stored in a layer of a site map.
    #[must_use]
    pub fn stored(layer: &LayerView<'_>) -> Self {
        Self(*layer.signature_bytes())
    }

    /// Sum of the absolute differences of the bytes, 0..=4080.
    #[must_use]
    pub fn distance(&self, other: &Self) -> u16 {
        self.0.iter().zip(&other.0).map(|(a, b)| u16::from(a.abs_diff(*b))).sum()
    }
}

/// Number of runs, and number of bins by class of run length.
#[derive(Default)]
struct Counts {
    runs: usize,
    windows: [usize; RUN_CLASSES.len() + 1],
    other: [usize; RUN_CLASSES.len() + 1],
}

impl Counts {
    fn add_runs(&mut self, windows: &Circle<bool>) {
        // Start at a transition, so that no run is split.
        let begins = |bin: &usize| windows.get(*bin) != windows.get(*bin + BINS - 1);
        let start = (0..BINS).find(begins).unwrap_or(0);
        let (mut length, mut value) = (0, windows.get(start));
        for bin in start..start + BINS {
            let here = windows.get(bin);
            if here == value {
                length += 1;
            } else {
                self.add_run(value, length);
                (length, value) = (1, here);
            }
        }
        self.add_run(value, length);
    }

    fn add_run(&mut self, windows: bool, length: usize) {
        let class = RUN_CLASSES.iter().take_while(|&&longest| length > longest).count();
        let counts = if windows { &mut self.windows } else { &mut self.other };
        if let Some(count) = counts.get_mut(class) {
            *count += length;
        }
        self.runs += 1;
    }
}

/// Window bins after a circular majority filter of five bins.
fn smooth(hit: &[Hit; BINS]) -> Circle<bool> {
    let hit = Circle::of(hit);
    let windows = |bin: usize| hit.get(bin) == Hit::Window;
    Circle::from_fn(|bin| (0..5).filter(|offset| windows(bin + BINS - 2 + offset)).count() >= 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn scan(seed: u64) -> Scan {
        let mut scan = Scan::OPEN;
        for j in 0..BINS {
            let run = (j as u64 / 9 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            scan.hit[j] = if run.is_multiple_of(3) { Hit::Window } else { Hit::Wall };
            scan.steps[j] = (50 + run % 900) as u16;
        }
        scan
    }

    proptest! {
        #[test]
        fn signatures_are_invariant_under_rotation(seed: u64, by in 0usize..360) {
            let mut turned = scan(seed);
            turned.steps.rotate_left(by);
            turned.hit.rotate_left(by);
            prop_assert_eq!(Signature::new(&scan(seed)), Signature::new(&turned));
        }

        #[test]
        fn two_wrong_bins_change_the_signature_little(seed: u64, at in 0usize..360) {
            let original = scan(seed);
            let mut wrong = original;
            for j in [at, (at + 180) % 360] {
                wrong.hit[j] = if wrong.hit[j] == Hit::Wall { Hit::Window } else { Hit::Wall };
                wrong.steps[j] = 60;
            }
            let moved = Signature::new(&original).distance(&Signature::new(&wrong));
            let elsewhere = Signature::new(&original).distance(&Signature::new(&Scan::OPEN));
            prop_assert!(moved < elsewhere / 2, "{moved} against {elsewhere}");
        }
    }

    #[test]
    fn runs_of_a_known_scan_are_counted() {
        let mut scan = Scan { steps: [100; BINS], hit: [Hit::Wall; BINS] };
        scan.hit[350..].fill(Hit::Window);
        scan.hit[..10].fill(Hit::Window);
        scan.hit[100] = Hit::Window;
        let signature = Signature::new(&scan).0;
        assert_eq!(signature[..10], [10, 4, 0, 0, 10, 0, 0, 0, 0, 170], "the lone bin is smoothed away");
    }
}
