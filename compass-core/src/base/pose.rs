//! Poses that count as apart.

use super::num::{Metres, Point, Turn};

/// Largest number of alternatives of an answer, the best included.
pub const MAX_ALTERNATIVES: usize = 10;

/// How far two poses are apart at least to count as two: by distance, or by the angle between their headings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Separation {
    /// Distance of the positions.
    pub distance: Metres,
    /// Angle between the headings.
    pub turn: Turn,
}

impl Separation {
    /// Alternatives of an answer: 1 m or 20 degrees.
    pub const ALTERNATIVES: Self = Self { distance: Metres::ONE, turn: Turn::from_ratio(20, 360) };

    /// Whether two poses count as one: both nearer than the distance and turned by less than the angle.
    #[must_use]
    pub fn is_near(&self, a: (Point, Turn), b: (Point, Turn)) -> bool {
        a.1.distance(b.1) < self.turn && a.0.within(b.0, self.distance)
    }
}

/// Where camera 0 is, and where it looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// Number of the floor, in the order of the site.
    pub floor: u8,
    /// Position on the map.
    pub at: Point,
    /// Direction of the optical axis, projected on the floor: counter-clockwise from +x.
    pub heading: Turn,
}
