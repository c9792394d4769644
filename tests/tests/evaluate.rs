//! `compass evaluate` as a script uses it.

use compass_host::dataset::tum::{self, Pose};
use compass_tests::{Folder, number};
use serde_json::Value;

const LINE: &str = "evaluate --map sample.site --calib set/calibration.yaml --dataset set \
    --groundtruth set/groundtruth.txt --mount upright --jobs 2";

/// A folder with four frames of the sample building, half a second and 0.4 m apart, in `set`, and their poses in
/// `poses.tum`. They are at a place where the track is certain, so that the wall check has verdicts.
fn recording() -> Folder {
    let folder = Folder::new();
    let pose = |n: u32| {
        let x = 20.0 + 0.4 * f64::from(n);
        Pose::looking(1_000_000_000 + 500_000_000 * u64::from(n), [x, 12.0, 1.5], 20.0, 0.0, 0.0)
    };
    folder.write("poses.tum", tum::text(&[pose(0), pose(1), pose(2), pose(3)]).as_bytes());
    let _ = folder
        .json("simulate sample.png --poses poses.tum --size 368x360 --people 0 --no-operator --out set");
    folder
}

fn row<'a>(result: &'a Value, name: &str) -> &'a Value {
    let rows = result["rows"].as_array().expect("rows");
    rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("no row {name}"))
}

#[test]
fn a_recording_is_evaluated_and_resumed() {
    let folder = recording();
    let first = folder.json(&format!("{LINE} --odometry poses.tum --out a"));
    assert_eq!(
        ["frames", "scored", "resumed", "unseen"].map(|key| number(&first[key])),
        [4.0, 4.0, 0.0, 0.0]
    );
    for name in [
        "single",
        "track",
        "track, sure",
        "oracle",
        "paper, plain",
        "paper, centred",
        "paper, hit type",
        "paper, range",
    ] {
        for key in
            ["recall_at_0_1_m", "recall_at_0_5_m", "recall_at_1_m", "recall_at_1_m_30_deg", "challenge_score"]
        {
            let value = &row(&first, name)[key];
            assert!(
                name == "track, sure" || (0.0..=100.0).contains(&number(value)),
                "{name}, {key}: {value}"
            );
        }
    }
    assert_eq!(number(&row(&first, "oracle")["recall_at_1_m_30_deg"]), 1.0, "{first}");
    let frames = first["results"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    for frame in frames {
        for way in
            ["single", "track", "oracle", "paper_plain", "paper_centred", "paper_hit_type", "paper_range"]
        {
            for key in ["x", "y", "heading_deg", "position_error_m", "heading_error_deg", "challenge_score"] {
                let _ = number(&frame[way][key]);
            }
        }
        assert!((0.0..=1.0).contains(&number(&frame["track"]["probability"])));
        let _ = number(&frame["margin"]);
    }
    for name in [
        "report.html",
        "trajectory.png",
        "errors.png",
        "recall.png",
        "reliability.png",
        "walls.png",
        "walls.csv",
        "worst_1.png",
    ] {
        assert!(folder.read(&format!("a/{name}")).len() > 500, "{name}");
    }
    for name in ["single", "track"] {
        let poses = tum::read(&folder.path(&format!("a/{name}.tum"))).unwrap();
        assert_eq!(poses.len(), 4);
        let heading = number(&frames[3][name]["heading_deg"]);
        assert!((poses[3].heading_deg() - heading).abs() < 0.01, "{name}: {heading}");
    }
    resumes(&folder, &first);
}

/// The third line was truncated by the interruption, and the evidence of the first frame is missing.
fn resumes(folder: &Folder, first: &Value) {
    let lines = String::from_utf8(folder.read("a/frames.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 4);
    let lengths: Vec<_> = lines.lines().map(|line| line.len() + 1).collect();
    folder.write("a/frames.jsonl", &lines.as_bytes()[..lengths[..3].iter().sum::<usize>() - 10]);
    std::fs::remove_file(folder.path("a/evidence/1000000000.png")).unwrap();
    let again = folder.json(&format!("{LINE} --odometry poses.tum --out a"));
    let kept = String::from_utf8_lossy(&lines.as_bytes()[..lengths[..2].iter().sum()]).into_owned();
    let whole = kept.lines().filter(|line| !line.contains("\"timestamp_ns\":1000000000,")).count();
    assert_eq!(number(&again["resumed"]) as usize, whole);
    let whole = folder.json(&format!("{LINE} --odometry poses.tum --out a"));
    assert_eq!(number(&whole["resumed"]), 4.0);
    for result in [&again, &whole] {
        assert_eq!((&result["rows"], &result["results"]), (&first["rows"], &first["results"]));
    }
    let other = folder.json(&format!("{LINE} --every 2 --camera-height 1.5 --out a"));
    assert_eq!(
        ["frames", "resumed"].map(|key| number(&other[key])),
        [2.0, 0.0],
        "other options, other results"
    );
}

#[test]
fn the_plan_decides_which_way_is_up() {
    let folder = recording();
    let told = folder.json(&format!("{LINE} --every 2 --out told"));
    let tried = folder.json(&format!("{} --every 2 --out tried", LINE.replace("--mount upright", "")));
    assert_eq!(number(&tried["unseen"]), 0.0);
    let results = |result: &Value| result["results"].as_array().unwrap().clone();
    for (tried, told) in results(&tried).iter().zip(&results(&told)) {
        for key in ["timestamp_ns", "single", "track", "up_from", "paper_range"] {
            assert_eq!(tried[key], told[key], "{key}");
        }
        // With the other side up the frames have a pose as well, a worse one: a rival.
        let margins = [tried, told].map(|frame| number(&frame["margin"]));
        assert!(0.0 < margins[0] && margins[0] <= margins[1], "{margins:?}");
    }
}

#[test]
fn bad_input_is_named_and_leaves_nothing() {
    let folder = recording();
    let list = "set/cam1/data.csv";
    let good = folder.read(list);
    folder.write("far.tum", b"9000 0 0 1 0 0 0 1\n");
    folder.write("bad.tum", b"1 0 0 1 0 0 0\n");
    let refused = |line: &str, named: &str| {
        let before = folder.names();
        let ran = folder.run(line);
        assert_eq!((ran.status, ran.stderr.lines().count()), (Some(2), 1), "{line}: {}", ran.stderr);
        assert!(ran.stderr.contains(named), "{line}: {}", ran.stderr);
        assert_eq!(folder.names(), before, "{line}");
    };
    let with = |from: &str, to: &str| format!("{} --out x", LINE.replace(from, to));
    for (line, named) in [
        (with("--map sample.site", "--map sample.map"), "sample.map: has no plan"),
        (with("--map sample.site", "--map none.site"), "none.site"),
        (with("set/calibration.yaml", "poses.tum"), "poses.tum"),
        (with("--dataset set", "--dataset ."), "no frames"),
        (with("set/groundtruth.txt", "far.tum"), "far.tum: no pose at the time"),
        (with("set/groundtruth.txt", "bad.tum"), "bad.tum:1: "),
        (format!("{LINE} --odometry bad.tum --out x"), "bad.tum:1: "),
        (format!("{LINE} --floor attic --out x"), "no floor 'attic'"),
    ] {
        refused(&line, named);
    }
    folder.write(list, b"#timestamp [ns],filename\n1000000000,none.jpg\n");
    refused(&format!("{LINE} --out x"), "data.csv:2: ");
    folder.write(list, &good);
    // Frames none of which can be used: nothing is left either.
    for camera in ["cam0", "cam1"] {
        for stamp in ["1000000000", "1500000000", "2000000000", "2500000000"] {
            folder.write(&format!("set/{camera}/data/{stamp}.jpg"), b"\xff\xd8\xff\xe0 no picture");
        }
    }
    refused(&format!("{LINE} --out deep/x"), "1000000000.jpg: damaged");
}

#[test]
fn one_bad_item_does_not_end_a_recording() {
    let folder = recording();
    let whole = folder.json(&format!("{LINE} --out whole"));
    assert_eq!((&whole["left_out"]["frames"], &whole["notes"]), (&Value::from(0), &Value::Array(vec![])));
    let jpeg = folder.read("set/cam0/data/1500000000.jpg");
    folder.write("set/cam0/data/1500000000.jpg", &jpeg[..jpeg.len() / 2]);
    let list = String::from_utf8(folder.read("set/cam1/data.csv")).unwrap();
    folder.write("set/cam1/data.csv", format!("{list}3000000000,gone.jpg\n-5,1000000000.jpg\n").as_bytes());
    std::fs::create_dir(folder.path("set/imu0")).unwrap();
    folder.write("set/imu0/data.csv", b"1000000000,0,0,0,0,0,9.81\n1500000000,0,0,0,nan,0,9.81\n");
    let poses = String::from_utf8(folder.read("set/groundtruth.txt")).unwrap();
    folder.write("set/groundtruth.txt", format!("{poses}9.0 nan nan nan nan nan nan nan\n").as_bytes());
    let result = folder.json(&format!("{LINE} --out part"));
    let left_out = &result["left_out"];
    assert_eq!(
        ["frames", "readings", "poses"].map(|key| number(&left_out[key])),
        [3.0, 1.0, 1.0],
        "{left_out}"
    );
    let first = left_out["first"].as_array().unwrap();
    for named in ["gone.jpg does not exist", "'-5'", "'nan'", "damaged or truncated image"] {
        let is_named = |item: &Value| item["problem"].as_str().unwrap().contains(named);
        assert!(first.iter().any(is_named), "{named}: {first:?}");
    }
    assert!(result["notes"][0].as_str().unwrap().contains("T_imu_cam"), "{}", result["notes"]);
    assert_eq!(["frames", "unseen"].map(|key| number(&result[key])), [4.0, 1.0]);
    let frames = |result: &Value| result["results"].as_array().unwrap().clone();
    for (at, (found, expected)) in frames(&result).iter().zip(&frames(&whole)).enumerate() {
        if at == 1 {
            assert!(found["problem"].as_str().unwrap().contains("1500000000.jpg: damaged"), "{found}");
        } else {
            assert_eq!(found["single"], expected["single"], "{at}");
        }
    }
    let report = String::from_utf8(folder.read("part/report.html")).unwrap();
    assert!(report.contains("Left out") && report.contains("gone.jpg"));
    let ran = folder.run(&format!("{LINE} --max-left-out 0.2 --out part"));
    assert_eq!(ran.status, Some(1), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("were left out, more than a share of 0.2 (--max-left-out)"),
        "{}",
        ran.stderr
    );
}

#[test]
fn both_lenses_in_one_image_are_taken_apart() {
    let folder = recording();
    let whole = folder.json(&format!("{LINE} --every 4 --out whole"));
    let open =
        |camera| image::open(folder.path(&format!("set/{camera}/data/1000000000.jpg"))).unwrap().to_rgb8();
    let halves = [open("cam0"), open("cam1")];
    let width = halves[0].width();
    let dual = image::RgbImage::from_fn(2 * width, halves[0].height(), |x, y| {
        *halves[(x / width) as usize].get_pixel(x % width, y)
    });
    dual.save(folder.path("dual.png")).unwrap();
    std::fs::create_dir_all(folder.path("one/cam0/data")).unwrap();
    std::fs::rename(folder.path("dual.png"), folder.path("one/cam0/data/1.png")).unwrap();
    folder.write("one/cam0/data.csv", b"1000000000,1.png\n");
    let result = folder.json(&format!("{} --out halves", LINE.replace("--dataset set", "--dataset one")));
    assert_eq!(result["results"][0]["single"], whole["results"][0]["single"]);
    assert!(result["notes"][0].as_str().unwrap().contains("both lenses are in one image"), "{result}");
    let gravity =
        |frames: &str| folder.run(&format!("gravity --calib set/calibration.yaml --mount upright {frames}"));
    let dual = gravity("--cam0 one/cam0/data/1.png");
    let pair = gravity("--cam0 set/cam0/data/1000000000.jpg --cam1 set/cam1/data/1000000000.jpg");
    assert_eq!((dual.status, &dual.stdout), (Some(0), &pair.stdout));
    assert!(dual.stderr.contains("its left half is taken for cam0"), "{}", dual.stderr);
}

#[test]
fn cameras_are_those_asked_for() {
    let folder = recording();
    let chain = String::from_utf8(folder.read("set/calibration.yaml")).unwrap();
    // The second camera is named cam2, after one of a model that nothing reads.
    let step = "  T_cn_cnm1: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
    let other = format!("cam1:\n{step}\n  camera_model: fov\ncam2:");
    folder.write("three.yaml", chain.replacen("cam1:", &other, 1).as_bytes());
    let frame = "--cam0 set/cam0/data/1000000000.jpg";
    let pair = format!("{frame} --cam1 set/cam1/data/1000000000.jpg");
    let gravity = |options: &str| folder.run(&format!("gravity --mount upright {options}"));
    let expected = gravity(&format!("--calib set/calibration.yaml {pair}"));
    let found = gravity(&format!("--calib three.yaml --cameras cam0,cam2 {pair}"));
    assert_eq!((found.status, &found.stdout), (Some(0), &expected.stdout), "{}", found.stderr);
    assert_eq!(gravity(&format!("--calib three.yaml {frame}")).status, Some(0), "cam1 is not asked for");
    let refused = gravity(&format!("--calib three.yaml {pair}"));
    assert_eq!(refused.status, Some(2));
    assert!(refused.stderr.contains("cam1.camera_model: 'fov' is not supported"), "{}", refused.stderr);
    std::fs::rename(folder.path("set/cam1"), folder.path("set/cam2")).unwrap();
    let line = LINE.replace("set/calibration.yaml", "three.yaml --cameras cam0,cam2");
    let result = folder.json(&format!("{line} --every 4 --out x"));
    assert_eq!((number(&result["frames"]), number(&result["unseen"])), (1.0, 0.0));
}
