//! Observed hit types against the plan, and the pictures of them, from the command line.
//!
//! Needs the recordings (`COMPASS_DATA`), except for the rejected input.

use compass_tests::{Folder, number, recordings};
use image::GenericImageView as _;
use serde_json::Value;
use std::path::Path;

/// Largest error of the heading at the peak, in degrees.
const PEAK_DEG: f64 = 8.0;

/// The pose of the rig in a room of floor 1, and its up vector.
const POSE: &str = "--at 36.57,20.95 --heading -113.5";
const UP: &str = "--up -0.20068357,0.89218988,0.40462738";

fn calibration(data: &Path) -> String {
    format!("--calib {}", data.join("hilti/config/kalibr_imucam_chain.yaml").display())
}

fn plan(data: &Path) -> String {
    let plans = data.join("hilti/floorplans");
    let [plan, walls] =
        ["masks_with_windows", "masks_no_windows"].map(|name| plans.join(name).join("floor_1.png"));
    format!("--plan {} --walls {}", plan.display(), walls.display())
}

fn frame(data: &Path, camera: u8) -> String {
    data.join(format!("hilti/frames/room_pair_cam{camera}.png")).display().to_string()
}

fn pair(data: &Path) -> String {
    format!("{} --cam0 {} --cam1 {} {UP}", calibration(data), frame(data, 0), frame(data, 1))
}

/// Asserts a picture of the common figure width that is not blank.
fn assert_picture(folder: &Folder, name: &str) {
    let picture = image::open(folder.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(picture.width(), 1600, "{name}");
    let first = picture.get_pixel(0, 0);
    assert!(picture.pixels().filter(|(.., pixel)| *pixel != first).count() > 10_000, "{name}");
}

fn at_peak(scores: &Value) -> [f64; 2] {
    ["at_zero", "peak"].map(|key| number(&scores[key]))
}

#[test]
fn real_frames_agree_with_the_plan() {
    let Some(data) = recordings("real_frames_agree_with_the_plan") else { return };
    let folder = Folder::new();
    let line = format!("compare-hits {POSE} {} {}", pair(&data), plan(&data));
    let built = folder.json(&format!("{line} --structure --figures pictures"));
    println!("{built}");
    assert!(number(&built["peak_shift_deg"]).abs() <= PEAK_DEG);
    let agreeing = &built["agreeing_bins"];
    let share = number(&agreeing["count"]) / number(&agreeing["of"]);
    assert!((share - number(&agreeing["share"])).abs() < 1e-6 && share > 0.8, "{agreeing}");
    for score in ["cosine", "centred"] {
        let [at_zero, peak] = at_peak(&built[score]);
        assert!(at_zero <= peak && peak <= 1.0 && at_zero > 0.6, "{score}: {at_zero} {peak}");
    }
    let cameras = built["windows_per_camera"].as_array().unwrap();
    assert!(cameras.iter().all(|count| number(count) >= 12.0), "{cameras:?}");
    for name in ["hits-linear", "hits-polar", "correlation"] {
        assert_picture(&folder, &format!("pictures/{name}.png"));
    }

    // Interior walls that the shell does not have yet occlude windows of the plan.
    let finished = folder.json(&line);
    assert!(at_peak(&finished["centred"])[1] < at_peak(&built["centred"])[1]);
}

#[test]
fn rendered_frames_agree_with_the_plan() {
    let Some(data) = recordings("rendered_frames_agree_with_the_plan") else { return };
    let (folder, rendered) = (Folder::new(), data.join("rendered/floor_1"));
    let list = |camera: &str| -> Vec<String> {
        let text = std::fs::read_to_string(rendered.join(camera).join("data.csv")).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        rows.map(|row| rendered.join(camera).join("data").join(row.split(',').nth(1).unwrap().trim()))
            .map(|path| path.display().to_string())
            .collect()
    };
    let (cam0, cam1) = (list("cam0"), list("cam1"));
    let truth = std::fs::read_to_string(rendered.join("groundtruth.txt")).unwrap();
    let poses: Vec<_> = truth.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!((poses.len(), cam0.len(), cam1.len()), (8, 8, 8));
    for ((pose, cam0), cam1) in poses.into_iter().zip(cam0).zip(cam1) {
        let pose: Vec<f64> = pose.split_whitespace().map(|field| field.parse().unwrap()).collect();
        let [_, x, y, _, qx, qy, qz, qw] = pose[..] else { panic!("{pose:?}") };
        // The up vector is the map's z in the axes of cam0; the heading is that of the optical axis.
        let up = [2.0 * (qx * qz - qy * qw), 2.0 * (qy * qz + qx * qw), 1.0 - 2.0 * (qx * qx + qy * qy)];
        let heading = (2.0 * (qy * qz - qx * qw)).atan2(2.0 * (qx * qz + qy * qw)).to_degrees();
        let line = format!(
            "compare-hits --at {x},{y} --heading {heading} {} --cam0 {cam0} --cam1 {cam1} --up {},{},{} {} \
             --structure 0.25",
            calibration(&data),
            up[0],
            up[1],
            up[2],
            plan(&data)
        );
        let result = folder.json(&line);
        let centred = at_peak(&result["centred"]);
        println!("{x} {y}: {centred:?} {}", result["peak_shift_deg"]);
        assert!(number(&result["peak_shift_deg"]).abs() <= 2.0 && centred[1] > 0.4, "{result}");
    }
}

#[test]
fn pictures_show_what_was_found() {
    let Some(data) = recordings("pictures_show_what_was_found") else { return };
    let folder = Folder::new();
    let (cam0, camera) = (frame(&data, 0), calibration(&data));
    let seen = folder.json(&format!("see {} {} {POSE} --debug-dir see", pair(&data), plan(&data)));
    assert_eq!(seen["hit"].as_array().unwrap().len(), 360);
    for name in ["cam0_segments", "cam1_segments", "cam0_windows", "cam1_windows", "ring", "polar"] {
        assert_picture(&folder, &format!("see/{name}.png"));
    }
    let level = folder.json(&format!("windows --camera cam0 {camera} {UP} {cam0} --debug-dir level"));
    let paper =
        folder.json(&format!("windows --camera cam0 {camera} {UP} {cam0} --debug-dir paper --method paper"));
    assert_picture(&folder, "level/ring.png");
    assert!(!folder.path("level/cam1_windows.png").exists());
    assert_picture(&folder, "paper/cam0_paper.png");
    let _ = folder.json(&format!("segments {cam0} --debug-dir segments"));
    assert_picture(&folder, "segments/segments.png");

    // The azimuths of the widest windows that both finders find agree.
    let spans = |result: &Value| -> Vec<[f64; 2]> {
        let windows = result["windows"].as_array().unwrap().iter();
        windows.map(|w| [0, 1].map(|end| number(&w["azimuth_deg"][end]))).collect()
    };
    let (level, paper) = (spans(&level), spans(&paper));
    let near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() < 1.5 && (a[1] - b[1]).abs() < 1.5;
    let common = level.iter().filter(|a| paper.iter().any(|b| near(a, b))).count();
    println!("{common} of {} and {}", level.len(), paper.len());
    assert!(paper.iter().all(|[from, to]| from < to) && common >= 6, "{level:?} {paper:?}");
}

#[test]
fn missing_structure_is_refused() {
    let folder = Folder::new();
    for (thickness, named) in [("0", "0 m"), ("9", "at most 5"), ("4", "no wall is 4 m thick")] {
        let ran = folder.run(&format!("describe sample.png --at 13.37,3.68 --structure {thickness}"));
        assert_eq!((ran.status, ran.stderr.lines().count()), (Some(2), 1), "{}", ran.stderr);
        assert!(
            ran.stderr.starts_with("compass: sample.png: ") && ran.stderr.contains(named),
            "{}",
            ran.stderr
        );
    }
    for line in
        ["see --calib a.yaml --cam0 a.png --at 1,2", "see --calib a.yaml --cam0 a.png --plan sample.png"]
    {
        let ran = folder.run(line);
        assert_eq!(ran.status, Some(2), "{line}");
        assert!(ran.stderr.contains("required"), "{line}: {}", ran.stderr);
    }
}
