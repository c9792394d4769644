//! A layout of the evidence table that scores a candidate at all headings by a few sums of long rows.
//!
//! The candidate's ray i, cast with heading 0, lies in bin i - h of a robot of heading h. Rows are stored in reverse
//! order, so that the values of all headings are contiguous, and twice, so that they do not wrap. A row holds prefix
//! sums: a run of rays of one plane (a third to two thirds of all rays are in such runs) costs one difference. Values
//! are offset by [`LIMIT`], so that prefix sums increase. They may wrap at 2^16, which the difference cancels: 360 values
//! add up to at most 63,360.

use super::evidence::{EvidenceTable, LIMIT, OPEN_PLANE, PLANES, plane_of};
use crate::base::ladder::RANGE_RUNGS;
#[cfg(doc)]
use crate::base::num::BinNats;
use crate::base::num::{BINS, Nats};
use crate::base::scan::{Hit, Scan};
use crate::map::site_map::{LADDER, PACKED_SCAN_BYTES};
use bytemuck::{Pod, Zeroable};

/// The value 0 with the offset [`LIMIT`].
const ZERO: u16 = LIMIT.to_bits().unsigned_abs() as u16;
const _: () = assert!(BINS * 2 * ZERO as usize <= u16::MAX as usize, "sums fit 16 bits");
/// Largest number of headings whose prefix sums over two turns do not wrap at 2^16.
const UNWRAPPED: usize = u16::MAX as usize / (4 * ZERO as usize);

/// Planes by the range code of a [packed scan](crate::map::site_map::PackedScan), for walls and open directions.
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time")]
static WALL_PLANES: [u8; 256] = {
    let mut planes = [OPEN_PLANE; 256];
    let mut code = 0;
    while code < LADDER.len() {
        planes[code] = plane_of(LADDER[code], Hit::Wall);
        code += 1;
    }
    planes
};

/// An [`EvidenceTable`] prepared for scoring at N headings: 870 N bytes. N is even and divides 360.
///
/// A bin is the mean of `360 / N` bins of the table, rounded to the nearest 1/16 nat.
///
/// # Accuracy
/// Sums are exact: for N = 360 a score equals the sum of the cells, for smaller N it differs by the rounding of the means,
/// at most 1/32 nat per bin (test `scores_equal_the_direct_sum`).
///
/// ```
/// use compass_core::pose::{EvidenceTable, Rows};
/// use compass_core::{Nats, Scan};
///
/// // Evidence of open directions, 1 nat in each.
/// let mut table = Box::new(EvidenceTable::EMPTY);
/// table.set_plane(compass_core::pose::OPEN_PLANE, &[Nats::ONE; 360]);
/// let mut rows = Box::new(Rows::<40>::BLANK);
/// rows.set(&table);
/// let mut scores = [0; 40];
/// rows.scores(&Rows::planes(&Scan::OPEN), &mut scores);
/// assert_eq!(scores, [40 * 16; 40], "40 nats at every heading");
/// ```
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub struct Rows<const N: usize> {
    /// Per plane: prefix sums in reverse order of the bins over two turns; then sums of [`ROUGH`](Self::ROUGH) bins,
    /// beginning at every second bin, in reverse order over two turns.
    sums: [[[u16; N]; 3]; PLANES],
}

impl<const N: usize> Rows<N> {
    /// Bins of the table in one bin.
    pub const STRIDE: usize = {
        assert!(N > 0 && BINS.is_multiple_of(N) && N.is_multiple_of(2), "N divides 360 and is even");
        BINS / N
    };

    /// Rows to be filled by [`Rows::set`]: all bytes zero.
    pub const BLANK: Self = Self { sums: [[[0; N]; 3]; PLANES] };

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

    /// Prepares a table for scoring.
    ///
    /// # Cost
    /// Per plane 360 additions for the means, 2 N for the prefix sums and at most 6 N for the rough sums.
    #[expect(clippy::cast_possible_truncation, reason = "at most 360")]
    pub fn set(&mut self, table: &EvidenceTable) {
        for (plane, [once, again, rough]) in (0..).zip(&mut self.sums) {
            let Some(values) = table.plane(plane) else { return };
            let mut bins = [0; N];
            for (bin, values) in bins.iter_mut().zip(values.chunks_exact(Self::STRIDE)) {
                let whole: u16 =
                    values.iter().map(|&v| i16::from(v.to_bits()).cast_unsigned().wrapping_add(ZERO)).sum();
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
    }

    /// The planes of a candidate, from its scan cast with heading 0.
    #[must_use]
    pub fn planes(scan: &Scan) -> [u8; N] {
        let mut planes = [OPEN_PLANE; N];
        // The middle one of the `STRIDE` bins of the scan.
        let middle = Self::STRIDE / 2;
        let rays = scan.steps.iter().zip(&scan.hit).skip(middle).step_by(Self::STRIDE);
        for (plane, (&steps, &hit)) in planes.iter_mut().zip(rays) {
            *plane = plane_of(steps, hit);
        }
        planes
    }

    /// The planes of a candidate from the bytes of a site map: the same as of the unpacked scan.
    #[must_use]
    #[inline]
    pub fn planes_of_packed(packed: &[u8; PACKED_SCAN_BYTES]) -> [u8; N] {
        let mut planes = [OPEN_PLANE; N];
        for (plane, seen) in planes.iter_mut().zip(Self::every_plane(packed, 1)) {
            *plane = seen;
        }
        planes
    }

    /// The planes of every `step`-th ray.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "72 rungs")]
    fn every_plane(packed: &[u8; PACKED_SCAN_BYTES], step: usize) -> impl Iterator<Item = u8> {
        let (codes, windows) = packed.split_at(BINS);
        (Self::STRIDE / 2..BINS).step_by(step * Self::STRIDE).map(move |bin| {
            let code = codes.get(bin).map_or(0, |code| usize::from(*code));
            let bits = windows.get(bin / 8).copied().unwrap_or(0);
            let wall = WALL_PLANES.get(code).copied().unwrap_or(OPEN_PLANE);
            (wall + RANGE_RUNGS as u8 * (bits >> (bin % 8) & 1)).min(OPEN_PLANE)
        })
    }

    /// Scores of a candidate at all headings: `out[s]` is the sum over N bins at heading s 360 / N degrees.
    ///
    /// # Formats
    /// `planes[i]` is the plane of ray i, cast with heading 0; planes above [`OPEN_PLANE`] count as open. `out` has the
    /// bits of [`BinNats`], 1/16 nat.
    ///
    /// # Cost
    /// 2 N additions per run of equal planes.
    #[inline]
    pub fn scores(&self, planes: &[u8; N], out: &mut [i16; N]) {
        *out = self.sums_of(planes).map(Self::of_sum);
    }

    /// Estimate of the best score of a candidate, in the bits of [`Rows::scores`], from a subset of its rays at every
    /// second heading. Each ray of the subset stands for the 2, 4 or 6 rays from it on.
    ///
    /// # Cost
    /// N / 2 additions per ray of the subset: N / 6 rays where 6 divides N, else N / 4, else N / 2.
    #[must_use]
    #[inline]
    pub fn rough_top(&self, packed: &[u8; PACKED_SCAN_BYTES]) -> i16 {
        let mut sums = [0; N];
        let sums = sums.get_mut(..N / 2).unwrap_or_default();
        let mut rays = (1..=N / 2).rev().step_by(Self::ROUGH / 2).zip(Self::every_plane(packed, Self::ROUGH));
        let mut row = || {
            let (from, plane) = rays.next()?;
            self.sums.get(usize::from(plane))?.get(2)?.get(from..from + N / 2)
        };
        while let Some(first) = row() {
            let mut more = || row().unwrap_or(&[0; N]);
            let five = [first, more(), more(), more(), more()];
            if N.is_multiple_of(4) { add_rough_pairs(five, sums) } else { add_rough(five, sums) }
        }
        Self::of_sum(sums.iter().fold(0, |top, sum| top.max(*sum)))
    }

    /// Sums of values with the offset [`LIMIT`] each.
    #[inline]
    fn sums_of(&self, planes: &[u8; N]) -> [u16; N] {
        let mut sums = [0; N];
        let mut runs = self.runs(planes);
        while let Some(first) = runs.next() {
            let mut more = || runs.next().unwrap_or(Run::NONE);
            let three = [first, more(), more()];
            if N <= UNWRAPPED { add_pairs(three, &mut sums) } else { add(three, &mut sums) }
        }
        sums
    }

    #[expect(clippy::cast_possible_truncation, reason = "at most 360")]
    const fn of_sum(sum: u16) -> i16 {
        sum.wrapping_sub(N as u16 * ZERO).cast_signed()
    }

    /// Per run of equal planes, the two rows of prefix sums whose difference is the sum of the run.
    #[inline]
    fn runs<'a>(&'a self, planes: &'a [u8; N]) -> impl Iterator<Item = Run<'a, N>> {
        let (mut at, mut rest) = (N, planes.as_slice());
        core::iter::from_fn(move || {
            let plane = *rest.first()?;
            let length = rest.iter().position(|other| *other != plane).unwrap_or(rest.len());
            rest = rest.get(length..).unwrap_or_default();
            let row = self.sums.get(usize::from(plane.min(OPEN_PLANE)));
            let row = row.map(|copies| copies.as_flattened()).unwrap_or_default();
            let part = |from: usize| row.get(from..).and_then(<[u16]>::first_chunk).unwrap_or(&[0; N]);
            let from = at;
            at = at.saturating_sub(length);
            Some(Run { plus: part(from), minus: part(at) })
        })
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
    use crate::map::site_map::PackedScan;
    use proptest::prelude::*;
    use std::boxed::Box;

    /// A table of noise, its values within the limit.
    fn noise(seed: u64) -> Box<EvidenceTable> {
        let mut table = Box::new(EvidenceTable::EMPTY);
        let mut state = seed | 1;
        for plane in 0..PLANES as u8 {
            for bin in 0..BINS {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                // A fifth lies beyond the limit and is clipped to it.
                table.set(plane, bin, Nats::from_bits((state % 221) as i32 - 110));
            }
        }
        table
    }

    /// The sum over a candidate's rays at a heading, exact, of all 360 bins, in units of [`Nats`].
    fn naive<const N: usize>(table: &EvidenceTable, planes: &[u8; N], heading: usize) -> f64 {
        let stride = BINS / N;
        let mut sum = 0.0;
        for (ray, &plane) in planes.iter().enumerate() {
            let bin = (ray + N - heading) % N * stride;
            sum += (0..stride).map(|k| f64::from(table.get(plane, bin + k).to_bits())).sum::<f64>();
        }
        sum
    }

    fn check<const N: usize>(seed: u64) -> Result<(), TestCaseError> {
        let table = noise(seed);
        let mut rows = Box::new(Rows::<N>::BLANK);
        rows.set(&table);
        let planes = core::array::from_fn(|i| ((i * i + seed as usize) % PLANES) as u8);
        let mut scores = [0; N];
        rows.scores(&planes, &mut scores);
        for (heading, &score) in scores.iter().enumerate() {
            let expected = naive(&table, &planes, heading) * N as f64 / BINS as f64;
            let rounding = if N == BINS { 0.0 } else { 0.5 * N as f64 };
            let got = f64::from(score);
            prop_assert!((got - expected).abs() <= rounding, "{} at {}, not {}", got, heading, expected);
        }
        Ok(())
    }

    /// The rough score equals the best score over every second heading if each ray of the subset equals those it stands for.
    fn check_rough<const N: usize>(seed: u64) -> Result<(), TestCaseError> {
        let mut rows = Box::new(Rows::<N>::BLANK);
        rows.set(&noise(seed));
        let mut packed = [0; PACKED_SCAN_BYTES];
        let (codes, windows) = packed.split_at_mut(BINS);
        let (alike, middle) = (Rows::<N>::ROUGH * BINS / N, BINS / N / 2);
        for (bin, code) in codes.iter_mut().enumerate() {
            let ray = bin / alike;
            *code = (ray * ray + seed as usize % 97) as u8;
            windows[bin / 8] |= u8::from(ray % 3 == 1) << (bin % 8);
        }
        let mut scores = [0; N];
        rows.scores(&Rows::planes_of_packed(&packed), &mut scores);
        let best = scores.iter().step_by(2).max().copied();
        prop_assert_eq!(Some(rows.rough_top(&packed)), best);
        // Rays in between do not matter.
        for (bin, code) in packed.iter_mut().take(BINS).enumerate().filter(|(bin, _)| bin % alike != middle) {
            *code = (bin + seed as usize) as u8;
        }
        prop_assert_eq!(Some(rows.rough_top(&packed)), best);
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn scores_equal_the_direct_sum(seed: u64) {
            check::<360>(seed)?;
            check::<180>(seed)?;
            check::<120>(seed)?;
            check::<90>(seed)?;
            check::<30>(seed)?;
        }

        #[test]
        fn rough_scores_are_exact_for_repeated_rays(seed: u64) {
            check_rough::<360>(seed)?;
            check_rough::<90>(seed)?;
            check_rough::<40>(seed)?;
            check_rough::<20>(seed)?;
            check_rough::<10>(seed)?;
        }
    }

    #[test]
    fn packed_scans_have_the_planes_of_unpacked_ones() {
        let mut packed = PackedScan([0; PACKED_SCAN_BYTES]);
        for seed in 0..8 {
            for (at, byte) in packed.0.iter_mut().enumerate() {
                *byte = (at * at + 37 * seed) as u8;
            }
            let mut scan = Scan::OPEN;
            packed.unpack(&mut scan);
            assert_eq!(Rows::<360>::planes_of_packed(&packed.0), Rows::planes(&scan));
            assert_eq!(Rows::<90>::planes_of_packed(&packed.0), Rows::planes(&scan));
        }
    }

    #[test]
    fn extremes_do_not_overflow() {
        for value in [-1000, 1000] {
            let mut table = Box::new(EvidenceTable::EMPTY);
            for (plane, bin) in (0..PLANES as u8).flat_map(|p| (0..BINS).map(move |b| (p, b))) {
                table.set(plane, bin, Nats::from_bits(value));
            }
            let mut rows = Box::new(Rows::<360>::BLANK);
            rows.set(&table);
            let mut scores = [0; 360];
            rows.scores(&[255; 360], &mut scores);
            assert_eq!(scores, [value.signum() as i16 * 360 * i16::from(LIMIT.to_bits()); 360]);
        }
    }

    #[test]
    fn headings_turn_counter_clockwise() {
        // A window straight ahead of a robot that looks along 30 degrees.
        let mut table = Box::new(EvidenceTable::EMPTY);
        let mut scan = Scan { steps: [100; BINS], hit: [Hit::Wall; BINS] };
        table.set(plane_of(100, Hit::Window), 0, Nats::from_bits(80));
        scan.hit[30] = Hit::Window;
        let mut rows = Box::new(Rows::<360>::BLANK);
        rows.set(&table);
        let mut scores = [0; 360];
        rows.scores(&Rows::planes(&scan), &mut scores);
        let expected = core::array::from_fn(|heading| if heading == 30 { 80 } else { 0 });
        assert_eq!(scores, expected, "elsewhere nothing is known");
    }
}
