//! The cosine as quotient of a numerator and two norms.

use crate::base::num::Score;

/// numerator / sqrt(a b), within 2^-29; 0 if a norm is 0. Saturates if `numerator^2 > a b`, which Cauchy-Schwarz excludes.
#[expect(clippy::cast_possible_truncation, reason = "clamped to +-2^30")]
pub(super) fn cosine(numerator: i64, a: u64, b: u64) -> Score {
    let Some((denominator, shift)) = norms(a, b) else { return Score::ZERO };
    let numerator = i128::from(numerator);
    let bits = if shift >= 0 { numerator << shift } else { numerator >> -shift };
    let one = i128::from(Score::ONE.to_bits());
    Score::from_bits((bits / i128::from(denominator)).clamp(-one, one) as i32)
}

/// `t` and `e` with `numerator 2^e / t` = score bits of `numerator / sqrt(a b)`, t in [2^30, 2^32); `None` if a norm is 0.
fn norms(a: u64, b: u64) -> Option<(u32, i32)> {
    if a == 0 || b == 0 {
        return None;
    }
    // sqrt(v) = root 2^-half, with the root in [2^31, 2^32).
    let root = |v: u64| {
        let half = v.leading_zeros() / 2;
        ((v << (2 * half)).isqrt(), half.cast_signed())
    };
    let ((a, a_half), (b, b_half)) = (root(a), root(b));
    // The product is in [2^62, 2^64). `max` tells the compiler that it is not 0.
    Some(((((a * b) >> 32) as u32).max(1), a_half + b_half - 2))
}

/// The cosine of many numerators over the same norms by one division.
pub(super) struct Normalizer {
    /// 2^62 / t, in (2^30, 2^32].
    reciprocal: i64,
    /// Right shift of numerator times reciprocal.
    down: u32,
}

impl Normalizer {
    /// For `numerator 2^exponent / sqrt(a b)`.
    pub(super) fn new(a: u64, b: u64, exponent: i32) -> Self {
        let Some((denominator, shift)) = norms(a, b) else { return Self { reciprocal: 0, down: 0 } };
        let reciprocal = (1 << 62) / i64::from(denominator);
        let down = 62 - shift - exponent;
        // Negative only for small numerators.
        let up = (-down).clamp(0, 30);
        Self { reciprocal: reciprocal << up, down: down.clamp(0, 63).unsigned_abs() }
    }

    /// The score of a numerator, within 2^-29 of the quotient.
    #[expect(clippy::cast_possible_truncation, reason = "clamped to +-2^30")]
    pub(super) fn cosine(&self, numerator: i32) -> Score {
        let bits = i64::from(numerator).wrapping_mul(self.reciprocal) >> self.down;
        let one = i64::from(Score::ONE.to_bits());
        Score::from_bits(bits.clamp(-one, one) as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn cosine_of_known_numbers() {
        assert_eq!(cosine(5, 0, 7), Score::ZERO);
        assert_eq!(cosine(12, 9, 16).to_bits(), Score::ONE.to_bits());
        assert_eq!(cosine(-6, 9, 16).to_bits(), -Score::ONE.to_bits() / 2);
        assert_eq!(cosine(i64::MAX, 1, 1), Score::ONE, "beyond Cauchy-Schwarz it saturates");
    }

    proptest! {
        #[test]
        fn cosine_is_within_2_pow_minus_29(a in 1u64..1 << 62, b in 1u64..1 << 62, share in -1.0f64..1.0) {
            let product = (a as f64).sqrt() * (b as f64).sqrt();
            let numerator = (product * share) as i64;
            let expected = numerator as f64 / product;
            let got = cosine(numerator, a, b).to_num::<f64>();
            prop_assert!((got - expected).abs() <= 2f64.powi(-29), "{got} {expected}");
        }

        #[test]
        fn normalized_cosine_is_within_2_pow_minus_29(a in 1u64..1 << 62, b in 1u64..1 << 62, n: i32, exponent in 0i32..30) {
            let expected = f64::from(n) * 2f64.powi(exponent) / ((a as f64).sqrt() * (b as f64).sqrt());
            let got = Normalizer::new(a, b, exponent).cosine(n).to_num::<f64>();
            prop_assert!((got - expected.clamp(-1.0, 1.0)).abs() <= 2f64.powi(-29), "{got} {expected}");
        }
    }
}
