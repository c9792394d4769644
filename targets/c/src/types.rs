//! What crosses the boundary, and how it becomes what the core knows.

use compass_board::Error;
use compass_core::base::ladder::height_rungs;
use compass_core::vision::camera::{Camera, Intrinsics, KannalaBrandt, View};
use compass_core::pose::ScoredPose;
use compass_core::pose::locate::{Effort, Fix, HeightPrior};
use compass_core::base::num::Metres;
use compass_core::map::plan::MarchError;
use compass_core::base::scan::Scan;
use compass_core::pose::track::{Estimate, Motion};
use nalgebra::{Matrix3, Vector3};

/// Directions of a scan: direction j looks along heading + j degrees, counter-clockwise.
pub const COMPASS_BINS: usize = 360;
/// Millimetres in a step of a range.
pub const COMPASS_STEP_MM: u32 = 20;
/// Most poses of a fix: the best and its alternatives.
pub const COMPASS_MAX_POSES: usize = 10;
/// Most layers of floors that a Compass holds: of a site file two for each floor, the plan and its structure.
pub const COMPASS_MAX_LAYERS: usize = 16;

const _: () = assert!(COMPASS_BINS == compass_core::base::num::BINS);
const _: () = assert!(COMPASS_STEP_MM == compass_core::base::scan::STEP_MM);
const _: () = assert!(COMPASS_MAX_POSES == compass_core::descriptor::matching::MAX_ALTERNATIVES);

/// What became of a call.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassStatus {
    /// Done.
    Ok = 0,
    /// A pointer is null that must not be, or a number makes no sense.
    Argument = 1,
    /// The memory is too short, or not aligned to 8 bytes.
    Memory = 2,
    /// The bytes are no site file, or no site map with the plan it was made from; or they are damaged.
    Site = 3,
    /// More than COMPASS_MAX_LAYERS layers.
    Full = 4,
    /// The position lies outside the plan.
    Outside = 5,
    /// The position lies inside a wall or glazing.
    Occupied = 6,
    /// The frames are not those of the cameras that were set.
    Camera = 7,
    /// Too few upright lines were seen to tell which way is up.
    Up = 8,
    /// The step before was not done.
    Order = 9,
    /// There is no pose: no layer was added, or nothing fits.
    Nowhere = 10,
}

impl From<Error> for CompassStatus {
    fn from(error: Error) -> Self {
        match error {
            Error::Memory => Self::Memory,
            Error::Up => Self::Up,
            Error::Order => Self::Order,
            // The cameras, and errors to come: frames that do not fit.
            _ => Self::Camera,
        }
    }
}

impl From<MarchError> for CompassStatus {
    fn from(error: MarchError) -> Self {
        match error {
            MarchError::Occupied => Self::Occupied,
            _ => Self::Outside,
        }
    }
}

/// A fisheye camera: lens of Kannala and Brandt ("equidistant" in Kalibr, "fisheye" in OpenCV). Axes are x right, y
/// down, z forward.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassCamera {
    /// Focal lengths, pixels.
    pub fx: f32,
    /// Focal lengths, pixels.
    pub fy: f32,
    /// Principal point, pixels.
    pub cx: f32,
    /// Principal point, pixels.
    pub cy: f32,
    /// Coefficients of the lens.
    pub k: [f32; 4],
    /// Pixels along x.
    pub width: u16,
    /// Pixels along y.
    pub height: u16,
    /// Turns bearings of this camera into bearings of camera 0, row by row: the identity for camera 0.
    pub rotation: [f32; 9],
    /// Where this camera is in the axes of camera 0, metres: zeros for camera 0.
    pub position_m: [f32; 3],
}

impl CompassCamera {
    pub(crate) fn view(&self) -> Option<View> {
        let Self { fx, fy, cx, cy, k, .. } = *self;
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, k).ok()?;
        let [x, y, z] = self.position_m;
        Some(View {
            rotation: Matrix3::from_row_slice(&self.rotation),
            position: Vector3::new(x, y, z),
            ..View::new(Camera::KannalaBrandt(lens), self.width, self.height)
        })
    }
}

/// What a camera saw.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassFrame {
    /// Gray levels, row by row, of the camera's width and height; null if there is no frame of this camera.
    pub gray: *const u8,
    /// One bit a pixel, set where it is red (safety gear in front of a window): rows of (width + 7) / 8 bytes, the first
    /// pixel in the lowest bit; null if that is not known.
    pub red: *const u8,
}

/// Range and hit type all around.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassScan {
    /// Ranges in steps of COMPASS_STEP_MM, 1 to 1500.
    pub steps: [u16; COMPASS_BINS],
    /// What is there: 0 nothing within 30 m, 1 glazing, 2 a wall.
    pub hit: [u8; COMPASS_BINS],
}

impl From<&Scan> for CompassScan {
    fn from(scan: &Scan) -> Self {
        Self { steps: scan.steps, hit: scan.hit.map(|hit| hit as u8) }
    }
}

/// What is known beforehand, and how much work the search may do.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassRoom {
    /// Height of the cameras above the floor, metres; 0 if it is to be found as well, which takes 2 to 5 times as long in all.
    pub camera_height_m: f32,
    /// Places to look at closely, 1 to 48: 8 do if the height is told, 24 if it is not.
    pub places: u8,
    /// Heights of the ceiling to try until an answer is sure: 1 does if the camera's height is told, 3 if it is not.
    pub ceilings: u8,
}

impl CompassRoom {
    pub(crate) fn parts(&self) -> (HeightPrior, Effort) {
        let told = self.camera_height_m > 0.0;
        let room = HeightPrior { height: told.then(|| height_rungs(self.camera_height_m)), ceiling: None };
        let effort = Effort::on_board(&room);
        (room, Effort { modes: self.places.into(), ceilings: self.ceilings.into(), ..effort })
    }
}

/// A pose on a floor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassPose {
    /// Map coordinate in 1/2^32 m: see compass_metres.
    pub x: i64,
    /// Map coordinate in 1/2^32 m: see compass_metres.
    pub y: i64,
    /// Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x: see compass_degrees.
    pub heading: u32,
    /// Log-likelihood ratio against knowing nothing, 1/16 nat.
    pub score: i32,
    /// Number of the layer, in the order in which they were added.
    pub layer: u8,
}

impl CompassPose {
    const NONE: Self = Self { x: 0, y: 0, heading: 0, score: 0, layer: 0 };
}

impl From<&ScoredPose> for CompassPose {
    fn from(mode: &ScoredPose) -> Self {
        let [x, y] = [mode.at.x, mode.at.y].map(Metres::to_bits);
        Self { x, y, heading: mode.heading.to_bits(), score: mode.score.to_bits(), layer: mode.layer }
    }
}

/// Where the cameras are.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassFix {
    /// The best pose and its alternatives, best first.
    pub poses: [CompassPose; COMPASS_MAX_POSES],
    /// How many they are.
    pub count: u32,
    /// How likely the best is within 1 m of the true one, 0 to 1.
    pub probability: f32,
    /// Height of the cameras above the floor, metres, to 3 %: that given, or that found.
    pub height_m: f32,
    /// The same as a step of 6.3 %, 0 for 1.5 m.
    pub height: i8,
    /// How many such steps the ceiling is higher above the cameras than the floor is below them.
    pub ceiling: i8,
}

impl From<&Fix> for CompassFix {
    fn from(fix: &Fix) -> Self {
        let mut poses = [CompassPose::NONE; COMPASS_MAX_POSES];
        poses.iter_mut().zip(fix.answer.modes()).for_each(|(pose, mode)| *pose = mode.into());
        Self {
            poses,
            count: fix.answer.modes().len() as u32,
            probability: fix.probability(),
            height_m: fix.height_m(),
            height: fix.height,
            ceiling: fix.ceiling,
        }
    }
}

/// How the cameras moved since the frames before, in the level axes they had then: forward is where camera 0 looked.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassMotion {
    /// Metres.
    pub forward_m: f32,
    /// Metres.
    pub left_m: f32,
    /// Radians, counter-clockwise.
    pub turn: f32,
}

impl From<&CompassMotion> for Motion {
    fn from(motion: &CompassMotion) -> Self {
        let CompassMotion { forward_m, left_m, turn } = *motion;
        Self { forward_m, left_m, turn }
    }
}

/// What is believed after a sequence of frames.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassEstimate {
    /// The likeliest pose.
    pub pose: CompassPose,
    /// Its probability.
    pub probability: f32,
    /// Root mean square distance of what else is possible on its floor, metres.
    pub spread_m: f32,
}

impl From<&Estimate> for CompassEstimate {
    fn from(estimate: &Estimate) -> Self {
        let Estimate { mode, probability, spread_m } = estimate;
        Self { pose: mode.into(), probability: *probability, spread_m: *spread_m }
    }
}
