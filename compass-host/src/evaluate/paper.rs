//! The paper's matching of observed descriptors: the cosine over the observed bins, at all headings of all candidates.
//!
//! In double precision with `rustfft`, in all [`PAPER`] ways at once: under a mask the norm of a candidate depends on
//! the heading, so that the core's bounds do not hold, and exact sums take seconds.

use super::record::PAPER;
use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, Score};
use compass_core::base::scan::Scan;
use compass_core::descriptor::matching::Match;
use compass_core::descriptor::similarity::{Peak, Profile, Similarity};
use compass_core::descriptor::{CHANNELS, Descriptor};
use compass_core::map::site_map::SiteMap;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::array::from_fn;
use std::sync::Arc;

/// Two real signals around the circle, as real and imaginary parts.
type Signals = [Complex64; BINS];

/// Squared norms below this share of the terms they are differences of are rounding noise and count as 0.
const NO_CONTRAST: f64 = 1e-9;

/// The query with its transforms, and buffers for those of a candidate.
pub struct Paper {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
    scan: Scan,
    descriptor: Descriptor,
    sums: Box<Sums>,
}

/// The query: an observed descriptor.
struct Query {
    /// The conjugate transforms of the mask and of the masked values.
    mask: Box<Signals>,
    values: [Box<Signals>; CHANNELS],
    /// Sums of the mask, of the masked values and of their squares.
    total: f64,
    sums: [f64; CHANNELS],
    /// The squared norm in each of the [`PAPER`] ways; 0 without contrast.
    norms: [f64; PAPER.len()],
}

/// Sums over the observed bins, by channel and shift.
struct Sums {
    products: [[f64; BINS]; CHANNELS],
    values: [[f64; BINS]; CHANNELS],
    squares: [[f64; BINS]; CHANNELS],
}

impl Sums {
    const ZERO: Self = Self {
        products: [[0.0; BINS]; CHANNELS],
        values: [[0.0; BINS]; CHANNELS],
        squares: [[0.0; BINS]; CHANNELS],
    };
}

impl std::fmt::Debug for Paper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Paper").finish_non_exhaustive()
    }
}

impl Default for Paper {
    fn default() -> Self {
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(BINS), planner.plan_fft_inverse(BINS));
        let length = forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len());
        let scratch = vec![Complex64::default(); length];
        let sums = Box::new(Sums::ZERO);
        Self { forward, inverse, scratch, scan: Scan::OPEN, descriptor: Descriptor::ZERO, sums }
    }
}

impl Paper {
    /// The best candidate and heading in each of the [`PAPER`] ways; the first of equal ones. `None` for a way without
    /// a score above 0.
    pub fn best(
        &mut self,
        map: &SiteMap<'_>,
        scan: &Scan,
        confidence: &Confidence,
    ) -> [Option<Match>; PAPER.len()] {
        let query = self.query(scan, confidence);
        let mut best = [(0.0, None); PAPER.len()];
        for (number, record) in (0..).zip(map.iter()) {
            record.scan(&mut self.scan);
            self.descriptor.fill(&self.scan);
            self.gather(&query, &Profile::from(&self.descriptor));
            for (way, best) in best.iter_mut().enumerate() {
                for shift in 0..BINS {
                    let score = query.score(&self.sums, way, shift);
                    if score > best.0 {
                        *best = (score, Some((number, shift)));
                    }
                }
            }
        }
        best.map(|(score, place)| {
            let (candidate, shift) = place?;
            let score_bits = (score * f64::from(Score::ONE.to_bits())) as i32;
            Some(Match { candidate, peak: Peak { shift: shift as u16, score_bits } })
        })
    }

    fn query(&mut self, scan: &Scan, confidence: &Confidence) -> Query {
        let profile = Profile::from(&Descriptor::from(scan));
        let mask = confidence.sixteenths().map(f64::from);
        let mut transformed = |value: &dyn Fn(usize) -> f64| {
            let mut signals: Box<Signals> =
                Box::new(from_fn(|bin| Complex64::new(mask[bin] * value(bin), 0.0)));
            self.forward.process_with_scratch(&mut *signals, &mut self.scratch);
            signals.iter_mut().for_each(|part| *part = part.conj());
            signals
        };
        let sum = |value: &dyn Fn(usize) -> f64| (0..BINS).map(|bin| mask[bin] * value(bin)).sum();
        let at = |channel: usize, bin: usize| f64::from(profile.values[channel][bin]);
        let total = sum(&|_| 1.0);
        let sums: [f64; CHANNELS] = from_fn(|channel| sum(&|bin| at(channel, bin)));
        let squares: [f64; CHANNELS] = from_fn(|channel| sum(&|bin| at(channel, bin).powi(2)));
        Query {
            mask: transformed(&|_| 1.0),
            values: from_fn(|channel| transformed(&|bin| at(channel, bin))),
            total,
            sums,
            norms: from_fn(|way| norm(way, total, |channel| [squares[channel], sums[channel]])),
        }
    }

    /// Computes the sums of a candidate.
    fn gather(&mut self, query: &Query, profile: &Profile) {
        for (channel, values) in profile.values.iter().enumerate() {
            // Values and squares as real and imaginary part of one signal.
            let mut pair: Signals = from_fn(|bin| {
                let value = f64::from(values[bin]);
                Complex64::new(value, value * value)
            });
            self.forward.process_with_scratch(&mut pair, &mut self.scratch);
            let mut masked: Signals = from_fn(|k| query.mask[k] * pair[k]);
            let mut product: Signals = from_fn(|k| {
                let of_values = (pair[k] + pair[(BINS - k) % BINS].conj()) / 2.0;
                query.values[channel][k] * of_values
            });
            for signals in [&mut masked, &mut product] {
                self.inverse.process_with_scratch(signals, &mut self.scratch);
            }
            for bin in 0..BINS {
                // Bin i of the query meets bin i + shift of the candidate.
                let [masked, product] = [masked[bin], product[bin]].map(|part| part / BINS as f64);
                self.sums.values[channel][bin] = masked.re;
                self.sums.squares[channel][bin] = masked.im;
                self.sums.products[channel][bin] = product.re;
            }
        }
    }
}

impl Query {
    /// The cosine of one of the [`PAPER`] ways at a shift, as [`compass_core::descriptor::similarity`] defines it.
    fn score(&self, sums: &Sums, way: usize, shift: usize) -> f64 {
        let (_, similarity, weights) = PAPER[way];
        let own = self.norms[way];
        let other =
            norm(way, self.total, |channel| [&sums.squares, &sums.values].map(|of| of[channel][shift]));
        if own == 0.0 || other == 0.0 {
            return 0.0;
        }
        let spread = |channel: usize| {
            let product = sums.products[channel][shift];
            match similarity {
                Similarity::Plain => product,
                Similarity::Centred => {
                    self.total * product - self.sums[channel] * sums.values[channel][shift]
                }
            }
        };
        let numerator: f64 =
            (0..CHANNELS).map(|channel| f64::from(weights.0[channel]) * spread(channel)).sum();
        numerator / (own * other).sqrt()
    }
}

/// The squared norm of one side in one of the [`PAPER`] ways, from the sum of the mask and the sums of squares and
/// values per channel; 0 without contrast.
fn norm(way: usize, total: f64, sums: impl Fn(usize) -> [f64; 2]) -> f64 {
    let (_, similarity, weights) = PAPER[way];
    let (mut norm, mut whole) = (0.0, 0.0);
    for (channel, weight) in weights.0.iter().map(|w| f64::from(*w)).enumerate() {
        let [squares, values] = sums(channel);
        let (spread, all) = match similarity {
            Similarity::Plain => (squares, squares),
            Similarity::Centred => (total * squares - values * values, total * squares),
        };
        norm += weight * spread;
        whole += weight * all;
    }
    if norm > NO_CONTRAST * whole { norm } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan_import::PlanRaster;
    use crate::sample::building;
    use crate::site::{BuildOptions, PackedPlan, build};
    use compass_core::descriptor::similarity::{Candidate, Query as ExactQuery};

    /// The sample building and its site map.
    fn floor(spacing_m: f64) -> (PackedPlan, Vec<u8>) {
        let raster = PlanRaster::from(building());
        let plan = PackedPlan::new(&raster).unwrap();
        let options = BuildOptions { spacing_m, ..BuildOptions::default() };
        let map = build(&raster, &plan, None, &options).unwrap();
        (plan, map)
    }

    /// The best score over all candidates, in exact integers.
    fn exact(map: &SiteMap<'_>, scan: &Scan, seen: &Confidence, way: usize) -> Match {
        let (_, similarity, weights) = PAPER[way];
        let mut query = Box::new(ExactQuery::EMPTY);
        query.set(&Descriptor::from(scan), seen, weights, similarity);
        let (mut best, mut scan) = (Match::NONE, Scan::OPEN);
        for (number, record) in (0..).zip(map.iter()) {
            record.scan(&mut scan);
            let candidate = Candidate::from(&Descriptor::from(&scan));
            for shift in 0..BINS {
                let score_bits = query.score(&candidate, shift).to_bits();
                if score_bits > best.peak.score_bits {
                    best = Match { candidate: number, peak: Peak { shift: shift as u16, score_bits } };
                }
            }
        }
        best
    }

    #[test]
    fn the_best_in_exact_integers_is_found_in_every_way() {
        let (plan, bytes) = floor(2.0);
        let map = SiteMap::new(&bytes).unwrap();
        let half = |bin: usize| if bin < 180 { 16 - (bin / 20) as u8 } else { 0 };
        for seen in [Confidence::CERTAIN, Confidence::new(&from_fn(half))] {
            let scan = plan.scan([13.37, 3.68], 200.0).unwrap();
            let found = Paper::default().best(&map, &scan, &seen);
            for (way, found) in found.into_iter().enumerate() {
                let (found, exact) = (found.unwrap(), exact(&map, &scan, &seen, way));
                assert_eq!((found.candidate, found.peak.shift), (exact.candidate, exact.peak.shift), "{way}");
                assert!(found.peak.score_bits.abs_diff(exact.peak.score_bits) < 1 << 6, "{way}");
            }
        }
    }

    #[test]
    fn what_has_no_contrast_finds_nothing() {
        let (_, bytes) = floor(4.0);
        let map = SiteMap::new(&bytes).unwrap();
        let found = Paper::default().best(&map, &Scan::OPEN, &Confidence::CERTAIN);
        assert!(found[1..].iter().all(Option::is_none), "{found:?}");
        assert_eq!(Paper::default().best(&map, &Scan::OPEN, &Confidence::NONE), [None; 4]);
    }
}
