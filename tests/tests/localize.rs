//! From frames to a pose, from the command line: rendered frames of the sample building, and the recordings.

use compass_host::dataset::tum::{self, Pose};
use compass_host::sample::FRAME_POSE;
use compass_tests::{Folder, angle, compass, number, numbers, recordings, sample_frames};
use image::{Rgb, RgbImage};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Frame size that fits a microcontroller.
const SIZE: (u32, u32) = (368, 360);
const LOCALIZE: &str = "localize --map sample.site --mount inverted";

/// A pose in the hall, upside down and tilted.
fn pose() -> Pose {
    let ([x, y], heading) = FRAME_POSE;
    Pose::looking(1, [x, y, 1.6], heading, 4.0, 187.0)
}

fn frames() -> [RgbImage; 2] {
    sample_frames(&pose(), SIZE)
}

fn folder_with_frames() -> (Folder, &'static str) {
    let folder = Folder::new();
    let options = folder.write_frames(&frames());
    (folder, options)
}

/// Position error in metres and heading error in degrees.
fn errors(answer: &Value, [x, y]: [f64; 2], heading: f64) -> (f64, f64) {
    let metres = (number(&answer["x"]) - x).hypot(number(&answer["y"]) - y);
    (metres, angle(number(&answer["heading_deg"]), heading))
}

#[test]
fn frames_find_their_place() {
    let (folder, options) = folder_with_frames();
    let (at, heading) = FRAME_POSE;
    let answer = folder.json(&format!("{LOCALIZE} {options}"));
    let (metres, degrees) = errors(&answer, at, heading);
    assert!(metres < 0.5 && degrees < 3.0, "{metres} m, {degrees} degrees");
    assert!((number(&answer["camera_height_m"]) - 1.6).abs() < 0.25, "{}", answer["camera_height_m"]);
    assert!(number(&answer["probability"]) > 0.9 && number(&answer["margin"]) > 50.0, "{answer}");
    assert_eq!(numbers(&answer["up_in_cam0"]).len(), 3);
    let candidates = answer["candidates"].as_array().unwrap();
    assert!((2..=10).contains(&candidates.len()));
    let scores: Vec<_> = candidates.iter().map(|c| number(&c["score"])).collect();
    assert!(scores.is_sorted_by(|a, b| a >= b), "{scores:?}");
    for (i, a) in candidates.iter().enumerate() {
        for b in &candidates[..i] {
            let (metres, degrees) = errors(a, [number(&b["x"]), number(&b["y"])], number(&b["heading_deg"]));
            assert!(metres >= 1.0 || degrees >= 20.0, "{a} and {b} are the same place");
        }
    }
    assert_eq!(answer["covariance"], candidates[0]["covariance"]);
    let spreads: Vec<_> = candidates.iter().map(|c| deviations(&c["covariance"])).collect();
    assert!(spreads.iter().flatten().all(|deviation| (0.008..1.0).contains(deviation)), "{spreads:?}");
    assert!(spreads[0][0].max(spreads[0][1]) < 0.2 && spreads[0][2] < 2_f64.to_radians(), "{spreads:?}");
    assert!(answer.get("prior").is_none(), "{answer}");
    let again = folder.json(&format!("{LOCALIZE} {options}"));
    assert_eq!(answer["candidates"], again["candidates"], "the same again is the same");
    // A known height and the truth are accepted. Larger frames: with these, the place found with a wrong ceiling
    // height has the larger lead, though the lower score, and is chosen.
    let _ = folder.write_frames(&sample_frames(&pose(), (2 * SIZE.0, 2 * SIZE.1)));
    let known = folder.json(&format!(
        "{LOCALIZE} {options} --camera-height 1.6 --at {},{} --heading {heading}",
        at[0], at[1]
    ));
    assert!(number(&known["position_error_m"]) < 0.5 && number(&known["heading_error_deg"]) < 3.0, "{known}");
}

/// Standard deviations of x, y (metres) and heading (radians); the matrix is symmetric.
fn deviations(covariance: &Value) -> [f64; 3] {
    let rows: Vec<_> = covariance.as_array().unwrap().iter().map(numbers).collect();
    for (row, column) in [(0, 1), (0, 2), (1, 2)] {
        assert_eq!(rows[row][column], rows[column][row]);
    }
    [0, 1, 2].map(|axis| rows[axis][axis].sqrt())
}

#[test]
fn what_is_told_of_the_pose_restricts_the_search() {
    let (folder, options) = folder_with_frames();
    let ([x, y], heading) = FRAME_POSE;
    let free = folder.json(&format!("{LOCALIZE} {options}"));
    let told = folder
        .json(&format!("{LOCALIZE} {options} --near {x},{y},3 --heading-near {heading},30 --floor sample"));
    let prior = &told["prior"];
    assert_eq!(
        (numbers(&prior["near"]), numbers(&prior["heading_near"])),
        (vec![x, y, 3.0], vec![heading, 30.0])
    );
    assert_eq!(prior["floor"], "sample");
    let (metres, degrees) = errors(&told, [x, y], heading);
    assert!(metres < 0.5 && degrees < 3.0, "{metres} m, {degrees} degrees");
    for candidate in told["candidates"].as_array().unwrap() {
        let (metres, degrees) = errors(candidate, [x, y], heading);
        assert!(metres <= 3.0 && degrees <= 30.0, "{candidate}");
    }
    assert!(told["candidates"].as_array().unwrap().len() < free["candidates"].as_array().unwrap().len());

    // Told to look elsewhere, it does not find the true place, and says where it was told to look.
    let elsewhere = format!("{LOCALIZE} {options} --heading-near {},20 --min-probability 0", heading + 180.0);
    let wrong = folder.json(&elsewhere);
    assert!(errors(&wrong, [x, y], heading).1 >= 160.0, "{wrong}");
    let ran = folder.run(&elsewhere);
    assert!(
        ran.stdout.starts_with("searched heading ") && ran.stdout.contains("+- 20 degrees"),
        "{}",
        ran.stdout
    );
    let ran = folder.run(&format!("{LOCALIZE} {options} --near -500,0,1"));
    assert_eq!(ran.status, Some(1), "{}", ran.stderr);
    assert!(
        ran.stdout.contains("nothing explains the frames where the pose is said to be"),
        "{}",
        ran.stdout
    );
}

#[test]
fn what_is_not_sure_is_not_said() {
    let (folder, options) = folder_with_frames();
    let ran = folder.run(&format!("{LOCALIZE} {options} --min-probability 1 --json -"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(1), ""));
    let answer: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(answer.get("x").is_none() && !answer["candidates"].as_array().unwrap().is_empty(), "{answer}");
    assert!((0.0..1.0).contains(&number(&answer["probability"])));

    // Frames without content give no place, whatever scores best.
    let [front, back] = frames();
    let gray = |frame: &RgbImage| RgbImage::from_pixel(frame.width(), frame.height(), Rgb([90; 3]));
    let _ = folder.write_frames(&[gray(&front), gray(&back)]);
    let ran = folder.run(&format!("{LOCALIZE} {options} --up 0,1,0 --json -"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(1), ""), "{}", ran.stdout);
}

#[test]
fn a_map_too_coarse_is_said() {
    let (folder, options) = folder_with_frames();
    let _ = folder.json("map build sample.png --spacing 2 --out coarse.site");
    let words = "the candidates of the map are 2 m apart";
    for (least, status) in [("0", 0), ("1", 1)] {
        let line = format!("localize --map coarse.site {options} --mount inverted --min-probability {least}");
        let ran = folder.run(&line);
        assert_eq!(ran.status, Some(status), "{}", ran.stderr);
        let said = if status == 0 { &ran.stderr } else { &ran.stdout };
        assert!(said.contains(words), "{}{}", ran.stdout, ran.stderr);
    }
}

#[test]
fn one_camera_works() {
    let folder = Folder::new();
    let _ = folder.write_frames(&sample_frames(&pose(), (736, 720)));
    let (at, heading) = FRAME_POSE;
    let up = pose().up_in_camera();
    let told = format!("--calib rig.yaml --up {},{},{} --camera-height 1.6", up.x, up.y, up.z);
    // The back camera sees three walls of the room, the front one two without windows: ambiguous.
    let answer = folder.json(&format!("{LOCALIZE} {told} --cam1 cam1.png"));
    let (metres, degrees) = errors(&answer, at, heading);
    assert!(metres < 1.0 && degrees < 5.0, "{metres} m, {degrees} degrees");
    let ran = folder.run(&format!("{LOCALIZE} {told} --cam0 cam0.png --json -"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(1), ""), "{}", ran.stdout);
}

#[test]
fn the_plan_decides_which_way_is_up() {
    let folder = Folder::new();
    let (at, heading) = FRAME_POSE;
    for roll in [7.0, 187.0] {
        let pose = Pose::looking(1, [at[0], at[1], 1.6], heading, 4.0, roll);
        let options = folder.write_frames(&sample_frames(&pose, SIZE));
        let answer = folder.json(&format!("localize --map sample.site {options}"));
        let (metres, degrees) = errors(&answer, at, heading);
        assert!(metres < 0.5 && degrees < 3.0, "roll {roll}: {metres} m, {degrees} degrees");
        let mount = if roll > 90.0 { "inverted" } else { "upright" };
        let told = folder.json(&format!("localize --map sample.site {options} --mount {mount}"));
        for key in ["candidates", "up_in_cam0", "bits", "walls"] {
            assert_eq!(answer[key], told[key], "roll {roll}: {key}");
        }
    }
    // Gray frames have no vertical lines: that is an answer, and no bad input.
    let gray = RgbImage::from_pixel(SIZE.0, SIZE.1, Rgb([90; 3]));
    let options = folder.write_frames(&[gray.clone(), gray]);
    let ran = folder.run(&format!("localize --map sample.site {options}"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(1), ""), "{}", ran.stdout);
    for part in ["I don't know", "cannot tell which way is up", "the frame of cam1 shows no detail"] {
        assert!(ran.stdout.contains(part), "{}", ran.stdout);
    }
}

#[test]
fn bad_input_is_refused() {
    let (folder, options) = folder_with_frames();
    let before = folder.names();
    for (line, named) in [
        (format!("localize --map sample.map --mount inverted {options}"), "sample.map"),
        (format!("localize --map none.site {options}"), "none.site"),
        ("localize --map sample.site --cam0 cam0.png".into(), "--calib"),
        ("localize --map sample.site --calib rig.yaml".into(), "--cam0"),
        (format!("{LOCALIZE} {options} --camera-height 9"), "--camera-height"),
        (format!("{LOCALIZE} {options} --camera-height 0.1"), "--camera-height"),
        (format!("{LOCALIZE} {options} --min-probability 2"), "--min-probability"),
        (format!("{LOCALIZE} {options} --near 1,2"), "'1,2' is not X,Y,RADIUS"),
        (format!("{LOCALIZE} {options} --near 1,2,0"), "--near"),
        (format!("{LOCALIZE} {options} --near 1e300,2,3"), "beyond the range of map coordinates"),
        (format!("{LOCALIZE} {options} --heading-near 90"), "--heading-near"),
        (
            format!("{LOCALIZE} {options} --floor attic"),
            "--floor attic: sample.site has no floor of this name, but sample",
        ),
        (format!("{LOCALIZE} {options} --at 1,1"), "--heading"),
        (format!("{LOCALIZE} {options} --from-plan sample.png --at 1,1 --heading 0"), "--from-plan"),
        ("localize --map sample.site --from-plan sample.png".into(), "--at"),
        (
            "localize --map sample.site --from-plan sample.png --at 4,17 --heading 0 --near 4,17,2".into(),
            "--near",
        ),
    ] {
        let ran = folder.run(&line);
        assert_eq!((ran.status, ran.stdout.as_str()), (Some(2), ""), "{line}");
        assert!(ran.stderr.contains(named), "{line}: {}", ran.stderr);
    }
    assert_eq!(folder.names(), before, "nothing is left behind");
}

/// Localizes a recorded pair on a site.
fn locate(site: &Path, data: &Path, frames: [&Path; 2], more: &[&str]) -> Value {
    let mut command = Command::new(compass());
    command.arg("localize").arg("--map").arg(site);
    command.arg("--calib").arg(data.join("hilti/config/kalibr_imucam_chain.yaml"));
    command.arg("--cam0").arg(frames[0]).arg("--cam1").arg(frames[1]);
    command.args(["--mount", "inverted", "--min-probability", "0", "--json", "-"]).args(more);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn recordings_find_their_place() {
    let Some(data) = recordings("recordings_find_their_place") else { return };
    let folder = Folder::new();
    let plans = data.join("hilti/floorplans");
    let site = folder.path("floor_1.site");
    let mut build = Command::new(compass());
    build.args(["map", "build"]).arg(plans.join("masks_with_windows/floor_1.png"));
    build.arg("--walls").arg(plans.join("masks_no_windows/floor_1.png")).arg("--out").arg(&site);
    assert!(build.output().unwrap().status.success());

    // The real pair: its pose was fitted by hand, to 0.2 m and 2 degrees; only the mounting is given.
    let frame = |camera: u8| data.join(format!("hilti/frames/room_pair_cam{camera}.png"));
    let answer = locate(&site, &data, [&frame(0), &frame(1)], &[]);
    let (metres, degrees) = errors(&answer, [36.57, 20.95], -113.5);
    println!("real pair: {metres:.2} m, {degrees:.1} degrees, {answer}");
    assert!(metres < 0.5 && degrees < 3.0, "{metres} m, {degrees} degrees");
    assert_eq!(answer["layer"], "structure", "the partitions of the plan did not stand");
    // The edge is expected a rung (6 %) beyond the drawn line, as in finished rooms, and here it is not: so much is added.
    assert!((number(&answer["camera_height_m"]) - 1.87).abs() < 0.2);

    let rendered = data.join("rendered/floor_1");
    let poses = tum::read(&rendered.join("groundtruth.txt")).unwrap();
    let mut off = Vec::new();
    for pose in &poses {
        let frame = |camera: u8| rendered.join(format!("cam{camera}/data/{}.jpg", pose.timestamp_ns));
        let answer = locate(&site, &data, [&frame(0), &frame(1)], &[]);
        let (metres, degrees) = errors(&answer, [pose.position.x, pose.position.y], pose.heading_deg());
        println!("{}: {metres:.2} m, {degrees:.1} degrees, margin {}", pose.timestamp_ns, answer["margin"]);
        off.push((metres, degrees));
    }
    let right = off.iter().filter(|(metres, degrees)| *metres < 1.0 && *degrees < 10.0).count();
    off.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Measured: 6, with errors of 0.00 to 0.31 m. One of the others stands in a drawn wall, one 0.6 m above the floor.
    assert!(right >= 6, "{right} of {}", off.len());
    assert!(off[3].0 < 0.2 && off[5].0 < 0.5, "{off:?}");
}
