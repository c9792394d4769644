//! The range ladder: rungs in geometric progression from [`NEAREST_MM`] to the largest range of a scan, and camera heights
//! in steps of the same ratio.
//!
//! # Formats
//! Rung k of [`RANGE_RUNGS`] lies at `0.4 m * 75^(k / 71)`: 0.4 to 30 m. A camera height is an `i8`: its shift in rungs
//! against [`NOMINAL_HEIGHT_M`].

use super::num::round_to_i8;
use super::scan::{MAX_STEPS, STEP_MM};

/// Number of range rungs.
pub const RANGE_RUNGS: usize = 72;
/// Range of rung 0, millimetres.
pub const NEAREST_MM: u32 = 400;
/// Range of rung 0, metres.
pub const NEAREST_M: f32 = NEAREST_MM as f32 / 1000.0;
/// Natural logarithm of the ratio of neighbouring rungs (6.3 %): `ln(30 m / 0.4 m) / (RANGE_RUNGS - 1)`.
pub const RUNG: f32 = 0.060_809_69;
/// Camera height, metres, at which the shift in rungs is 0.
pub const NOMINAL_HEIGHT_M: f32 = 1.5;
/// Natural logarithm of `NEAREST_M / NOMINAL_HEIGHT_M`.
pub(crate) const NEAREST_LOG: f32 = -1.321_756;
/// Smallest and largest camera height, metres, that a prior may give and a search tries.
pub const HEIGHTS_M: [f32; 2] = [0.55, 2.4];

/// Fractional bits of a position between rungs.
pub(crate) const FRACTION_BITS: u32 = 8;
/// March steps of rung 0.
const NEAREST: u32 = NEAREST_MM / STEP_MM;
/// Ratio of the last rung's range to that of rung 0.
const SPAN: u32 = MAX_STEPS as u32 / NEAREST;

/// Ranges of the rungs in millimetres, rounded to the nearest: rung k lies at
/// `nearest span^(k / (RANGE_RUNGS - 1))`.
///
/// # Accuracy
/// Within 0.5001 mm of the exact value (test `rungs_are_a_geometric_progression`).
///
/// ```
/// use compass_core::base::ladder::RUNG_MM;
///
/// assert_eq!((RUNG_MM[0], RUNG_MM[1], RUNG_MM[71]), (400, 425, 30_000));
/// ```
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "rung is below `RANGE_RUNGS`, and ranges are at most 30000 mm"
)]
pub static RUNG_MM: [u16; RANGE_RUNGS] = {
    let mut rungs = [0; RANGE_RUNGS];
    let mut rung = 0;
    while rung < RANGE_RUNGS {
        // Bisection for the smallest range whose upper half millimetre exceeds the rung.
        let (mut below, mut beyond) = (NEAREST_MM - 1, MAX_STEPS as u32 * STEP_MM);
        while beyond - below > 1 {
            let mm = below.midpoint(beyond);
            let half_up = position(2 * mm + 1, 2 * NEAREST_MM, 16);
            *(if half_up > (rung as u64) << 16 { &mut beyond } else { &mut below }) = mm;
        }
        rungs[rung] = beyond as u16;
        rung += 1;
    }
    rungs
};

/// Position among the rungs, Q8, by range in march steps.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "steps are at most `MAX_STEPS`, and positions below 72 in Q8"
)]
static POSITIONS: [u16; MAX_STEPS as usize + 1] = {
    let mut positions = [0; MAX_STEPS as usize + 1];
    let mut steps = NEAREST;
    while steps <= MAX_STEPS as u32 {
        positions[steps as usize] = position(steps, NEAREST, FRACTION_BITS) as u16;
        steps += 1;
    }
    positions
};

/// `(RANGE_RUNGS - 1) log(range / nearest) / log(SPAN)` with `bits` fractional bits, rounded to the nearest.
#[expect(
    clippy::cast_possible_truncation,
    reason = "ranges are at most 60001, so that positions are below 72 with at most 16 fractional bits"
)]
const fn position(range: u32, nearest: u32, bits: u32) -> u64 {
    const WHOLE: u128 = log2(SPAN) as u128;
    let part = (log2(range) - log2(nearest)) as u128 * (RANGE_RUNGS as u128 - 1);
    (((part << bits) + WHOLE / 2) / WHOLE) as u64
}

/// Binary logarithm, Q32, within 2^-23; 0 for 0.
const fn log2(value: u32) -> u64 {
    if value == 0 {
        return 0;
    }
    let exponent = value.ilog2();
    let mut mantissa = (value as u64) << (31 - exponent);
    let mut log = (exponent as u64) << 32;
    let mut bit = 31;
    while bit >= 8 {
        mantissa = (mantissa * mantissa) >> 31;
        if mantissa >> 32 != 0 {
            mantissa >>= 1;
            log |= 1 << bit;
        }
        bit -= 1;
    }
    log
}

/// Position among the rungs, Q8, in `0..RANGE_RUNGS`; ranges above [`MAX_STEPS`] are clamped to it.
#[expect(clippy::indexing_slicing, reason = "clamped to `MAX_STEPS`, the last index")]
pub(crate) const fn position_of(steps: u16) -> u16 {
    POSITIONS[if steps < MAX_STEPS { steps } else { MAX_STEPS } as usize]
}

/// The shift in rungs of a camera height in metres: 0 at [`NOMINAL_HEIGHT_M`]; the height is clamped to [`HEIGHTS_M`],
/// NaN to its lower end.
///
/// # Formats
/// Metres to whole rungs of 6.3 %, rounded to the nearest: -16 to 8.
///
/// ```
/// use compass_core::base::ladder::height_rungs;
///
/// assert_eq!((height_rungs(1.5), height_rungs(1.6), height_rungs(0.0)), (0, 1, -16));
/// ```
#[must_use]
pub fn height_rungs(height_m: f32) -> i8 {
    let bounded = if height_m >= HEIGHTS_M[0] { height_m.min(HEIGHTS_M[1]) } else { HEIGHTS_M[0] };
    round_to_i8(libm::logf(bounded / NOMINAL_HEIGHT_M) / RUNG)
}

/// The camera height, metres, of a shift in rungs: the inverse of [`height_rungs`], which rounds by up to half a rung (3 %).
///
/// ```
/// use compass_core::base::ladder::{height_m, height_rungs};
///
/// assert_eq!(height_m(0), 1.5);
/// assert_eq!(height_rungs(height_m(-5)), -5);
/// ```
#[must_use]
pub fn height_m(rungs: i8) -> f32 {
    NOMINAL_HEIGHT_M * libm::expf(f32::from(rungs) * RUNG)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_are_a_geometric_progression() {
        for (k, &mm) in RUNG_MM.iter().enumerate() {
            let expected = 400.0 * 75f64.powf(k as f64 / 71.0);
            assert!((f64::from(mm) - expected).abs() <= 0.5001, "rung {k}: {mm} mm, not {expected}");
        }
        assert_eq!((RUNG_MM[0], RUNG_MM[71]), (400, 30_000));
    }

    #[test]
    fn stated_logarithms_match_the_ladder() {
        assert_eq!(RUNG, (75f64.ln() / 71.0) as f32);
        let nearest = (0.4f64 / 1.5).ln();
        assert!((f64::from(NEAREST_LOG) - nearest).abs() < 5e-7, "{NEAREST_LOG}, not {nearest}");
    }
}
