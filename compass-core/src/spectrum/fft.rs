//! Radix-2 fast Fourier transform in fixed point.
//!
//! Decimation in frequency forwards (natural order in, bit-reversed order out), decimation in time
//! backwards (bit-reversed in, natural out): a product of spectra needs no reordering at all.
//!
//! # Formats
//! | | input | every stage | output |
//! |---|---|---|---|
//! | [`forward`] | modulus up to 2^30 - 32 | halves | DFT / N, bit-reversed |
//! | [`inverse`] | modulus up to 2^30 - 32, bit-reversed | halves | (1/N) sum X e^(+i), natural |
//!
//! The halving makes overflow impossible: (|a| + |b|) / 2 is at most the larger modulus, so the
//! modulus grows by rounding alone (at most 2 LSB a stage), and the difference of two parts fits the
//! word. Nothing is lost to it that the word could have kept: the sum of N values of full scale needs
//! the log2 N bits. Input beyond the range wraps: wrong numbers, no panic.
//!
//! # Accuracy
//! Against `rustfft` in f64 on full-scale noise: at least 120 dB of signal to noise, no part off by
//! more than 12 LSB (tested).

/// No part of a transform is off by more LSB than this.
pub const FFT_WORST_LSB: i32 = 12;
/// Signal to noise of a transform of full-scale noise, in dB, at least.
pub const FFT_SNR_DB: i32 = 120;

/// Largest number of points of a transform.
pub const MAX_POINTS: usize = 1024;

/// A complex number of two 32-bit fixed-point parts; the caller knows their scale.
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

/// cos and sin of 2 pi k / 1024 in Q31, k in 0..512; 1.0 is stored as 2^31 - 1.
static TWIDDLES: [Complex; MAX_POINTS / 2] = {
    // cos and sin of 2 pi / 1024 in Q62; the recursion's error stays below 2^-52.
    const COS_1: i128 = 4_611_599_204_741_358_747;
    const SIN_1: i128 = 28_296_773_447_188_932;
    const fn q31(v: i128) -> i32 {
        let rounded = (v + (1 << 30)) >> 31;
        if rounded > i32::MAX as i128 { i32::MAX } else { rounded as i32 }
    }
    let mut table = [Complex::ZERO; MAX_POINTS / 2];
    let (mut cos, mut sin) = (1_i128 << 62, 0_i128);
    let mut k = 0;
    while k < MAX_POINTS / 2 {
        table[k] = Complex { re: q31(cos), im: q31(sin) };
        let next = (cos * COS_1 - sin * SIN_1) >> 62;
        sin = (sin * COS_1 + cos * SIN_1) >> 62;
        cos = next;
        k += 1;
    }
    table
};

/// The high word of the product: a * b / 2 for b in Q31.
const fn half_product(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// Transforms `data` in place: `data[bitrev(k)] = (1/N) sum_n data[n] exp(-2 pi i n k / N)`.
///
/// N is the length of the slice: a power of two from 2 to [`MAX_POINTS`]. Any other length leaves the
/// data as they are and returns `false`.
#[must_use]
pub fn forward(data: &mut [Complex]) -> bool {
    let n = data.len();
    if !is_supported(n) {
        return false;
    }
    let mut half = n / 2;
    while half >= 1 {
        for block in data.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            let twiddles = TWIDDLES.iter().step_by(MAX_POINTS / 2 / half);
            for ((a, b), w) in low.iter_mut().zip(high).zip(twiddles) {
                let sum = Complex { re: (a.re >> 1) + (b.re >> 1), im: (a.im >> 1) + (b.im >> 1) };
                let (re, im) = (a.re.wrapping_sub(b.re), a.im.wrapping_sub(b.im));
                // (re + i im) (cos - i sin) / 2
                b.re = half_product(re, w.re).wrapping_add(half_product(im, w.im));
                b.im = half_product(im, w.re).wrapping_sub(half_product(re, w.im));
                *a = sum;
            }
        }
        half /= 2;
    }
    true
}

/// Transforms `data` in place: `out[n] = (1/N) sum_k data[bitrev(k)] exp(+2 pi i n k / N)`.
///
/// The same lengths as [`forward`].
#[must_use]
pub fn inverse(data: &mut [Complex]) -> bool {
    let n = data.len();
    if !is_supported(n) {
        return false;
    }
    let mut half = 1;
    while half < n {
        for block in data.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            let twiddles = TWIDDLES.iter().step_by(MAX_POINTS / 2 / half);
            for ((a, b), w) in low.iter_mut().zip(high).zip(twiddles) {
                // b (cos + i sin) / 2
                let re = half_product(b.re, w.re).wrapping_sub(half_product(b.im, w.im));
                let im = half_product(b.im, w.re).wrapping_add(half_product(b.re, w.im));
                let (a_re, a_im) = (a.re >> 1, a.im >> 1);
                *b = Complex { re: a_re.wrapping_sub(re), im: a_im.wrapping_sub(im) };
                *a = Complex { re: a_re.wrapping_add(re), im: a_im.wrapping_add(im) };
            }
        }
        half *= 2;
    }
    true
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

    /// Signal to noise in dB and worst part in LSB.
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
    fn refuses_other_lengths() {
        for n in [0, 1, 3, 360, 2048] {
            let mut data = std::vec![Complex::ZERO; n];
            assert!(!forward(&mut data) && !inverse(&mut data), "{n}");
        }
    }
}
