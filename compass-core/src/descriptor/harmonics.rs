//! Low harmonics of 360 bins, for sketches and for the bounds of the exhaustive search.
//!
//! `R_k = sum_j v_j exp(-2 pi i j k / 360)` for k in 1..=32, with cosines and sines in Q14.

use crate::base::num::{BINS, degree_cosine, degree_sine};

/// Number of harmonics in the bounds of the exhaustive search.
pub(crate) const HARMONICS: usize = 32;

/// Real and imaginary part.
pub(crate) type Pair<T> = [T; 2];

/// cos and -sin of 2 pi j k / 360 in Q14, for k in 1..=32.
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time")]
static BASIS: [Pair<[i16; BINS]>; HARMONICS] = {
    let mut basis = [[[0; BINS]; 2]; HARMONICS];
    let mut k = 0;
    while k < HARMONICS {
        let mut j = 0;
        while j < BINS {
            let degrees = j * (k + 1);
            // Q30 to Q14, rounded to the nearest.
            basis[k][0][j] = ((degree_cosine(degrees) + (1 << 15)) >> 16) as i16;
            basis[k][1][j] = ((-degree_sine(degrees) + (1 << 15)) >> 16) as i16;
            j += 1;
        }
        k += 1;
    }
    basis
};

/// The first `N` harmonics of a channel, N at most 32, in units of 2^-14 of those of the values.
///
/// # Formats
/// Values within +-1820, so that 72 products with Q14 fit 32 bits.
pub(crate) fn harmonics<const N: usize>(values: &[i16; BINS]) -> [Pair<i64>; N] {
    let mut out = [[0; 2]; N];
    for (pair, basis) in out.iter_mut().zip(&BASIS) {
        for (part, basis) in pair.iter_mut().zip(basis) {
            *part = dot::<72>(values, basis);
        }
    }
    out
}

/// The dot product. The sum of `BLOCK` products must fit 32 bits.
pub(crate) fn dot<const BLOCK: usize>(a: &[i16], b: &[i16; BINS]) -> i64 {
    let blocks = a.as_chunks::<BLOCK>().0.iter().zip(b.as_chunks::<BLOCK>().0);
    blocks
        .map(|(a, b)| {
            let sum: i32 = a.iter().zip(b).map(|(&a, &b)| i32::from(a) * i32::from(b)).sum();
            i64::from(sum)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_has_one_harmonic() {
        let values = core::array::from_fn(|j| ((j as f64 * 3.0).to_radians().cos() * 1500.0) as i16);
        let found = harmonics::<HARMONICS>(&values);
        let scale = 180.0 * 1500.0 * 16384.0;
        for (k, [re, im]) in found.into_iter().enumerate() {
            let expected = if k == 2 { 1.0 } else { 0.0 };
            assert!((re as f64 / scale - expected).abs() < 1e-3, "harmonic {} is {re}", k + 1);
            assert!((im as f64 / scale).abs() < 1e-3);
        }
    }
}
