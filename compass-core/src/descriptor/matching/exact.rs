//! The exhaustive search: branch and bound over candidates.
//!
//! The correlation of a query with a candidate is split into the harmonics 1..=32 and the rest. The low part is evaluated
//! at 64 headings by one short transform. Between two of them it exceeds the larger sample by at most half the squared half
//! spacing times its largest second derivative, which the norms of the derivatives bound. The rest is at most the product
//! of the two residual norms (Cauchy-Schwarz, per channel). A candidate whose bound is below the best score found so far is
//! rejected.
#![expect(
    clippy::indexing_slicing,
    reason = "channels, lanes, points and places are below the lengths of their arrays; the linker test of panics shows that no check remains"
)]

use super::answer::{Answer, Match, Pool};
use super::index::{Group, Index, Rest, spectrum};
use super::lanes::{self, LANES, Lane, POINTS, TRANSFORM_ERROR};
use super::shortlist::top_candidates;
use crate::base::circle;
use crate::base::num::{BINS, Score};
use crate::base::scan::Scan;
use crate::descriptor::harmonics::{HARMONICS, Pair};
use crate::descriptor::signature::Signature;
use crate::descriptor::similarity::{Candidate, Peak, Query, Similarity};
use crate::descriptor::{BINS_I64, CHANNELS, Descriptor};
use crate::map::site_map::SiteMap;

/// Number of candidates of the highest bounds, from which alternatives are selected.
const SEEDS: usize = 64;
/// Number of these that are scored first, to set the threshold.
const PROBES: usize = 8;
/// Upper bound of the norm of the scaled harmonics of the query.
const QUERY_NORM: u64 = 1 << 14;
/// Right shift of products from 32 to 16 bits.
const PRODUCT_SHIFT: u32 = 17;
/// Error bound of a sample of the low part, LSB: 45 for the rounding of 32 products, that of the transform, and 24 for
/// rounded coefficients and tables at the largest norms.
const LOW_ERROR: i64 = 45 + TRANSFORM_ERROR as i64 + 24;

/// Workspace of [`exhaustive`]: about 60 KiB.
#[derive(Debug)]
pub struct Exact {
    low: LowQuery,
    re: [Lane; POINTS],
    im: [Lane; POINTS],
    scan: Scan,
    descriptor: Descriptor,
    candidate: Candidate,
    scores: [Option<i32>; BINS],
}

impl Exact {
    /// An empty workspace.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            low: LowQuery::EMPTY,
            re: [[0; LANES]; POINTS],
            im: [[0; LANES]; POINTS],
            scan: Scan::BLANK,
            descriptor: Descriptor::ZERO,
            candidate: Candidate::ZERO,
            scores: [None; BINS],
        }
    }
}

impl Default for Exact {
    fn default() -> Self {
        Self::new()
    }
}

/// The low harmonics of a query and the bounds of the rest.
#[derive(Debug, Clone)]
struct LowQuery {
    /// Weighted harmonics `[channel][k][re, im]`, repeated in all lanes.
    splat: [[[Lane; 2]; HARMONICS]; CHANNELS],
    /// The harmonics are scaled by 2^-exponent.
    exponent: i32,
    /// Weight times residual norm, Q10.
    residual: [i64; CHANNELS],
    /// Weight times norm of the derivative, Q10.
    slope: [i64; CHANNELS],
    /// Weight times sum, for the plain cosine; 0 for the centred one.
    offset: [i64; CHANNELS],
    weights: [i64; CHANNELS],
    /// Square root of the query's squared norm, rounded down.
    norm: u64,
    similarity: Similarity,
}

/// Finds the best match over all candidates and headings. Alternatives are the best local maxima of the 64 candidates of
/// the highest bounds.
///
/// `bounds` needs one element per candidate; about 400 elements suffice for `pool`, from which the matches are selected.
/// With `signature`, candidates whose signature is farther from it than the given distance are rejected, and
/// [`Answer::exhaustive`] is false. Returns `None` if `bounds` is too short or the index has another number of candidates
/// than the map.
///
/// A masked query has no bounds, because the norm of a candidate depends on the heading: every candidate is then scored at
/// every heading.
///
/// # Accuracy
/// The best match and its score equal those of scoring everything (`tests/tests/properties.rs`,
/// `the_exact_search_finds_what_scoring_everything_finds`).
///
/// # Cost
/// One bound per candidate by a 64-point transform, shared by 64 candidates; then exact scores of the candidates whose
/// bound reaches the best score: all of them in the worst case, and for a masked query. Cortex-M7: `exact` in
/// `targets/budget.txt`.
///
/// # References
/// The score is that of the paper. The bounds: `docs/design.md`.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// # use compass_core::descriptor::Descriptor;
/// # use compass_core::descriptor::signature::Signature;
/// # use compass_core::descriptor::similarity::{Confidence, Query, Similarity, Weights};
/// # use compass_core::Scan;
/// # let map = floor.map();
/// # let mut scan = Scan::OPEN;
/// # map.get(7).unwrap().scan(&mut scan);
/// # let mut query = Query::EMPTY;
/// # query.set(&Descriptor::from(&scan), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
/// use compass_core::descriptor::matching::{Exact, Group, Index, Match, exhaustive};
///
/// let mut groups = vec![Group::EMPTY; Index::groups(map)];
/// for (number, group) in groups.iter_mut().enumerate() {
///     group.fill(map, number);
/// }
/// let index = Index::new(&groups, map).unwrap();
/// // `query` is the scan of candidate 7.
/// let (mut bounds, mut pool, mut work) = (vec![0; map.len()], [Match::NONE; 400], Box::new(Exact::new()));
/// let answer = exhaustive(&index, map, &query, None, &mut work, &mut bounds, &mut pool).unwrap();
/// assert!(answer.exhaustive);
/// assert_eq!(answer.best().map(|best| (best.candidate, best.peak.shift)), Some((7, 0)));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn exhaustive(
    index: &Index<'_>,
    map: &SiteMap<'_>,
    query: &Query,
    signature: Option<(&Signature, u16)>,
    work: &mut Exact,
    bounds: &mut [i32],
    pool: &mut [Match],
) -> Option<Answer> {
    let bounds = bounds.get_mut(..index.len())?;
    if index.len() != map.len() {
        return None;
    }
    if query.is_masked() {
        bounds.fill(0);
    } else {
        work.low.set(query);
        for (group, bounds) in index.as_groups().iter().zip(bounds.chunks_mut(super::GROUP)) {
            work.bound(group, bounds);
        }
    }
    if let Some((signature, limit)) = signature {
        for (bound, record) in bounds.iter_mut().zip(map.iter()) {
            if Signature::stored(&record.plan_layer()).distance(signature) > limit {
                *bound = i32::MIN;
            }
        }
    }
    let whole = signature.is_none();
    let mut search =
        Search { index, map, query, work, pool: Pool::new(pool), scored: 0, whole, best: i32::MIN };
    Some(search.run(bounds))
}

struct Search<'s, 'm> {
    index: &'s Index<'m>,
    map: &'s SiteMap<'m>,
    query: &'s Query,
    work: &'s mut Exact,
    pool: Pool<'s>,
    scored: u32,
    /// Whether no candidate was rejected by its signature.
    whole: bool,
    /// Bits of the best score so far.
    best: i32,
}

impl Search<'_, '_> {
    fn run(&mut self, bounds: &[i32]) -> Answer {
        let candidates = (0..).zip(bounds.iter()).filter(|(_, b)| **b > i32::MIN);
        if self.query.is_masked() {
            for (candidate, _) in candidates {
                self.score(candidate, None);
            }
            return self.pool.select(self.map, self.scored, self.whole);
        }
        let mut seeds = [(0, 0); SEEDS];
        let used = top_candidates(&mut seeds, candidates.map(|(c, b)| (*b, c)));
        let seeds = seeds.get(..used).unwrap_or_default();
        let (first, others) = seeds.split_at_checked(PROBES).unwrap_or((seeds, &[]));
        for &(_, candidate) in first {
            self.score(candidate, None);
        }
        for (candidate, bound) in (0..).zip(bounds.iter()) {
            if *bound >= self.best {
                self.score(candidate, Some(self.best));
            }
        }
        for &(_, candidate) in others {
            self.score(candidate, None);
        }
        self.pool.select(self.map, self.scored, self.whole)
    }

    /// Inserts local maxima of a candidate into the pool: those near the maxima of the low part, or all that reach `floor`;
    /// for a masked query all.
    fn score(&mut self, candidate: u32, floor: Option<i32>) {
        let (number, place) = (candidate as usize / super::GROUP, candidate as usize % super::GROUP);
        let Some(group) = self.index.as_groups().get(number) else { return };
        let Some(record) = self.map.get(candidate as usize) else { return };
        let near = match floor {
            _ if self.query.is_masked() => [true; POINTS],
            None => highest(&self.work.low.curve(group, place)),
            Some(floor) => {
                let reach = self.work.low.reach(group, place, floor);
                self.work.low.curve(group, place).map(|low| low >= reach)
            }
        };
        if !near.contains(&true) {
            return;
        }
        record.scan(&mut self.work.scan);
        self.work.descriptor.fill(&self.work.scan);
        self.work.candidate.fill(&self.work.descriptor);
        self.work.scores = [None; BINS];
        self.scored += 1;
        for shift in (0..BINS).filter(|&s| near[nearest_point(s)]) {
            self.insert_if_peak(candidate, shift, floor.unwrap_or(i32::MIN));
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "shifts are below 360")]
    fn insert_if_peak(&mut self, candidate: u32, shift: usize, floor: i32) {
        let here = self.at(shift);
        let [before, after] = circle::beside(shift);
        let (before, after) = (self.at(before), self.at(after));
        // Of a plateau its first shift counts, of constant scores shift 0.
        if here < floor || here < after || here < before || (here == before && shift != 0) {
            return;
        }
        self.best = self.best.max(here);
        let peak = Peak { shift: shift as u16, score_bits: here };
        self.pool.insert_if_better(Match { candidate, peak });
    }

    /// The exact score at a shift, cached.
    fn at(&mut self, shift: usize) -> i32 {
        let Exact { scores, candidate, .. } = &mut *self.work;
        let query = self.query;
        let Some(slot) = scores.get_mut(shift) else { return i32::MIN };
        *slot.get_or_insert_with(|| query.score(candidate, shift).to_bits())
    }
}

/// The sample of the low part nearest to a shift.
const fn nearest_point(shift: usize) -> usize {
    // 64 points over 360 shifts: (64 s + 180) / 360, rounded down.
    (shift * POINTS + BINS / 2) / BINS % POINTS
}

/// Marks the four highest local maxima of a curve and their neighbours.
fn highest(curve: &[i64; POINTS]) -> [bool; POINTS] {
    let mut peaks = [(i64::MIN, 0); 4];
    for (m, &here) in curve.iter().enumerate() {
        let (before, after) = (curve[(m + POINTS - 1) % POINTS], curve[(m + 1) % POINTS]);
        if here >= after
            && here >= before
            && let Some(worst) = peaks.iter_mut().min()
            && here > worst.0
        {
            *worst = (here, m);
        }
    }
    let mut near = [false; POINTS];
    for (_, m) in peaks.into_iter().filter(|p| p.0 > i64::MIN) {
        for neighbour in [m + POINTS - 1, m, m + 1] {
            near[neighbour % POINTS] = true;
        }
    }
    near
}

impl Exact {
    /// Upper bounds of the scores of the candidates of a group, as bits of [`Score`].
    fn bound(&mut self, group: &Group, bounds: &mut [i32]) {
        self.products(group);
        lanes::inverse(&mut self.re, &mut self.im);
        let mut top = [[i16::MIN; LANES]; 2];
        for (re, im) in self.re.iter().zip(&self.im) {
            for (top, part) in top.iter_mut().zip([re, im]) {
                for lane in 0..LANES {
                    top[lane] = top[lane].max(part[lane]);
                }
            }
        }
        for ((place, bound), top) in (0..).zip(bounds).zip(top.as_flattened()) {
            let low = (i64::from(*top) + LOW_ERROR) << PRODUCT_SHIFT;
            *bound = self.low.upper(group, place, low);
        }
    }

    /// The cross spectra of a group in bit-reversed order. A lane holds two candidates, whose correlations become the real
    /// and the imaginary part.
    fn products(&mut self, group: &Group) {
        // Harmonic 0 stays zero: the low part excludes the means.
        (self.re, self.im) = ([[0; LANES]; POINTS], [[0; LANES]; POINTS]);
        let reversed = |k: usize| k.reverse_bits() >> (usize::BITS - POINTS.ilog2());
        for k in 0..HARMONICS {
            let [a, b] = [0, 1].map(|half| self.low.product(group, k, half));
            let (plus, minus) = (reversed(k + 1), reversed(POINTS - k - 1));
            for lane in 0..LANES {
                let ([ar, ai], [br, bi]) = ([a[0][lane], a[1][lane]], [b[0][lane], b[1][lane]]);
                // X_k = A + i B at +k, conj(A) + i conj(B) at -k; at k = 32 both meet.
                self.re[plus][lane] = self.re[plus][lane].wrapping_add(ar.wrapping_sub(bi));
                self.im[plus][lane] = self.im[plus][lane].wrapping_add(ai.wrapping_add(br));
                self.re[minus][lane] = self.re[minus][lane].wrapping_add(ar.wrapping_add(bi));
                self.im[minus][lane] = self.im[minus][lane].wrapping_add(br.wrapping_sub(ai));
            }
        }
    }
}

impl LowQuery {
    const EMPTY: Self = Self {
        splat: [[[[0; LANES]; 2]; HARMONICS]; CHANNELS],
        exponent: 0,
        residual: [0; CHANNELS],
        slope: [0; CHANNELS],
        offset: [0; CHANNELS],
        weights: [0; CHANNELS],
        norm: 1,
        similarity: Similarity::Centred,
    };

    /// Prepares a query without a mask.
    fn set(&mut self, query: &Query) {
        self.similarity = query.similarity();
        self.norm = query.squared_norm().isqrt().max(1);
        let mut weighted = [[[0; 2]; HARMONICS]; CHANNELS];
        for (channel, harmonics_out) in weighted.iter_mut().enumerate() {
            let values: [i16; BINS] = core::array::from_fn(|bin| query.balanced(channel, bin));
            let weight = i64::from(query.weights().0[channel]);
            let found: [Pair<i64>; HARMONICS] = spectrum(&values);
            let sum: i32 = values.iter().map(|&v| i32::from(v)).sum();
            let square: i32 = values.iter().map(|&v| i32::from(v) * i32::from(v)).sum();
            let rest = Rest::of(&found, sum, square);
            self.weights[channel] = weight;
            self.residual[channel] = weight * i64::from(rest.residual);
            self.slope[channel] = weight * i64::from(rest.slope);
            self.offset[channel] = match self.similarity {
                Similarity::Plain => weight * query.sum(channel),
                Similarity::Centred => 0,
            };
            *harmonics_out = found.map(|pair| pair.map(|v| v * weight));
        }
        self.scale(&weighted);
    }

    #[expect(clippy::cast_possible_truncation, reason = "the norm of the scaled parts is at most 2^14")]
    fn scale(&mut self, weighted: &[[Pair<i64>; HARMONICS]; CHANNELS]) {
        let parts = weighted.as_flattened().as_flattened();
        // Shifted right by 12, the sum of the squares is below 2^61 (Parseval).
        let norm = |down: u32| {
            parts.iter().map(|v| ((v.unsigned_abs() >> down) + 1).pow(2)).sum::<u64>().isqrt() + 1
        };
        let mut exponent = 12;
        while norm(exponent) > QUERY_NORM {
            exponent += 1;
        }
        while exponent > 0 && norm(exponent - 1) <= QUERY_NORM {
            exponent -= 1;
        }
        self.exponent = exponent.cast_signed();
        for (splat, pair) in self.splat.as_flattened_mut().iter_mut().zip(weighted.as_flattened()) {
            for (lane, &value) in splat.iter_mut().zip(pair) {
                let half = (1_i64 << exponent) >> 1;
                *lane = [((value + half) >> exponent) as i16; LANES];
            }
        }
    }

    /// conj(query) x candidate, summed over the channels, for one harmonic and half of a group.
    fn product(&self, group: &Group, k: usize, half: usize) -> [Lane; 2] {
        let (mut re, mut im) = ([0_i32; LANES], [0_i32; LANES]);
        for (query, group) in self.splat.iter().zip(&group.coefficients) {
            let ([q_re, q_im], [d_re, d_im]) = (&query[k % HARMONICS], &group[k % HARMONICS][half % 2]);
            for lane in 0..LANES {
                let [qr, qi, dr, di] = [q_re[lane], q_im[lane], d_re[lane], d_im[lane]].map(i32::from);
                re[lane] += qr * dr + qi * di;
                im[lane] += qr * di - qi * dr;
            }
        }
        let round = 1 << (PRODUCT_SHIFT - 1);
        let mut out = [[0; LANES]; 2];
        for lane in 0..LANES {
            out[0][lane] = ((re[lane] + round) >> PRODUCT_SHIFT) as i16;
            out[1][lane] = ((im[lane] + round) >> PRODUCT_SHIFT) as i16;
        }
        out
    }

    /// Upper bound of the part of a correlation (weighted, centred, Q20) above the samples of the low part: harmonics above
    /// the 32nd, and the rise between samples.
    fn rest(&self, group: &Group, place: usize) -> i64 {
        // (pi / 64)^2 / 2 in Q18, rounded up, and 8 for the unit of the candidates' slopes.
        const CURVATURE: i64 = 316 * 8;
        let over = |own: &[i64; CHANNELS], theirs: &[[u16; super::GROUP]; CHANNELS]| -> i64 {
            own.iter().zip(theirs).map(|(a, b)| a * i64::from(b[place % super::GROUP])).sum()
        };
        over(&self.residual, &group.residual) + ((over(&self.slope, &group.slope) * CURVATURE) >> 18) + 1
    }

    /// Binary exponent of the unit of products relative to that of correlations.
    fn exponent(&self, group: &Group, place: usize) -> i32 {
        self.exponent - i32::from(group.shift[place % super::GROUP]) - 20
    }

    /// The bound, as bits of [`Score`], of a candidate whose low part is at most `low`, in units of the products.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "norms are shifted to 31 bits, bounds clamped to +-2^30"
    )]
    fn upper(&self, group: &Group, place: usize, low: i64) -> i32 {
        let exponent = self.exponent(group, place);
        let low = if exponent >= 0 { low << exponent } else { (low >> -exponent) + 1 };
        let Sizes { norms, offset } = self.sizes(group, place);
        if norms == 0 {
            // A norm of 0 gives a score of 0.
            return 0;
        }
        let numerator = (low + self.rest(group, place)) * self.factor() + offset;
        // Numerators are below 2^50. A denominator of 31 bits is rounded down, which increases the bound.
        let down = (u64::BITS - norms.leading_zeros()).saturating_sub(31);
        let denominator = i64::from((norms >> down) as u32).max(1);
        let up = 30 - down.cast_signed();
        let scaled = if up >= 0 { numerator.saturating_mul(1 << up) } else { (numerator >> -up) + 1 };
        let one = i64::from(Score::ONE.to_bits());
        (scaled / denominator).clamp(-one, one) as i32 + 16
    }

    /// The low part, in units of the products, from which on a candidate can reach a score.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a product of norms below 2^63 and of a score of at most 1"
    )]
    fn reach(&self, group: &Group, place: usize, floor: i32) -> i64 {
        let Sizes { norms, offset } = self.sizes(group, place);
        let product = (i128::from(norms) * i128::from(floor)) >> 30;
        let correlation = (product as i64 - offset) / self.factor() - self.rest(group, place) - 2;
        let exponent = self.exponent(group, place);
        if exponent >= 0 { (correlation >> exponent) - 1 } else { (correlation << -exponent) - 1 }
    }

    /// Factor of a correlation in the numerator of the cosine.
    const fn factor(&self) -> i64 {
        match self.similarity {
            Similarity::Plain => 1,
            Similarity::Centred => BINS_I64,
        }
    }

    /// The product of the norms, rounded down, and the part of the means in the numerator, rounded up.
    fn sizes(&self, group: &Group, place: usize) -> Sizes {
        let (mut norm, mut offset) = (0_i64, 0_i64);
        for (channel, weight) in self.weights.iter().enumerate() {
            let of_place = place % super::GROUP;
            let (sum, square) =
                (i64::from(group.sums[channel][of_place]), i64::from(group.squares[channel][of_place]));
            norm += weight
                * match self.similarity {
                    Similarity::Plain => square,
                    Similarity::Centred => BINS_I64 * square - sum * sum,
                };
            offset += self.offset[channel] * sum;
        }
        let offset = if offset == 0 { 0 } else { offset / BINS_I64 + 1 };
        Sizes { norms: self.norm * norm.unsigned_abs().isqrt(), offset }
    }

    /// Upper bound of the low part of a candidate at each of the 64 headings, in units of the products.
    fn curve(&self, group: &Group, place: usize) -> [i64; POINTS] {
        let (half, lane) = (place / LANES, place % LANES);
        let mut products = [[0_i64; 2]; HARMONICS];
        for (query, group) in self.splat.iter().zip(&group.coefficients) {
            for (([re, im], q), d) in products.iter_mut().zip(query).zip(group) {
                let [qr, qi, dr, di] = [q[0][0], q[1][0], d[half][0][lane], d[half][1][lane]].map(i64::from);
                *re += qr * dr + qi * di;
                *im += qr * di - qi * dr;
            }
        }
        core::array::from_fn(|m| {
            let mut sum = LOW_ERROR << (PRODUCT_SHIFT + 15);
            for (k, [re, im]) in products.iter().enumerate() {
                let [cos, sin] = lanes::TURNS[(k + 1) * m % POINTS].map(i64::from);
                sum += 2 * (re * cos - im * sin);
            }
            sum >> 15
        })
    }
}

/// The terms that convert a correlation to a cosine.
struct Sizes {
    norms: u64,
    offset: i64,
}
