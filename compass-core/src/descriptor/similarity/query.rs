//! A query prepared for scoring many candidates.

use super::cosine::{Normalizer, cosine};
use super::profile::{Candidate, Profile};
use super::weights::{Similarity, Weights};
use crate::base::confidence::Confidence;
use crate::base::num::{BINS, Score};
use crate::descriptor::harmonics::dot;
use crate::descriptor::spectrum::{Correlator, Extent};
use crate::descriptor::{BINS_I32, BINS_I64, CHANNELS, Descriptor};

/// A heading shift of a candidate and its score.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Heading of the query relative to that of the candidate, degrees counter-clockwise, 0..360.
    pub shift: u16,
    /// Bits of the [`Score`] at this shift (2^30 is 1.0).
    pub score_bits: i32,
}

impl Peak {
    /// The score.
    #[must_use]
    pub const fn score(self) -> Score {
        Score::from_bits(self.score_bits)
    }
}

/// Values of two turns, so that every shift is a contiguous slice.
type Doubled<T> = [T; 2 * BINS];

/// A query descriptor with weights, confidence and the kind of cosine: 9 KiB.
///
/// # Formats
/// Values are rounded to 2^-10; weights are 8-bit integers, confidence is in sixteenths. Numerators and norms are exact
/// integers.
///
/// # Accuracy
/// Scores are within 2^-29 of the cosine of the rounded values, and within
/// [`SCORE_ERROR`](super::SCORE_ERROR) of that of the real-valued descriptors.
///
/// # References
/// The plain cosine over 360 heading shifts is the score of the paper.
#[derive(Debug, Clone)]
pub struct Query {
    similarity: Similarity,
    weights: Weights,
    /// m q; m is 1 for a query without mask.
    values: [Doubled<i16>; CHANNELS],
    /// m in sixteenths, for a masked query.
    mask: Option<Doubled<i16>>,
    /// M: the sum of m.
    total: i64,
    /// sum m q per channel.
    sums: [i64; CHANNELS],
    norm: u64,
}

impl Query {
    /// A query whose scores are 0, to be filled by [`Query::set`].
    pub const EMPTY: Self = Self {
        similarity: Similarity::Centred,
        weights: Weights::EQUAL,
        values: [[0; 2 * BINS]; CHANNELS],
        mask: None,
        total: 0,
        sums: [0; CHANNELS],
        norm: 0,
    };

    /// Prepares a query.
    ///
    /// If every bin is certain, the query has no mask and is scored by FFT; otherwise each bin is weighted by its confidence
    /// and scores are summed directly.
    ///
    /// # Cost
    /// Linear in the 5 x 360 values. Cortex-M7, with the spectra: `query` in `targets/budget.txt`.
    ///
    /// ```
    /// use compass_core::descriptor::similarity::{Candidate, Confidence, Query, Similarity, Weights};
    /// use compass_core::descriptor::Descriptor;
    /// use compass_core::{Hit, Scan};
    ///
    /// // A wall at 1 m in a quarter of the circle, at 10 m elsewhere.
    /// let mut scan = Scan { steps: [500; 360], hit: [Hit::Wall; 360] };
    /// scan.steps[..90].fill(50);
    /// let candidate = Candidate::from(&Descriptor::from(&scan));
    /// // The same from a heading of 77 degrees.
    /// scan.steps.rotate_left(77);
    /// let mut query = Query::EMPTY;
    /// query.set(&Descriptor::from(&scan), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
    /// assert!(!query.is_masked());
    /// assert!(query.score(&candidate, 77).to_num::<f32>() > 0.999);
    /// ```
    pub fn set(
        &mut self,
        descriptor: &Descriptor,
        confidence: &Confidence,
        weights: Weights,
        similarity: Similarity,
    ) {
        self.similarity = similarity;
        self.weights = weights;
        let certain = confidence.is_certain();
        let mask = |bin: usize| {
            if certain { 1 } else { confidence.sixteenths().get(bin).copied().map_or(0, i16::from) }
        };
        self.total = (0..BINS).map(|bin| i64::from(mask(bin))).sum();
        self.mask = (!certain).then(|| doubled(mask));
        let profile = Profile::from(descriptor);
        let mut squares = [0; CHANNELS];
        for (((values, sum), square), profile) in
            self.values.iter_mut().zip(&mut self.sums).zip(&mut squares).zip(&profile.values)
        {
            let value = |bin: usize| profile.get(bin).copied().unwrap_or(0);
            // At most 16 * 1536 < 2^15.
            *values = doubled(|bin| mask(bin) * value(bin));
            *sum = (0..BINS).map(|bin| i64::from(mask(bin)) * i64::from(value(bin))).sum();
            *square = (0..BINS).map(|bin| i64::from(mask(bin)) * i64::from(value(bin)).pow(2)).sum();
        }
        self.norm = self.norm_of(&self.sums, &squares);
    }

    /// Weights of the channels.
    #[must_use]
    pub const fn weights(&self) -> Weights {
        self.weights
    }

    /// The kind of cosine.
    #[must_use]
    pub const fn similarity(&self) -> Similarity {
        self.similarity
    }

    /// Whether the confidence of any bin is below [`Confidence::FULL`].
    #[must_use]
    pub const fn is_masked(&self) -> bool {
        self.mask.is_some()
    }

    /// Squared norm of the query, in the unit of [`Query::parts`].
    #[must_use]
    pub const fn squared_norm(&self) -> u64 {
        self.norm
    }

    /// sum m q of a channel.
    pub(crate) fn sum(&self, channel: usize) -> i64 {
        pick(&self.sums, channel)
    }

    /// m q per channel and bin, in units of 2^-10 (2^-14 for a masked query).
    #[must_use]
    pub fn channel(&self, channel: usize) -> &[i16] {
        self.values.get(channel).and_then(|v| v.get(..BINS)).unwrap_or_default()
    }

    /// Value of the query without the mean of the channel, times its confidence, in units of 2^-10: the operand of the
    /// correlation of the centred cosine.
    #[expect(clippy::cast_possible_truncation, reason = "at most 1536 in magnitude")]
    pub(crate) fn balanced(&self, channel: usize, bin: usize) -> i16 {
        let (value, sum) = (i64::from(pick(self.channel(channel), bin)), pick(&self.sums, channel));
        let mask = self.mask.as_ref().map_or(1, |m| i64::from(pick(m, bin)));
        let full = if self.is_masked() { i64::from(Confidence::FULL) } else { 1 };
        // m (q - mean), the mean weighted by confidence; at most 1536 in magnitude.
        let centred = value * self.total - mask * sum;
        centred.checked_div(self.total * full).unwrap_or(0) as i16
    }

    /// The score of a candidate at one heading shift in degrees, modulo 360.
    ///
    /// # Accuracy
    /// Within 2^-29 of the cosine of the rounded values (test `cosine_is_within_2_pow_minus_29`).
    ///
    /// # Cost
    /// 5 dot products of 360 bins, or 15 for a masked query; channels of weight 0 are skipped.
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
    /// // `query` is `candidate` from a heading of 77 degrees.
    /// assert!(query.score(&candidate, 77).to_num::<f32>() > 0.999);
    /// assert!(query.score(&candidate, 0).to_num::<f32>() < 0.5);
    /// ```
    #[must_use]
    pub fn score(&self, candidate: &Candidate, shift: usize) -> Score {
        let (numerator, norm) = self.parts(candidate, shift);
        cosine(numerator, self.norm, norm)
    }

    /// Numerator and squared norm of the candidate at one heading shift, exact.
    #[must_use]
    pub fn parts(&self, candidate: &Candidate, shift: usize) -> (i64, u64) {
        let start = (BINS - shift % BINS) % BINS;
        let numerator = self.of_channels(|c| {
            let values = self.values.get(c).and_then(|v| v.get(start..start + BINS)).unwrap_or_default();
            let other = channel(candidate, c);
            if self.is_masked() { masked_dot(values, other) } else { dot::<BINS>(values, other) }
        });
        let (sums, squares) = self.moments(candidate, start);
        let numerator =
            self.weigh(|c| self.spread(pick(&numerator, c), pick(&self.sums, c) * pick(&sums, c)));
        (numerator, self.norm_of(&sums, &squares))
    }

    /// Squared norm from sums and sums of squares.
    fn norm_of(&self, sums: &[i64; CHANNELS], squares: &[i64; CHANNELS]) -> u64 {
        self.weigh(|c| self.spread(pick(squares, c), pick(sums, c).pow(2))).unsigned_abs()
    }

    /// sum m d and sum m d^2 per channel.
    fn moments(&self, candidate: &Candidate, start: usize) -> ([i64; CHANNELS], [i64; CHANNELS]) {
        let Some(mask) = &self.mask else {
            return (candidate.sums.map(i64::from), candidate.squares.map(i64::from));
        };
        let mask = mask.get(start..start + BINS).unwrap_or_default();
        let sums = self.of_channels(|c| dot::<BINS>(mask, channel(candidate, c)));
        let squares = self.of_channels(|c| {
            let values = channel(candidate, c);
            // At most 16 * 1536 < 2^15.
            let mut products = [0; BINS];
            for ((product, m), v) in products.iter_mut().zip(mask).zip(values) {
                *product = m * v;
            }
            masked_dot(&products, values)
        });
        (sums, squares)
    }

    /// The best heading shift and its score; of equal ones the smallest shift.
    ///
    /// All shifts are correlated by FFT; those within the error bound of the maximum are then scored exactly. A masked query
    /// is scored exactly at all shifts. `correlator` must hold this query: see [`Query::load`].
    ///
    /// # Accuracy
    /// That of [`Query::score`].
    ///
    /// # Cost
    /// One [`Correlator::correlate`], and [`Query::score`] at the shifts near the maximum; for a masked query at 360 shifts.
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
    /// use compass_core::descriptor::spectrum::Correlator;
    ///
    /// // `query` is `candidate` from a heading of 77 degrees.
    /// let mut correlator = Box::new(Correlator::new());
    /// query.load(&mut correlator);
    /// assert_eq!(query.peak(&candidate, &mut correlator).shift, 77);
    /// ```
    #[must_use]
    pub fn peak(&self, candidate: &Candidate, correlator: &mut Correlator) -> Peak {
        if self.is_masked() {
            return self.best_of(candidate, 0..BINS);
        }
        let mut rough = [0; BINS];
        let _ = correlator.correlate(
            self.other_extent(candidate),
            |c, bin| self.other_value(candidate, c, bin),
            &mut rough,
        );
        let top = rough.iter().copied().max().unwrap_or(0);
        let near = (0..BINS).filter(|&s| pick(&rough, s) >= top.saturating_sub(2 * CORRELATION_ERROR));
        self.best_of(candidate, near)
    }

    /// The scores at all 360 heading shifts, by one correlation; for a masked query by direct sums. `correlator` must hold
    /// this query: see [`Query::load`].
    ///
    /// # Accuracy
    /// Within [`SCORE_ERROR`](super::SCORE_ERROR) of [`Query::score`]; equal to it for a masked query.
    ///
    /// # Cost
    /// One [`Correlator::correlate`]; for a masked query 360 times [`Query::score`]. Cortex-M7, with unpacking of the
    /// candidate: `correlate` in `targets/budget.txt`.
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
    /// use compass_core::base::num::Score;
    /// use compass_core::descriptor::spectrum::Correlator;
    ///
    /// // `query` is `candidate` from a heading of 77 degrees.
    /// let mut correlator = Box::new(Correlator::new());
    /// query.load(&mut correlator);
    /// let mut scores = [Score::ZERO; 360];
    /// query.scores(&candidate, &mut correlator, &mut scores);
    /// assert!(scores.iter().all(|score| *score <= scores[77]));
    /// ```
    pub fn scores(&self, candidate: &Candidate, correlator: &mut Correlator, out: &mut [Score; BINS]) {
        if self.is_masked() {
            for (shift, score) in out.iter_mut().enumerate() {
                *score = self.score(candidate, shift);
            }
            return;
        }
        let mut rough = [0; BINS];
        let exponent = correlator.correlate(
            self.other_extent(candidate),
            |c, bin| self.other_value(candidate, c, bin),
            &mut rough,
        );
        let (sums, squares) = self.moments(candidate, 0);
        let norm = self.norm_of(&sums, &squares);
        // Centred values have a factor M on both sides, the parts only one.
        let factor = if self.similarity == Similarity::Centred { self.total.unsigned_abs() } else { 1 };
        let norm = norm * factor;
        let normalizer = Normalizer::new(self.norm * factor, norm, exponent);
        for (score, value) in out.iter_mut().zip(rough) {
            *score = normalizer.cosine(value);
        }
    }

    /// Loads the weighted channels of this query into a correlator.
    #[expect(clippy::cast_possible_truncation, reason = "weights are below 2^8 and values below 2^20")]
    pub fn load(&self, correlator: &mut Correlator) {
        correlator.set_query(CHANNELS, |c, bin| {
            let value = self.centred(i64::from(pick(self.channel(c), bin)), pick(&self.sums, c));
            (i64::from(pick(&self.weights.0, c)) * value) as i32
        });
    }

    /// Magnitude and norm of the values of a candidate.
    fn other_extent(&self, candidate: &Candidate) -> Extent {
        let energy = |(&sum, &square): (&i32, &i32)| {
            let (sum, square) = (i64::from(sum), i64::from(square));
            match self.similarity {
                Similarity::Plain => square,
                // sum (360 v - S)^2 = 360 (360 sum v^2 - S^2)
                Similarity::Centred => BINS_I64 * (BINS_I64 * square - sum * sum),
            }
        };
        let total: i64 = candidate.sums.iter().zip(&candidate.squares).map(energy).sum();
        // Values are at most 1536, centred ones 360 times that.
        let largest = match self.similarity {
            Similarity::Plain => 1536,
            Similarity::Centred => 1536 * BINS_I32.unsigned_abs(),
        };
        Extent { largest, norm: total.unsigned_abs().isqrt() + 1 }
    }

    fn other_value(&self, candidate: &Candidate, channel: usize, bin: usize) -> i32 {
        let value = i32::from(candidate.profile.values.get(channel).map_or(0, |v| pick(v, bin)));
        match self.similarity {
            Similarity::Plain => value,
            // Below 2^20 in magnitude.
            Similarity::Centred => BINS_I32 * value - pick(&candidate.sums, channel),
        }
    }

    /// 360 v - sum for the centred cosine, v for the plain one; below 2^20 in magnitude.
    fn centred(&self, value: i64, sum: i64) -> i64 {
        match self.similarity {
            Similarity::Plain => value,
            Similarity::Centred => BINS_I64 * value - sum,
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "shifts are below 360")]
    fn best_of(&self, candidate: &Candidate, shifts: impl Iterator<Item = usize>) -> Peak {
        let mut best: Option<Peak> = None;
        for shift in shifts {
            let score_bits = self.score(candidate, shift).to_bits();
            if best.is_none_or(|b| score_bits > b.score_bits) {
                best = Some(Peak { shift: shift as u16, score_bits });
            }
        }
        best.unwrap_or(Peak { shift: 0, score_bits: 0 })
    }

    /// The plain or centred form of a product sum.
    fn spread(&self, products: i64, product_of_sums: i64) -> i64 {
        match self.similarity {
            Similarity::Plain => products,
            Similarity::Centred => self.total * products - product_of_sums,
        }
    }

    /// A value per channel, 0 for channels of weight 0.
    fn of_channels(&self, value: impl Fn(usize) -> i64) -> [i64; CHANNELS] {
        core::array::from_fn(|c| if pick(&self.weights.0, c) == 0 { 0 } else { value(c) })
    }

    /// The weighted sum over channels; below 2^57.
    fn weigh(&self, value: impl Fn(usize) -> i64) -> i64 {
        self.weights.0.iter().enumerate().map(|(c, &w)| i64::from(w) * value(c)).sum()
    }
}

/// Error bound of a correlation, LSB.
const CORRELATION_ERROR: i32 = 16;

fn doubled(value: impl Fn(usize) -> i16) -> Doubled<i16> {
    core::array::from_fn(|i| value(i % BINS))
}

fn pick<T: Copy + Default>(values: &[T], index: usize) -> T {
    values.get(index).copied().unwrap_or_default()
}

fn channel(candidate: &Candidate, channel: usize) -> &[i16; BINS] {
    candidate.profile.values.get(channel).unwrap_or(&[0; BINS])
}

/// The sum of products of up to 24576 and 1536: each of eight sums stays below 45 x 24576 x 1536 < 2^31.
fn masked_dot(a: &[i16], b: &[i16; BINS]) -> i64 {
    const SUMS: usize = 8;
    let mut sums = [0_i32; SUMS];
    for (a, b) in a.as_chunks::<SUMS>().0.iter().zip(b.as_chunks::<SUMS>().0) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += i32::from(*a) * i32::from(*b);
        }
    }
    sums.into_iter().map(i64::from).sum()
}
