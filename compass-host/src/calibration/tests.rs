use super::*;
use crate::reference::camera::Model;
use nalgebra::{Matrix3, Vector3};

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
    let loaded = load(&GOOD.replacen(from, to, 1));
    let message = line(&loaded.and_then(|calibration| calibration.all_valid()).unwrap_err());
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
    for other in [
        GOOD.replace("%YAML:1.0", "%YAML 1.2\n---"),
        GOOD.replace("%YAML:1.0\n", ""),
        GOOD.replace("%YAML:1.0", "# Licence: none.\n\n  # more\n%YAML:1.0\n---"),
        GOOD.replace("[800, 600]", "[\"800\", '600']"),
    ] {
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
    refused("430, 431, 402, 300", "fine", &["cam0.intrinsics", "['fine']", "list of numbers"]);
    refused("[800, 600]", "800x600", &["cam0.resolution", "'800x600'"]);
    refused("[430, 431, 402, 300]", "{fx: 430}", &["cam0.intrinsics", "a table"]);
    refused("camera_model: pinhole", "camera_model: [pinhole]", &["cam0.camera_model", "a name"]);
    for model in ["fov", "plumb_bob"] {
        refused("equidistant", model, &["cam0.distortion_model", model]);
    }
    for model in ["fisheye", "pinhole-equi"] {
        refused("pinhole", model, &["cam0.camera_model", &format!("'{model}'")]);
    }
    refused("pinhole", "omni", &["cam0.distortion_model", "'equidistant'", "omni with radtan"]);
    refused("pinhole", "ds", &["cam0.distortion_model", "ds takes none"]);
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
fn nominal_rig_faces_both_ways() {
    let rig = Calibration::nominal().rig([Some((736, 720)), Some((736, 720))]).unwrap();
    let [front, back] = [0, 1].map(|number| *rig.view(number).unwrap());
    let axis = back.rotation * compass_core::vision::camera::Bearing::z();
    assert!(axis.z < -0.999 && (back.position.norm() - 0.038).abs() < 1e-3, "{axis} {}", back.position);
    assert!(front.camera.max_angle() > 96f32.to_radians() && back.camera.max_angle() > 96f32.to_radians());
}

/// The good file with cam0 of another model.
fn with_cam0(camera_model: &str, distortion_model: &str, intrinsics: &str, coefficients: &str) -> String {
    GOOD.replacen("camera_model: pinhole", &format!("camera_model: {camera_model}"), 1)
        .replacen("equidistant", distortion_model, 1)
        .replacen("[430, 431, 402, 300]", intrinsics, 1)
        .replacen("[0.02, -0.01, -0.001, 0.0001]", coefficients, 1)
}

#[test]
fn every_model_of_kalibr_is_read() {
    let model = |camera_model, distortion_model, intrinsics, coefficients| {
        let calibration = load(&with_cam0(camera_model, distortion_model, intrinsics, coefficients)).unwrap();
        calibration.all_valid().unwrap();
        let camera = calibration.cameras[0].as_ref().unwrap().camera;
        assert_eq!((camera.focal, camera.centre), ([430.0, 431.0], [402.0, 300.0]));
        calibration.rig(BOTH).unwrap();
        camera.model
    };
    let radtan = [-0.1, 0.02, 0.001, -0.002, 0.0];
    let (pinhole, coefficients) = ("[430, 431, 402, 300]", "[-0.1, 0.02, 0.001, -0.002]");
    let omni = "[1.2, 430, 431, 402, 300]";
    assert_eq!(
        model("ds", "none", "[-0.2, 0.59, 430, 431, 402, 300]", "[]"),
        Model::DoubleSphere { xi: -0.2, alpha: 0.59 }
    );
    assert_eq!(model("omni", "radtan", omni, coefficients), Model::Omni { xi: 1.2, distortion: radtan });
    assert_eq!(model("omni", "none", omni, "[]"), Model::Omni { xi: 1.2, distortion: [0.0; 5] });
    assert_eq!(
        model("pinhole", "radtan", pinhole, coefficients),
        Model::Omni { xi: 0.0, distortion: radtan }
    );
    assert_eq!(model("pinhole", "none", pinhole, "[]"), Model::Omni { xi: 0.0, distortion: [0.0; 5] });
}

#[test]
fn lenses_that_make_no_sense_are_refused_by_field() {
    let message = |camera_model, distortion_model, intrinsics, coefficients| {
        let text = with_cam0(camera_model, distortion_model, intrinsics, coefficients);
        line(&load(&text).unwrap().all_valid().unwrap_err())
    };
    let omni = "[1.2, 430, 431, 402, 300]";
    for (found, named) in [
        (message("ds", "none", "[-1.2, 0.59, 430, 431, 402, 300]", "[]"), "cam0.intrinsics: xi"),
        (message("ds", "none", "[0.59, 430, 431, 402, 300]", "[]"), "xi, alpha, fx"),
        (message("omni", "radtan", "[430, 431, 402, 300]", "[0, 0, 0, 0]"), "xi, fx, fy"),
        (message("omni", "radtan", "[-1, 430, 431, 402, 300]", "[0, 0, 0, 0]"), "cam0.intrinsics: xi"),
        (message("omni", "radtan", omni, "[0, 0]"), "[k1, k2, p1, p2]"),
        (message("omni", "radtan", omni, "[0, 0, 0, 0, 0, 0.1]"), "rational"),
        (message("omni", "radtan", omni, "[-900, 0, 0, 0]"), "cam0.distortion_coeffs: coefficients give"),
        (message("omni", "none", omni, "[0.1, 0, 0, 0]"), "takes no coefficients"),
    ] {
        assert!(found.contains(named), "{named}: {found}");
    }
}

#[test]
fn transforms_are_read_either_way_round() {
    let calibration = load(GOOD).unwrap();
    let expected = calibration.cameras[0].as_ref().unwrap().from_imu.unwrap();
    let back = transform::inverse(&expected);
    let rows: Vec<_> = back.row_iter().map(|row| format!("{:?}", row.iter().collect::<Vec<_>>())).collect();
    let old = GOOD[..GOOD.find("  cam_overlaps").unwrap()].to_owned();
    let old = &old[old.find("  T_cam_imu").unwrap()..];
    let openvins = format!("  T_imu_cam: [{}]\n", rows.join(", "));
    let flat: Vec<_> = back.transpose().iter().map(f64::to_string).collect();
    let opencv = format!(
        "  T_imu_cam: !!opencv-matrix\n    rows: 4\n    cols: 4\n    dt: d\n    data: [{}]\n",
        flat.join(", ")
    );
    for other in [&openvins, &opencv, &(openvins.clone() + old)] {
        let read = load(&GOOD.replacen(old, other, 1)).unwrap();
        let found = read.cameras[0].as_ref().unwrap().from_imu.unwrap();
        assert!((found - expected).amax() < 1e-9, "{other}");
        let (a, b) = (read.rig(BOTH).unwrap(), calibration.rig(BOTH).unwrap());
        assert!((a.view(1).unwrap().position - b.view(1).unwrap().position).amax() < 1e-6);
    }
    let both = GOOD.replacen(old, &(openvins.replace("0.02", "0.03") + old), 1);
    let message = line(&load(&both).unwrap().all_valid().unwrap_err());
    assert!(message.contains("cam0.T_imu_cam"), "{message}");
}

#[test]
fn a_camera_that_is_not_asked_for_may_be_anything() {
    let other = GOOD.replacen("camera_model: eucm", "camera_model: fov", 1);
    let calibration = load(&other).unwrap();
    assert!(calibration.rig([BOTH[0], None]).is_ok());
    let message = line(&calibration.rig(BOTH).unwrap_err());
    assert!(message.contains("cam1.camera_model") && message.contains("'fov'"), "{message}");
    assert!(calibration.cameras[1].is_none() && calibration.all_valid().is_err());
}

#[test]
fn any_two_cameras_of_a_chain_make_a_rig() {
    let step = |name: &str, z: f64| {
        let camera = &GOOD[GOOD.find("  camera_model: eucm").unwrap()..];
        format!("{name}:\n{camera}  T_cn_cnm1: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, {z}], [0, 0, 0, 1]]\n")
    };
    let first = step("cam0", 9.0).replace("T_cn_cnm1", "unread");
    let chain = format!("{}{}{first}{}", step("cam10", 1000.0), step("cam2", 100.0), step("cam1", 10.0));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.yaml");
    std::fs::write(&path, chain).unwrap();
    let rig = |names: &str| {
        let calibration = Calibration::load_cameras(&path, &names.parse().unwrap())?;
        let sizes = calibration.cameras.each_ref().map(|camera| Some(camera.as_ref()?.resolution));
        Ok::<_, CalibrationError>(calibration.rig(sizes)?.view(1).map(|view| view.position.z))
    };
    assert_eq!(rig("cam0,cam1").unwrap(), Some(-10.0));
    assert_eq!(rig("cam0,cam2").unwrap(), Some(-110.0));
    assert_eq!(rig("cam10,cam1").unwrap(), Some(1100.0));
    assert_eq!(rig("cam2").unwrap(), None);
    let message = line(&rig("cam7,cam9").unwrap_err());
    assert!(message.contains("no cam7 and no cam9, but cam0, cam1, cam2, cam10"), "{message}");
    for bad in ["", ",", "cam0,cam1,cam2", "cam1,cam1"] {
        assert!(bad.parse::<CameraNames>().is_err(), "{bad}");
    }
}

#[test]
fn a_camera_info_is_one_camera() {
    let info = "image_width: 800\nimage_height: 600\ncamera_name: front\ncamera_matrix:\n  rows: 3\n  cols: 3\n  \
                data: [430, 0, 402, 0, 431, 300, 0, 0, 1]\ndistortion_model: equidistant\n\
                distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [0.02, -0.01, -0.001, 0.0001]\n\
                rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
    let lens = |text: &str| load(text).map(|calibration| calibration.cameras[0].clone().unwrap().camera);
    let expected = load(GOOD).unwrap().cameras[0].as_ref().unwrap().camera;
    assert_eq!(lens(info).unwrap(), expected);
    assert!(line(&load(info).unwrap().rig(BOTH).unwrap_err()).contains("cam1: this camera is asked for"));
    let plumb_bob = info.replace("equidistant", "plumb_bob").replace("0.0001]", "0.0001, 0.03]");
    let distortion = [0.02, -0.01, -0.001, 0.0001, 0.03];
    assert_eq!(lens(&plumb_bob).unwrap().model, Model::Omni { xi: 0.0, distortion });
    for (from, to, named) in [
        ("equidistant", "mystery", "distortion_model: 'mystery'"),
        ("[430, 0,", "[0, 0,", "camera_matrix: focal"),
        ("image_height: 600", "image_height: many", "image_width, image_height"),
    ] {
        let message = line(&lens(&info.replace(from, to)).unwrap_err());
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn a_calibration_of_basalt_is_read() {
    let text = r#"{"value0": {
        "T_imu_cam": [
            {"px": 0, "py": 0, "pz": 0.1, "qx": 0, "qy": 0, "qz": 0, "qw": 1},
            {"px": 0, "py": 0, "pz": -0.1, "qx": 0, "qy": 1, "qz": 0, "qw": 0}],
        "intrinsics": [
            {"camera_type": "ds", "intrinsics":
                {"fx": 150, "fy": 151, "cx": 400, "cy": 300, "xi": -0.2, "alpha": 0.57}},
            {"camera_type": "kb4", "intrinsics":
                {"fx": 150, "fy": 151, "cx": 400, "cy": 300, "k1": 0.02, "k2": -0.01, "k3": 0, "k4": 0}}],
        "resolution": [[800, 600], [800, 600]],
        "cam_time_offset_ns": -6000000}}"#;
    let calibration = load(text).unwrap();
    let [Some(cam0), Some(cam1)] = &calibration.cameras else { panic!("{calibration:?}") };
    assert_eq!(cam0.camera.model, Model::DoubleSphere { xi: -0.2, alpha: 0.57 });
    assert_eq!(cam1.camera.model, Model::KannalaBrandt([0.02, -0.01, 0.0, 0.0]));
    assert_eq!((cam0.camera.focal, cam0.camera.centre), ([150.0, 151.0], [400.0, 300.0]));
    assert_eq!((cam0.resolution, cam0.timeshift_s), ((800, 600), -0.006));
    let back = *calibration.rig(BOTH).unwrap().view(1).unwrap();
    assert!((back.position - Vector3::new(0.0, 0.0, -0.2)).amax() < 1e-6, "{}", back.position);
    assert!((back.rotation - Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0))).amax() < 1e-6);
    let fov = load(&text.replace("\"ds\"", "\"fov\"")).unwrap().all_valid().unwrap_err();
    assert!(line(&fov).contains("value0.intrinsics[0].camera_type: 'fov'"), "{fov}");
}

#[test]
fn other_files_are_named() {
    for (text, named) in [
        ("model_type: MEI\nmirror_parameters: {xi: 1}\n", "VINS"),
        ("sensor_type: camera\nT_BS: {data: [1]}\n", "sensor.yaml"),
        ("image: a.png\nresolution: 0.05\n", "map_server"),
        ("[1, 2]", "not a calibration"),
        ("cam0: [unclosed", "not valid YAML"),
    ] {
        let message = line(&load(text).unwrap_err());
        assert!(message.contains(named), "{message}");
    }
}
