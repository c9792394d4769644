//! Conversions from metres and degrees to the core's positions and headings.

use compass_core::base::num::{Metres, Point, Turn};

/// A point of the map from metres; `None` when it is not finite or out of range.
#[must_use]
pub fn point(x: f64, y: f64) -> Option<Point> {
    Some(Point::new(metres(x)?, metres(y)?))
}

/// A length from metres; `None` when it is not finite or out of range.
#[must_use]
pub fn metres(value: f64) -> Option<Metres> {
    if value.is_finite() { Metres::checked_from_num(value) } else { None }
}

/// A heading from degrees.
#[must_use]
pub fn turn(degrees: f64) -> Turn {
    let share = degrees.rem_euclid(360.0) / 360.0;
    // 2^32 itself is a full turn, hence 0.
    Turn::from_bits((share * 4_294_967_296.0).round() as u64 as u32)
}

/// An angle in degrees, wrapped to [-180, 180).
#[must_use]
pub fn wrapped(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_become_turns() {
        for degrees in [-720.0, -90.0, 0.0, 12.345, 359.999_999_999_9, 1e6] {
            let back = f64::from(turn(degrees).to_bits()) / 4_294_967_296.0 * 360.0;
            let error = wrapped(back - f64::rem_euclid(degrees, 360.0));
            assert!(error.abs() < 1e-7, "{degrees} became {back}");
        }
        assert!(point(f64::NAN, 0.0).is_none());
        assert!(point(1e12, 0.0).is_none());
    }
}
