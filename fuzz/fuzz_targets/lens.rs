//! Lenses with any numbers: what is accepted is finite over its field.
#![no_main]

use compass_core::Bearing;
use compass_core::vision::camera::{
    Camera, DoubleSphere, Equidistant, Eucm, Intrinsics, KannalaBrandt, Omni, Pixel, Radtan,
};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: (u8, [f32; 4], [f32; 6], [f32; 5])| {
    let (model, [fx, fy, cx, cy], n, [x, y, a, b, c]) = data;
    let intrinsics = Intrinsics { fx, fy, cx, cy };
    let radtan = Radtan { k1: n[1], k2: n[2], p1: n[3], p2: n[4], k3: n[5] };
    let lens = match model % 5 {
        0 => KannalaBrandt::new(intrinsics, [n[0], n[1], n[2], n[3]]).map(Camera::KannalaBrandt),
        1 => Eucm::new(intrinsics, n[0], n[1]).map(Camera::Eucm),
        2 => DoubleSphere::new(intrinsics, n[0], n[1]).map(Camera::DoubleSphere),
        3 => Omni::new(intrinsics, n[0], radtan).map(Camera::Omni),
        _ => Equidistant::new(intrinsics).map(Camera::Equidistant),
    };
    let Ok(lens) = lens else { return };
    assert!(lens.max_angle().is_finite());
    let bearing = Bearing::new(a, b, c);
    if let Some(pixel) = lens.project(&bearing) {
        assert!(pixel.x.is_finite() && pixel.y.is_finite(), "{lens:?} {bearing:?} {pixel:?}");
    }
    for pixel in [Pixel { x, y }, Pixel { x: cx + fx * a, y: cy + fy * b }] {
        if let Some(bearing) = lens.unproject(pixel) {
            assert!((bearing.norm() - 1.0).abs() < 1e-3, "{lens:?} {pixel:?} {bearing:?}");
        }
    }
});
