//! Vision on recordings, and the segments against the reference detector's: needs `COMPASS_DATA`.

use compass_host::compare::segments::coverage;
use compass_tests::{Folder, number, numbers, recordings};
use image::DynamicImage;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::FilterType;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Least mean share of the observed bins that agree with the plan. Measured: 0.858, of the structure alone 0.832.
const AGREEING: f64 = 0.80;
/// Least recall and precision of the labelled windows, and the overlap from which a window counts as found. Measured:
/// 1 and 1.
const FOUND: f64 = 0.85;
const OVERLAP: f64 = 0.3;
/// Largest error of the heading at the peak, in degrees.
const PEAK_DEG: f64 = 8.0;
/// Largest change of the up vector when the frames are reduced or compressed, degrees. Measured: 0.21.
const STABLE_DEG: f64 = 1.0;
/// Least coverage of the reference's segments by ours, and of ours by the reference's. Measured: 0.951.
const COVERAGE: f64 = 0.90;

fn rig(data: &Path) -> String {
    format!("--calib {}", data.join("hilti/config/kalibr_imucam_chain.yaml").display())
}

fn plan(data: &Path) -> String {
    let plans = data.join("hilti/floorplans");
    let [plan, walls] =
        ["masks_with_windows", "masks_no_windows"].map(|name| plans.join(name).join("floor_1.png"));
    format!("--plan {} --walls {}", plan.display(), walls.display())
}

fn room_pair(data: &Path) -> [PathBuf; 2] {
    [0, 1].map(|camera| data.join(format!("hilti/frames/room_pair_cam{camera}.png")))
}

/// Angle between two unit vectors, degrees.
fn between_deg(a: &[f64], b: &[f64]) -> f64 {
    let chord = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    2.0 * (chord / 2.0).min(1.0).asin().to_degrees()
}

/// Position, heading and up vector of a TUM line.
fn pose(line: &str) -> ([f64; 2], f64, [f64; 3]) {
    let fields: Vec<f64> = line.split_whitespace().map(|field| field.parse().unwrap()).collect();
    let [_, x, y, _, qx, qy, qz, qw] = fields[..] else { panic!("{line}") };
    // Up is the map's z in the axes of cam0; the heading is that of the optical axis.
    let up = [2.0 * (qx * qz - qy * qw), 2.0 * (qy * qz + qx * qw), 1.0 - 2.0 * (qx * qx + qy * qy)];
    let heading = (2.0 * (qy * qz - qx * qw)).atan2(2.0 * (qx * qz + qy * qw)).to_degrees();
    ([x, y], heading, up)
}

#[test]
fn rendered_hits_agree_with_the_plan() {
    let Some(data) = recordings("rendered_hits_agree_with_the_plan") else { return };
    let (folder, rendered) = (Folder::new(), data.join("rendered/floor_1"));
    let truth = std::fs::read_to_string(rendered.join("groundtruth.txt")).unwrap();
    let names = std::fs::read_to_string(rendered.join("cam0/data.csv")).unwrap();
    let names = names.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<_> = names.map(|row| row.split(',').nth(1).unwrap().trim()).collect();
    let poses: Vec<_> = truth.lines().filter(|line| !line.starts_with('#')).map(pose).collect();
    assert_eq!((poses.len(), names.len()), (8, 8));
    let (mut agreeing, mut up_errors) = ([0.0, 0.0], Vec::new());
    for (([x, y], heading, [ux, uy, uz]), name) in poses.into_iter().zip(names) {
        let frames = ["cam0", "cam1"]
            .map(|camera| format!("--{camera} {}", rendered.join(camera).join("data").join(name).display()));
        let pair = format!("{} {}", rig(&data), frames.join(" "));
        let line = format!("compare-hits --at {x},{y} --heading {heading} {pair} --up {ux},{uy},{uz}");
        let against = |structure: &str| {
            let ran = folder.run(&format!("{line} {} {structure} --json -", plan(&data)));
            if ran.stderr.contains("position is inside a wall") {
                return None;
            }
            let result: Value = serde_json::from_str(&ran.stdout).unwrap_or_else(|e| panic!("{e}: {ran:?}"));
            assert!(number(&result["agreeing_bins"]["of"]) >= 300.0, "two cameras see nearly all: {result}");
            println!(
                "{x:.1} {y:.1} {structure}: {} peak {}",
                result["agreeing_bins"], result["peak_shift_deg"]
            );
            Some(number(&result["agreeing_bins"]["share"]))
        };
        // The operator walked through walls of the plan that the frames do not have: there the structure is the ground
        // truth.
        let structure = against("--structure").expect("nobody walks through structure");
        let shares = [against("").unwrap_or(structure), structure];
        let gravity = folder.json(&format!("gravity {pair} --mount inverted"));
        let error = between_deg(&numbers(&gravity["up_in_cam0"]), &[ux, uy, uz]);
        println!("  up {error:.3} degrees off");
        up_errors.push(error);
        for (sum, share) in agreeing.iter_mut().zip(shares) {
            *sum += share / 8.0;
        }
    }
    println!("mean agreement {agreeing:?} (whole plan, structure); up {up_errors:?} degrees off");
    assert!(agreeing[0] >= AGREEING, "{agreeing:?}");
    assert!(up_errors.iter().all(|error| *error < STABLE_DEG), "{up_errors:?}");
}

/// The calibration of cam0 for the labelled picture: a frame of 1472 x 1440 reduced to 623 x 601, in a border of 5
/// pixels.
fn write_labelled_calibration(folder: &Folder, data: &Path) {
    let text = std::fs::read_to_string(data.join("hilti/config/kalibr_imucam_chain.yaml")).unwrap();
    let cam0 = text.split("cam1:").next().unwrap();
    let list = |key: &str| -> Vec<f64> {
        let line = cam0.lines().find(|line| line.trim_start().starts_with(key)).unwrap();
        let inside = line.split_once('[').unwrap().1.split_once(']').unwrap().0;
        inside.split(',').map(|field| field.trim().parse().unwrap()).collect()
    };
    let [fx, fy, cx, cy] = list("intrinsics")[..] else { panic!("four intrinsics") };
    assert_eq!(list("resolution"), [1472.0, 1440.0]);
    let (sx, sy) = (623.0 / 1472.0, 601.0 / 1440.0);
    let centre = |c: f64, s: f64| (c + 0.5) * s - 0.5 + 5.0;
    let mut yaml = String::from(
        "cam0:\n  camera_model: pinhole\n  distortion_model: equidistant\n  resolution: [638, 614]\n",
    );
    let _ = writeln!(yaml, "  distortion_coeffs: {:?}", list("distortion_coeffs"));
    let _ = writeln!(yaml, "  intrinsics: {:?}", [fx * sx, fy * sy, centre(cx, sx), centre(cy, sy)]);
    folder.write("small.yaml", yaml.as_bytes());
}

/// Intersection over union of two boxes.
fn overlap(a: &[f64], b: &[f64]) -> f64 {
    let shared = |k: usize| (a[k + 2].min(b[k + 2]) - a[k].max(b[k])).max(0.0);
    let area = |c: &[f64]| (c[2] - c[0]) * (c[3] - c[1]);
    let both = shared(0) * shared(1);
    both / (area(a) + area(b) - both)
}

/// Recall and precision of the windows found: each label is matched once, and the optional ones do not count.
fn recall_and_precision(found: &Value, labels: &Value) -> [f64; 2] {
    let boxes = |value: &Value| -> Vec<Vec<f64>> { value.as_array().unwrap().iter().map(numbers).collect() };
    let (wanted, optional) = (boxes(&labels["windows"]), boxes(&labels["optional"]));
    let found: Vec<_> = found["windows"].as_array().unwrap().iter().map(|w| numbers(&w["box"])).collect();
    let mut pairs = Vec::new();
    for (i, label) in wanted.iter().enumerate() {
        pairs.extend(found.iter().enumerate().map(|(j, window)| (overlap(label, window), i, j)));
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut labels_left, mut found_left) = (vec![true; wanted.len()], vec![true; found.len()]);
    for (overlap, i, j) in pairs {
        if overlap >= OVERLAP && labels_left[i] && found_left[j] {
            (labels_left[i], found_left[j]) = (false, false);
        }
    }
    let hits = labels_left.iter().filter(|left| !**left).count() as f64;
    let is_optional = |window: &[f64]| optional.iter().any(|label| overlap(label, window) >= OVERLAP);
    let wrong = found.iter().zip(found_left).filter(|(window, left)| *left && !is_optional(window)).count();
    println!("{hits} of {} labels, {wrong} wrong of {}", wanted.len(), found.len());
    [hits / wanted.len() as f64, hits / (hits + wrong as f64).max(1.0)]
}

#[test]
fn labelled_windows_are_found() {
    let Some(data) = recordings("labelled_windows_are_found") else { return };
    let folder = Folder::new();
    write_labelled_calibration(&folder, &data);
    let frames = data.join("hilti/frames");
    let labels = std::fs::read(frames.join("back_camera_room.windows.json")).unwrap();
    let labels: Value = serde_json::from_slice(&labels).unwrap();
    let picture = frames.join("back_camera_room.png");
    let line = format!("windows --calib small.yaml --camera cam0 {}", picture.display());

    let told = folder.json(&format!("{line} --up -0.13934893,0.88098253,0.45214382"));
    let [recall, precision] = recall_and_precision(&told, &labels);
    println!("told up: recall {recall:.3}, precision {precision:.3}");

    // That up vector was estimated as well.
    let gravity =
        folder.run(&format!("gravity --calib small.yaml --cam0 {} --mount inverted", picture.display()));
    println!("{}{}", gravity.stdout, gravity.stderr);
    let alone = folder.json(&format!("{line} --mount inverted"));
    let [own_recall, own_precision] = recall_and_precision(&alone, &labels);
    println!("own up: recall {own_recall:.3}, precision {own_precision:.3}");
    assert!(own_recall >= FOUND && own_precision >= FOUND, "{own_recall} {own_precision}: {alone}");
    assert!(recall >= FOUND && precision >= FOUND, "{recall} {precision}: {told}");
}

#[test]
fn a_real_pair_knows_its_heading() {
    let Some(data) = recordings("a_real_pair_knows_its_heading") else { return };
    let folder = Folder::new();
    let [cam0, cam1] = room_pair(&data);
    let line = format!(
        "compare-hits --at 36.57,20.95 --heading -113.5 {} --cam0 {} --cam1 {} --mount inverted {} --structure",
        rig(&data),
        cam0.display(),
        cam1.display(),
        plan(&data)
    );
    let result = folder.json(&line);
    println!("{result}");
    assert!(number(&result["peak_shift_deg"]).abs() <= PEAK_DEG, "{result}");
    assert!(number(&result["agreeing_bins"]["share"]) >= AGREEING, "{result}");
}

#[test]
fn up_is_stable_in_smaller_and_compressed_frames() {
    let Some(data) = recordings("up_is_stable_in_smaller_and_compressed_frames") else { return };
    let folder = Folder::new();
    let images = room_pair(&data).map(|path| image::open(path).unwrap());
    let up = |name: &str| {
        let line = format!("gravity {} --cam0 {name}.0 --cam1 {name}.1 --mount inverted", rig(&data));
        let result = folder.json(&line);
        println!("{name}: {result}");
        numbers(&result["up_in_cam0"])
    };
    // The file name makes no difference.
    let write = |name: &str, camera: usize, image: &DynamicImage, quality: Option<u8>| {
        let mut file = std::fs::File::create(folder.path(&format!("{name}.{camera}"))).unwrap();
        match quality {
            Some(quality) => JpegEncoder::new_with_quality(file, quality).encode_image(image).unwrap(),
            None => image.write_to(&mut std::io::BufWriter::new(&mut file), image::ImageFormat::Png).unwrap(),
        }
    };
    for (camera, image) in images.iter().enumerate() {
        let half = image.resize_exact(image.width() / 2, image.height() / 2, FilterType::Triangle);
        write("whole", camera, image, None);
        write("half", camera, &half, None);
        write("compressed", camera, image, Some(50));
        write("both", camera, &half, Some(50));
    }
    let whole = up("whole");
    for name in ["half", "compressed", "both"] {
        let off = between_deg(&up(name), &whole);
        println!("{name}: {off:.3} degrees");
        assert!(off <= STABLE_DEG, "{name}: {off} degrees");
    }
}

/// The two ends of each segment of a table with a heading.
fn read_segments(text: &str) -> Vec<[[f64; 2]; 2]> {
    let ends = |row: &str| {
        let fields: Vec<f64> = row.split(',').take(4).map(|field| field.trim().parse().unwrap()).collect();
        let [x1, y1, x2, y2] = fields[..] else { panic!("{row}") };
        [[x1, y1], [x2, y2]]
    };
    text.lines().skip(1).map(ends).collect()
}

#[test]
fn segments_cover_those_of_the_reference() {
    let Some(data) = recordings("segments_cover_those_of_the_reference") else { return };
    let reference = data.join("../reference/elsed");
    if !reference.is_dir() {
        eprintln!("SKIPPED segments_cover_those_of_the_reference: no reference beside COMPASS_DATA");
        return;
    }
    let folder = Folder::new();
    let mut worst = 1.0_f64;
    for name in ["back_camera_room", "P1020829", "indoor_1"] {
        let image = reference.join(format!("{name}.png"));
        let result = folder.json(&format!("segments {} --csv ours.csv", image.display()));
        let ours = read_segments(&String::from_utf8(folder.read("ours.csv")).unwrap());
        assert_eq!(ours.len() as f64, number(&result["count"]));
        let theirs = read_segments(&std::fs::read_to_string(reference.join(format!("{name}.csv"))).unwrap());
        let (found, back) = (coverage(&theirs, &ours), coverage(&ours, &theirs));
        println!("{name}: {} of {}; {found:.3} found, {back:.3} back", ours.len(), theirs.len());
        worst = worst.min(found).min(back);
    }
    assert!(worst >= COVERAGE, "{worst}");
}
