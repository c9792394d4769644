use super::*;

const GOOD: &str = "%YAML:1.0
cam0:
  T_cam_imu:
    - [0, 0, -1, 0.02]
    - [1, 0, 0, 0.015]
    - [0, -1, 0, -0.016]
    - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: []
  camera_model: pinhole
  distortion_coeffs: [0.02, -0.01, -0.001, 0.0001]
  distortion_model: equidistant
  intrinsics: [430, 431, 402, 300]
  resolution: [800, 600]
  timeshift_cam_imu: -0.006
cam1:
  T_cam_imu:
    - [0, 0, 1, -0.02]
    - [1, 0, 0, 0.015]
    - [0, 1, 0, -0.024]
    - [0.0, 0.0, 0.0, 1.0]
  camera_model: eucm
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [0.6, 0.9, 440, 441, 399, 302]
  resolution: [800, 600]
";

/// The same chain without IMU, as Kalibr writes it for cameras alone.
const DIRECT: &str = "  T_cn_cnm1:
    - [-1, 0, 0, 0]
    - [0, 1, 0, 0]
    - [0, 0, -1, -0.04]
    - [0.0, 0.0, 0.0, 1.0]
";

fn load(text: &str) -> Result<Calibration, CalibrationError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.yaml");
    std::fs::write(&path, text).unwrap();
    Calibration::load(&path)
}

fn line(error: &CalibrationError) -> String {
    let message = error.to_string();
    assert!(message.contains("chain.yaml: ") && !message.contains('\n'), "{message}");
    message
}

/// Loads the good file with `from` replaced by `to`, which must be rejected with all of `named`.
fn refused(from: &str, to: &str, named: &[&str]) {
    assert!(GOOD.contains(from), "{from}");
    let message = line(&load(&GOOD.replacen(from, to, 1)).unwrap_err());
    for name in named {
        assert!(message.contains(name), "{from} -> {to}: no '{name}' in {message}");
    }
}

const BOTH: [Option<(u32, u32)>; 2] = [Some((800, 600)), Some((800, 600))];

#[test]
fn reads_a_chain_of_both_models() {
    let calibration = load(GOOD).unwrap();
    let [Some(cam0), Some(cam1)] = &calibration.cameras else { panic!("{calibration:?}") };
    assert_eq!(cam0.camera.model, Model::KannalaBrandt([0.02, -0.01, -0.001, 0.0001]));
    assert_eq!((cam0.camera.focal, cam0.camera.centre), ([430.0, 431.0], [402.0, 300.0]));
    assert_eq!((cam0.resolution, cam0.timeshift_s, cam0.from_previous), ((800, 600), -0.006, None));
    assert_eq!(cam1.camera.model, Model::Eucm { alpha: 0.6, beta: 0.9 });
    assert_eq!((cam1.camera.focal, cam1.camera.centre), ([440.0, 441.0], [399.0, 302.0]));
    assert_eq!(cam1.timeshift_s, 0.0);
    for other in [GOOD.replace("%YAML:1.0", "%YAML 1.2\n---"), GOOD.replace("%YAML:1.0\n", "")] {
        assert_eq!(load(&other).unwrap().cameras, calibration.cameras, "{other}");
    }
}

#[test]
fn the_rig_is_scaled_to_the_images() {
    let calibration = load(GOOD).unwrap();
    let rig = calibration.rig([Some((400, 300)), None]).unwrap();
    let view = rig.view(0).unwrap();
    assert_eq!((view.width, view.height, rig.view(1)), (400, 300, None));
    let i = view.camera.intrinsics();
    assert_eq!((i.fx, i.fy, i.cx, i.cy), (215.0, 215.5, 200.75, 149.75));
    assert_eq!(view.rotation, Matrix3::identity());
    // 333 x 250 is 333.3 x 250 rounded.
    assert!(calibration.rig([Some((333, 250)), None]).is_ok());
    let message = line(&calibration.rig([Some((332, 250)), None]).unwrap_err());
    assert!(message.contains("800 x 600") && message.contains("332 x 250"), "{message}");
    let message = line(&calibration.rig([Some((600, 800)), None]).unwrap_err());
    assert!(message.contains("swapped"), "{message}");
    assert!(line(&calibration.rig([Some((0, 0)), None]).unwrap_err()).contains("0 x 0"));
    assert!(line(&calibration.rig([Some((80_000, 60_000)), None]).unwrap_err()).contains("80000 x 60000"));
    assert!(line(&calibration.rig([None, None]).unwrap_err()).contains("no camera"));
}

#[test]
fn cam1_is_placed_by_either_transform() {
    let by_imu = load(GOOD).unwrap().rig(BOTH).unwrap();
    let back = by_imu.view(1).unwrap();
    let turned = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0));
    // z of the IMU is -x of cam0 and x of cam1; y is -z of cam0 and z of cam1.
    assert_eq!(back.rotation, turned);
    let expected = Vector3::new(0.0, 0.0, -0.04);
    assert!((back.position - expected).amax() < 1e-6, "{}", back.position);
    let without_imu: String = GOOD
        .lines()
        .filter(|l| !l.contains("T_cam_imu") && !l.starts_with("    -"))
        .map(|l| format!("{l}\n"))
        .collect();
    let direct = load(&(without_imu.clone() + DIRECT)).unwrap().rig(BOTH).unwrap();
    let place = direct.view(1).unwrap();
    assert_eq!(place.rotation, turned);
    assert!((place.position - expected).amax() < 1e-6, "{}", place.position);
    assert!(load(&(GOOD.to_owned() + DIRECT)).unwrap().rig(BOTH).is_ok(), "both, agreeing");
    let message =
        line(&load(&(GOOD.to_owned() + &DIRECT.replace("-0.04", "-0.14"))).unwrap().rig(BOTH).unwrap_err());
    assert!(message.contains("cam1.T_cn_cnm1") && message.contains("disagrees"), "{message}");
    let neither = load(&without_imu).unwrap();
    assert!(neither.rig([BOTH[0], None]).is_ok());
    let message = line(&neither.rig(BOTH).unwrap_err());
    assert!(message.contains("cam1.T_cn_cnm1") && message.contains("T_cam_imu"), "{message}");
}

#[test]
fn a_camera_that_is_not_there() {
    let only = load(&GOOD[..GOOD.find("cam1:").unwrap()]).unwrap();
    assert!(only.rig([BOTH[0], None]).is_ok());
    let message = line(&only.rig(BOTH).unwrap_err());
    assert!(message.contains("cam1: ") && message.contains("not in the file"), "{message}");
    for text in ["", "cam7: {}\n", "just words", "cam0: [unclosed", "%YAML:1.0", "\u{0}"] {
        line(&load(text).unwrap_err());
    }
    assert!(matches!(Calibration::load(Path::new("no/such.yaml")), Err(CalibrationError::Read { .. })));
}

#[test]
fn names_the_field_at_fault() {
    refused("  camera_model: pinhole\n", "", &["cam0.camera_model", "missing"]);
    refused("  distortion_model: equidistant\n", "", &["cam0.distortion_model", "missing"]);
    refused("  intrinsics: [430, 431, 402, 300]\n", "", &["cam0.intrinsics", "missing"]);
    refused("  resolution: [800, 600]\n", "", &["cam0.resolution", "missing"]);
    refused(
        "  distortion_coeffs: [0.02, -0.01, -0.001, 0.0001]\n",
        "",
        &["cam0.distortion_coeffs", "missing"],
    );
    refused("430, 431, 402, 300", "430, 431, 402", &["cam0.intrinsics", "has 3 values", "fx, fy, cx, cy"]);
    refused("0.6, 0.9, ", "", &["cam1.intrinsics", "has 4 values", "alpha, beta"]);
    refused("430, 431, 402, 300", "fine", &["line 12"]);
    for model in ["radtan", "fov", "none", "plumb_bob"] {
        refused("equidistant", model, &["cam0.distortion_model", model]);
    }
    for model in ["omni", "ds", "pinhole-equi"] {
        refused("pinhole", model, &["cam0.camera_model", &format!("'{model}'")]);
    }
    refused("none", "equidistant", &["cam1.distortion_model"]);
    refused("distortion_coeffs: []", "distortion_coeffs: [0, 0, 0, 0]", &["cam1.distortion_model", "eucm"]);
}

#[test]
fn numbers_that_make_no_sense() {
    refused("[430,", "[0,", &["cam0.intrinsics", "focal"]);
    refused(" 431,", " -431,", &["cam0.intrinsics", "focal"]);
    refused("[430,", "[.nan,", &["cam0.intrinsics", "NaN"]);
    refused("[430,", "[1e60,", &["cam0.intrinsics"]);
    refused("0.0001]", ".inf]", &["cam0.distortion_coeffs", "inf"]);
    refused("[0.6,", "[1.6,", &["cam1.intrinsics", "alpha"]);
    refused(" 0.9,", " -0.9,", &["cam1.intrinsics", "beta"]);
    refused("[0.02, -0.01", "[-200, -0.01", &["cam0.distortion_coeffs", "6 degrees"]);
    refused("402, 300", "802, 300", &["cam0.intrinsics", "principal point (802, 300)", "800 x 600"]);
    refused("431, 402, 300", "431, 402, 900", &["cam0.intrinsics", "(402, 900)"]);
    refused(
        "[430, 431, 402, 300]\n  resolution: [800, 600]",
        "[430, 431, 402, 300]\n  resolution: [350, 600]",
        &["cam0.resolution", "swapped"],
    );
    refused("-0.006", ".nan", &["cam0.timeshift_cam_imu"]);
    for sides in ["[800]", "[0, 600]", "[800, -600]", "[800, 70000]", "[800, 600, 3]"] {
        refused("[800, 600]", sides, &["cam0.resolution", "1 to 65535"]);
    }
}

#[test]
fn coefficients_of_another_convention() {
    let from = "[0.02, -0.01, -0.001, 0.0001]";
    let coeffs = "cam0.distortion_coeffs";
    refused(from, "[1.0, 0.02, -0.01, -0.001, 0.0001]", &[coeffs, "starts with 1", "left out"]);
    refused(from, "[1, 0.02, -0.01, -0.001]", &[coeffs, "starts with 1", "left out"]);
    refused(from, "[0.02, -0.01, -0.001, 0.0001, 0.0]", &[coeffs, "has 5 values", "k1 to k5", "theta^9"]);
    refused(from, "[0.02, -0.01]", &[coeffs, "has 2 values"]);
    refused(from, "[]", &[coeffs, "has 0 values"]);
}

#[test]
fn invalid_transforms_are_refused() {
    let field = "cam0.T_cam_imu";
    refused("[0, 0, -1, 0.02]", "[0, 0, -1.01, 0.02]", &[field, "orthonormal"]);
    refused("[0, 0, -1, 0.02]", "[0, 0, 1, 0.02]", &[field, "mirrors"]);
    refused("[0, 0, -1, 0.02]", "[0, 0, -1]", &[field, "four rows"]);
    refused("    - [0, 0, -1, 0.02]\n", "", &[field, "four rows"]);
    refused("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 0.1, 1.0]", &[field, "last row"]);
    refused("-1, 0.02]", "-1, .nan]", &[field, "NaN"]);
}

#[test]
fn three_decimals_make_a_rotation() {
    let rounded = Matrix3::new(0.766, -0.643, 0.0, 0.643, 0.766, 0.0, 0.0, 0.0, 1.0);
    let exact = orthonormal(&rounded);
    assert!((exact * exact.transpose() - Matrix3::identity()).amax() < 1e-14);
    assert!((exact - rounded).amax() < 1e-3);
}

#[test]
fn nominal_rig_faces_both_ways() {
    let rig = Calibration::nominal().rig([Some((736, 720)), Some((736, 720))]).unwrap();
    let [front, back] = [0, 1].map(|number| *rig.view(number).unwrap());
    let axis = back.rotation * compass_core::vision::camera::Bearing::z();
    assert!(axis.z < -0.999 && (back.position.norm() - 0.038).abs() < 1e-3, "{axis} {}", back.position);
    assert!(front.camera.max_angle() > 96f32.to_radians() && back.camera.max_angle() > 96f32.to_radians());
}
