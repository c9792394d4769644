//! What the eyes of the sample see: two frames of 368 x 360 pixels.

use compass_board::{Frame, Locator, words};
use compass_core::vision::attitude::UpHint;
use compass_core::vision::camera::{Bearing, Camera, Intrinsics, KannalaBrandt, Rig, View};
use compass_core::base::raster::{BitMask, GrayImage};
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::panorama::Resolution;

/// Size of the frames.
const WIDTH: u16 = 368;
/// Size of the frames.
const HEIGHT: u16 = 360;

/// The chain from these frames to a pose.
pub type Eyes = Locator<[u32; SCRATCH]>;

/// Words of scratch that they need.
pub(crate) const SCRATCH: usize = words(WIDTH, HEIGHT, Resolution::COARSE);

/// The frames of both cameras: gray levels, and a mask of what is red.
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

/// Both frames, as the eyes take them.
///
/// # Panics
/// Never: the files have their size.
#[must_use]
pub fn frames() -> [Option<Frame<'static>>; 2] {
    FRAMES.map(|(gray, red)| {
        let (width, height) = (WIDTH.into(), HEIGHT.into());
        let gray = GrayImage::new(gray, width, height).expect("the frame has its size");
        let red = BitMask::new(red, width, height).expect("the mask is of the frame's size");
        Some(Frame { gray, red: ExclusionMask::Mask(red) })
    })
}

/// The rig hangs upside down.
pub const UP: UpHint = UpHint::Up(Bearing::new(0.0, 1.0, 0.0));

/// The nominal rig of `compass-host`, for frames half as wide and high.
///
/// # Panics
/// Never: it is a usual one.
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
