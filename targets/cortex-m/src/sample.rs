//! The product's own data: here, the sample of the tests. Copy what you need.

use compass_core::vision::camera::{Camera, CameraError, Intrinsics, KannalaBrandt, Rig, View};
use nalgebra::{Matrix3, Vector3};

/// Size of the frames, pixels.
pub const WIDTH: u16 = 368;
/// Size of the frames, pixels.
pub const HEIGHT: u16 = 360;

/// The images of the two cameras, row by row: a product's cameras write them into RAM.
pub static FRAMES: [&[u8]; 2] = [
    include_bytes!("../../../tests/vectors/frame_368x360_cam0.gray"),
    include_bytes!("../../../tests/vectors/frame_368x360_cam1.gray"),
];

/// Rotation of the back camera's bearings into the front camera, row by row.
const BACK: [f32; 9] =
    [-0.999_975, 0.005_025, 0.004_975, 0.005, 0.999_974_7, -0.005_025, -0.005, -0.005, -0.999_974_9];

/// Two fisheye cameras back to back, from a calibration.
///
/// # Errors
/// As [`Rig::new`].
pub fn rig() -> Result<Rig, CameraError> {
    let view = |[fx, fy, cx, cy]: [f32; 4], coefficients| {
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, coefficients)?;
        Ok(View::new(Camera::KannalaBrandt(lens), WIDTH, HEIGHT))
    };
    let front = view([116.0, 116.1, 182.95, 179.9], [0.024, -0.0105, -0.0016, 0.000_14])?;
    let back = View {
        rotation: Matrix3::from_row_slice(&BACK),
        position: Vector3::new(0.0012, -0.0007, -0.038),
        ..view([116.25, 116.3, 183.65, 179.2], [0.025, -0.0107, -0.001_55, 0.000_13])?
    };
    Rig::new([Some(front), Some(back)])
}
