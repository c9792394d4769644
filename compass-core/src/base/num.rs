//! The fixed-point vocabulary: every scale is a type.
//!
//! | type | format | range | quantum |
//! |---|---|---|---|
//! | [`ChannelValue`] | I2F14 | [-2, 2), 1.0 exact | 6.1e-5 |
//! | [`Metres`] | I32F32 | +-2.1e9 m | 2.3e-10 m |
//! | [`Unit`] | I2F30 | [-2, 2), +-1 exact | 9.3e-10 |
//! | [`Score`] | I2F30 | [-2, 2), +-1 exact | 9.3e-10 |
//! | [`Turn`] | whole turn = 2^32 | wraps | 8.4e-8 degrees |
//! | [`Nats`] | I28F4 | +-1.3e8 nat | 1/16 nat |
//! | [`BinNats`] | I12F4 | [-2048, 2048) nat | 1/16 nat |
//! | [`CellNats`] | I4F4 | [-8, 8) nat | 1/16 nat |
//! | [`LogOdds`] | I8F8 | [-128, 128) nat | 1/256 nat |
//! | [`LogWeight`] | I24F8 | +-8.4e6 nat | 1/256 nat |
//! | [`CastNats`] | I20F12 | +-5.2e5 nat | 1/4096 nat |
//!
//! Log-likelihood ratios have several types because range and quantum follow from what is summed: a table cell is a byte,
//! a pose sums 360 cells, a cast ray interpolates between cells.
//!
//! Ranges are whole march steps of 0.02 m ([`crate::base::scan`]): they are exact.

use core::ops::{Add, Neg, Sub};
use fixed::types::{I2F14, I2F30, I4F4, I8F8, I12F4, I20F12, I24F8, I28F4, I32F32};

/// Bins of a scan or a descriptor channel: one per degree, counter-clockwise from the heading.
pub const BINS: usize = 360;

/// A descriptor value. Channel values lie in [0, 1.5], mean-free ones in [-1.5, 1.5].
pub type ChannelValue = I2F14;

/// A length or coordinate in metres.
pub type Metres = I32F32;

/// A component of a unit vector.
pub type Unit = I2F30;

/// A cosine similarity in [-1, 1].
pub type Score = I2F30;

/// A log-likelihood ratio summed over directions: the score of a pose, or the margin between two.
pub type Nats = I28F4;

/// A log-likelihood ratio of one direction.
pub type BinNats = I12F4;

/// A log-likelihood ratio of one cell: one direction, range rung and hit type.
pub type CellNats = I4F4;

/// Log odds of a window, of a box or of a direction.
pub type LogOdds = I8F8;

/// A sum of [`LogOdds`], or the logarithm of a probability.
pub type LogWeight = I24F8;

/// A log-likelihood ratio summed over cast rays, from cells interpolated between rungs.
pub type CastNats = I20F12;

/// Truncates towards zero; saturates beyond the range of `i32`, and NaN becomes 0.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "a cast from a float truncates and saturates, as documented"
)]
pub(crate) const fn truncate_to_i32(value: f32) -> i32 {
    value as i32
}

/// Truncates towards zero; negative values and NaN become 0, values beyond the range of `usize` saturate.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast from a float truncates and saturates, as documented"
)]
pub(crate) const fn truncate_to_index(value: f32) -> usize {
    value as usize
}

/// Truncates towards zero; negative values and NaN become 0, values above 65535 saturate.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast from a float truncates and saturates, as documented"
)]
pub(crate) const fn truncate_to_u16(value: f32) -> u16 {
    value as u16
}

/// Truncates towards zero; negative values and NaN become 0, values above 255 saturate.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast from a float truncates and saturates, as documented"
)]
pub(crate) const fn truncate_to_u8(value: f32) -> u8 {
    value as u8
}

/// Rounds to the nearest, ties away from zero; saturates beyond the range of `i8`, and NaN becomes 0.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "a cast from a float saturates, as documented")]
pub(crate) fn round_to_i8(value: f32) -> i8 {
    libm::roundf(value) as i8
}

/// Rounds to the nearest, ties away from zero; saturates beyond the range of `i16`, and NaN becomes 0.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "a cast from a float saturates, as documented")]
pub(crate) fn round_to_i16(value: f32) -> i16 {
    libm::roundf(value) as i16
}

/// The index of a coordinate. A negative one gives an index beyond the end of every slice.
#[inline(always)]
#[expect(
    clippy::cast_sign_loss,
    reason = "sign extension puts negative coordinates beyond the end of every slice"
)]
pub(crate) const fn index_of(coordinate: i32) -> usize {
    coordinate as usize
}

/// A count or an index as `i32`: exact below 2^31, which debug builds assert.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "sides of rasters, rows of tables and lengths of lists are below 2^31"
)]
pub(crate) const fn count_as_i32(count: usize) -> i32 {
    debug_assert!(count <= i32::MAX as usize, "count exceeds i32");
    count as i32
}

/// An unsigned integer as `u16`, saturated.
#[inline(always)]
pub(crate) fn saturate_to_u16(value: impl TryInto<u16>) -> u16 {
    value.try_into().unwrap_or(u16::MAX)
}

/// An unsigned integer as `u32`, saturated.
#[inline(always)]
pub(crate) fn saturate_to_u32(value: impl TryInto<u32>) -> u32 {
    value.try_into().unwrap_or(u32::MAX)
}

/// Narrows a sum of log odds, saturating.
#[expect(clippy::cast_possible_truncation, reason = "clamped to the range of `i16`")]
#[inline(always)]
pub(crate) fn log_odds(sum: LogWeight) -> LogOdds {
    LogOdds::from_bits(sum.to_bits().clamp(i16::MIN.into(), i16::MAX.into()) as i16)
}

/// Conversion to `f32`, rounded to the nearest: one conversion and one product. `to_num` of `fixed` takes dozens of
/// instructions.
pub(crate) trait ToFloat {
    /// The value as `f32`.
    fn to_float(self) -> f32;
}

impl ToFloat for CellNats {
    fn to_float(self) -> f32 {
        f32::from(self.to_bits()) / f32::from(Self::ONE.to_bits())
    }
}

impl ToFloat for LogOdds {
    fn to_float(self) -> f32 {
        f32::from(self.to_bits()) / f32::from(Self::ONE.to_bits())
    }
}

impl ToFloat for LogWeight {
    fn to_float(self) -> f32 {
        self.to_bits() as f32 / Self::ONE.to_bits() as f32
    }
}

/// A point of the map in metres: x right, y up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Point {
    /// Metres to the right of the map's origin.
    pub x: Metres,
    /// Metres above the map's origin.
    pub y: Metres,
}

impl Point {
    /// Makes a point of its coordinates in metres.
    #[must_use]
    pub const fn new(x: Metres, y: Metres) -> Self {
        Self { x, y }
    }

    /// Whether the distance to the other point is at most `distance`, compared by squares.
    ///
    /// # Formats
    /// Differences saturate at the range of [`Metres`]; squares are exact in Q64 of 128 bits.
    ///
    /// # Accuracy
    /// Exact (test `within_is_a_closed_disc`).
    ///
    /// ```
    /// use compass_core::{Metres, Point};
    ///
    /// let at = |x: i32, y: i32| Point::new(Metres::from_num(x), Metres::from_num(y));
    /// assert!(at(3, 4).within(at(0, 0), Metres::from_num(5)));
    /// assert!(!at(3, 4).within(at(0, 0), Metres::from_num(4.999)));
    /// ```
    #[must_use]
    pub fn within(self, other: Self, distance: Metres) -> bool {
        let square = |d: Metres| i128::from(d.to_bits()) * i128::from(d.to_bits());
        let dx = self.x.saturating_sub(other.x);
        let dy = self.y.saturating_sub(other.y);
        // Each square is below 2^126, so the sum cannot overflow.
        square(dx) + square(dy) <= square(distance)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Point {
    fn format(&self, f: defmt::Formatter<'_>) {
        // Whole metres are below 2^31 and their rest below 2^32: neither product overflows.
        let millimetres = |v: Metres| {
            let (whole, rest) = (v.to_bits() >> 32, v.to_bits() & 0xffff_ffff);
            whole * 1000 + ((rest * 1000) >> 32)
        };
        defmt::write!(f, "({} mm, {} mm)", millimetres(self.x), millimetres(self.y));
    }
}

/// A binary angle: 2^32 is the whole turn, so that addition wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Turn(u32);

impl Turn {
    /// The angle 0.
    pub const ZERO: Self = Self(0);

    /// Makes an angle of raw bits: 2^32 is the whole turn.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The raw bits: 2^32 is the whole turn.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0
    }

    /// `numerator / denominator` of a turn, of either sign, rounded to the nearest. A denominator of 0 gives 0.
    ///
    /// ```
    /// use compass_core::Turn;
    ///
    /// assert_eq!(Turn::from_ratio(-1, 4).to_bits(), 3 << 30);
    /// // Millionths of a degree.
    /// assert_eq!(Turn::from_ratio(1_500_000, 360_000_000).to_microdegrees(), 1_500_000);
    /// ```
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "the quotient is taken modulo a whole turn")]
    pub const fn from_ratio(numerator: i64, denominator: u32) -> Self {
        if denominator == 0 {
            return Self::ZERO;
        }
        let reduced = numerator.rem_euclid(denominator as i64).cast_unsigned();
        let denominator = denominator as u64;
        Self((((reduced << 32) + denominator / 2) / denominator) as u32)
    }

    /// Whole degrees of either sign, rounded to the nearest 2^-32 of a turn.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "`BINS` is 360")]
    pub const fn from_degrees(degrees: i64) -> Self {
        Self::from_ratio(degrees, BINS as u32)
    }

    /// The angle of a bin, taken modulo 360, from bin 0.
    #[must_use]
    #[expect(clippy::cast_possible_wrap, reason = "the remainder is below 360")]
    pub const fn from_bin(bin: usize) -> Self {
        Self::from_degrees((bin % BINS) as i64)
    }

    /// The bin nearest to this angle from bin 0, below 360.
    ///
    /// ```
    /// use compass_core::Turn;
    ///
    /// assert_eq!(Turn::from_ratio(3597, 3600).to_bin(), 0);
    /// assert_eq!(Turn::from_bin(359).to_bin(), 359);
    /// ```
    #[must_use]
    pub const fn to_bin(self) -> usize {
        ((self.0 as u64 * BINS as u64 + (1 << 31)) >> 32) as usize % BINS
    }

    /// The angle as whole degrees in `0..360` and the remainder in 2^-32 degree.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "degrees are below 360, and the remainder is the lower 32 bits"
    )]
    const fn split_degrees(self) -> (usize, u32) {
        let scaled = self.0 as u64 * BINS as u64;
        let degrees = scaled >> 32;
        (degrees as usize, scaled as u32)
    }

    /// The angle in millionths of a degree, `0..360_000_000`, rounded to the nearest.
    #[must_use]
    pub const fn to_microdegrees(self) -> u32 {
        let scaled = (self.0 as u64 * 360_000_000 + (1 << 31)) >> 32;
        (scaled % 360_000_000) as u32
    }

    /// The smaller angle between two directions, at most half a turn.
    ///
    /// ```
    /// use compass_core::Turn;
    ///
    /// assert_eq!(Turn::from_degrees(350).distance(Turn::from_degrees(15)), Turn::from_degrees(25));
    /// ```
    #[must_use]
    pub const fn distance(self, other: Self) -> Self {
        let forward = self.0.wrapping_sub(other.0);
        let backward = other.0.wrapping_sub(self.0);
        Self(if forward < backward { forward } else { backward })
    }

    /// Cosine and sine: a table of whole degrees, rotated by a Taylor series of the rest.
    ///
    /// # Formats
    /// Q32 of a turn to I2F30. Multiples of a quarter turn are exact.
    ///
    /// # Accuracy
    /// Each within 2^-29 of the exact value (test `cos_sin_is_within_2_pow_minus_29`).
    ///
    /// # Cost
    /// One table look-up, a polynomial of degree 5 and one complex product: about 300 instructions on a Cortex-M7 (720
    /// calls are `cos_sin` of `targets/budget.txt`).
    ///
    /// ```
    /// use compass_core::Turn;
    ///
    /// let (cos, sin) = Turn::from_degrees(150).cos_sin();
    /// assert_eq!(sin.to_num::<f32>(), 0.5);
    /// assert!((cos.to_num::<f32>() + 0.866_025_4).abs() < 1e-7);
    /// ```
    #[must_use]
    pub fn cos_sin(self) -> (Unit, Unit) {
        let (degrees, rest) = self.split_degrees();
        rotate(degree_cos_sin(degrees), small_cos_sin(rest))
    }

    /// Precomputes what the directions a whole number of degrees from this one share: cosine and sine of each then take
    /// one table look-up and one complex product.
    pub(crate) fn fan(self) -> Fan {
        let (degrees, rest) = self.split_degrees();
        Fan { degrees, rest: small_cos_sin(rest) }
    }
}

impl Add for Turn {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl Sub for Turn {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl Neg for Turn {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

/// Directions at whole degrees from a heading.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fan {
    degrees: usize,
    rest: (Unit, Unit),
}

impl Fan {
    /// Cosine and sine of heading + `degrees`, each within 2^-29 of the exact value.
    pub(crate) fn cos_sin(&self, degrees: usize) -> (Unit, Unit) {
        rotate(degree_cos_sin((self.degrees + degrees) % BINS), self.rest)
    }
}

/// Cosine of 1 degree, Q62.
const COS_1: i128 = 4_610_983_636_309_578_612;
/// Sine of 1 degree, Q62.
const SIN_1: i128 = 80_485_018_754_732_517;

/// Sine of 0 to 90 degrees, Q30, by the recursion e^(i(n+1)d) = e^(ind) e^(id) in Q62 (error below 2^-54).
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "n is at most 90, and sines are at most 2^30"
)]
const SINE: [i32; 91] = {
    let mut table = [0; 91];
    let (mut cos, mut sin) = (1_i128 << 62, 0_i128);
    let mut n = 0;
    while n <= 90 {
        table[n] = ((sin + (1 << 31)) >> 32) as i32;
        let next = (cos * COS_1 - sin * SIN_1) >> 62;
        sin = (sin * COS_1 + cos * SIN_1) >> 62;
        cos = next;
        n += 1;
    }
    table
};

/// Cosine of whole degrees in Q30, at compile time.
pub(crate) const fn degree_cosine(degrees: usize) -> i32 {
    degree_sine(degrees + 90)
}

/// Sine of whole degrees in Q30, at compile time.
#[expect(clippy::indexing_slicing, reason = "remainders of 90 index 91 entries")]
pub(crate) const fn degree_sine(degrees: usize) -> i32 {
    let degrees = degrees % BINS;
    let within = degrees % 90;
    match degrees / 90 {
        0 => SINE[within],
        1 => SINE[90 - within],
        2 => -SINE[within],
        _ => -SINE[90 - within],
    }
}

/// Cosine and sine of whole degrees below 360; multiples of 90 are exact.
fn degree_cos_sin(degrees: usize) -> (Unit, Unit) {
    let sine = |d: usize| SINE.get(d).copied().unwrap_or(0);
    let within = degrees % 90;
    let (s, c) = (sine(within), sine(90 - within));
    let (c, s) = match degrees / 90 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    };
    (Unit::from_bits(c), Unit::from_bits(s))
}

/// Cosine and sine of an angle below one degree, given in 2^-32 degree.
///
/// Taylor series to x^5; the first omitted term is below 2^-43.
#[expect(clippy::cast_possible_truncation, reason = "cosine and sine are at most 2^30 in Q30")]
fn small_cos_sin(rest: u32) -> (Unit, Unit) {
    if rest == 0 {
        return (Unit::ONE, Unit::ZERO);
    }
    // Q32 degrees times pi / 180 in Q36 gives Q36: x < 2^-5.8, so that x * x stays below 2^61.
    const RADIANS: u64 = 1_199_381_129;
    let x = (u64::from(rest) * RADIANS) >> 32;
    let x2 = (x * x) >> 36;
    let x3 = (x2 * x) >> 36;
    let x4 = (x3 * x) >> 36;
    let x5 = (x4 * x) >> 36;
    let sin = x - x3 / 6 + x5 / 120;
    let cos = (1 << 36) - x2 / 2 + x4 / 24;
    // Q36 to Q30, rounded to the nearest.
    let narrow = |v: u64| Unit::from_bits(((v + (1 << 5)) >> 6) as i32);
    (narrow(cos), narrow(sin))
}

/// The product of two unit complex numbers, rounded to the nearest.
#[expect(
    clippy::cast_possible_truncation,
    reason = "components of a unit complex number are at most 2^30 in Q30"
)]
fn rotate((c, s): (Unit, Unit), (rc, rs): (Unit, Unit)) -> (Unit, Unit) {
    let product = |a: Unit, b: Unit| i64::from(a.to_bits()) * i64::from(b.to_bits());
    let narrow = |v: i64| Unit::from_bits(((v + (1 << 29)) >> 30) as i32);
    (narrow(product(c, rc) - product(s, rs)), narrow(product(s, rc) + product(c, rs)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn radians(turn: Turn) -> f64 {
        f64::from(turn.to_bits()) / 4_294_967_296.0 * core::f64::consts::TAU
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (quarter, expected) in [(1, 0), (0, 1), (-1, 0), (0, -1)].into_iter().enumerate() {
            let (c, s) = Turn::from_ratio(quarter as i64, 4).cos_sin();
            assert_eq!((c, s), (Unit::from_num(expected.0), Unit::from_num(expected.1)));
        }
    }

    #[test]
    fn turn_round_trips_degrees() {
        for degrees in -720_i64..720 {
            let turn = Turn::from_degrees(degrees);
            assert_eq!(turn.to_bin(), degrees.rem_euclid(360) as usize);
            assert_eq!(i64::from(turn.to_microdegrees()), degrees.rem_euclid(360) * 1_000_000);
        }
        assert_eq!(Turn::from_ratio(5, 0), Turn::ZERO);
        assert_eq!(
            Turn::from_ratio(350, 360).distance(Turn::from_ratio(15, 360)).to_microdegrees(),
            25_000_000
        );
    }

    #[test]
    fn within_is_a_closed_disc() {
        let at = |x: f64, y: f64| Point::new(Metres::from_num(x), Metres::from_num(y));
        assert!(at(3.0, 4.0).within(at(0.0, 0.0), Metres::from_num(5)));
        assert!(!at(3.0, 4.0).within(at(0.0, 0.0), Metres::from_num(4.999)));
        assert!(!at(1e9, -1e9).within(at(-1e9, 1e9), Metres::from_num(5)), "far apart saturates");
    }

    proptest! {
        #[test]
        fn cos_sin_is_within_2_pow_minus_29(bits: u32) {
            let turn = Turn::from_bits(bits);
            let (c, s) = turn.cos_sin();
            let bound = 2f64.powi(-29);
            prop_assert!((c.to_num::<f64>() - radians(turn).cos()).abs() <= bound);
            prop_assert!((s.to_num::<f64>() - radians(turn).sin()).abs() <= bound);
        }

        #[test]
        fn fan_equals_the_sum_of_angles(bits: u32, degrees in 0usize..360) {
            let turn = Turn::from_bits(bits);
            let (c, s) = turn.fan().cos_sin(degrees);
            let angle = radians(turn) + (degrees as f64).to_radians();
            let bound = 2f64.powi(-29);
            prop_assert!((c.to_num::<f64>() - angle.cos()).abs() <= bound);
            prop_assert!((s.to_num::<f64>() - angle.sin()).abs() <= bound);
        }
    }
}
