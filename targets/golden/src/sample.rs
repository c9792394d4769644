//! The sample frames of every target: two of 368 x 360 pixels.

use crate::Inputs;
use crate::pipeline::SampleLocator;
use compass_core::base::num::{Metres, Point, Turn};
use compass_core::base::raster::{BitMask, GrayImage};
use compass_core::locator::{Frame, Frames, Locator, Prior, Settings, Trace};
use compass_core::pose::heights::HeightPrior;
use compass_core::vision::attitude::UpHint;
use compass_core::vision::camera::{Bearing, Camera, Intrinsics, KannalaBrandt, Rig, View};
use compass_core::vision::sample::ExclusionMask;

/// Size of the frames.
const WIDTH: u16 = 368;
/// Size of the frames.
const HEIGHT: u16 = 360;

/// Words of memory for these frames.
pub const WORDS: usize = Settings::BOARD.memory_words(WIDTH, HEIGHT);

/// The pose of the frames (`compass_host::sample`).
pub const FRAMES_FROM: (Point, Turn) =
    (Point::new(Metres::lit("4.12"), Metres::lit("17.77")), Turn::from_ratio(2886, 3600));

/// The frames of both cameras: gray levels, and a mask that excludes red pixels.
pub(crate) static FRAMES: [(&[u8], &[u8]); 2] = [
    (
        include_bytes!("../../../tests/vectors/frame_368x360_cam0.gray"),
        include_bytes!("../../../tests/vectors/frame_368x360_cam0.red"),
    ),
    (
        include_bytes!("../../../tests/vectors/frame_368x360_cam1.gray"),
        include_bytes!("../../../tests/vectors/frame_368x360_cam1.red"),
    ),
];

/// Both frames.
///
/// # Panics
/// Never: the files have the right size.
#[must_use]
pub fn frames() -> Frames<'static> {
    FRAMES.map(|(gray, red)| {
        let (width, height) = (WIDTH.into(), HEIGHT.into());
        let gray = GrayImage::new(gray, width, height).expect("the frame has its size");
        let red = BitMask::new(red, width, height).expect("the mask is of the frame's size");
        Some(Frame { gray, excluded: ExclusionMask::Mask(red) })
    })
}

/// The rig hangs upside down, 1.6 m above the floor.
#[must_use]
pub const fn prior() -> Prior {
    Prior::new(UpHint::Up(Bearing::new(0.0, 1.0, 0.0)), HeightPrior::camera(1.6))
}

/// The nominal rig of `compass-host`, for frames of a quarter of its width and height.
///
/// # Panics
/// Never: its parameters are valid.
#[must_use]
pub fn rig() -> Rig {
    let view = |[fx, fy, cx, cy]: [f32; 4], k| {
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, k).expect("a usual lens");
        View::new(Camera::KannalaBrandt(lens), WIDTH, HEIGHT)
    };
    let front = view([116.0, 116.1, 182.95, 179.9], [0.024, -0.0105, -0.0016, 0.000_14]);
    let mut back = view([116.25, 116.3, 183.65, 179.2], [0.025, -0.0107, -0.001_55, 0.000_13]);
    back.rotation = nalgebra::Matrix3::new(
        -0.999_975,
        0.005_025,
        0.004_975,
        0.005,
        0.999_974_7,
        -0.005_025,
        -0.005,
        -0.005,
        -0.999_974_9,
    );
    back.position = nalgebra::Vector3::new(0.0012, -0.0007, -0.038);
    Rig::new([Some(front), Some(back)]).expect("the rotation is one")
}

impl<'a> Inputs<'a> {
    /// A locator for the frames on the floor of these inputs, with a sink for the stages' results.
    ///
    /// # Panics
    /// Never with [`WORDS`] words of memory.
    pub(crate) fn locator<'m, T: Trace>(&self, memory: &'m mut [u32], trace: T) -> SampleLocator<'a, 'm, T> {
        let locator = Locator::traced(rig(), Settings::BOARD, memory, trace);
        let mut locator = locator.expect("the memory is made for the frames");
        locator.add_site(&self.site()).expect("there is room for a floor");
        locator
    }
}
