//! A layout of the evidence that scores a candidate at all headings by a few sums of long rows.
//!
//! The candidate's ray i, cast with heading 0, lies in bin i - h of a robot of heading h. Rows are stored in reverse
//! order, so that the values of all headings are contiguous, and twice, so that they do not wrap. A row holds prefix
//! sums: a run of rays of one row (a third to two thirds of all rays are in such runs) costs one difference. Values
//! are offset, so that prefix sums increase. They may wrap at 2^16, which the difference cancels.
//!
//! Floor, ceiling and hit type are sources of their own. A height shifts the rows of its source: a candidate is scored at
//! each height of the camera and at each of the ceiling, not at each pair of them.

use super::blur::Blur;
use super::evidence::HitEvidence;
use crate::base::ladder::{FRACTION_BITS, RANGE_RUNGS, position_of};
#[cfg(doc)]
use crate::base::num::BinNats;
use crate::base::num::{BINS, CellNats, Nats};
use crate::map::site_map::{LADDER, PACKED_SCAN_BYTES};
use crate::vision::boundary::{BoundaryEvidence, RUNGS, rung_of};
use bytemuck::{Pod, Zeroable};
use heapless::Vec;

/// The value 0 with its offset: no cell is below -4 nats.
const ZERO: u16 = 64;
/// Largest value with its offset.
const MOST: u16 = ZERO + 72;
const _: () = assert!(BINS * MOST as usize <= u16::MAX as usize, "sums fit 16 bits");
/// Largest number of headings whose prefix sums over two turns do not wrap at 2^16.
const UNWRAPPED: usize = u16::MAX as usize / (2 * MOST as usize);

/// The row of zeros, and those of hit types.
const NOTHING: usize = 2 * RUNGS;
const WALL: usize = NOTHING + 1;
const WINDOW: usize = NOTHING + 2;
const ROWS: usize = NOTHING + 3;

/// The code of an open direction, beyond those of the ranges.
#[expect(clippy::cast_possible_truncation, reason = "`RANGE_RUNGS` is 72")]
const OPEN: u8 = RANGE_RUNGS as u8;

/// Range rungs by the range code of a [packed scan](crate::map::site_map::PackedScan).
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time")]
static RUNG_OF_CODE: [u8; 256] = {
    let mut rungs = [OPEN; 256];
    let mut code = 0;
    while code < LADDER.len() {
        rungs[code] = ((position_of(LADDER[code]) + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS) as u8;
        code += 1;
    }
    rungs
};

/// A source of evidence, at a height in rungs where it has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The boundary of the floor, for a height of the camera above it.
    Floor(i8),
    /// The boundary of the ceiling, for its height above the camera.
    Ceiling(i8),
    /// Window or wall.
    HitType,
}

impl Source {
    /// The row of a ray.
    #[inline(always)]
    fn row(self, ray: Ray) -> usize {
        let (base, height) = match self {
            _ if ray.rung == OPEN => return NOTHING,
            Self::HitType => return if ray.window { WINDOW } else { WALL },
            Self::Floor(height) => (0, height),
            Self::Ceiling(height) => (RUNGS, height),
        };
        rung_of(ray.rung.into(), height.into()).map_or(NOTHING, |rung| base + rung)
    }
}

/// What a ray of a candidate meets: the rung of its range, and whether it is a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ray {
    rung: u8,
    window: bool,
}

/// The rays of a candidate, cast with heading 0, as runs of equal ones with their lengths.
pub(super) type Runs<const N: usize> = Vec<(Ray, u16), N>;

/// Evidence prepared for scoring at N headings: 1098 N bytes. N is even and divides 360.
///
/// A bin is the mean of `360 / N` bins of the evidence, rounded to the nearest 1/16 nat.
///
/// # Accuracy
/// Sums are exact: for N = 360 a score equals the sum of the cells, for smaller N it differs by the rounding of the means,
/// at most 1/32 nat per bin (test `scores_equal_the_direct_sum`).
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct Rows<const N: usize> {
    /// Per row: prefix sums in reverse order of the bins over two turns; then sums of [`ROUGH`](Self::ROUGH) bins,
    /// beginning at every second bin, in reverse order over two turns.
    sums: [[[u16; N]; 3]; ROWS],
}

impl<const N: usize> Rows<N> {
    /// Bins of the evidence in one bin.
    pub const STRIDE: usize = {
        assert!(N > 0 && BINS.is_multiple_of(N) && N.is_multiple_of(2), "N divides 360 and is even");
        BINS / N
    };

    /// Rows to be filled by [`Rows::set`]: all bytes zero.
    pub const BLANK: Self = Self { sums: [[[0; N]; 3]; ROWS] };

    /// Stride of the rays of a rough score: an even divisor of N.
    const ROUGH: usize = if N.is_multiple_of(6) {
        6
    } else if N.is_multiple_of(4) {
        4
    } else {
        2
    };

    /// A sum over N bins, the bits of [`BinNats`], scaled to 360 bins.
    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 360")]
    pub(super) const fn of_360(score: i16) -> Nats {
        Nats::from_bits(score as i32 * Self::STRIDE as i32)
    }

    /// The inverse, rounded down.
    #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 360")]
    pub(super) const fn from_360(nats: CellNats) -> i16 {
        nats.to_bits() as i16 / Self::STRIDE as i16
    }

    /// Prepares evidence for scoring candidates that are `spacing_m` apart: between candidates, ranges differ by a part of
    /// that, over which likelihoods are averaged.
    ///
    /// # Cost
    /// Per row of a surface 360 additions and logarithms for the means, 2 N for the prefix sums and at most 6 N for the rough
    /// sums.
    pub fn set(&mut self, evidence: &BoundaryEvidence<'_>, hits: &HitEvidence, spacing_m: f32) {
        for surface in 0..2 {
            let mut blur = Blur::new(evidence, surface, spacing_m);
            for rung in 0..RUNGS {
                self.store(surface * RUNGS + rung, &blur.rung(rung));
            }
        }
        self.store(NOTHING, &[CellNats::ZERO; BINS]);
        self.store(WALL, &hits.wall);
        self.store(WINDOW, &hits.window);
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "strides are at most 360; values are within +-4 nats or above 0"
    )]
    fn store(&mut self, row: usize, values: &[CellNats; BINS]) {
        let Some([once, again, rough]) = self.sums.get_mut(row) else { return };
        let mut bins = [0; N];
        for (bin, values) in bins.iter_mut().zip(values.chunks_exact(Self::STRIDE)) {
            let limit = i16::from(MOST as u8 - ZERO as u8);
            let value = |value: &CellNats| {
                (i16::from(value.to_bits()).clamp(-ZERO.cast_signed(), limit) + ZERO.cast_signed()) as u16
            };
            let whole: u16 = values.iter().map(value).sum();
            *bin = (whole + Self::STRIDE as u16 / 2) / Self::STRIDE as u16;
        }
        let mut sum = 0_u16;
        for copy in [once, again] {
            for (slot, bin) in copy.iter_mut().zip(bins.iter().rev()) {
                *slot = sum;
                sum = sum.wrapping_add(*bin);
            }
        }
        for (at, slot) in rough.iter_mut().enumerate() {
            let from = 2 * N - 2 * at;
            *slot = (from..from + Self::ROUGH).map(|bin| bins.get(bin % N).copied().unwrap_or(0)).sum();
        }
    }

    /// Every `step`-th ray of a candidate, from the bytes of a site map.
    #[inline]
    fn every_ray(packed: &[u8; PACKED_SCAN_BYTES], step: usize) -> impl Iterator<Item = Ray> {
        let (codes, windows) = packed.split_at(BINS);
        // The middle one of the `STRIDE` bins of the scan.
        (Self::STRIDE / 2..BINS).step_by(step * Self::STRIDE).map(move |bin| {
            let code = codes.get(bin).map_or(0, |code| usize::from(*code));
            let bits = windows.get(bin / 8).copied().unwrap_or(0);
            let rung = RUNG_OF_CODE.get(code).copied().unwrap_or(OPEN);
            Ray { rung, window: rung != OPEN && bits >> (bin % 8) & 1 != 0 }
        })
    }

    /// The rays of a candidate as runs.
    #[must_use]
    #[inline]
    pub(super) fn runs_of(packed: &[u8; PACKED_SCAN_BYTES]) -> Runs<N> {
        let mut runs: Runs<N> = Vec::new();
        for ray in Self::every_ray(packed, 1) {
            match runs.last_mut() {
                Some((last, length)) if *last == ray => *length += 1,
                // Never full: N rays.
                _ => _ = runs.push((ray, 1)),
            }
        }
        runs
    }

    /// A part of the rays of a candidate, for rough scores.
    #[must_use]
    #[inline]
    pub(super) fn rough_rays(packed: &[u8; PACKED_SCAN_BYTES]) -> Vec<Ray, BINS> {
        Self::every_ray(packed, Self::ROUGH).collect()
    }

    /// Scores of a candidate at all headings by one source: `out[s]` is the sum over N bins at heading s 360 / N degrees.
    ///
    /// # Formats
    /// The bits of [`BinNats`], 1/16 nat.
    ///
    /// # Cost
    /// 2 N additions per run.
    #[inline]
    pub(super) fn scores(&self, runs: &Runs<N>, source: Source, out: &mut [i16; N]) {
        let mut sums = [0; N];
        let mut at = N;
        let mut runs = runs.iter();
        let mut next = || {
            let (ray, length) = runs.next()?;
            let row = self.sums.get(source.row(*ray)).map(|copies| copies.as_flattened()).unwrap_or_default();
            let part = |from: usize| row.get(from..).and_then(<[u16]>::first_chunk).unwrap_or(&[0; N]);
            let from = at;
            at = at.saturating_sub(usize::from(*length));
            Some(Run { plus: part(from), minus: part(at) })
        };
        while let Some(first) = next() {
            let mut more = || next().unwrap_or(Run::NONE);
            let three = [first, more(), more()];
            if N <= UNWRAPPED { add_pairs(three, &mut sums) } else { add(three, &mut sums) }
        }
        *out = sums.map(Self::of_sum);
    }

    /// Estimates of the [scores](Self::scores) at every second heading from [a part of the rays](Self::rough_rays), each of
    /// which stands for the 2, 4 or 6 rays from it on. Half of `out` is used.
    ///
    /// # Cost
    /// N / 2 additions per ray of the subset: N / 6 rays where 6 divides N, else N / 4, else N / 2.
    #[inline]
    pub(super) fn rough_scores(&self, rays: &[Ray], source: Source, out: &mut [i16; N]) {
        let mut sums = [0; N];
        let sums = sums.get_mut(..N / 2).unwrap_or_default();
        let mut rays = (1..=N / 2).rev().step_by(Self::ROUGH / 2).zip(rays);
        let mut row = || {
            let (from, ray) = rays.next()?;
            self.sums.get(source.row(*ray))?.get(2)?.get(from..from + N / 2)
        };
        while let Some(first) = row() {
            let mut more = || row().unwrap_or(&[0; N]);
            let five = [first, more(), more(), more(), more()];
            if N.is_multiple_of(4) { add_rough_pairs(five, sums) } else { add_rough(five, sums) }
        }
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = Self::of_sum(*sum);
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "at most 360")]
    const fn of_sum(sum: u16) -> i16 {
        sum.wrapping_sub(N as u16 * ZERO).cast_signed()
    }
}

/// Prefix sums at all headings, at the first ray of a run and behind its last.
#[derive(Debug, Clone, Copy)]
struct Run<'a, const N: usize> {
    plus: &'a [u16; N],
    minus: &'a [u16; N],
}

impl<const N: usize> Run<'_, N> {
    const NONE: Self = Self { plus: &[0; N], minus: &[0; N] };
}

/// Adds three runs: the number whose pointers fit the registers of a Cortex-M.
#[inline]
fn add<const N: usize>([a, b, c]: [Run<'_, N>; 3], sums: &mut [u16; N]) {
    let plus = a.plus.iter().zip(b.plus).zip(c.plus);
    let minus = a.minus.iter().zip(b.minus).zip(c.minus);
    for (sum, (((a, b), c), ((d, e), f))) in sums.iter_mut().zip(plus.zip(minus)) {
        let rise = a.wrapping_sub(*d).wrapping_add(b.wrapping_sub(*e)).wrapping_add(c.wrapping_sub(*f));
        *sum = sum.wrapping_add(rise);
    }
}

/// Adds three runs, two headings per word. Prefix sums that do not wrap give sums that are not negative, so that a borrow
/// between the halves cancels within the word.
#[inline]
fn add_pairs<const N: usize>(runs: [Run<'_, N>; 3], sums: &mut [u16; N]) {
    let rise = |plus: &[u16; 2], minus: &[u16; 2]| word(plus).wrapping_sub(word(minus));
    let [a, b, c] = runs.map(|run| run.plus.as_chunks::<2>().0.iter().zip(run.minus.as_chunks::<2>().0));
    for (sum, ((a, b), c)) in sums.as_chunks_mut::<2>().0.iter_mut().zip(a.zip(b).zip(c)) {
        let rise = rise(a.0, a.1).wrapping_add(rise(b.0, b.1)).wrapping_add(rise(c.0, c.1));
        *sum = pair(word(sum).wrapping_add(rise));
    }
}

/// Adds five rows of a rough score.
#[inline]
fn add_rough([a, b, c, d, e]: [&[u16]; 5], sums: &mut [u16]) {
    for (sum, ((((a, b), c), d), e)) in sums.iter_mut().zip(a.iter().zip(b).zip(c).zip(d).zip(e)) {
        *sum += a + b + c + d + e;
    }
}

/// Adds five rows of a rough score, two headings per word. No half overflows: a rough sum fits 16 bits.
#[inline]
fn add_rough_pairs(rows: [&[u16]; 5], sums: &mut [u16]) {
    let [a, b, c, d, e] = rows.map(|row| row.as_chunks::<2>().0.iter().map(word));
    for (sum, ((((a, b), c), d), e)) in
        sums.as_chunks_mut::<2>().0.iter_mut().zip(a.zip(b).zip(c).zip(d).zip(e))
    {
        *sum = pair(word(sum) + a + b + c + d + e);
    }
}

/// Two values as one word.
#[inline]
fn word(pair: &[u16; 2]) -> u32 {
    u32::from(pair[0]) | u32::from(pair[1]) << 16
}

#[inline]
#[expect(clippy::cast_possible_truncation, reason = "the halves of a word")]
const fn pair(word: u32) -> [u16; 2] {
    [word as u16, (word >> 16) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::boundary::CELLS;
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec;

    /// Evidence of noise, of values that the boundary finder gives.
    fn noise(seed: u64) -> (Vec<CellNats>, HitEvidence) {
        let mut state = seed | 1;
        let mut value = |least: i8, span: u64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            CellNats::from_bits(least + (state % span) as i8)
        };
        let cells = (0..CELLS).map(|_| value(-11, 80)).collect();
        let hits = HitEvidence {
            wall: core::array::from_fn(|_| value(-52, 78)),
            window: core::array::from_fn(|_| value(-52, 78)),
        };
        (cells, hits)
    }

    /// A packed scan of any ranges and hit types.
    fn packed(seed: u64) -> [u8; PACKED_SCAN_BYTES] {
        core::array::from_fn(|at| (((at * at / 3) as u64 * (seed % 251 + 1)) >> 2) as u8)
    }

    /// The sum over a candidate's rays at a heading, exact, of all 360 bins, in units of [`Nats`].
    fn naive<const N: usize>(
        rows: &dyn Fn(usize) -> [CellNats; BINS],
        packed: &[u8; PACKED_SCAN_BYTES],
        source: Source,
        heading: usize,
    ) -> f64 {
        let stride = BINS / N;
        let mut sum = 0.0;
        for (ray, met) in Rows::<N>::every_ray(packed, 1).enumerate() {
            let bin = (ray + N - heading) % N * stride;
            let row = rows(source.row(met));
            sum += (0..stride).map(|k| f64::from(row[bin + k].to_bits())).sum::<f64>();
        }
        sum
    }

    fn check<const N: usize>(seed: u64, source: Source) -> Result<(), TestCaseError> {
        let (cells, hits) = noise(seed);
        let evidence = BoundaryEvidence::new(&cells).unwrap();
        let mut rows = Box::new(Rows::<N>::BLANK);
        rows.set(&evidence, &hits, 0.5);
        let blurred = |row: usize| {
            let surface = row / RUNGS;
            match row {
                WALL => hits.wall,
                WINDOW => hits.window,
                NOTHING => [CellNats::ZERO; BINS],
                _ => Blur::new(&evidence, surface, 0.5).rung(row % RUNGS),
            }
        };
        let packed = packed(seed);
        let mut scores = [0; N];
        rows.scores(&Rows::runs_of(&packed), source, &mut scores);
        for heading in (0..N).step_by(7) {
            let exact = naive::<N>(&blurred, &packed, source, heading) * N as f64 / BINS as f64;
            let error = f64::from(scores[heading]) - exact;
            prop_assert!(error.abs() <= 0.5 * N as f64, "{error} at {heading}, {source:?}");
            prop_assert!(N < BINS || error == 0.0, "sums of all bins are exact");
        }
        Ok(())
    }

    /// Rough scores equal the scores if each ray of the subset equals those it stands for.
    fn check_rough<const N: usize>(seed: u64, source: Source) -> Result<(), TestCaseError> {
        let (cells, hits) = noise(seed);
        let mut rows = Box::new(Rows::<N>::BLANK);
        rows.set(&BoundaryEvidence::new(&cells).unwrap(), &hits, 0.5);
        let mut packed = packed(seed);
        let (codes, windows) = packed.split_at_mut(BINS);
        let alike = Rows::<N>::ROUGH * BINS / N;
        for (bin, code) in codes.iter_mut().enumerate() {
            let ray = bin / alike;
            *code = (ray * ray + seed as usize % 97) as u8;
            windows[bin / 8] = windows[bin / 8] & !(1 << (bin % 8)) | u8::from(ray % 3 == 1) << (bin % 8);
        }
        let (mut scores, mut rough) = ([0; N], [0; N]);
        rows.scores(&Rows::runs_of(&packed), source, &mut scores);
        rows.rough_scores(&Rows::<N>::rough_rays(&packed), source, &mut rough);
        for (at, rough) in rough.iter().enumerate().take(N / 2) {
            prop_assert!(scores.iter().step_by(2).any(|score| score == rough), "{rough} at {at}");
        }
        prop_assert_eq!(rough[..N / 2].iter().max(), scores.iter().step_by(2).max());
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4))]
        #[test]
        fn scores_equal_the_direct_sum(seed: u64, height in -16_i8..=8) {
            for source in [Source::Floor(height), Source::Ceiling(height), Source::HitType] {
                check::<360>(seed, source)?;
                check::<90>(seed, source)?;
                check::<40>(seed, source)?;
            }
        }

        #[test]
        fn rough_scores_are_exact_for_repeated_rays(seed: u64, height in -16_i8..=8) {
            for source in [Source::Floor(height), Source::Ceiling(height), Source::HitType] {
                check_rough::<360>(seed, source)?;
                check_rough::<90>(seed, source)?;
                check_rough::<40>(seed, source)?;
            }
        }
    }

    #[test]
    fn extremes_do_not_overflow() {
        for bits in [i8::MIN, i8::MAX] {
            let value = CellNats::from_bits(bits);
            let cells = std::vec![value; CELLS];
            let hits = HitEvidence { wall: [value; BINS], window: [value; BINS] };
            let mut rows = Box::new(Rows::<360>::BLANK);
            rows.set(&BoundaryEvidence::new(&cells).unwrap(), &hits, 0.5);
            let mut scores = [0; 360];
            let packed = [0; PACKED_SCAN_BYTES];
            rows.scores(&Rows::runs_of(&packed), Source::HitType, &mut scores);
            let clamped = i16::from(bits).clamp(-(ZERO as i16), (MOST - ZERO) as i16);
            assert_eq!(scores, [360 * clamped; 360]);
        }
    }
}
