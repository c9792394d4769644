//! Radix-2 fast Fourier transform in fixed point, two stages per pass.
//!
//! The forward transform decimates in frequency (natural order in, bit-reversed order out), the inverse in time
//! (bit-reversed in, natural out): products of spectra need no reordering.
//!
//! # Formats
//! | | input | every stage | output |
//! |---|---|---|---|
//! | [`forward`] | modulus up to 2^30 - 32 | halves | DFT / N, bit-reversed |
//! | [`inverse`] | modulus up to 2^30 - 32, bit-reversed | halves | (1/N) sum X e^(+i), natural |
//!
//! Halving at each stage excludes overflow: (|a| + |b|) / 2 is at most the larger modulus, so that the modulus grows by
//! rounding alone (at most 2 LSB per stage), and the difference of two parts fits the word. The sum of N values of full
//! scale needs the log2 N bits that are shifted out. Input beyond the range wraps, without a panic.
//!
//! # Accuracy
//! Against `rustfft` in f64 on full-scale noise: signal-to-noise ratio at least [`FFT_SNR_DB`], error of a part at most
//! [`FFT_WORST_LSB`] (test `forward_agrees_with_rustfft`).
#![expect(
    clippy::indexing_slicing,
    reason = "indices are constants or below the length of an array; the linker test of panics shows that no check remains"
)]

/// Largest error of a part of a transform, LSB.
pub const FFT_WORST_LSB: i32 = 12;
/// Smallest signal-to-noise ratio of a transform of full-scale noise, dB.
pub const FFT_SNR_DB: i32 = 120;

/// Largest number of points of a transform.
pub const MAX_POINTS: usize = 1024;

/// A complex number of two 32-bit fixed-point parts, whose scale is up to the caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Complex {
    /// Real part.
    pub re: i32,
    /// Imaginary part.
    pub im: i32,
}

impl Complex {
    /// Zero.
    pub const ZERO: Self = Self { re: 0, im: 0 };
}

/// exp(2 pi i k / 1024) for k, 2 k and 3 k, in Q31 with 1.0 as 2^31 - 1; by k in 0..256.
static TWIDDLES: [[Complex; 3]; MAX_POINTS / 4] = {
    // cos and sin of 2 pi / 1024 in Q62; the recursion's error stays below 2^-51.
    const COS_1: i128 = 4_611_599_204_741_358_747;
    const SIN_1: i128 = 28_296_773_447_188_932;
    #[expect(clippy::cast_possible_truncation, reason = "at most 2^31 - 1 in magnitude, or saturated")]
    const fn q31(v: i128) -> i32 {
        let rounded = (v + (1 << 30)) >> 31;
        if rounded > i32::MAX as i128 { i32::MAX } else { rounded as i32 }
    }
    let mut turns = [Complex::ZERO; MAX_POINTS];
    let (mut cos, mut sin) = (1_i128 << 62, 0_i128);
    let mut k = 0;
    while k < MAX_POINTS {
        turns[k] = Complex { re: q31(cos), im: q31(sin) };
        let next = (cos * COS_1 - sin * SIN_1) >> 62;
        sin = (sin * COS_1 + cos * SIN_1) >> 62;
        cos = next;
        k += 1;
    }
    let mut table = [[Complex::ZERO; 3]; MAX_POINTS / 4];
    let mut k = 0;
    while k < MAX_POINTS / 4 {
        table[k] = [turns[k], turns[2 * k], turns[3 * k]];
        k += 1;
    }
    table
};

/// The twiddle factors of k, 2 k and 3 k of 1024; k is taken modulo 256.
#[inline(always)]
fn twiddles(k: usize) -> &'static [Complex; 3] {
    &TWIDDLES[k % (MAX_POINTS / 4)]
}

/// exp(2 pi i k / 1024), k below 512.
fn twiddle(k: usize) -> Complex {
    let [turn, ..] = *twiddles(k);
    if k < MAX_POINTS / 4 { turn } else { turn.quarter_turn() }
}

/// The high word of the product: a * b / 2 for b in Q31.
#[inline(always)]
const fn half_product(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

impl Complex {
    /// (a + b) / 2.
    #[inline(always)]
    const fn half_sum(self, b: Self) -> Self {
        self.sum(b).halved()
    }

    /// (a - b) / 2.
    #[inline(always)]
    const fn half_difference(self, b: Self) -> Self {
        self.difference(b).halved()
    }

    /// a / 2.
    #[inline(always)]
    const fn halved(self) -> Self {
        Self { re: self.re >> 1, im: self.im >> 1 }
    }

    /// a / 2 + b / 2, for operands of the full word.
    #[inline(always)]
    const fn halves(self, b: Self) -> Self {
        self.halved().sum(b.halved())
    }

    /// a / 2 - b / 2.
    #[inline(always)]
    const fn halves_apart(self, b: Self) -> Self {
        self.halved().difference(b.halved())
    }

    /// a / 4 + b / 4.
    #[inline(always)]
    const fn quarters(self, b: Self) -> Self {
        Self { re: (self.re >> 2).wrapping_add(b.re >> 2), im: (self.im >> 2).wrapping_add(b.im >> 2) }
    }

    /// a / 4 - b / 4.
    #[inline(always)]
    const fn quarters_apart(self, b: Self) -> Self {
        Self { re: (self.re >> 2).wrapping_sub(b.re >> 2), im: (self.im >> 2).wrapping_sub(b.im >> 2) }
    }

    /// a + b.
    #[inline(always)]
    const fn sum(self, b: Self) -> Self {
        Self { re: self.re.wrapping_add(b.re), im: self.im.wrapping_add(b.im) }
    }

    /// a - b.
    #[inline(always)]
    const fn difference(self, b: Self) -> Self {
        Self { re: self.re.wrapping_sub(b.re), im: self.im.wrapping_sub(b.im) }
    }

    /// i a.
    #[inline(always)]
    const fn quarter_turn(self) -> Self {
        Self { re: self.im.wrapping_neg(), im: self.re }
    }

    /// a w / 2.
    #[inline(always)]
    const fn turn_half(self, w: Self) -> Self {
        Self {
            re: half_product(self.re, w.re).wrapping_sub(half_product(self.im, w.im)),
            im: half_product(self.re, w.im).wrapping_add(half_product(self.im, w.re)),
        }
    }

    /// a conj(w) / 2.
    #[inline(always)]
    const fn turn_back_half(self, w: Self) -> Self {
        Self {
            re: half_product(self.re, w.re).wrapping_add(half_product(self.im, w.im)),
            im: half_product(self.im, w.re).wrapping_sub(half_product(self.re, w.im)),
        }
    }
}

/// Forward transform in place: `data[bitrev(k)] = (1/N) sum_n data[n] exp(-2 pi i n k / N)`.
///
/// N is the length of the slice: a power of two from 2 to [`MAX_POINTS`]. For any other length the data are not changed and
/// `false` is returned.
///
/// # Formats
/// Input in natural order, modulus up to 2^30 - 32. Output in bit-reversed order, scaled by 1/N.
///
/// # Accuracy
/// [`FFT_SNR_DB`] and [`FFT_WORST_LSB`].
///
/// # Cost
/// N/2 log2 N butterflies, in log2 N / 2 passes. Cortex-M7, 1024 points: `fft` in `targets/budget.txt`.
///
/// # References
/// J. W. Cooley, J. W. Tukey, "An algorithm for the machine calculation of complex Fourier series", Math. Comp. 19, 1965;
/// W. M. Gentleman, G. Sande, "Fast Fourier transforms: for fun and profit", AFIPS 1966 (decimation in frequency).
///
/// ```
/// use compass_core::descriptor::spectrum::{Complex, forward};
///
/// // 8 equal points have harmonic 0 alone.
/// let mut data = [Complex { re: 1000, im: 0 }; 8];
/// assert!(forward(&mut data));
/// assert_eq!(data[0], Complex { re: 1000, im: 0 });
/// assert_eq!(data[1..], [Complex::ZERO; 7]);
/// ```
#[must_use]
pub fn forward(data: &mut [Complex]) -> bool {
    let n = data.len();
    if !is_supported(n) {
        return false;
    }
    let mut size = n;
    // Two stages per pass; a single stage comes first for odd log2 N.
    if n.ilog2() % 2 == 1 {
        let (low, high) = data.split_at_mut(n / 2);
        for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
            let difference = a.difference(*b);
            *a = a.half_sum(*b);
            *b = difference.turn_back_half(twiddle(k * (MAX_POINTS / n)));
        }
        size /= 2;
    }
    forward_passes(data, size);
    true
}

/// The passes from blocks of `size` points, a power of four, down to blocks of 4.
fn forward_passes(data: &mut [Complex], mut size: usize) {
    while size > 4 {
        match size {
            1024 => forward_pass::<256, 1024>(data),
            256 => forward_pass::<64, 256>(data),
            64 => forward_pass::<16, 64>(data),
            _ => forward_pass::<4, 16>(data),
        }
        size /= 4;
    }
    if size == 4 {
        for [a, b, c, d] in data.as_chunks_mut::<4>().0 {
            let (sum, difference) = (a.sum(*c), a.difference(*c));
            let (other_sum, turned) = (b.sum(*d), b.difference(*d).quarter_turn());
            *a = sum.quarters(other_sum);
            *b = sum.quarters_apart(other_sum);
            *c = difference.quarters_apart(turned);
            *d = difference.quarters(turned);
        }
    }
}

/// Two stages of decimation in frequency over every block of `SIZE` = 4 `QUARTER` points. Constant sizes allow addressing
/// by one pointer.
fn forward_pass<const QUARTER: usize, const SIZE: usize>(data: &mut [Complex]) {
    for block in data.as_chunks_mut::<SIZE>().0 {
        for k in 0..QUARTER {
            let [w1, w2, w3] = *twiddles(k * (MAX_POINTS / SIZE));
            let (a, c) = (block[k], block[k + 2 * QUARTER]);
            let (sum, difference) = (a.sum(c), a.difference(c));
            let (b, d) = (block[k + QUARTER], block[k + 3 * QUARTER]);
            let (other_sum, turned) = (b.sum(d), b.difference(d).quarter_turn());
            block[k] = sum.quarters(other_sum);
            block[k + QUARTER] = sum.halves_apart(other_sum).turn_back_half(w2);
            block[k + 2 * QUARTER] = difference.halves_apart(turned).turn_back_half(w1);
            block[k + 3 * QUARTER] = difference.halves(turned).turn_back_half(w3);
        }
    }
}

/// [`forward`] of 1024 points of which the last 512 are zero: the first pass does not read them. The result has the same
/// bits.
pub(super) fn forward_padded(data: &mut [Complex; MAX_POINTS]) {
    const QUARTER: usize = MAX_POINTS / 4;
    for k in 0..QUARTER {
        let [w1, w2, w3] = *twiddles(k);
        let (a, b) = (data[k], data[k + QUARTER]);
        let turned = b.quarter_turn();
        data[k] = a.quarters(b);
        data[k + QUARTER] = a.halves_apart(b).turn_back_half(w2);
        data[k + 2 * QUARTER] = a.halves_apart(turned).turn_back_half(w1);
        data[k + 3 * QUARTER] = a.halves(turned).turn_back_half(w3);
    }
    forward_passes(data, QUARTER);
}

/// Inverse transform in place: `out[n] = (1/N) sum_k data[bitrev(k)] exp(+2 pi i n k / N)`.
///
/// Lengths as for [`forward`]. Since both directions divide by N, the inverse of the forward transform is the input divided
/// by N.
///
/// # Formats
/// Input in bit-reversed order, modulus up to 2^30 - 32. Output in natural order, scaled by 1/N.
///
/// # Accuracy
/// Forward and inverse together are within 24 LSB (test `inverse_undoes_forward_up_to_the_scale`).
///
/// # Cost
/// That of [`forward`].
///
/// # References
/// Those of [`forward`].
///
/// ```
/// use compass_core::descriptor::spectrum::{Complex, inverse};
///
/// // Harmonic 0 alone gives 8 equal points.
/// let mut data = [Complex::ZERO; 8];
/// data[0].re = 8000;
/// assert!(inverse(&mut data));
/// assert_eq!(data, [Complex { re: 1000, im: 0 }; 8]);
/// ```
#[must_use]
pub fn inverse(data: &mut [Complex]) -> bool {
    let n = data.len();
    if !is_supported(n) {
        return false;
    }
    let mut size = 4;
    if n >= 4 {
        for [a, b, c, d] in data.as_chunks_mut::<4>().0 {
            let (sum, difference) = (a.half_sum(*b), a.half_difference(*b));
            let (other_sum, turned) = (c.half_sum(*d), c.half_difference(*d).quarter_turn());
            *a = sum.half_sum(other_sum);
            *c = sum.half_difference(other_sum);
            *b = difference.half_sum(turned);
            *d = difference.half_difference(turned);
        }
        while size * 4 <= n {
            size *= 4;
            match size {
                16 => inverse_pass::<4, 16>(data),
                64 => inverse_pass::<16, 64>(data),
                256 => inverse_pass::<64, 256>(data),
                _ => inverse_pass::<256, 1024>(data),
            }
        }
    } else {
        size = 1;
    }
    if size < n {
        let (low, high) = data.split_at_mut(n / 2);
        for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
            let turned = b.turn_half(twiddle(k * (MAX_POINTS / n)));
            let halved = a.halved();
            *a = halved.sum(turned);
            *b = halved.difference(turned);
        }
    }
    true
}

/// Two stages of decimation in time over every block of `SIZE` = 4 `QUARTER` points.
fn inverse_pass<const QUARTER: usize, const SIZE: usize>(data: &mut [Complex]) {
    for block in data.as_chunks_mut::<SIZE>().0 {
        for k in 0..QUARTER {
            let [w1, w2, w3] = *twiddles(k * (MAX_POINTS / SIZE));
            let (a, b) = (block[k].halved(), block[k + QUARTER].turn_half(w2));
            let (sum, difference) = (a.sum(b), a.difference(b));
            let (c, d) = (block[k + 2 * QUARTER].turn_half(w1), block[k + 3 * QUARTER].turn_half(w3));
            let (other_sum, turned) = (c.sum(d), c.difference(d).quarter_turn());
            block[k] = sum.half_sum(other_sum);
            block[k + 2 * QUARTER] = sum.half_difference(other_sum);
            block[k + QUARTER] = difference.half_sum(turned);
            block[k + 3 * QUARTER] = difference.half_difference(turned);
        }
    }
}

const fn is_supported(n: usize) -> bool {
    n.is_power_of_two() && n >= 2 && n <= MAX_POINTS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rustfft::FftPlanner;
    use rustfft::num_complex::Complex64;
    use std::vec::Vec;

    fn oracle(data: &[Complex]) -> Vec<Complex64> {
        let mut out: Vec<_> = data.iter().map(|c| Complex64::new(c.re.into(), c.im.into())).collect();
        FftPlanner::new().plan_fft_forward(out.len()).process(&mut out);
        let n = out.len() as f64;
        out.iter().map(|c| c / n).collect()
    }

    fn reversed(k: usize, n: usize) -> usize {
        k.reverse_bits() >> (usize::BITS - n.trailing_zeros())
    }

    /// Signal-to-noise ratio in dB and largest error of a part in LSB.
    fn errors(data: &[Complex]) -> (f64, f64) {
        let expected = oracle(data);
        let mut got = data.to_vec();
        assert!(forward(&mut got));
        let (mut signal, mut noise, mut worst) = (0.0, 0.0, 0f64);
        for (k, e) in expected.iter().enumerate() {
            let g = got[reversed(k, got.len())];
            let d = Complex64::new(g.re.into(), g.im.into()) - e;
            signal += e.norm_sqr();
            noise += d.norm_sqr();
            worst = worst.max(d.re.abs()).max(d.im.abs());
        }
        (10.0 * (signal / noise.max(1e-30)).log10(), worst)
    }

    fn signals() -> impl Strategy<Value = Vec<Complex>> {
        (1u32..=10).prop_flat_map(|log| {
            let part = -(1i32 << 29)..=(1 << 29);
            let point = (part.clone(), part).prop_map(|(re, im)| Complex { re, im });
            proptest::collection::vec(point, 1 << log)
        })
    }

    proptest! {
        #[test]
        fn forward_agrees_with_rustfft(data in signals()) {
            let (snr, worst) = errors(&data);
            prop_assert!(snr >= f64::from(FFT_SNR_DB) && worst <= f64::from(FFT_WORST_LSB), "SNR {snr} dB, worst {worst} LSB, N {}", data.len());
        }

        #[test]
        fn inverse_undoes_forward_up_to_the_scale(data in signals()) {
            // forward and inverse each divide by N once, so the signal comes back divided by N.
            let n = data.len() as i32;
            let mut work = data.clone();
            prop_assert!(forward(&mut work) && inverse(&mut work));
            for (before, after) in data.iter().zip(&work) {
                let worst = (before.re / n - after.re).abs().max((before.im / n - after.im).abs());
                // The rounding of both directions adds up, at worst in the same sense.
                prop_assert!(worst <= 24, "{worst}");
            }
        }
    }

    #[test]
    fn degenerate_signals() {
        let full = Complex { re: (1 << 30) - 32, im: 0 };
        let mut constant = [full; 1024];
        assert!(forward(&mut constant));
        assert!((constant[0].re - full.re).abs() <= 12);
        assert!(constant[1..].iter().all(|c| c.re.abs() <= 12 && c.im.abs() <= 12));
        let mut zero = [Complex::ZERO; 1024];
        assert!(forward(&mut zero));
        assert!(zero.iter().all(|&c| c == Complex::ZERO));
        let mut corner = [Complex { re: 1 << 29, im: 1 << 29 }; 1024];
        corner[1].re = -(1 << 29);
        assert!(forward(&mut corner) && inverse(&mut corner), "no overflow");
    }

    #[test]
    fn other_lengths_are_rejected() {
        for n in [0, 1, 3, 360, 2048] {
            let mut data = std::vec![Complex::ZERO; n];
            assert!(!forward(&mut data) && !inverse(&mut data), "{n}");
        }
    }
}
