//! `compass simulate` as a script uses it.

use compass_tests::{Folder, number};

const POSES: &str = "# timestamp tx ty tz qx qy qz qw\n\
    1.500000001 13.37 3.68 1.6 0.5 0.5 0.5 0.5\n\
    2.25 24.13 8.71 1.55 -0.5 0.5 -0.5 0.5\n";

const LINE: &str = "simulate sample.png --poses poses.tum --size 184x180";

#[test]
fn frames_come_in_the_dataset_layout() {
    let folder = Folder::new();
    folder.write("poses.tum", POSES.as_bytes());
    let result = folder.json(&format!("{LINE} --out a"));
    assert_eq!(
        ["frames", "cameras", "width", "height"].map(|name| number(&result[name])),
        [2.0, 2.0, 184.0, 180.0]
    );
    for camera in ["cam0", "cam1"] {
        let list = String::from_utf8(folder.read(&format!("a/{camera}/data.csv"))).unwrap();
        assert_eq!(list, "#timestamp [ns],filename\n1500000001,1500000001.jpg\n2250000000,2250000000.jpg\n");
        for name in ["1500000001.jpg", "2250000000.jpg"] {
            let frame = image::load_from_memory(&folder.read(&format!("a/{camera}/data/{name}"))).unwrap();
            assert_eq!((frame.width(), frame.height()), (184, 180));
        }
    }
    let truth = String::from_utf8(folder.read("a/groundtruth.txt")).unwrap();
    let second = truth.lines().nth(2).unwrap();
    assert!(second.starts_with("2.250000000 24.130000 8.710000 1.550000 -0.5"), "{second}");
    let calibrated = folder.json(&format!("{LINE} --calib a/calibration.yaml --out b"));
    assert_eq!(number(&calibrated["frames"]), 2.0);
    let frame = |set: &str| folder.read(&format!("{set}/cam1/data/2250000000.jpg"));
    assert!(frame("a") == frame("b"), "the calibration written is the one used");
}

#[test]
fn the_seed_decides_the_pictures() {
    let folder = Folder::new();
    folder.write("poses.tum", POSES.as_bytes());
    for (out, options) in
        [("a", "--seed 5 --png"), ("b", "--seed 5 --png"), ("c", "--seed 6 --style 5 --png")]
    {
        let _ = folder.json(&format!("{LINE} {options} --people 2 --clutter 20 --missing 0.3 --out {out}"));
    }
    let frame = |set: &str| folder.read(&format!("{set}/cam0/data/1500000001.png"));
    assert!(frame("a") == frame("b"));
    assert!(frame("a") != frame("c"));
}

#[test]
fn bad_input_is_named_and_leaves_nothing() {
    let folder = Folder::new();
    let good = "1 13.37 3.68 1.6 0.5 0.5 0.5 0.5\n";
    for (bad, named) in [
        ("2 13.37 3.68 1.6 0.5 0.5 0.5", "7 fields"),
        ("2 13.37 east 1.6 0.5 0.5 0.5 0.5", "ty is 'east'"),
        ("2 13.37 3.68 1.6 0.5 0.5 0.5 5", "length 5"),
        ("2 13.37 -3.68 1.6 0.5 0.5 0.5 0.5", "off the plan"),
        ("2 13.37 3.68 3.6 0.5 0.5 0.5 0.5", "ceiling"),
        ("1 13.37 3.68 1.6 0.5 0.5 0.5 0.5", "same timestamp"),
    ] {
        folder.write("poses.tum", format!("# head\n{good}{bad}\n").as_bytes());
        let before = folder.names();
        let ran = folder.run(&format!("{LINE} --out x"));
        assert_eq!(ran.status, Some(2), "{bad}");
        assert!(ran.stderr.contains("poses.tum:3: ") && ran.stderr.contains(named), "{}", ran.stderr);
        assert_eq!((ran.stderr.lines().count(), folder.names()), (1, before), "{bad}");
    }
    folder.write("poses.tum", good.as_bytes());
    for (options, named) in [
        ("--calib none.yaml", "none.yaml"),
        ("--size 184x90", "not the same shape"),
        ("--ceiling 0.2", "--ceiling"),
    ] {
        let ran = folder.run(&format!("simulate sample.png --poses poses.tum {options} --out x"));
        assert!(ran.status == Some(2) && ran.stderr.contains(named), "{options}: {}", ran.stderr);
        assert!(!folder.path("x").exists());
    }
}
