//! Camera models against `OpenCV` and against real calibrations; invalid calibrations on the command line.

use compass_core::vision::camera::{
    Bearing, Camera, CameraError, DoubleSphere, Equidistant, Eucm, Intrinsics, KannalaBrandt, Omni, Pixel,
    ROUND_TRIP_PX, Radtan,
};
use compass_host::calibration::Calibration;
use compass_host::compare::camera::stages;
use compass_tests::{Folder, number, recordings};
use proptest::prelude::*;

/// Largest difference to the projection of `OpenCV`, in pixels.
const OPENCV_PX: f64 = 0.001;

/// Largest difference of two calibrations of one lens, Kannala-Brandt and EUCM, in pixels.
const MODELS_PX: f64 = 0.1;

#[test]
fn kannala_brandt_projects_as_opencv_does() {
    let (mut worst, mut count) = (0.0_f64, 0);
    let table = include_str!("../vectors/opencv_fisheye.csv");
    for line in table.lines().filter(|line| !line.starts_with(['#', 'f'])) {
        let row: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let single: Vec<f32> = row.iter().map(|&value| value as f32).collect();
        let [fx, fy, cx, cy, k1, k2, k3, k4, x, y, z, _, _] = single[..] else { panic!("{line}") };
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, [k1, k2, k3, k4]).unwrap();
        let pixel = Camera::KannalaBrandt(lens).project(&Bearing::new(x, y, z)).unwrap();
        worst = worst.max((f64::from(pixel.x) - row[11]).hypot(f64::from(pixel.y) - row[12]));
        count += 1;
    }
    println!("worst of {count}: {worst} px");
    assert!(count > 500 && worst <= OPENCV_PX, "{count}: {worst} px");
}

#[test]
fn omnidirectional_lenses_project_as_opencv_does() {
    let (mut worst, mut worst_back, mut count) = (0.0_f64, 0.0_f32, 0);
    let table = include_str!("../vectors/opencv_omnidir.csv");
    for line in table.lines().filter(|line| !line.starts_with(['#', 'f'])) {
        let row: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let single: Vec<f32> = row.iter().map(|&value| value as f32).collect();
        let [fx, fy, cx, cy, xi, k1, k2, p1, p2, x, y, z, _, _] = single[..] else { panic!("{line}") };
        let distortion = Radtan { k1, k2, p1, p2, k3: 0.0 };
        let lens = Camera::Omni(Omni::new(Intrinsics { fx, fy, cx, cy }, xi, distortion).unwrap());
        let pixel = lens.project(&Bearing::new(x, y, z)).unwrap_or_else(|| panic!("{line}"));
        worst = worst.max((f64::from(pixel.x) - row[12]).hypot(f64::from(pixel.y) - row[13]));
        worst_back = worst_back.max((lens.unproject(pixel).unwrap() - Bearing::new(x, y, z)).norm());
        count += 1;
    }
    println!("worst of {count}: {worst} px, back {worst_back} rad");
    assert!(count > 800 && worst <= OPENCV_PX && worst_back < 2e-5, "{count}: {worst} px, {worst_back} rad");
}

fn lenses(calibration: &Calibration) -> Vec<Camera> {
    let sizes = calibration.cameras.each_ref().map(|camera| Some(camera.as_ref()?.resolution));
    calibration.rig(sizes).unwrap().views().map(|(_, view)| view.camera).collect()
}

#[test]
fn real_lenses_agree_between_models() {
    let Some(data) = recordings("real_lenses_agree_between_models") else { return };
    let load = |name| Calibration::load(&data.join("hilti/config").join(name)).unwrap();
    let polynomial = load("kalibr_imucam_chain.yaml");
    let unified = load("kalibr_imucam_chain_eucm.yaml");
    let both = [lenses(&polynomial), lenses(&unified)];
    assert_eq!((both[0].len(), both[1].len()), (2, 2));
    for (number, (a, b)) in both[0].iter().zip(&both[1]).enumerate() {
        let mut worst = 0.0_f32;
        for tenths in 0..=950_u16 {
            let (sin, cos) = (f32::from(tenths) / 10.0).to_radians().sin_cos();
            for degrees in (0..360_u16).step_by(5) {
                let (s, c) = f32::from(degrees).to_radians().sin_cos();
                let bearing = Bearing::new(sin * c, sin * s, cos);
                let (a, b) = (a.project(&bearing).unwrap(), b.project(&bearing).unwrap());
                worst = worst.max((a.x - b.x).hypot(a.y - b.y));
            }
        }
        println!("cam{number}: {worst} px; fields {} and {} rad", a.max_angle(), b.max_angle());
        assert!(f64::from(worst) <= MODELS_PX, "cam{number}: {worst} px");
    }
    for stage in both.iter().flat_map(|lenses| stages(lenses)) {
        println!("{stage:?}");
        assert!(stage.in_bounds, "{stage:?}");
    }
}

#[test]
fn real_rig_is_back_to_back() {
    let Some(data) = recordings("real_rig_is_back_to_back") else { return };
    let calibration = Calibration::load(&data.join("hilti/config/kalibr_imucam_chain.yaml")).unwrap();
    let [Some(front), Some(_)] = &calibration.cameras else { panic!("two cameras") };
    let (width, height) = front.resolution;
    let rig = calibration.rig([Some((width, height)), Some((width / 2, height / 2))]).unwrap();
    let back = rig.view(1).unwrap();
    let behind = back.rotation * Bearing::new(0.0, 0.0, 1.0);
    let down = back.rotation * Bearing::new(0.0, 1.0, 0.0);
    println!("cam1's axis {behind:?}, its down {down:?}, at {:?}", back.position);
    assert!(behind.z < -0.999 && down.y > 0.999, "{behind:?} {down:?}");
    assert!(back.position.norm() < 0.1, "{:?}", back.position);
    assert_eq!((u32::from(back.width), u32::from(back.height)), (width / 2, height / 2));
}

const CHAIN: &str = "%YAML:1.0\ncam0:\n  camera_model: pinhole\n  distortion_model: equidistant\n  \
                     intrinsics: [430, 431, 402, 300]\n  distortion_coeffs: [0.02, -0.01, -0.001, 0.0001]\n  \
                     resolution: [800, 600]\n";

#[test]
fn compare_takes_a_calibration() {
    let folder = Folder::new();
    folder.write("chain.yaml", CHAIN.as_bytes());
    let output = folder.json("compare --poses 2 --calib chain.yaml");
    let stages: Vec<_> = output["stages"].as_array().unwrap().iter().collect();
    let cameras: Vec<_> =
        stages.iter().filter(|stage| stage["stage"].as_str().unwrap().starts_with("camera: ")).collect();
    assert_eq!(cameras.len(), 3, "one model: {cameras:?}");
    assert!(cameras.iter().all(|stage| number(&stage["compared"]) > 0.0 && stage["in_bounds"] == true));
    let round_trip = cameras[2];
    assert!((number(&round_trip["bound"]) - f64::from(ROUND_TRIP_PX)).abs() < 1e-6, "{round_trip}");
}

#[test]
fn bad_calibrations_are_refused_in_one_line() {
    let folder = Folder::new();
    let refused = |text: &str, named: &[&str]| {
        folder.write("chain.yaml", text.as_bytes());
        let ran = folder.run("compare --poses 2 --calib chain.yaml");
        assert_eq!((ran.status, ran.stdout.as_str()), (Some(2), ""), "{}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
        for name in named {
            assert!(ran.stderr.contains(name), "no '{name}' in {}", ran.stderr);
        }
    };
    refused("", &["chain.yaml"]);
    refused(&CHAIN.replace("equidistant", "fov"), &["chain.yaml", "cam0.distortion_model", "fov"]);
    refused(&CHAIN.replace("[0.02,", "[1, 0.02,"), &["cam0.distortion_coeffs", "left out"]);
    refused(&CHAIN.replace("430", "0"), &["cam0.intrinsics", "focal"]);
    refused(&CHAIN[..CHAIN.find("  resolution").unwrap()], &["cam0.resolution", "missing"]);
    let ran = folder.run("compare --poses 2 --calib nowhere.yaml");
    assert_eq!(ran.status, Some(2));
    assert!(ran.stderr.contains("nowhere.yaml"), "{}", ran.stderr);
}

/// Any number, and those near the limits of what lenses accept more often.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>(),
        -2.0_f32..2.0,
        Just(0.0),
        Just(0.5),
        Just(1.0),
        Just(f32::MAX),
        Just(f32::MIN_POSITIVE)
    ]
}

fn any_lens() -> impl Strategy<Value = Camera> {
    let intrinsics = prop_oneof![
        [any_number(), any_number(), any_number(), any_number()],
        [100.0_f32..2000.0, 100.0_f32..2000.0, 0.0_f32..2000.0, 0.0_f32..2000.0],
    ];
    let intrinsics = intrinsics.prop_map(|[fx, fy, cx, cy]| Intrinsics { fx, fy, cx, cy });
    let numbers = prop::array::uniform6(any_number());
    let model = 0..5_usize;
    (intrinsics, numbers, model).prop_filter_map("the lens is refused", |(intrinsics, n, model)| {
        let radtan = Radtan { k1: n[1], k2: n[2], p1: n[3], p2: n[4], k3: n[5] };
        match model {
            0 => KannalaBrandt::new(intrinsics, [n[0], n[1], n[2], n[3]]).ok().map(Camera::KannalaBrandt),
            1 => Eucm::new(intrinsics, n[0], n[1]).ok().map(Camera::Eucm),
            2 => DoubleSphere::new(intrinsics, n[0], n[1]).ok().map(Camera::DoubleSphere),
            3 => Omni::new(intrinsics, n[0], radtan).ok().map(Camera::Omni),
            _ => Equidistant::new(intrinsics).ok().map(Camera::Equidistant),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, max_global_rejects: 4_000_000, ..ProptestConfig::default() })]

    /// Whatever numbers a lens is accepted with: a pixel has a bearing of length 1 or none, a bearing a finite pixel or none.
    #[test]
    fn every_accepted_lens_is_finite_over_its_field(
        lens in any_lens(), x in any_number(), y in any_number(), radius in 0.0_f32..4.0, turn in 0.0_f32..7.0
    ) {
        prop_assert!(lens.max_angle().is_finite());
        let Intrinsics { fx, fy, cx, cy } = lens.intrinsics();
        let inside = Pixel { x: cx + fx * radius * turn.cos(), y: cy + fy * radius * turn.sin() };
        for pixel in [Pixel { x, y }, inside] {
            if let Some(bearing) = lens.unproject(pixel) {
                prop_assert!((bearing.norm() - 1.0).abs() < 1e-3, "{lens:?} {pixel:?} {bearing:?}");
            }
        }
        for bearing in [Bearing::new(x, y, radius), Bearing::new(turn.cos(), turn.sin(), radius - 2.0)] {
            if let Some(pixel) = lens.project(&bearing) {
                prop_assert!(pixel.x.is_finite() && pixel.y.is_finite(), "{lens:?} {bearing:?} {pixel:?}");
            }
        }
    }
}

/// A beta that overflows has no depth: it was accepted, with bearings that are no numbers.
#[test]
fn a_lens_without_depth_is_refused() {
    let intrinsics = Intrinsics { fx: 1582.8, fy: 2095.2, cx: 5807.0, cy: 15172.0 };
    assert_eq!(Eucm::new(intrinsics, 0.41953126, 3.4e38), Err(CameraError::Field));
    let intrinsics = Intrinsics { fx: f32::MIN_POSITIVE, fy: 0.5, cx: 0.5, cy: 0.0 };
    let point = Radtan { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
    let lens = Camera::Omni(Omni::new(intrinsics, f32::MAX, point).unwrap());
    assert_eq!(lens.unproject(Pixel { x: 0.5, y: 0.0 }), None);
}
