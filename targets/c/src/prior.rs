//! What is known before anything is seen.

use crate::failure::Failure;
use compass_core::base::ladder::HEIGHTS_M;
use compass_core::base::num::Metres;
use compass_core::pose::heights::Heights;
use compass_core::{Bearing, HeightPrior, Point, PosePrior, Turn};

/// Least height of the cameras above the floor that can be known, metres.
pub const COMPASS_LEAST_CAMERA_HEIGHT_M: f32 = 0.55;
/// Largest height of the cameras above the floor that can be known, metres.
pub const COMPASS_MOST_CAMERA_HEIGHT_M: f32 = 2.4;

const _: () = assert!(COMPASS_LEAST_CAMERA_HEIGHT_M == HEIGHTS_M[0]);
const _: () = assert!(COMPASS_MOST_CAMERA_HEIGHT_M == HEIGHTS_M[1]);

/// What is known of the upward direction. There is no 0: a prior that says nothing is refused.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassUpKind {
    /// Unknown but for camera 0 being upright or upside down, to about 35 degrees: vertical lines tell the axis, and the
    /// sky in the windows the side.
    Unknown = 1,
    /// Near `up`, to about 35 degrees: the mounting, or an accelerometer. Vertical lines tell the rest.
    Near = 2,
    /// Exactly `up`, to a degree or better: no vertical lines are needed.
    Exact = 3,
}

/// What is known of the heights of camera and ceiling. There is no 0: a prior that says nothing is refused.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassHeightKind {
    /// Unknown: both are searched, which takes 2 to 5 times as long in all.
    Unknown = 1,
    /// The cameras' height above the floor is `camera_height_m`.
    Camera = 2,
    /// Both are `heights`, as from an earlier fix on this floor.
    Both = 3,
}

/// What is known of the pose: `Anywhere`, or a sum of the others. There is no 0: a prior that says nothing is refused.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassPlaceKind {
    /// Unknown: all floors are searched at all headings.
    Anywhere = 1,
    /// The position is at most `near_radius_m` from `near_x`, `near_y`.
    Near = 2,
    /// The heading is at most `heading_width` from `heading`, to either side.
    Heading = 4,
    /// The pose is on `floor`.
    Floor = 8,
}

/// What is known of the pose, as C gives it: any number. The header calls it `CompassPlaceKind`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyPlaceKind(pub(crate) i32);

/// What is known of up, as C gives it: any number. The header calls it `CompassUpKind`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyUpKind(pub(crate) i32);

/// What is known of heights, as C gives it: any number. The header calls it `CompassHeightKind`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyHeightKind(pub(crate) i32);

/// Heights as the search counts them, in steps of 6.3 %: copy them from a fix.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassHeights {
    /// Height of the cameras above the floor, 0 for 1.5 m.
    pub camera: i8,
    /// By how many steps the ceiling is higher above the cameras than the floor is below them.
    pub ceiling: i8,
}

/// What is known before anything is seen.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassPrior {
    /// What `up` says: read by compass_see.
    pub up_kind: AnyUpKind,
    /// Upward direction in the axes of camera 0, of any length: {0, -1, 0} if it is upright, {0, 1, 0} upside down.
    pub up: [f32; 3],
    /// Which of the fields below hold: read by compass_locate.
    pub height_kind: AnyHeightKind,
    /// Height of the cameras above the floor, metres, COMPASS_LEAST_CAMERA_HEIGHT_M to COMPASS_MOST_CAMERA_HEIGHT_M.
    pub camera_height_m: f32,
    /// Heights of camera and ceiling.
    pub heights: CompassHeights,
    /// Which of the fields below hold: read by compass_locate. They restrict the search, so be generous: poses elsewhere are
    /// not found.
    pub place_kind: AnyPlaceKind,
    /// Map coordinate in 1/2^32 m: see compass_coordinate.
    pub near_x: i64,
    /// Map coordinate in 1/2^32 m: see compass_coordinate.
    pub near_y: i64,
    /// Largest distance from there, metres, above 0.
    pub near_radius_m: f32,
    /// Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x.
    pub heading: u32,
    /// Largest angle from it to either side, in 1/2^32 turn, above 0.
    pub heading_width: u32,
    /// Number of the floor, in the order in which the sites have them and were added.
    pub floor: u8,
}

/// What is known of the upward direction.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Up {
    Unknown,
    Near(Bearing),
    Exact(Bearing),
}

impl CompassPrior {
    /// # Errors
    /// [`Failure::Prior`].
    pub(crate) fn up(&self) -> Result<Up, Failure> {
        const UNKNOWN: i32 = CompassUpKind::Unknown as i32;
        const NEAR: i32 = CompassUpKind::Near as i32;
        const EXACT: i32 = CompassUpKind::Exact as i32;
        match self.up_kind.0 {
            UNKNOWN => Ok(Up::Unknown),
            NEAR => self.direction().map(Up::Near),
            EXACT => self.direction().map(Up::Exact),
            _ => Err(Failure::Prior("up_kind does not say what is known of the upward direction")),
        }
    }

    /// The up vector with its largest component at 1, so that any length will do.
    fn direction(&self) -> Result<Bearing, Failure> {
        if !self.up.iter().all(|value| value.is_finite()) {
            return Err(Failure::Prior("the up vector is infinite or not a number"));
        }
        let largest = self.up.iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
        if largest == 0.0 {
            return Err(Failure::Prior("the up vector is zero"));
        }
        let [x, y, z] = self.up.map(|value| value / largest);
        Ok(Bearing::new(x, y, z))
    }

    /// What is known of the pose, on a number of floors.
    ///
    /// # Errors
    /// [`Failure::Prior`].
    pub(crate) fn place(&self, floors: u8) -> Result<PosePrior, Failure> {
        const ANYWHERE: i32 = CompassPlaceKind::Anywhere as i32;
        const NEAR: i32 = CompassPlaceKind::Near as i32;
        const HEADING: i32 = CompassPlaceKind::Heading as i32;
        const FLOOR: i32 = CompassPlaceKind::Floor as i32;
        let kind = self.place_kind.0;
        let mut place = PosePrior::UNKNOWN;
        if kind == ANYWHERE {
            return Ok(place);
        }
        if kind <= 0 || kind & !(NEAR | HEADING | FLOOR) != 0 {
            return Err(Failure::Prior("place_kind does not say what is known of the pose"));
        }
        if kind & NEAR != 0 {
            let radius = Metres::checked_from_num(self.near_radius_m).filter(|radius| *radius > 0);
            let radius = radius.ok_or(Failure::Prior("near_radius_m is not above 0"))?;
            place = place
                .near(Point::new(Metres::from_bits(self.near_x), Metres::from_bits(self.near_y)), radius);
        }
        if kind & HEADING != 0 {
            if self.heading_width == 0 {
                return Err(Failure::Prior("heading_width is 0"));
            }
            place = place.heading_near(Turn::from_bits(self.heading), Turn::from_bits(self.heading_width));
        }
        if kind & FLOOR != 0 {
            if self.floor >= floors {
                return Err(Failure::Prior("there is no floor of this number"));
            }
            place = place.on_floor(self.floor);
        }
        Ok(place)
    }

    /// # Errors
    /// [`Failure::Prior`].
    pub(crate) fn heights(&self) -> Result<HeightPrior, Failure> {
        const UNKNOWN: i32 = CompassHeightKind::Unknown as i32;
        const CAMERA: i32 = CompassHeightKind::Camera as i32;
        const BOTH: i32 = CompassHeightKind::Both as i32;
        // The prior clamps what lies outside; here that is refused.
        let (height, is_kept) = match self.height_kind.0 {
            UNKNOWN => return Ok(HeightPrior::UNKNOWN),
            CAMERA => {
                let height = HeightPrior::camera(self.camera_height_m);
                (height, height.camera_m() == Some(self.camera_height_m))
            }
            BOTH => {
                let heights = Heights::from_rungs([self.heights.camera, self.heights.ceiling]);
                let height = HeightPrior::both(heights);
                (height, height.camera_m() == Some(heights.camera_m()))
            }
            _ => return Err(Failure::Prior("height_kind does not say what is known of the heights")),
        };
        if is_kept { Ok(height) } else { Err(Failure::Prior("the camera height lies outside 0.55 to 2.4 m")) }
    }
}
