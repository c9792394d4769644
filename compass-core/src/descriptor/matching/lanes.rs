//! A 64-point inverse FFT of 32 signals in parallel, in 16-bit lanes.
//!
//! The inner loops run over all lanes, and each factor is repeated in a lane array, so that compilers generate 16-bit
//! vector instructions. Cores without them run plain loops, with the same bits.
#![expect(
    clippy::indexing_slicing,
    reason = "lanes and points are below the lengths of their arrays; the linker test of panics shows that no check remains"
)]

use crate::base::num::{degree_cosine, degree_sine};

/// Number of signals in parallel.
pub(super) const LANES: usize = 32;
/// Number of points of the transform.
pub(super) const POINTS: usize = 64;

/// One value of every signal.
pub(super) type Lane = [i16; LANES];

/// Error bound of a part of [`inverse`], LSB: two exact stages, then four that double the error and add at most 3.9 LSB:
/// 3.9 x (8 + 4 + 2 + 1).
pub(super) const TRANSFORM_ERROR: i32 = 59;

/// cos and sin of 2 pi k / 64 in Q15, by k in 0..32, in all lanes.
static TWIDDLES: [[Lane; 2]; POINTS / 2] = {
    let mut twiddles = [[[0; LANES]; 2]; POINTS / 2];
    let mut k = 0;
    while k < POINTS / 2 {
        let [cos, sin] = turn(k);
        twiddles[k] = [[cos; LANES], [sin; LANES]];
        k += 1;
    }
    twiddles
};

/// cos and sin of 2 pi k / 64 in Q15, by k in 0..64.
pub(super) static TURNS: [[i16; 2]; POINTS] = {
    let mut turns = [[0; 2]; POINTS];
    let mut k = 0;
    while k < POINTS {
        turns[k] = turn(k);
        k += 1;
    }
    turns
};

/// cos and sin of 2 pi k / 64 in Q15, 1.0 as 2^15 - 1.
#[expect(clippy::cast_possible_wrap, reason = "eighths of a degree below 8")]
const fn turn(k: usize) -> [i16; 2] {
    // Multiples of 5.625 degrees, from the table of whole degrees by angle addition: exact to 2^-28.
    let eighths = k * 45;
    let (whole, rest) = (eighths / 8, eighths % 8);
    let (cos, sin) = (degree_cosine(whole) as i64, degree_sine(whole) as i64);
    // cos and sin of rest / 8 degrees in Q30, by their series.
    let angle = rest as i64 * 18_740_330 / 8;
    let square = (angle * angle) >> 30;
    let small_cos = (1 << 30) - square / 2 + ((square * square) >> 30) / 24;
    let small_sin = angle - ((square * angle) >> 30) / 6;
    let turned_cos = (cos * small_cos - sin * small_sin) >> 30;
    let turned_sin = (sin * small_cos + cos * small_sin) >> 30;
    [q15(turned_cos), q15(turned_sin)]
}

#[expect(clippy::cast_possible_truncation, reason = "at most 2^15 in magnitude, saturated")]
const fn q15(q30: i64) -> i16 {
    let rounded = (q30 + (1 << 14)) >> 15;
    if rounded > i16::MAX as i64 { i16::MAX } else { rounded as i16 }
}

/// Transforms in place, from bit-reversed to natural order, without scaling:
/// `out[m] = sum_k in[bitrev(k)] exp(+2 pi i k m / 64)`.
///
/// The sum of moduli of each signal must stay below 2^15.
pub(super) fn inverse(re: &mut [Lane; POINTS], im: &mut [Lane; POINTS]) {
    first_stages(re, im);
    let mut half = 4;
    while half < POINTS {
        let blocks = re.chunks_exact_mut(2 * half).zip(im.chunks_exact_mut(2 * half));
        for (re, im) in blocks {
            let ((a_re, b_re), (a_im, b_im)) = (re.split_at_mut(half), im.split_at_mut(half));
            let twiddles = TWIDDLES.iter().step_by(POINTS / 2 / half);
            let (low, high) = (a_re.iter_mut().zip(a_im), b_re.iter_mut().zip(b_im));
            for ((a, b), w) in low.zip(high).zip(twiddles) {
                butterfly(a, b, w);
            }
        }
        half *= 2;
    }
}

/// The stages of half length 1 and 2: factors 1 and i, so that no product is needed.
fn first_stages(re: &mut [Lane; POINTS], im: &mut [Lane; POINTS]) {
    let (re, im) = (re.as_chunks_mut::<4>().0, im.as_chunks_mut::<4>().0);
    for ([r0, r1, r2, r3], [i0, i1, i2, i3]) in re.iter_mut().zip(im) {
        for lane in 0..LANES {
            let (a, b) = (r0[lane].wrapping_add(r1[lane]), r0[lane].wrapping_sub(r1[lane]));
            let (c, d) = (r2[lane].wrapping_add(r3[lane]), r2[lane].wrapping_sub(r3[lane]));
            let (e, f) = (i0[lane].wrapping_add(i1[lane]), i0[lane].wrapping_sub(i1[lane]));
            let (g, h) = (i2[lane].wrapping_add(i3[lane]), i2[lane].wrapping_sub(i3[lane]));
            (r0[lane], r2[lane]) = (a.wrapping_add(c), a.wrapping_sub(c));
            (i0[lane], i2[lane]) = (e.wrapping_add(g), e.wrapping_sub(g));
            // (d + i h) i = -h + i d
            (r1[lane], r3[lane]) = (b.wrapping_sub(h), b.wrapping_add(h));
            (i1[lane], i3[lane]) = (f.wrapping_add(d), f.wrapping_sub(d));
        }
    }
}

#[inline(never)]
#[expect(clippy::needless_pass_by_value, reason = "pairs of exclusive borrows")]
fn butterfly(a: (&mut Lane, &mut Lane), b: (&mut Lane, &mut Lane), [cos, sin]: &[Lane; 2]) {
    // a w / 2, rounded down.
    let half = |value: i16, w: i16| ((i32::from(value) * i32::from(w)) >> 16) as i16;
    for lane in 0..LANES {
        let (re, im) = (b.0[lane], b.1[lane]);
        let turned_re = half(re, cos[lane]).wrapping_sub(half(im, sin[lane])) << 1;
        let turned_im = half(im, cos[lane]).wrapping_add(half(re, sin[lane])) << 1;
        b.0[lane] = a.0[lane].wrapping_sub(turned_re);
        b.1[lane] = a.1[lane].wrapping_sub(turned_im);
        a.0[lane] = a.0[lane].wrapping_add(turned_re);
        a.1[lane] = a.1[lane].wrapping_add(turned_im);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::boxed::Box;

    #[test]
    fn turns_are_rounded_cosines() {
        for k in 0..POINTS {
            let angle = core::f64::consts::TAU * k as f64 / POINTS as f64;
            let [cos, sin] = turn(k).map(|v| f64::from(v) / 32768.0);
            assert!((cos - angle.cos()).abs() < 3.1e-5 && (sin - angle.sin()).abs() < 3.1e-5, "{k}");
        }
    }

    #[test]
    fn agrees_with_the_direct_sum_within_its_error() {
        let mut seed = 1_u32;
        let mut noise = |scale: i32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((seed >> 16) as i32 % (2 * scale + 1) - scale) as i16
        };
        for round in 0..20 {
            // The moduli of 64 points add up to less than 2^15.
            let scale = if round == 0 { 0 } else { 355 };
            let mut re: Box<[Lane; POINTS]> = Box::new([[0; LANES]; POINTS]);
            let mut im = re.clone();
            for k in 0..POINTS {
                for lane in 0..LANES {
                    (re[k][lane], im[k][lane]) = (noise(scale), noise(scale));
                }
            }
            let (before_re, before_im) = (re.clone(), im.clone());
            inverse(&mut re, &mut im);
            for m in 0..POINTS {
                for lane in 0..LANES {
                    let mut sum = (0.0, 0.0);
                    for k in 0..POINTS {
                        let from = k.reverse_bits() >> (usize::BITS - 6);
                        let (s, c) = (core::f64::consts::TAU * (k * m % 64) as f64 / 64.0).sin_cos();
                        let (a, b) = (f64::from(before_re[from][lane]), f64::from(before_im[from][lane]));
                        sum = (sum.0 + a * c - b * s, sum.1 + a * s + b * c);
                    }
                    let worst =
                        (sum.0 - f64::from(re[m][lane])).abs().max((sum.1 - f64::from(im[m][lane])).abs());
                    assert!(worst <= f64::from(TRANSFORM_ERROR), "{worst}");
                }
            }
        }
    }
}
