//! A sketch of a descriptor in 24 bytes: the first six harmonics of the range and hit-type channels.
//!
//! A sketch keeps the phases, so that two sketches can be correlated at any heading. [`shortlist`](super::matching::shortlist())
//! ranks all candidates by their sketches, without an index in RAM, and scores the best of them exactly.

use super::channels::Channel;
#[cfg(test)]
use crate::base::num::BINS;
use crate::base::num::{degree_cosine, degree_sine};
use crate::descriptor::harmonics::{Pair, harmonics};
use crate::descriptor::similarity::{Candidate, Query};
use crate::map::site_map::{LayerView, SKETCH_BYTES};

/// Number of harmonics per channel.
pub const SKETCH_HARMONICS: usize = 6;
/// Number of headings at which two sketches are correlated: every 11.25 degrees.
pub const SKETCH_POINTS: usize = 32;
const _: () = assert!(SKETCH_BYTES == 4 * SKETCH_HARMONICS);

/// The channels of a sketch.
const SKETCHED: [Channel; 2] = [Channel::Range, Channel::HitType];

/// Real and imaginary parts of the harmonics 1..=6 of range, then of hit type.
///
/// # Formats
/// Scaled so that the largest part is 127.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sketch(pub [i8; SKETCH_BYTES]);

type Coefficients = [[Pair<i64>; SKETCH_HARMONICS]; 2];

impl Sketch {
    /// The sketch of a candidate.
    ///
    /// # Cost
    /// 24 dot products of 360 bins.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "parts are scaled to +-127, weights have 8 bits")]
    pub fn new(candidate: &Candidate) -> Self {
        let coefficients =
            SKETCHED.map(|c| candidate.profile().values.get(c as usize).map_or([[0; 2]; 6], harmonics));
        let largest = coefficients.as_flattened().as_flattened().iter().map(|v| v.abs()).max().unwrap_or(0);
        let mut bytes = [0; SKETCH_BYTES];
        for (byte, value) in bytes.iter_mut().zip(coefficients.as_flattened().as_flattened()) {
            *byte = (value * 127).checked_div(largest).unwrap_or(0) as i8;
        }
        Self(bytes)
    }

    /// The sketch stored in a layer of a site map.
    #[must_use]
    pub fn stored(layer: &LayerView<'_>) -> Self {
        Self(layer.sketch_bytes().map(u8::cast_signed))
    }
}

/// The sketch of a query, prepared for ranking candidates.
#[derive(Debug, Clone)]
pub struct SketchQuery {
    /// Weighted coefficients, at most 127 in magnitude.
    coefficients: [i32; SKETCH_BYTES],
    weights: [i32; 2],
}

/// cos and sin of 2 pi s / 32 in Q6, by s.
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time")]
static TURNS: [Pair<i32>; SKETCH_POINTS] = {
    let mut turns = [[0; 2]; SKETCH_POINTS];
    let mut s = 0;
    while s < SKETCH_POINTS {
        // Every 11.25 degrees, rounded to the nearest degree: sufficient for ranking.
        let degrees = (s * 45 + 2) / 4;
        turns[s] = [degree_cosine(degrees) >> 24, degree_sine(degrees) >> 24];
        s += 1;
    }
    turns
};

impl SketchQuery {
    /// The sketch of a query. Bins of a masked query are weighted by their confidence.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "parts are scaled to +-127, weights have 8 bits")]
    pub fn new(query: &Query) -> Self {
        let weights = SKETCHED.map(|c| i64::from(query.weights().0.get(c as usize).copied().unwrap_or(0)));
        let mut coefficients: Coefficients = [[[0; 2]; SKETCH_HARMONICS]; 2];
        for ((block, channel), weight) in coefficients.iter_mut().zip(SKETCHED).zip(weights) {
            let values = core::array::from_fn(|bin| query.balanced(channel as usize, bin));
            *block = harmonics::<SKETCH_HARMONICS>(&values).map(|pair| pair.map(|v| v * weight));
        }
        let flat = || coefficients.as_flattened().as_flattened().iter();
        let largest = flat().map(|v| v.abs()).max().unwrap_or(0);
        let mut scaled = [0; SKETCH_BYTES];
        for (out, value) in scaled.iter_mut().zip(flat()) {
            *out = (value * 127).checked_div(largest).unwrap_or(0) as i32;
        }
        Self { coefficients: scaled, weights: weights.map(|w| w as i32) }
    }

    /// Maximum over 32 headings of the low-pass correlation, relative to the norm of the candidate.
    ///
    /// Values are comparable between candidates of one query; they are no cosines.
    ///
    /// # Cost
    /// 32 headings of 6 complex products. Cortex-M7, for 541 candidates: `rank` in `targets/budget.txt`.
    ///
    /// ```
    /// # use compass_core::descriptor::similarity::{Candidate, Confidence, Query, Similarity, Weights};
    /// # use compass_core::descriptor::Descriptor;
    /// # use compass_core::{Hit, Scan};
    /// #
    /// # // A wall at 1 m in a quarter of the circle, at 10 m elsewhere.
    /// # let mut scan = Scan { steps: [500; 360], hit: [Hit::Wall; 360] };
    /// # scan.steps[..90].fill(50);
    /// # let candidate = Candidate::from(&Descriptor::from(&scan));
    /// # // The same from a heading of 77 degrees.
    /// # scan.steps.rotate_left(77);
    /// # let mut query = Query::EMPTY;
    /// # query.set(&Descriptor::from(&scan), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
    /// use compass_core::descriptor::sketch::{Sketch, SketchQuery};
    ///
    /// // `query` is `candidate` from a heading of 77 degrees.
    /// let ranked = SketchQuery::new(&query);
    /// let open = Candidate::from(&Descriptor::from(&Scan::OPEN));
    /// assert!(ranked.rank(&Sketch::new(&candidate)) > ranked.rank(&Sketch::new(&open)));
    /// ```
    #[must_use]
    pub fn rank(&self, sketch: &Sketch) -> i32 {
        let mut products = [[0; 2]; SKETCH_HARMONICS];
        let mut energy = 0_i32;
        let (queries, others) = (self.coefficients.as_chunks::<2>().0, sketch.0.as_chunks::<2>().0);
        for ((channel_q, channel_d), weight) in queries
            .chunks_exact(SKETCH_HARMONICS)
            .zip(others.chunks_exact(SKETCH_HARMONICS))
            .zip(self.weights)
        {
            for (([re, im], q), d) in products.iter_mut().zip(channel_q).zip(channel_d) {
                let d = d.map(i32::from);
                // conj(q) d
                *re += q[0] * d[0] + q[1] * d[1];
                *im += q[0] * d[1] - q[1] * d[0];
                energy += weight * (d[0] * d[0] + d[1] * d[1]);
            }
        }
        let best = (0..SKETCH_POINTS).map(|s| at(&products, s)).max().unwrap_or(0);
        // Energy is at most 24 * 255 * 127^2 < 2^27; the peak at most 6 * 2 * 4 * 127^2 * 64 < 2^26.
        let norm = energy.unsigned_abs().isqrt().cast_signed();
        best.checked_div(norm >> 4).unwrap_or(0)
    }
}

/// `Re sum_k p_k exp(2 pi i k s / 32)`, Q6.
fn at(products: &[Pair<i32>; SKETCH_HARMONICS], s: usize) -> i32 {
    let turn = |k: usize| TURNS.get(k * s % SKETCH_POINTS).copied().unwrap_or([0; 2]);
    products
        .iter()
        .enumerate()
        .map(|(k, [re, im])| {
            let [cos, sin] = turn(k + 1);
            re * cos - im * sin
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::scan::{Hit, Scan};
    use crate::descriptor::Descriptor;
    use crate::descriptor::similarity::{Confidence, Similarity, Weights};
    use std::boxed::Box;

    fn descriptor(seed: usize, turn: usize) -> Descriptor {
        let mut scan = Scan::OPEN;
        for j in 0..BINS {
            let i = (j + turn) % BINS;
            scan.steps[j] = (200 + (i * seed) % 331 + 3 * (i / 40) * seed % 400) as u16;
            scan.hit[j] = if (i / 25 + seed).is_multiple_of(3) { Hit::Window } else { Hit::Wall };
        }
        Descriptor::from(&scan)
    }

    #[test]
    fn its_own_place_ranks_high_at_any_heading() {
        let mut query = Box::new(Query::EMPTY);
        let mut first = 0;
        for turn in (0..BINS).step_by(12) {
            query.set(&descriptor(7, turn), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
            let sketch = SketchQuery::new(&query);
            let rank = |seed: usize| sketch.rank(&Sketch::new(&Candidate::from(&descriptor(seed, 0))));
            let better =
                [3, 5, 11, 13, 29, 31, 37, 41, 43].into_iter().filter(|&s| rank(s) >= rank(7)).count();
            assert!(better <= 2, "turn {turn}: {better} of 9 rank higher");
            first += usize::from(better == 0);
        }
        assert!(first >= 20, "first at {first} of 30 headings");
    }
}
