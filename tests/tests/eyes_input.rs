//! The commands with camera frames on bad input (exit status 2, one line that names the fault, no files left behind)
//! and on good but unusual input.

use compass_host::calibration::NOMINAL_YAML;
use compass_host::dataset::tum::Pose;
use compass_tests::{Folder, Ran, number, numbers, sample_frames};
use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage};
use serde_json::Value;
use std::io::Cursor;
use std::sync::OnceLock;

const UP: &str = "--up 0.25846434,0.96460206,-0.05233596";

/// Most degrees of hit type that may change with compression or without colour. Measured: 20, one window.
const MOST_OFF: usize = 30;
/// Most windows in frames without content. Measured: 0.
const MOST_IN_NOTHING: usize = 2;

/// Frames of half the size with windows in both: facade rooms in the corner of the building.
fn frames() -> &'static [RgbImage; 2] {
    static FRAMES: OnceLock<[RgbImage; 2]> = OnceLock::new();
    FRAMES.get_or_init(|| {
        let pose = Pose::looking(4, [4.12, 17.77, 1.6], 288.6, -3.0, 195.0);
        sample_frames(&pose, (368, 360))
    })
}

/// A folder with the frames and `rig.yaml`.
fn folder() -> Folder {
    let folder = Folder::new();
    let _ = folder.write_frames(frames());
    folder
}

/// Runs `line`, which must leave the folder unchanged, and must not panic.
fn run(folder: &Folder, line: &str) -> Ran {
    let before = folder.names();
    let ran = folder.run(line);
    assert!(!ran.stderr.contains("panicked"), "{line}: {}", ran.stderr);
    let left: Vec<_> = folder.names().symmetric_difference(&before).cloned().collect();
    assert!(left.is_empty(), "{line}: left {left:?}");
    ran
}

/// Runs `line`, which must be rejected in one line that contains all of `named`.
fn refused(folder: &Folder, line: &str, named: &[&str]) {
    let Ran { status, stdout, stderr } = run(folder, line);
    assert_eq!((status, stdout.as_str()), (Some(2), ""), "{line}: {stderr}");
    assert!(stderr.starts_with("compass: ") && stderr.ends_with('\n'), "{line}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{line}: {stderr}");
    for name in named {
        assert!(stderr.contains(name), "{line}: no '{name}' in {stderr}");
    }
}

/// Runs `line`, which the command line parser must reject; its message may have several lines.
fn misused(folder: &Folder, line: &str, named: &[&str]) {
    let Ran { status, stdout, stderr } = run(folder, line);
    assert_eq!((status, stdout.as_str()), (Some(2), ""), "{line}: {stderr}");
    for name in named {
        assert!(stderr.contains(name), "{line}: no '{name}' in {stderr}");
    }
}

/// Every command that takes frames, with `file` in place of one; each would write a file and a folder.
fn with_frame(file: &str, calibration: &str) -> [String; 5] {
    let out = "--json out.json";
    let pictures = "--debug-dir pictures";
    [
        format!("windows --calib {calibration} --camera cam0 {file} {UP} {pictures} {out}"),
        format!("windows --calib {calibration} --camera cam0 {file} {UP} --method paper {pictures} {out}"),
        format!("gravity --calib {calibration} --cam0 {file} --cam1 cam1.png {out}"),
        format!("see --calib {calibration} --cam0 {file} --cam1 cam1.png {UP} {pictures} {out}"),
        format!(
            "compare-hits sample.png --at 4.12,17.77 --heading 288 --calib {calibration} --cam0 cam0.png \
             --cam1 {file} {UP} --figures figures {out}"
        ),
    ]
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn what_is_no_frame() {
    let folder = folder();
    let jpeg = encoded(&frames()[0].clone().into(), ImageFormat::Jpeg);
    let png = folder.read("cam0.png");
    folder.write("half.jpg", &jpeg[..jpeg.len() / 2]);
    folder.write("end.jpg", &jpeg[..jpeg.len() * 9 / 10]);
    folder.write("head.jpg", &jpeg[..20]);
    folder.write("half.png", &png[..png.len() / 2]);
    folder.write("text.png", b"a view of the room\n");
    folder.write("empty.png", b"");
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    for (file, problem) in [
        ("half.jpg", "truncated"),
        ("end.jpg", "truncated"),
        ("head.jpg", "truncated"),
        ("half.png", "truncated"),
        ("text.png", "not a PNG"),
        ("empty.png", "not a PNG"),
        ("folder.png", "cannot be read"),
        ("missing.png", "cannot be read"),
    ] {
        for line in with_frame(file, "rig.yaml") {
            refused(&folder, &line, &[file, problem]);
        }
        refused(&folder, &format!("segments {file} --csv s.csv --debug-dir pictures"), &[file, problem]);
    }
}

#[test]
fn frames_of_another_shape() {
    let folder = folder();
    let frame = &frames()[0];
    let resized =
        |width, height| image::imageops::resize(frame, width, height, image::imageops::FilterType::Triangle);
    resized(368, 340).save(folder.path("low.png")).unwrap();
    resized(360, 368).save(folder.path("turned.png")).unwrap();
    resized(1, 1).save(folder.path("dot.png")).unwrap();
    for line in with_frame("low.png", "rig.yaml") {
        refused(&folder, &line, &["rig.yaml: cam", "736 x 720", "368 x 340", "not the same shape"]);
    }
    for line in with_frame("turned.png", "rig.yaml") {
        refused(&folder, &line, &["rig.yaml: cam", "360 x 368", "swapped"]);
    }
    // A square can be a frame of 736 x 720 reduced to a few pixels.
    for line in with_frame("dot.png", "rig.yaml") {
        let Ran { status, stderr, .. } = folder.run(&line);
        let refused = matches!(status, Some(1 | 2)) && stderr.lines().count() == 1;
        assert!(status == Some(0) || refused, "{line}: {stderr}");
    }
}

#[test]
fn cameras_that_are_not_there() {
    let folder = folder();
    let cam0 = NOMINAL_YAML.split("cam1:").next().unwrap();
    folder.write("front.yaml", cam0.as_bytes());
    refused(
        &folder,
        "windows --calib front.yaml --camera cam1 cam1.png",
        &["front.yaml: cam1", "not in the file"],
    );
    for line in with_frame("cam0.png", "front.yaml").into_iter().skip(2) {
        refused(&folder, &line, &["front.yaml: cam1", "not in the file"]);
    }
    let alone = folder.json(&format!("windows --calib front.yaml --camera cam0 cam0.png {UP}"));
    let both = folder.json(&format!("windows --calib rig.yaml --camera cam0 cam0.png {UP}"));
    assert_eq!(alone, both);
    // cam1 alone needs its extrinsics.
    let floating =
        NOMINAL_YAML.lines().filter(|line| !line.contains("T_cn_cnm1") && !line.starts_with("    - "));
    folder.write("floating.yaml", floating.collect::<Vec<_>>().join("\n").as_bytes());
    let line = "see --calib floating.yaml --cam1 cam1.png";
    refused(&folder, &format!("{line} {UP}"), &["floating.yaml: cam1.T_cn_cnm1", "missing"]);

    for command in ["see", "gravity", "compare-hits sample.png --at 4.12,17.77 --heading 288"] {
        refused(&folder, &format!("{command} --calib rig.yaml --json out.json"), &["no frame", "--cam0"]);
        misused(&folder, &format!("{command} --cam0 cam0.png --json out.json"), &["--calib"]);
    }
    misused(&folder, "windows --calib rig.yaml --camera cam2 cam0.png", &["--camera", "cam2"]);
    misused(&folder, "windows --calib rig.yaml --camera cam0", &["IMAGE"]);
}

#[test]
fn invalid_up_vectors_are_refused() {
    let folder = folder();
    let pair = "--calib rig.yaml --cam0 cam0.png --cam1 cam1.png";
    let lines = [
        format!("see {pair} --debug-dir pictures --json out.json"),
        "windows --calib rig.yaml --camera cam0 cam0.png --debug-dir pictures --json out.json".to_owned(),
        format!("compare-hits sample.png --at 4.12,17.77 --heading 288 {pair} --figures f --json out.json"),
    ];
    for line in lines {
        for up in ["0,0,0", "0,1", "0,1,0,0", "up", "0,nan,1", "0,inf,0", "1e-9,0,0"] {
            misused(&folder, &format!("{line} --up {up}"), &["--up", up]);
        }
        for up in ["0,0,1", "0,0,-2", "0.00001,0,1"] {
            refused(&folder, &format!("{line} --up {up}"), &["up vector", "optical axis"]);
        }
        misused(&folder, &format!("{line} --mount sideways"), &["--mount", "sideways"]);
    }
    // Of an up vector only the direction counts.
    let hits = |up: &str| folder.json(&format!("see {pair} --up {up}"))["hit"].clone();
    assert_eq!(hits("0,1,0"), hits("0,1000,0"));
}

#[test]
fn calibrations_that_make_no_sense() {
    let folder = folder();
    let line = |name: &str| with_frame("cam0.png", name);
    for line in line("missing.yaml") {
        refused(&folder, &line, &["missing.yaml: cannot be read"]);
    }
    // All values of the first camera are changed before those of the second.
    for (from, to, named) in [
        ("  camera_model: pinhole\n", "", &["cam0.camera_model", "missing"][..]),
        ("  distortion_model: equidistant\n", "", &["cam0.distortion_model", "missing"]),
        ("  intrinsics: [232.0, 232.2, 366.4, 360.3]\n", "", &["cam0.intrinsics", "missing"]),
        ("  distortion_coeffs: [0.024, -0.0105, -0.0016, 0.00014]\n", "", &["cam0.distortion_coeffs"]),
        ("  resolution: [736, 720]\n", "", &["cam0.resolution", "missing"]),
        ("[232.0, 232.2, 366.4, 360.3]", "[232.0, 232.2, 366.4]", &["cam0.intrinsics"]),
        ("[232.0, 232.2, 366.4, 360.3]", "[232.0, 232.2, 366.4, 360.3, 1]", &["cam0.intrinsics"]),
        ("[0.024, -0.0105, -0.0016, 0.00014]", "[0.024, -0.0105]", &["cam0.distortion_coeffs"]),
        ("[736, 720]", "[736]", &["cam0.resolution"]),
        ("[736, 720]", "[736, 720, 3]", &["cam0.resolution"]),
        ("[736, 720]", "[736, -720]", &["cam0.resolution"]),
        ("[736, 720]", "[736, 0]", &["cam0.resolution"]),
        ("[232.0,", "[0,", &["cam0.intrinsics", "focal"]),
        ("[232.0,", "[-232,", &["cam0.intrinsics", "focal"]),
        ("[232.0,", "[.nan,", &["cam0.intrinsics"]),
        ("[232.0,", "[.inf,", &["cam0.intrinsics"]),
        ("366.4,", ".nan,", &["cam0.intrinsics"]),
        ("366.4,", "36640,", &["cam0.intrinsics"]),
        ("[0.024,", "[.nan,", &["cam0.distortion_coeffs"]),
        ("[232.0,", "[wide,", &["cam0.intrinsics", "wide"]),
        ("pinhole", "omni", &["cam0.distortion_model", "omni"]),
        ("pinhole", "spherical", &["cam0.camera_model", "spherical"]),
        ("equidistant", "fov", &["cam0.distortion_model", "fov"]),
        ("cam0:", "cam0", &[]),
    ] {
        assert!(NOMINAL_YAML.contains(from), "{from}");
        folder.write("bad.yaml", NOMINAL_YAML.replacen(from, to, 1).as_bytes());
        for line in line("bad.yaml") {
            refused(&folder, &line, &[&["bad.yaml: "], named].concat());
        }
    }
    for (from, to, named) in [
        ("[-0.999975,", "[.nan,", "cam1.T_cn_cnm1"),
        ("[-0.999975,", "[0.5,", "cam1.T_cn_cnm1"),
        ("    - [0.0, 0.0, 0.0, 1.0]\n", "", "cam1.T_cn_cnm1"),
        ("-0.038]", "-0.038, 1]", "cam1.T_cn_cnm1"),
    ] {
        assert!(NOMINAL_YAML.contains(from), "{from}");
        folder.write("bad.yaml", NOMINAL_YAML.replacen(from, to, 1).as_bytes());
        // `windows` asks for cam0 alone, and a camera that is not asked for is not refused.
        for line in line("bad.yaml").iter().filter(|line| !line.starts_with("windows")) {
            refused(&folder, line, &["bad.yaml: ", named]);
        }
    }
    for bytes in [&b""[..], b"\n", b"cam2: {}\n", b"- 1\n", b"\xff\xfe\x00", b"cam0: [", b"cam0: {}\n"] {
        folder.write("bad.yaml", bytes);
        for line in line("bad.yaml") {
            refused(&folder, &line, &["bad.yaml: "]);
        }
    }
    folder.write("bad.yaml", &folder.read("cam0.png"));
    for line in line("bad.yaml") {
        refused(&folder, &line, &["bad.yaml: "]);
    }
}

/// The azimuths of the windows in the frame of cam1.
fn windows(folder: &Folder, file: &str) -> Vec<[f64; 2]> {
    let result = folder.json(&format!("windows --calib rig.yaml --camera cam1 {file} {UP}"));
    let span = |window: &Value| <[f64; 2]>::try_from(numbers(&window["azimuth_deg"])).unwrap();
    result["windows"].as_array().unwrap().iter().map(span).collect()
}

fn covers(spans: &[[f64; 2]], azimuth: f64) -> bool {
    spans.iter().any(|[from, to]| (azimuth - from).rem_euclid(360.0) <= to - from)
}

/// Degrees in which only one of the two has a window.
fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> usize {
    (0..360).filter(|&degree| covers(a, f64::from(degree)) != covers(b, f64::from(degree))).count()
}

#[test]
fn the_kind_of_file_makes_no_difference() {
    let folder = folder();
    let frame = DynamicImage::from(frames()[1].clone());
    let save = |name: &str, image: DynamicImage| image.save(folder.path(name)).unwrap();
    save("deep.png", frame.to_rgb16().into());
    save("alpha.png", frame.to_rgba8().into());
    save("deep_alpha.png", frame.to_rgba16().into());
    save("gray.png", frame.to_luma8().into());
    save("deep_gray.png", frame.to_luma16().into());
    save("gray_alpha.png", frame.to_luma_alpha8().into());
    let jpeg = |name: &str, image: &DynamicImage, quality: u8| {
        let file = std::fs::File::create(folder.path(name)).unwrap();
        image::codecs::jpeg::JpegEncoder::new_with_quality(file, quality).encode_image(image).unwrap();
    };
    jpeg("colour.jpg", &frame, 95);
    jpeg("gray.jpg", &frame.to_luma8().into(), 95);

    let truth = windows(&folder, "cam1.png");
    println!("{truth:?}");
    assert!(truth.len() >= 2, "{truth:?}");
    for file in ["deep.png", "alpha.png", "deep_alpha.png"] {
        assert_eq!(windows(&folder, file), truth, "{file}");
    }
    let gray = windows(&folder, "gray.png");
    for file in ["deep_gray.png", "gray_alpha.png"] {
        assert!(difference(&windows(&folder, file), &gray) <= MOST_OFF, "{file}");
    }
    for file in ["gray.png", "colour.jpg", "gray.jpg"] {
        let found = windows(&folder, file);
        let off = difference(&found, &truth);
        println!("{file}: {off} degrees differ, {found:?}");
        assert!(off <= MOST_OFF, "{file}: {off} degrees differ");
    }
    // The content decides, not the extension.
    folder.write("really.jpg", &folder.read("cam1.png"));
    assert_eq!(windows(&folder, "really.jpg"), truth);
}

/// Noise of all levels, from a fixed seed.
fn noise(width: u32, height: u32) -> RgbImage {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut byte = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as u8
    };
    RgbImage::from_fn(width, height, |_, _| Rgb([byte(), byte(), byte()]))
}

#[test]
fn frames_that_show_nothing() {
    let folder = folder();
    for (name, image) in [
        ("black.png", RgbImage::from_pixel(368, 360, Rgb([0; 3]))),
        ("white.png", RgbImage::from_pixel(368, 360, Rgb([255; 3]))),
        ("red.png", RgbImage::from_pixel(368, 360, Rgb([255, 0, 0]))),
        ("noise.png", noise(368, 360)),
    ] {
        image.save(folder.path(name)).unwrap();
        let pair = format!("--calib rig.yaml --cam0 {name} --cam1 {name}");
        let seen = folder.json(&format!("see {pair} {UP}"));
        let count = seen["windows"].as_array().unwrap().len();
        println!("{name}: {count} windows");
        assert!(count <= MOST_IN_NOTHING, "{name}: {count} windows");
        assert!(name == "noise.png" || count == 0, "{name}: {count} windows");
        for method in ["level", "paper"] {
            let line = format!("windows --calib rig.yaml --camera cam0 {name} {UP} --method {method}");
            let count = folder.json(&line)["windows"].as_array().unwrap().len();
            println!("{name}, {method}: {count} windows");
            assert!(count <= MOST_IN_NOTHING, "{name}, {method}: {count} windows");
        }
        let plan = "compare-hits sample.png --at 4.12,17.77 --heading 288.6";
        let compared = folder.json(&format!("{plan} {pair} {UP} --figures pictures"));
        for score in ["cosine", "centred"] {
            let [zero, peak] = ["at_zero", "peak"].map(|at| number(&compared[score][at]));
            assert!(zero.is_finite() && zero <= peak && peak <= 1.0, "{name}: {compared}");
        }
        let drawn = folder.run(&format!("see {pair} {UP} --debug-dir pictures"));
        assert_eq!((drawn.status, drawn.stderr.as_str()), (Some(0), ""), "{name}");
        for command in ["see", "gravity", plan] {
            for mount in ["auto", "upright", "inverted"] {
                let line = format!("{command} {pair} --mount {mount} --json out.json");
                let before = folder.names();
                let ran = folder.run(&line);
                assert_eq!((ran.status, folder.names()), (Some(1), before), "{line}: the answer is no");
                assert!(
                    ran.stderr.contains("cannot tell which way is up") && ran.stderr.contains("--up"),
                    "{line}: {}",
                    ran.stderr
                );
            }
        }
        let segments = folder.json(&format!("segments {name}"));
        assert!(name == "noise.png" || number(&segments["count"]) == 0.0, "{name}: {segments}");
    }
    // One of the two has no content: the result for the other is unchanged.
    let alone = folder.json(&format!("see --calib rig.yaml --cam0 cam0.png --cam1 black.png {UP}"));
    assert_eq!(alone["hit"].as_array().unwrap().len(), 360);
}

#[test]
fn the_smallest_images_have_no_segments() {
    let folder = Folder::new();
    for (width, height) in [(1, 1), (1, 50), (50, 1), (2, 2), (3, 3), (7, 5)] {
        let image = GrayImage::from_fn(width, height, |x, y| Luma([if (x + y) % 2 == 0 { 0 } else { 255 }]));
        image.save(folder.path("small.png")).unwrap();
        let result = folder.json("segments small.png --csv small.csv");
        assert_eq!(number(&result["count"]), 0.0, "{width} x {height}");
        assert_eq!(folder.read("small.csv"), b"x1,y1,x2,y2,score\n");
    }
}
