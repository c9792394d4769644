//! Poses, and the separation that makes two poses distinct.

use super::num::{Metres, Nats, Point, Turn};
use core::cmp::Reverse;

/// Largest number of alternatives of an answer, the best included.
pub const MAX_ALTERNATIVES: usize = 10;

/// Position and heading of camera 0 on a floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// Number of the floor, in the order of the site; all layers of one floor share its coordinates.
    pub floor: u8,
    /// Position in the floor's map coordinates.
    pub at: Point,
    /// Direction of bin 0, the optical axis projected on the floor: counter-clockwise from +x.
    pub heading: Turn,
}

impl Pose {
    /// Position and heading.
    #[must_use]
    pub const fn place(&self) -> (Point, Turn) {
        (self.at, self.heading)
    }
}

/// A pose on a layer of a floor, with the score of the evidence at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScoredPose {
    /// Index of the [`FloorLayer`](crate::pose::FloorLayer).
    pub layer: u8,
    /// Position.
    pub at: Point,
    /// Direction of bin 0.
    pub heading: Turn,
    /// Log-likelihood ratio against "nothing known", summed over 360 bins.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub score: Nats,
}

impl ScoredPose {
    /// A placeholder; its score is below all others.
    pub const NONE: Self =
        Self { layer: 0, at: Point::new(Metres::ZERO, Metres::ZERO), heading: Turn::ZERO, score: Nats::MIN };

    /// Position and heading.
    #[must_use]
    pub const fn place(&self) -> (Point, Turn) {
        (self.at, self.heading)
    }

    /// Sort key: descending score, then layer, y, x and heading.
    pub(crate) fn order(&self) -> impl Ord + use<> {
        (Reverse(self.score), self.layer, self.at.y, self.at.x, self.heading)
    }
}

/// Smallest distance, or smallest angle between headings, at which two poses are distinct.
///
/// Distances are compared exactly, by squares, and headings by the smaller angle between them.
///
/// ```
/// use compass_core::base::pose::Separation;
/// use compass_core::{Metres, Point, Turn};
///
/// let at = |x, degrees| (Point::new(Metres::from_num(x), Metres::ZERO), Turn::from_degrees(degrees));
/// // 0.75 m or 15 degrees.
/// assert!(Separation::FOUND.is_near(at(0.0, 355), at(0.75, 9)));
/// assert!(!Separation::FOUND.is_near(at(0.0, 355), at(0.0, 10)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Separation {
    /// Largest distance of positions that coincide (inclusive).
    pub distance: Metres,
    /// Smallest angle between headings that differ.
    pub turn: Turn,
}

impl Separation {
    /// Alternatives of an answer: 1 m or 20 degrees.
    pub const ALTERNATIVES: Self = Self { distance: Metres::ONE, turn: Turn::from_degrees(20) };
    /// Poses found by a search, before they are refined: 0.75 m or 15 degrees.
    pub const FOUND: Self = Self { distance: Metres::lit("0.75"), turn: Turn::from_degrees(15) };
    /// Hypotheses of a track: 0.5 m or 15 degrees.
    pub const HYPOTHESES: Self = Self { distance: Metres::lit("0.5"), turn: Turn::from_degrees(15) };

    /// Whether two poses in one floor's coordinates coincide: their distance is at most [`distance`](Self::distance) and
    /// the angle between their headings below [`turn`](Self::turn).
    #[must_use]
    pub fn is_near(&self, a: (Point, Turn), b: (Point, Turn)) -> bool {
        self.is_turn_near(a.1, b.1) && self.is_place_near(a.0, b.0)
    }

    /// Whether the angle between two headings is below [`turn`](Self::turn).
    #[must_use]
    pub fn is_turn_near(&self, a: Turn, b: Turn) -> bool {
        a.distance(b) < self.turn
    }

    /// Whether two positions are at most [`distance`](Self::distance) apart.
    #[must_use]
    pub fn is_place_near(&self, a: Point, b: Point) -> bool {
        a.within(b, self.distance)
    }

    /// Whether two poses coincide: same floor, and [near](Self::is_near).
    #[must_use]
    pub fn joins(&self, a: &Pose, b: &Pose) -> bool {
        a.floor == b.floor && self.is_near(a.place(), b.place())
    }

    /// Whether two scored poses coincide: same layer, and [near](Self::is_near).
    #[must_use]
    pub fn joins_on_layer(&self, a: &ScoredPose, b: &ScoredPose) -> bool {
        a.layer == b.layer && self.is_near(a.place(), b.place())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_differ_by_floor_distance_or_heading() {
        let pose = |floor: u8, x: &str, degrees: i64| Pose {
            floor,
            at: Point::new(x.parse().unwrap(), Metres::ZERO),
            heading: Turn::from_degrees(degrees),
        };
        let here = pose(0, "0", 355);
        let joins = |other: Pose| Separation::FOUND.joins(&here, &other);
        assert!(joins(pose(0, "0.75", 9)) && joins(pose(0, "-0.75", 341)));
        assert!(!joins(pose(0, "0.76", 355)) && !joins(pose(0, "0", 10)) && !joins(pose(1, "0", 355)));
    }
}
