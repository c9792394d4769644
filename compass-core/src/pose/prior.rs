//! What is known of a pose before anything is seen.

use crate::base::num::{Metres, Point, Turn};
use crate::base::pose::{Pose, Separation};

/// What is known of a pose before anything is seen: where it is, where it looks, on which floor.
///
/// It restricts the search: poses elsewhere are no candidates and no alternatives. What is said is believed, so be generous: a
/// radius and a width that hold the true pose with its error.
///
/// ```
/// use compass_core::{Metres, Point, PosePrior, Turn};
///
/// let desk = Point::new(Metres::from_num(4), Metres::from_num(2));
/// let prior = PosePrior::UNKNOWN.near(desk, Metres::from_num(3)).heading_near(Turn::from_degrees(350), Turn::from_degrees(30));
/// let door = Point::new(Metres::from_num(6), Metres::from_num(4));
/// assert!(prior.has_place(door) && prior.has_heading(Turn::from_degrees(19)));
/// assert!(!prior.has_place(Point::default()) && !prior.has_heading(Turn::from_degrees(21)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PosePrior {
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    place: Option<(Point, Metres)>,
    heading: Option<(Turn, Turn)>,
    floor: Option<u8>,
}

impl PosePrior {
    /// Nothing is known: all candidates of all floors at all headings.
    pub const UNKNOWN: Self = Self { place: None, heading: None, floor: None };

    /// The position is at most `radius` from a point of the map; none is, if the radius is negative.
    #[must_use]
    pub const fn near(self, at: Point, radius: Metres) -> Self {
        Self { place: Some((at, radius)), ..self }
    }

    /// The heading is at most `width` from a direction, to either side; half a turn or more says nothing.
    #[must_use]
    pub const fn heading_near(self, heading: Turn, width: Turn) -> Self {
        Self { heading: Some((heading, width)), ..self }
    }

    /// The pose is on this floor, by its number in the site.
    #[must_use]
    pub const fn on_floor(self, floor: u8) -> Self {
        Self { floor: Some(floor), ..self }
    }

    /// Whether nothing is known.
    #[must_use]
    pub const fn is_unknown(&self) -> bool {
        self.place.is_none() && self.heading.is_none() && self.floor.is_none()
    }

    /// The point that the position is near, and the radius.
    #[must_use]
    pub const fn place(&self) -> Option<(Point, Metres)> {
        self.place
    }

    /// The heading that the pose is near, and the width to either side.
    #[must_use]
    pub const fn heading(&self) -> Option<(Turn, Turn)> {
        self.heading
    }

    /// Number of the floor.
    #[must_use]
    pub const fn floor(&self) -> Option<u8> {
        self.floor
    }

    /// Whether a position agrees.
    #[must_use]
    pub fn has_place(&self, at: Point) -> bool {
        self.has_place_within(at, Metres::ZERO)
    }

    /// Whether a heading agrees.
    #[must_use]
    pub fn has_heading(&self, heading: Turn) -> bool {
        self.has_heading_within(heading, Turn::ZERO)
    }

    /// Whether a floor agrees.
    #[must_use]
    pub fn has_floor(&self, floor: u8) -> bool {
        self.floor.is_none_or(|known| known == floor)
    }

    /// Whether a pose agrees.
    #[must_use]
    pub fn has(&self, pose: &Pose) -> bool {
        self.has_within(pose, &Separation { distance: Metres::ZERO, turn: Turn::ZERO })
    }

    /// Whether a pose agrees, or is at most this far outside.
    #[inline(never)]
    pub(super) fn has_within(&self, pose: &Pose, beyond: &Separation) -> bool {
        self.has_floor(pose.floor)
            && self.has_place_within(pose.at, beyond.distance)
            && self.has_heading_within(pose.heading, beyond.turn)
    }

    /// Whether a position agrees, or is at most `beyond` outside.
    #[inline(never)]
    pub(super) fn has_place_within(&self, at: Point, beyond: Metres) -> bool {
        let near = |(centre, radius): (Point, Metres)| {
            radius >= Metres::ZERO && at.within(centre, radius.saturating_add(beyond))
        };
        self.place.is_none_or(near)
    }

    /// Whether a heading agrees, or is at most `beyond` outside.
    pub(super) fn has_heading_within(&self, heading: Turn, beyond: Turn) -> bool {
        let near = |(middle, width): (Turn, Turn)| {
            heading.distance(middle).to_bits() <= width.to_bits().saturating_add(beyond.to_bits())
        };
        self.heading.is_none_or(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_inclusive_and_wrap() {
        let at = |x: f64| Point::new(Metres::from_num(x), Metres::ZERO);
        let degrees = Turn::from_degrees;
        let prior =
            PosePrior::UNKNOWN.near(at(1.0), Metres::from_num(2)).heading_near(degrees(5), degrees(10));
        assert!(prior.has_place(at(3.0)) && !prior.has_place(at(3.01)));
        assert!(prior.has_place_within(at(3.5), Metres::from_num(0.5)));
        assert!(prior.has_heading(degrees(356)) && !prior.has_heading(degrees(354)));
        assert!(prior.has_heading_within(degrees(354), degrees(2)));
        assert!(PosePrior::UNKNOWN.heading_near(degrees(5), degrees(180)).has_heading(degrees(185)));
        assert!(
            PosePrior::UNKNOWN.heading_near(degrees(5), Turn::from_bits(u32::MAX)).has_heading(degrees(185))
        );
        assert!(!PosePrior::UNKNOWN.near(at(1.0), Metres::from_num(-1)).has_place(at(1.0)));
        assert!(!PosePrior::UNKNOWN.near(at(1.0), -Metres::MAX).has_place_within(at(1.0), Metres::ONE));
        assert!(PosePrior::UNKNOWN.has_floor(7) && PosePrior::UNKNOWN.on_floor(7).has_floor(7));
        assert!(!PosePrior::UNKNOWN.on_floor(7).has_floor(6) && PosePrior::UNKNOWN.is_unknown());
    }
}
