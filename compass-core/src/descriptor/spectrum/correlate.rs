//! Circular cross-correlation of 360 bins, summed over channels, by 1024-point transforms.
//!
//! `c[s] = sum_ch sum_i query[ch][i] * other[ch][(i + s) mod 360]`, s in 0..360.
//!
//! 360 is not a power of two: the query is extended periodically over the indices -359..360 and the other side padded
//! with zeros, so that 1024 points hold every shift without aliasing. Two real channels form one complex signal: the real
//! part of the inverse transform of the product is the sum of both correlations, so that the channels are not separated.

use super::fft::{Complex, forward, forward_padded, inverse};
use crate::base::num::BINS;

/// Number of points of the transforms.
pub const CORRELATION_POINTS: usize = 1024;

/// Largest number of channels: three complex signals of two channels.
const MAX_CHANNELS: usize = 6;
/// Number of complex signals.
const PAIRS: usize = MAX_CHANNELS / 2;
type Signal = [Complex; CORRELATION_POINTS];

/// Values are scaled to at most 2^29 before a transform, so that the modulus of two parts is below 2^30.
const FULL_SCALE_BITS: u32 = 29;

/// Cross-correlation with a query: its spectra and the workspace, 40 KiB, suited for a static.
///
/// # Formats
/// Values up to 2^29 in magnitude, block-scaled to 2^29. Spectra are shifted left as far as their norms allow (no value
/// exceeds the norm), and the high words of their products are summed: about 18 significant bits at a perfect match.
///
/// # Accuracy
/// Within 2^-12 of the product of the two norms (test `agrees_with_the_direct_sum`).
///
/// # Cost
/// Per correlation of c channels, c / 2 (rounded up) transforms and one inverse transform of 1024 points.
///
/// # References
/// Cross-correlation theorem; the extension to 1024 points is that of a circular convolution by a longer FFT.
///
/// ```
/// use compass_core::descriptor::spectrum::{Correlator, Extent};
///
/// // One channel: an impulse at bin 10, and one at bin 87.
/// let impulse = |at| move |_: usize, bin: usize| if bin == at { 1 << 20 } else { 0 };
/// let mut correlator = Box::new(Correlator::new());
/// correlator.set_query(1, impulse(10));
/// let mut out = [0; 360];
/// let exponent = correlator.correlate(Extent::of(1, impulse(87)), impulse(87), &mut out);
/// let peak = f64::from(out[77]) * 2f64.powi(exponent);
/// assert!((peak / 2f64.powi(40) - 1.0).abs() < 2f64.powi(-12));
/// assert!(out.iter().all(|value| *value <= out[77]));
/// ```
#[derive(Debug, Clone)]
pub struct Correlator {
    query: [Signal; PAIRS],
    other: Signal,
    sum: Signal,
    channels: usize,
    scale: Scale,
}

/// Magnitude and norm of the values of one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Upper bound of the magnitude of the values, at most 2^29.
    pub largest: u32,
    /// Upper bound of the norm of the values.
    pub norm: u64,
}

impl Extent {
    /// The extent of `value(channel, bin)` over `channels` channels.
    pub fn of(channels: usize, value: impl Fn(usize, usize) -> i32) -> Self {
        let magnitudes = || {
            let bins = |channel: usize| (0..BINS).map(move |bin| (channel, bin));
            (0..channels.min(MAX_CHANNELS)).flat_map(bins).map(|(c, j)| value(c, j).unsigned_abs())
        };
        let largest = magnitudes().max().unwrap_or(0);
        // 21 bits per value: the sum of 2160 squares is below 2^54.
        let down = (u32::BITS - largest.leading_zeros()).saturating_sub(20);
        let energy: u64 = magnitudes().map(|v| u64::from((v >> down) + u32::from(down > 0)).pow(2)).sum();
        Self { largest, norm: (energy.isqrt() + 1) << down }
    }
}

/// The block scaling of one side.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// Left shift of the values.
    shift: u32,
    /// Left shift of the spectra.
    headroom: u32,
}

impl Correlator {
    /// A correlator without a query: all correlations are 0.
    #[must_use]
    pub const fn new() -> Self {
        let empty = [Complex::ZERO; CORRELATION_POINTS];
        Self {
            query: [empty; PAIRS],
            other: empty,
            sum: empty,
            channels: 0,
            scale: Scale { shift: 0, headroom: 0 },
        }
    }

    /// Sets a query of up to six channels.
    ///
    /// # Formats
    /// `value(channel, bin)` within +-2^29.
    ///
    /// # Cost
    /// One transform of 1024 points per two channels.
    pub fn set_query(&mut self, channels: usize, value: impl Fn(usize, usize) -> i32) {
        self.channels = channels.min(MAX_CHANNELS);
        let extent = Extent::of(self.channels, &value);
        // The periodic extension holds every sample at most twice: the norm grows by a factor below 3/2.
        let norm = extent.norm + extent.norm / 2 + 1;
        self.scale = Scale::new(Extent { norm, ..extent }, 31);
        for (pair, signal) in self.query.iter_mut().enumerate().take(self.channels.div_ceil(2)) {
            let (first, rest) = signal.split_at_mut(BINS);
            load(first, pair, self.channels, self.scale.shift, &value);
            let gap = CORRELATION_POINTS - (BINS - 1) - BINS;
            let (gap, last) = rest.split_at_mut(gap);
            gap.fill(Complex::ZERO);
            // Index 1024 - m holds bin 360 - m, for m in 1..=359.
            last.copy_from_slice(first.get(1..).unwrap_or_default());
            let _ = forward(signal);
            for point in signal {
                point.re <<= self.scale.headroom;
                point.im <<= self.scale.headroom;
            }
        }
    }

    /// Correlates the query with the same number of channels of another side, whose values are within `extent`.
    ///
    /// Returns the binary exponent of the results: `c[s] = out[s] * 2^exponent` is the sum over channels and bins of
    /// `query[bin] * value[bin + s]`.
    pub fn correlate(
        &mut self,
        extent: Extent,
        value: impl Fn(usize, usize) -> i32,
        out: &mut [i32; BINS],
    ) -> i32 {
        let scale = Scale::new(extent, 30);
        if self.channels == 0 {
            self.sum.fill(Complex::ZERO);
        }
        for (pair, query) in self.query.iter().enumerate().take(self.channels.div_ceil(2)) {
            let (first, rest) = self.other.split_at_mut(BINS);
            load(first, pair, self.channels, scale.shift, &value);
            // The padded transform does not read the second half.
            if let Some(gap) = rest.get_mut(..CORRELATION_POINTS / 2 - BINS) {
                gap.fill(Complex::ZERO);
            }
            forward_padded(&mut self.other);
            if pair == 0 {
                accumulate::<true>(&mut self.sum, query, &self.other, scale.headroom);
            } else {
                accumulate::<false>(&mut self.sum, query, &self.other, scale.headroom);
            }
        }
        let _ = inverse(&mut self.sum);
        let backwards = self.sum.iter().take(1).chain(self.sum.iter().rev());
        for (result, point) in out.iter_mut().zip(backwards) {
            *result = point.re;
        }
        // Both forward transforms divide by 1024 and the high word by 2^32; the 1/1024 of the inverse is part of `c`.
        20 + 32 - self.scale.bits() - scale.bits()
    }
}

impl Default for Correlator {
    fn default() -> Self {
        Self::new()
    }
}

impl Scale {
    /// Scales the spectrum to `width` bits: 31 for one side and 30 for the other bound the high words of the products by
    /// 2^29.
    fn new(extent: Extent, width: u32) -> Self {
        // No value exceeds the norm.
        let norm = extent.norm;
        let largest = u64::from(extent.largest).min(norm).max(1);
        let bits = u64::BITS - largest.leading_zeros();
        let shift = FULL_SCALE_BITS.saturating_sub(bits);
        // The norm of the spectrum is that of the samples / 32, and bounds every part.
        let spectrum = ((norm << shift) >> 5) + 64;
        let headroom = spectrum.leading_zeros().saturating_sub(u64::BITS - width);
        Self { shift, headroom }
    }

    const fn bits(self) -> i32 {
        (self.shift + self.headroom).cast_signed()
    }
}

/// Writes the channels 2 `pair` and 2 `pair` + 1 as real and imaginary parts.
fn load(
    signal: &mut [Complex],
    pair: usize,
    channels: usize,
    shift: u32,
    value: &impl Fn(usize, usize) -> i32,
) {
    let odd = 2 * pair + 1 < channels;
    for (bin, point) in signal.iter_mut().enumerate() {
        let im = if odd { value(2 * pair + 1, bin) << shift } else { 0 };
        *point = Complex { re: value(2 * pair, bin) << shift, im };
    }
}

/// sum += conj(other) * query * 2^headroom / 2^32; with `FIRST` the former sum is 0.
fn accumulate<const FIRST: bool>(sum: &mut Signal, query: &Signal, other: &Signal, headroom: u32) {
    let high = |a: i32, b: i32| ((i64::from(a) * i64::from(b)) >> 32) as i32;
    for (sum, (q, o)) in sum.iter_mut().zip(query.iter().zip(other)) {
        let (re, im) = (o.re << headroom, o.im << headroom);
        let before = if FIRST { Complex::ZERO } else { *sum };
        sum.re = before.re.wrapping_add(high(re, q.re)).wrapping_add(high(im, q.im));
        sum.im = before.im.wrapping_add(high(re, q.im)).wrapping_sub(high(im, q.re));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec;

    type Channels = Vec<Vec<i32>>;

    fn direct(query: &Channels, other: &Channels, s: usize) -> i128 {
        query
            .iter()
            .zip(other)
            .flat_map(|(q, o)| (0..BINS).map(move |i| i128::from(q[i]) * i128::from(o[(i + s) % BINS])))
            .sum()
    }

    fn norm(channels: &Channels) -> f64 {
        channels.iter().flatten().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt()
    }

    /// The worst error over all shifts, relative to the product of the norms.
    fn worst_error(query: &Channels, other: &Channels) -> f64 {
        let mut correlator = Box::new(Correlator::new());
        correlator.set_query(query.len(), |c, j| query[c][j]);
        let mut out = [0; BINS];
        let exponent =
            correlator.correlate(Extent::of(other.len(), |c, j| other[c][j]), |c, j| other[c][j], &mut out);
        let scale = (norm(query) * norm(other)).max(1e-300);
        (0..BINS)
            .map(|s| (f64::from(out[s]) * 2f64.powi(exponent) - direct(query, other, s) as f64).abs() / scale)
            .fold(0.0, f64::max)
    }

    fn channels() -> impl Strategy<Value = (Channels, Channels)> {
        (1usize..=6, 0u32..29).prop_flat_map(|(count, bits)| {
            let side = move |bits: u32| {
                let value = -(1i32 << bits)..=(1 << bits);
                proptest::collection::vec(proptest::collection::vec(value, BINS), count)
            };
            (side(bits), side(28 - bits.min(28)))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn agrees_with_the_direct_sum((query, other) in channels()) {
            let worst = worst_error(&query, &other);
            prop_assert!(worst <= 2f64.powi(-12), "{worst}");
        }
    }

    #[test]
    fn degenerate_input() {
        let constant = |v: i32| std::vec![std::vec![v; BINS]; 5];
        let mut spike = constant(0);
        spike[3][17] = 1 << 29;
        let mut small = constant(0);
        small[3][300] = 1;
        for (a, b) in [
            (constant(1), constant(1 << 29)),
            (constant(0), constant(5)),
            (spike.clone(), small.clone()),
            (small, spike.clone()),
            (spike, constant(-7)),
        ] {
            assert!(worst_error(&a, &b) <= 2f64.powi(-12));
        }
    }

    #[test]
    fn a_shift_moves_the_peak() {
        let query: Channels = std::vec![(0..360).map(|j| (j * j * 37) % 1001).collect()];
        let other: Channels = std::vec![(0..360).map(|j| query[0][(j + 360 - 77) % 360]).collect()];
        let mut correlator = Box::new(Correlator::new());
        correlator.set_query(1, |c, j| query[c][j]);
        let mut out = [0; BINS];
        correlator.correlate(Extent::of(other.len(), |c, j| other[c][j]), |c, j| other[c][j], &mut out);
        assert_eq!(out.iter().enumerate().max_by_key(|&(_, v)| *v).map(|(s, _)| s), Some(77));
    }
}
