use super::*;
use core::f32::consts::{FRAC_PI_2, PI};
use proptest::prelude::*;
use std::vec::Vec;

const INTRINSICS: Intrinsics = Intrinsics { fx: 431.5, fy: 430.25, cx: 702.75, cy: 690.5 };

fn kannala_brandt(k: [f32; 4]) -> Camera {
    Camera::KannalaBrandt(KannalaBrandt::new(INTRINSICS, k).unwrap())
}

fn eucm(alpha: f32, beta: f32) -> Camera {
    Camera::Eucm(Eucm::new(INTRINSICS, alpha, beta).unwrap())
}

fn equidistant() -> Camera {
    Camera::Equidistant(Equidistant::new(INTRINSICS).unwrap())
}

fn double_sphere(xi: f32, alpha: f32) -> Camera {
    Camera::DoubleSphere(DoubleSphere::new(INTRINSICS, xi, alpha).unwrap())
}

/// Distortion from k1, k2, p1, p2 and k3.
fn radtan([k1, k2, p1, p2, k3]: [f32; 5]) -> Radtan {
    Radtan { k1, k2, p1, p2, k3 }
}

fn omni(xi: f32, distortion: [f32; 5]) -> Camera {
    Camera::Omni(Omni::new(INTRINSICS, xi, radtan(distortion)).unwrap())
}

/// Lenses of all models.
fn lenses() -> Vec<Camera> {
    let mut lenses = radial_lenses();
    lenses.extend(sphere_lenses());
    lenses
}

/// Double spheres and distorted unified lenses: typical parameters and the ends of their ranges.
fn sphere_lenses() -> Vec<Camera> {
    let mut lenses = Vec::new();
    for xi in [-0.5, -0.2, 0.0, 0.3, 0.8] {
        lenses.extend([0.0, 0.3, 0.5, 0.59, 0.75, 1.0].map(|alpha| double_sphere(xi, alpha)));
    }
    for xi in [0.0, 0.7, 1.0, 1.5, 2.2] {
        lenses.extend([
            omni(xi, [0.0; 5]),
            omni(xi, [-0.25, 0.06, 0.0004, -0.0007, 0.0]),
            omni(xi, [0.12, -0.02, -0.003, 0.002, 0.01]),
        ]);
    }
    lenses
}

/// Lenses of the other models: typical parameters and the ends of their ranges.
fn radial_lenses() -> Vec<Camera> {
    let mut lenses = std::vec![
        equidistant(),
        kannala_brandt([0.0; 4]),
        kannala_brandt([0.03, -0.012, -0.001, 0.0001]),
        kannala_brandt([-0.05, 0.01, -0.005, 0.0004]),
        kannala_brandt([0.3, 0.2, 0.1, 0.05]),
        kannala_brandt([-0.3, 0.0, 0.0, 0.0]),
    ];
    for alpha in [0.0, 0.3, 0.499, 0.5, 0.501, 0.69, 1.0] {
        lenses.extend([0.5, 0.9, 1.0, 2.0].map(|beta| eucm(alpha, beta)));
    }
    lenses
}

fn at(theta: f32, azimuth: f32) -> Bearing {
    let (s, c) = (libm::sinf(theta), libm::cosf(theta));
    Bearing::new(s * libm::cosf(azimuth), s * libm::sinf(azimuth), c)
}

fn distance(a: Pixel, b: Pixel) -> f32 {
    libm::hypotf(a.x - b.x, a.y - b.y)
}

#[test]
fn axes_are_those_of_opencv() {
    for lens in lenses() {
        let centre = lens.project(&Bearing::new(0.0, 0.0, 1.0)).unwrap();
        assert_eq!((centre.x, centre.y), (INTRINSICS.cx, INTRINSICS.cy), "{lens:?}");
        assert_eq!(lens.unproject(centre), Some(Bearing::new(0.0, 0.0, 1.0)));
        // Tangential distortion bends the axes by fractions of a pixel.
        let near = |a: f32, b: f32| (a - b).abs() < 0.05;
        let right = lens.project(&Bearing::new(0.1, 0.0, 1.0)).unwrap();
        assert!(right.x > centre.x && near(right.y, centre.y), "{lens:?}");
        let down = lens.project(&Bearing::new(0.0, 0.1, 1.0)).unwrap();
        assert!(near(down.x, centre.x) && down.y > centre.y, "{lens:?}");
    }
}

#[test]
fn formulas_at_known_points() {
    let near = |pixel: Option<Pixel>, radius: f32| {
        let pixel = pixel.unwrap();
        assert!((pixel.x - (INTRINSICS.cx + INTRINSICS.fx * radius)).abs() < 1e-3, "{pixel:?} {radius}");
    };
    let (side, behind) = (Bearing::new(1.0, 0.0, 0.0), Bearing::new(1.0, 0.0, -1.0));
    near(equidistant().project(&side), FRAC_PI_2);
    near(equidistant().project(&behind), 3.0 * PI / 4.0);
    near(kannala_brandt([0.1, 0.0, 0.0, 0.0]).project(&side), FRAC_PI_2 + 0.1 * libm::powf(FRAC_PI_2, 3.0));
    near(kannala_brandt([0.0, 0.0, 0.0, 0.01]).project(&side), FRAC_PI_2 + 0.01 * libm::powf(FRAC_PI_2, 9.0));
    near(eucm(0.0, 1.0).project(&Bearing::new(2.0, 0.0, 1.0)), 2.0);
    // Alpha 1/2 and beta 1 is the stereographic lens, 2 tan(theta / 2).
    near(eucm(0.5, 1.0).project(&side), 2.0);
    // Xi 0 is the unified model, alpha 0 a pinhole behind the moved centre.
    near(double_sphere(0.0, 0.5).project(&side), 2.0);
    near(double_sphere(0.5, 0.0).project(&side), 2.0);
    near(double_sphere(-0.2, 0.6).project(&side), 1.0 / (0.6 * libm::sqrtf(1.04) - 0.4 * 0.2));
    // tan(theta / 2), and a pinhole at 45 degrees.
    near(omni(1.0, [0.0; 5]).project(&side), 1.0);
    near(omni(0.0, [-0.2, 0.02, 0.0, 0.0, 0.005]).project(&Bearing::new(1.0, 0.0, 1.0)), 0.825);
    // Along x: 3 p2 to the side, p1 across.
    let bent = omni(1.0, [0.0, 0.0, 0.002, 0.001, 0.0]).project(&side).unwrap();
    let expected =
        Pixel { x: INTRINSICS.cx + INTRINSICS.fx * 1.003, y: INTRINSICS.cy + INTRINSICS.fy * 0.002 };
    assert!(distance(bent, expected) < 1e-3, "{bent:?} {expected:?}");
    // Sideways the radius is 1 / (alpha sqrt(beta)).
    near(eucm(0.64, 0.81).project(&side), 1.0 / (0.64 * 0.9));
}

#[test]
fn the_field_ends_where_the_model_does() {
    assert_eq!(equidistant().max_angle(), WIDEST_ANGLE);
    assert_eq!(kannala_brandt([0.0; 4]).max_angle(), WIDEST_ANGLE);
    // 1 - 0.9 theta^2 vanishes at 1.0541.
    assert!((kannala_brandt([-0.3, 0.0, 0.0, 0.0]).max_angle() - 1.054_092_6).abs() < 1e-6);
    // atan2(sqrt((2 alpha - 1) / beta), alpha - 1)
    let limit = libm::atan2f(libm::sqrtf(0.38 / 0.9), -0.31);
    assert!((eucm(0.69, 0.9).max_angle() - limit).abs() < 1e-3, "{} {limit}", eucm(0.69, 0.9).max_angle());
    assert!((eucm(0.0, 1.0).max_angle() - libm::atanf(WIDEST_RADIUS)).abs() < 1e-6);
    // Beyond 1 / sqrt(2 alpha - 1) the second sphere has no image; from there it looks (alpha - 1) / (2 alpha - 1) back.
    let [sin, cos] = [libm::sqrtf(1.0 / 0.18), -0.41 / 0.18]
        .map(|v| v / libm::sqrtf(1.0 / 0.18 + (0.41 / 0.18) * (0.41 / 0.18)));
    let k = -0.2 * cos + libm::sqrtf(1.0 - 0.04 * sin * sin);
    let limit = libm::atan2f(k * sin, k * cos + 0.2);
    assert!((double_sphere(-0.2, 0.59).max_angle() - limit).abs() < 1e-3, "{limit}");
    assert!((omni(0.0, [0.0; 5]).max_angle() - libm::atanf(WIDEST_RADIUS)).abs() < 1e-6);
    // Above xi 1 the radius is largest where cos is -1 / xi.
    assert!((omni(2.0, [0.0; 5]).max_angle() - 2.0 * PI / 3.0).abs() < 1e-3);
    // 1 - 0.75 r^2 vanishes at 1.1547.
    assert!((omni(0.0, [-0.25, 0.0, 0.0, 0.0, 0.0]).max_angle() - libm::atanf(1.154_700_5)).abs() < 1e-5);
    for lens in lenses() {
        let limit = lens.max_angle();
        assert!(lens.project(&at(limit - 1e-3, 1.0)).is_some(), "{lens:?}");
        assert!(limit > 3.13 || lens.project(&at(limit + 3e-3, 1.0)).is_none(), "{lens:?}");
        assert_eq!(lens.project(&Bearing::new(0.0, 0.0, -1.0)), None);
    }
}

#[test]
fn invalid_bearings_and_pixels_have_no_image() {
    for lens in lenses() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for slot in 0..3 {
                let mut bearing = Bearing::new(0.1, 0.2, 0.9);
                bearing[slot] = bad;
                assert_eq!(lens.project(&bearing), None);
            }
            assert_eq!(lens.unproject(Pixel { x: bad, y: 1.0 }), None);
            assert_eq!(lens.unproject(Pixel { x: 1.0, y: bad }), None);
            let unusable = lens.scaled(bad, 1.0);
            assert_eq!(unusable.project(&at(0.5, 0.0)), None);
            assert_eq!(unusable.unproject(Pixel { x: 700.0, y: 700.0 }), None);
        }
        assert_eq!(lens.project(&Bearing::zeros()), None);
        assert_eq!(lens.unproject(Pixel { x: f32::MAX, y: f32::MIN }), None);
        assert_eq!(lens.scaled(0.0, 1.0).project(&at(0.5, 0.0)), None);
        assert_eq!(lens.scaled(1.0, -1.0).unproject(Pixel { x: 700.0, y: 700.0 }), None);
    }
}

#[test]
fn the_length_of_a_bearing_does_not_matter() {
    for lens in lenses() {
        let pixel = lens.project(&at(0.7, 2.0)).unwrap();
        for length in [1e-30, 0.01, 1e37] {
            let other = lens.project(&(at(0.7, 2.0) * length)).unwrap();
            assert!(distance(pixel, other) < 1e-3, "{lens:?} {length}");
        }
    }
}

#[test]
fn rejects_invalid_parameters() {
    let with = |change: &dyn Fn(&mut Intrinsics)| {
        let mut intrinsics = INTRINSICS;
        change(&mut intrinsics);
        Equidistant::new(intrinsics).unwrap_err()
    };
    assert_eq!(with(&|i| i.fx = f32::NAN), CameraError::NotFinite);
    assert_eq!(with(&|i| i.cy = f32::INFINITY), CameraError::NotFinite);
    assert_eq!(with(&|i| i.fx = 0.0), CameraError::Focal);
    assert_eq!(with(&|i| i.fy = -400.0), CameraError::Focal);
    let lens = |k| KannalaBrandt::new(INTRINSICS, k).unwrap_err();
    assert_eq!(lens([0.0, f32::NAN, 0.0, 0.0]), CameraError::NotFinite);
    assert_eq!(lens([-1000.0, 0.0, 0.0, 0.0]), CameraError::Field);
    assert_eq!(lens([0.0, 0.0, 0.0, f32::MAX]), CameraError::Field);
    assert_eq!(lens([f32::MAX, f32::MIN, f32::MAX, f32::MIN]), CameraError::Field);
    let lens = |alpha, beta| Eucm::new(INTRINSICS, alpha, beta).unwrap_err();
    assert_eq!(lens(-0.01, 1.0), CameraError::Alpha);
    assert_eq!(lens(1.01, 1.0), CameraError::Alpha);
    assert_eq!(lens(f32::NAN, 1.0), CameraError::NotFinite);
    assert_eq!(lens(0.6, 0.0), CameraError::Beta);
    assert_eq!(lens(0.6, -1.0), CameraError::Beta);
    assert_eq!(lens(0.6, f32::MAX), CameraError::Field);
    let lens = |xi, alpha| DoubleSphere::new(INTRINSICS, xi, alpha).unwrap_err();
    assert_eq!(lens(-1.0, 0.5), CameraError::Xi);
    assert_eq!(lens(1.1, 0.5), CameraError::Xi);
    assert_eq!(lens(f32::NAN, 0.5), CameraError::NotFinite);
    assert_eq!(lens(0.1, 1.5), CameraError::Alpha);
    let lens = |xi, distortion| Omni::new(INTRINSICS, xi, radtan(distortion)).unwrap_err();
    assert_eq!(lens(-0.1, [0.0; 5]), CameraError::Xi);
    assert_eq!(lens(f32::INFINITY, [0.0; 5]), CameraError::NotFinite);
    assert_eq!(lens(1.0, [0.0, f32::NAN, 0.0, 0.0, 0.0]), CameraError::NotFinite);
    assert_eq!(lens(1.0, [-1000.0, 0.0, 0.0, 0.0, 0.0]), CameraError::Field);
    assert_eq!(lens(1.0, [0.0, 0.0, 10.0, 0.0, 0.0]), CameraError::Field);
    assert_eq!(lens(0.0, [f32::MAX; 5]), CameraError::Field);
}

#[test]
fn scaling_keeps_the_outer_edges_of_the_image() {
    let half = equidistant().scaled(0.5, 0.25);
    let found = half.intrinsics();
    assert_eq!((found.fx, found.fy), (215.75, 107.5625));
    assert_eq!((found.cx, found.cy), (703.25 * 0.5 - 0.5, 691.0 * 0.25 - 0.5));
    for lens in lenses() {
        let same = lens.scaled(1.0, 1.0);
        assert!((same.intrinsics().cx - INTRINSICS.cx).abs() < 1e-3);
        let (large, small) =
            (lens.project(&at(0.8, 0.3)).unwrap(), lens.scaled(0.5, 0.5).project(&at(0.8, 0.3)));
        let small = small.unwrap();
        let expected = Pixel { x: (large.x + 0.5) * 0.5 - 0.5, y: (large.y + 0.5) * 0.5 - 0.5 };
        assert!(distance(small, expected) < 1e-3, "{lens:?}");
    }
}

#[test]
fn pixels_on_the_rim_round_trip() {
    for lens in lenses() {
        for step in 0..360_u16 {
            let azimuth = f32::from(step).to_radians();
            let Some(pixel) = lens.project(&at(lens.max_angle(), azimuth)) else {
                panic!("{lens:?} {step}");
            };
            let bearing = lens.unproject(pixel).unwrap();
            let again = lens.project(&bearing).unwrap();
            assert!(distance(pixel, again) <= ROUND_TRIP_PX, "{lens:?} {step}: {pixel:?} {again:?}");
        }
    }
}

/// Hash of the bits of projections and bearings; it differs on a target that rounds differently.
#[test]
fn bits_are_the_same_on_every_target() {
    let sums = [radial_lenses(), sphere_lenses()].map(|lenses| bits(&lenses));
    assert_eq!(sums, [0x10d2_152d_c85f_7b9b, 0xb962_5a21_7895_79e1], "{sums:#x?}");
}

fn bits(lenses: &[Camera]) -> u64 {
    let mut sum = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |value: f32| {
        for byte in value.to_bits().to_le_bytes() {
            sum = (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for lens in lenses {
        for step in 0..200_u16 {
            let pixel = Pixel { x: f32::from(step) * 7.0, y: 1400.0 - f32::from(step) * 5.5 };
            let Some(bearing) = lens.unproject(pixel) else { continue };
            bearing.iter().copied().for_each(&mut add);
            let again = lens.project(&bearing).unwrap();
            add(again.x);
            add(again.y);
        }
    }
    sum
}

fn intrinsics() -> impl Strategy<Value = Intrinsics> {
    (100.0_f32..2000.0, 0.95_f32..1.05, 0.0_f32..4096.0, 0.0_f32..4096.0)
        .prop_map(|(fx, aspect, cx, cy)| Intrinsics { fx, fy: fx * aspect, cx, cy })
}

/// Lenses of all models, including implausible ones.
fn any_lens() -> impl Strategy<Value = Camera> {
    let k = [-0.3_f32..0.3, -0.1..0.1, -0.05..0.05, -0.01..0.01];
    prop_oneof![
        (intrinsics(), k)
            .prop_filter_map("field", |(i, k)| Some(Camera::KannalaBrandt(KannalaBrandt::new(i, k).ok()?))),
        (intrinsics(), 0.0_f32..=1.0, 0.1_f32..4.0)
            .prop_filter_map("field", |(i, alpha, beta)| Some(Camera::Eucm(Eucm::new(i, alpha, beta).ok()?))),
        (intrinsics(), -0.5_f32..0.8, 0.0_f32..=1.0).prop_filter_map("field", |(i, xi, alpha)| Some(
            Camera::DoubleSphere(DoubleSphere::new(i, xi, alpha).ok()?)
        )),
        (intrinsics(), 0.0_f32..3.0, [-0.3_f32..0.3, -0.1..0.1, -0.01..0.01, -0.01..0.01, -0.05..0.05])
            .prop_filter_map("field", |(i, xi, d)| Some(Camera::Omni(Omni::new(i, xi, radtan(d)).ok()?))),
        intrinsics().prop_map(|i| Camera::Equidistant(Equidistant::new(i).unwrap())),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn pixels_round_trip(lens in any_lens(), x in 0.0_f32..4096.0, y in 0.0_f32..4096.0) {
        let pixel = Pixel { x, y };
        if let Some(bearing) = lens.unproject(pixel) {
            prop_assert!((bearing.norm() - 1.0).abs() < 1e-6);
            let again = lens.project(&bearing).unwrap();
            prop_assert!(distance(pixel, again) <= ROUND_TRIP_PX, "{pixel:?} {again:?}");
        }
    }

    /// The output is finite for every bit pattern of the input.
    #[test]
    fn output_is_finite_for_any_bits(lens in any_lens(), bits in [any::<u32>(), any::<u32>(), any::<u32>()]) {
        let [x, y, z] = bits.map(f32::from_bits);
        if let Some(pixel) = lens.project(&Bearing::new(x, y, z)) {
            prop_assert!(pixel.x.is_finite() && pixel.y.is_finite());
        }
        if let Some(bearing) = lens.unproject(Pixel { x, y }) {
            prop_assert!((bearing.norm() - 1.0).abs() < 1e-6);
        }
        let polynomial = KannalaBrandt::new(INTRINSICS, [x, y, z, x]).map(Camera::KannalaBrandt);
        let unified = Eucm::new(Intrinsics { fx: x, ..INTRINSICS }, y, z).map(Camera::Eucm);
        let spheres = DoubleSphere::new(INTRINSICS, x, y).map(Camera::DoubleSphere);
        let omni = Omni::new(INTRINSICS, x.abs(), radtan([y, z, x, y, z])).map(Camera::Omni);
        for lens in [polynomial, unified, spheres, omni].into_iter().flatten() {
            prop_assert!(lens.max_angle() >= NARROWEST_ANGLE && lens.max_angle() <= WIDEST_ANGLE);
            let _ = lens.project(&at(1.0, 2.0));
            let _ = lens.unproject(Pixel { x: 600.0, y: 700.0 });
        }
    }
}

#[test]
fn invalid_rigs_are_rejected() {
    let view = View::new(equidistant(), 1408, 1382);
    assert_eq!(Rig::new([None, None]).unwrap_err(), CameraError::Empty);
    assert_eq!(Rig::new([Some(View { width: 0, ..view }), None]).unwrap_err(), CameraError::Size);
    let mut bad = view;
    bad.position.x = f32::NAN;
    assert_eq!(Rig::new([None, Some(bad)]).unwrap_err(), CameraError::NotFinite);
    let mut bad = view;
    bad.rotation *= 1.001;
    assert_eq!(Rig::new([None, Some(bad)]).unwrap_err(), CameraError::Rotation);
    let mut bad = view;
    bad.rotation[(2, 2)] = -1.0;
    assert_eq!(Rig::new([None, Some(bad)]).unwrap_err(), CameraError::Rotation, "a reflection");
    let rig = Rig::new([None, Some(view)]).unwrap();
    assert_eq!((rig.view(0), rig.view(1), rig.view(2)), (None, Some(&view), None));
    assert_eq!(rig.views().map(|(number, _)| number).collect::<Vec<_>>(), [1]);
}

#[test]
fn back_to_back_cameras_face_opposite_ways() {
    let view = View::new(equidistant(), 1408, 1382);
    let rig = Rig::back_to_back(view, view).unwrap();
    assert_eq!(rig.view(0), Some(&view));
    let back = rig.view(1).unwrap();
    assert_eq!(back.rotation * Bearing::new(0.0, 0.0, 1.0), Bearing::new(0.0, 0.0, -1.0));
    assert_eq!(back.rotation * Bearing::new(1.0, 0.0, 0.0), Bearing::new(-1.0, 0.0, 0.0));
    assert_eq!(back.rotation * Bearing::new(0.0, 1.0, 0.0), Bearing::new(0.0, 1.0, 0.0), "y is unchanged");
    assert_eq!(back.position, nalgebra::Vector3::zeros());
}
