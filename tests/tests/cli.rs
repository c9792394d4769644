//! The commands from end to end, as a script uses them, on the bundled sample building.

use compass_core::vision::camera::Bearing;
use compass_core::vision::shot::Shot;
use compass_host::calibration::Calibration;
use compass_host::dataset::tum::Pose;
use compass_host::frame::Frame;
use compass_host::sample::{self, FRAME_POSE};
use compass_tests::{Folder, POSE, angle, number, numbers, sample_frames, sample_map, sample_site};
use image::{GrayImage, Luma};
use serde_json::Value;
use std::f64::consts::SQRT_2;
use std::path::PathBuf;

const LOCALIZE: &str = "localize --map sample.map --from-plan sample.png";

/// Poses off the grid, one per part of the floor: room S3, open plan, corridors, facade rooms.
const POSES: [([f64; 2], f64); 5] = [
    ([13.37, 3.68], 74.0),
    ([24.13, 8.71], 203.4),
    ([9.58, 6.83], 351.2),
    ([28.31, 16.87], 120.0),
    ([4.12, 17.77], 288.6),
];

fn hits(result: &Value) -> Vec<&str> {
    result["hit"].as_array().unwrap().iter().map(|h| h.as_str().unwrap()).collect()
}

/// The same ranges, hits and channels.
fn assert_same_descriptor(a: &Value, b: &Value) {
    for part in ["range_m", "hit", "channels", "stats"] {
        assert_eq!(a[part], b[part], "{part}");
    }
}

#[test]
fn describe_has_the_promised_shape() {
    let result = Folder::new().json(&format!("describe sample.png {POSE}"));
    let (ranges, hits) = (numbers(&result["range_m"]), hits(&result));
    assert_eq!((ranges.len(), hits.len()), (360, 360));
    assert!(ranges.iter().all(|r| (0.02..=30.0).contains(r)));
    assert!(hits.iter().all(|h| ["wall", "window", "open"].contains(h)));
    let channels: Vec<_> = result["channels"].as_array().unwrap().iter().map(numbers).collect();
    assert_eq!(channels.iter().map(Vec::len).collect::<Vec<_>>(), [360; 5]);
    assert!(channels.iter().flatten().all(|v| (0.0..=1.5).contains(v)));

    // The channels follow from ranges and hits by the paper's definition.
    let near = |a: f64, b: f64| (a - b).abs() < 1.0 / 512.0;
    for j in 0..360 {
        let (before, r, after) = (ranges[(j + 359) % 360], ranges[j], ranges[(j + 1) % 360]);
        let level = ["open", "window", "wall"].iter().position(|&name| name == hits[j]).unwrap();
        let around: Vec<f64> = (0..11).map(|k| ranges[(j + 355 + k) % 360]).collect();
        let mean = around.iter().sum::<f64>() / 11.0;
        let deviation = (around.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 11.0).sqrt();
        assert!(near(channels[0][j], r / 30.0), "channel 0, bin {j}");
        assert!(near(channels[1][j], level as f64 / 2.0), "channel 1, bin {j}");
        assert!(near(channels[2][j], ((after - before).abs() / 10.0).min(1.0)), "channel 2, bin {j}");
        assert!(near(channels[3][j], 1.0 / (1.0 + r)), "channel 3, bin {j}");
        assert!(near(channels[4][j], deviation / 10.0), "channel 4, bin {j}");
    }

    let stats = &result["stats"];
    let count = |name| hits.iter().filter(|&&h| h == name).count() as f64;
    assert_eq!(number(&stats["window_bins"]), count("window"));
    assert_eq!(number(&stats["open_bins"]), count("open"));
    assert!(count("window") > 0.0, "room S3 has a window");
    assert_eq!(number(&stats["range_min"]), ranges.iter().copied().fold(f64::MAX, f64::min));
    assert_eq!(number(&stats["range_max"]), ranges.iter().copied().fold(0.0, f64::max));
    let changes = (0..360).filter(|&j| hits[j] != hits[(j + 1) % 360]).count() as f64;
    assert_eq!(number(&stats["segments"]), changes);
    let gradient = (0..360).map(|j| (ranges[(j + 1) % 360] - ranges[(j + 359) % 360]).abs() / 2.0);
    assert!((number(&stats["gradient_mean"]) - gradient.sum::<f64>() / 360.0).abs() < 1e-5);
}

#[test]
fn bins_run_counter_clockwise_from_the_heading() {
    let folder = Folder::new();
    let at_0 = folder.json("describe sample.png --at 13.37,3.68");
    let at_90 = folder.json("describe sample.png --at 13.37,3.68 --heading 90");
    let (mut turned, ahead) = (numbers(&at_0["range_m"]), numbers(&at_90["range_m"]));
    turned.rotate_left(90);
    assert_eq!(turned, ahead);
    let backwards = folder.json("describe sample.png --at 13.37,3.68 --heading -270");
    assert_same_descriptor(&at_90, &backwards);

    // A free square of 4 m and a position in it that distinguishes the directions.
    let wall = |x: u32, y: u32| !(50..450).contains(&x) || !(50..450).contains(&y);
    let square = GrayImage::from_fn(500, 500, |x, y| Luma([if wall(x, y) { 0 } else { 255 }]));
    square.save(folder.path("square.png")).unwrap();
    let ranges = numbers(&folder.json("describe square.png --at 1.5,1")["range_m"]);
    for (bin, expected) in [(0, 3.0), (90, 3.5), (180, 1.0), (270, 0.5), (225, 0.5 * SQRT_2)] {
        assert!((ranges[bin] - expected).abs() <= 0.03, "bin {bin}: {} m", ranges[bin]);
    }
}

#[test]
fn the_two_engines_agree() {
    let folder = Folder::new();
    for ([x, y], heading) in POSES {
        let line = format!("describe sample.png --at {x},{y} --heading {heading}");
        let fixed = folder.json(&line);
        let float = folder.json(&format!("{line} --engine float"));
        let (a, b) = (numbers(&fixed["range_m"]), numbers(&float["range_m"]));
        let (hits_a, hits_b) = (hits(&fixed), hits(&float));
        // At most one ray of 360 may graze a corner and resolve differently.
        let agrees = |j: &usize| hits_a[*j] == hits_b[*j] && (a[*j] - b[*j]).abs() <= 0.0201;
        let agreeing = (0..360).filter(agrees).count();
        assert!(agreeing >= 359, "{agreeing} of 360 at {x},{y}");
    }
}

#[test]
fn a_plan_can_be_named_in_every_way() {
    let folder = Folder::new();
    let expected = folder.json(&format!("describe sample.png {POSE}"));
    assert_same_descriptor(&expected, &folder.json(&format!("describe --plan sample.png {POSE}")));
    assert_same_descriptor(&expected, &folder.json(&format!("describe {POSE} --resolution 0.01 sample.png")));

    let ros = |origin: &str| {
        format!(
            "image: sample.png\nresolution: 0.01\norigin: {origin}\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        )
    };
    folder.write("map.yaml", ros("[0.0, 0.0, 0.0]").as_bytes());
    assert_same_descriptor(&expected, &folder.json(&format!("describe map.yaml {POSE}")));
    folder.write("moved.yaml", ros("[-20.0, 4.5, 0.0]").as_bytes());
    assert_same_descriptor(&expected, &folder.json("describe moved.yaml --at -6.63,8.18 --heading 74"));
    let moved = folder.json("describe sample.png --origin -20,4.5 --at -6.63,8.18 --heading 74");
    assert_same_descriptor(&expected, &moved);

    // A pair of rasters without colour: the full plan, and the walls alone.
    let building = sample::building();
    let mask =
        |bits| compass_core::base::raster::BitMask::new(bits, building.width, building.height).unwrap();
    let (walls, windows) = (mask(&building.walls), mask(&building.windows));
    let draw = |name: &str, glazing: bool| {
        let dark = |x, y| walls.get(x, y) || glazing && windows.get(x, y);
        let (width, height) = (building.width, building.height);
        let pixel = |x, y| Luma([if dark(x, height - 1 - y) { 0 } else { 255 }]);
        GrayImage::from_fn(width, height, pixel).save(folder.path(name)).unwrap();
    };
    draw("all.png", true);
    draw("walls.png", false);
    let pair = folder.json(&format!("describe all.png --walls walls.png {POSE}"));
    assert_same_descriptor(&expected, &pair);
}

#[test]
fn json_goes_to_the_named_destination() {
    let folder = Folder::new();
    let ran = folder.run(&format!("describe sample.png {POSE} --json result.json"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""));
    assert!(ran.stdout.contains("window bins"), "a person still gets a summary: {}", ran.stdout);
    let file: Value = serde_json::from_slice(&folder.read("result.json")).unwrap();
    assert_eq!(file, folder.json(&format!("describe sample.png {POSE}")));
    let plain = String::from_utf8(folder.read("result.json")).unwrap();
    let exponent = |w: &[u8]| w[0].is_ascii_digit() && (w[1] == b'e' || w[1] == b'E');
    assert!(!plain.as_bytes().windows(2).any(exponent), "numbers are plain decimals");
}

#[test]
fn figures_are_drawn_on_request() {
    let folder = Folder::new();
    let ran = folder.run(&format!("describe sample.png {POSE} --figures pictures"));
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""));
    for name in ["rays", "polar", "descriptor", "profile"] {
        let image = image::open(folder.path(&format!("pictures/{name}.png"))).unwrap().to_rgb8();
        assert!(image.width() >= 400 && image.height() >= 200, "{name}");
        let first = *image.get_pixel(0, 0);
        assert!(image.pixels().any(|p| *p != first), "{name} is blank");
    }
}

#[test]
fn a_map_is_built_and_described() {
    let folder = Folder::new();
    let built = folder.json("map build sample.png --spacing 0.5 --out built.map");
    let bytes = folder.read("built.map");
    assert_eq!(number(&built["bytes"]), bytes.len() as f64);
    assert!(number(&built["seconds"]) > 0.0);
    let info = folder.json("map info built.map");
    for part in ["candidates", "layers", "bytes"] {
        assert_eq!(built[part], info[part], "{part}");
    }
    assert_eq!(info["layers"], 2);
    assert_eq!(number(&info["spacing_m"]), 0.5);
    assert_eq!(number(&info["resolution_m"]), 0.01);
    assert_eq!(numbers(&info["plan_size_px"]), [3200.0, 2200.0]);
    // 30 m x 20 m less walls and core at 4 candidates per square metre.
    let candidates = number(&info["candidates"]);
    assert!((1400.0..2300.0).contains(&candidates), "{candidates}");
    for (axis, far) in [("x", 31.0), ("y", 21.0)] {
        let [from, to] = numbers(&info[axis])[..] else { panic!("{axis}: two numbers") };
        assert!(1.0 < from && from < 3.0 && far - 3.0 < to && to < far, "{axis}: {from} to {to}");
    }

    // Again, with the other way to name the plan.
    let again = folder.run("map build --plan sample.png --spacing 0.5 --name sample --out again.map");
    assert_eq!(again.status, Some(0), "{}", again.stderr);
    assert!(folder.read("again.map") == bytes, "two builds differ");
    assert!(sample_site() == bytes, "command and library differ");

    let coarse = folder.json("map build sample.png --spacing 1 --out coarse.map");
    let share = number(&coarse["candidates"]) / candidates;
    assert!((0.2..0.3).contains(&share), "a quarter of the candidates at twice the spacing: {share}");
}

#[test]
fn candidates_stand_inside_and_clear_of_everything() {
    let (raster, _) = compass_tests::sample_plan();
    let map = compass_core::map::site_map::SiteMap::new(sample_map()).unwrap();
    let mut scan = compass_core::base::scan::Scan::OPEN;
    for (index, record) in map.iter().enumerate() {
        let [column, row] = record.cell();
        assert!(!raster.occupied(column.into(), row.into()), "candidate {index}");
        record.scan(&mut scan);
        let nearest = scan.steps.iter().min().unwrap();
        assert!(*nearest >= 9, "candidate {index} is {nearest} steps from something");
        // The facade is closed: from inside, no ray leaves the building.
        let open = scan.count(compass_core::base::scan::Hit::Open);
        assert_eq!(open, 0, "candidate {index} at {:?}", map.position(index));
    }
}

#[test]
fn a_pose_cast_from_the_plan_is_found_again() {
    let folder = Folder::new();
    for ([x, y], heading) in POSES {
        let found = folder.json(&format!("{LOCALIZE} --at {x},{y} --heading {heading}"));
        let metres = (number(&found["x"]) - x).hypot(number(&found["y"]) - y);
        let degrees = angle(number(&found["heading_deg"]), heading);
        assert!(metres <= 0.75 && degrees <= 5.0, "{x},{y},{heading}: off by {metres} m, {degrees} degrees");
        assert!((number(&found["position_error_m"]) - metres).abs() < 1e-5);
        assert!((number(&found["heading_error_deg"]) - degrees).abs() < 1e-5);
        assert_eq!(found["exhaustive"], true);
        assert!(found["milliseconds"]["search"].is_number());
    }
}

#[test]
fn alternatives_lie_apart_and_the_best_comes_first() {
    let folder = Folder::new();
    for noise in ["", " --noise 1 --seed 3", " --noise 3 --seed 4"] {
        for similarity in ["centred", "plain"] {
            let found = folder.json(&format!("{LOCALIZE} {POSE} --similarity {similarity}{noise}"));
            let candidates = found["candidates"].as_array().unwrap();
            assert!((2..=10).contains(&candidates.len()), "{}", candidates.len());
            for part in ["x", "y", "heading_deg", "score"] {
                assert_eq!(found[part], candidates[0][part], "{part}");
            }
            let score = |k: usize| number(&candidates[k]["score"]);
            for (k, a) in candidates.iter().enumerate() {
                assert!((-1.0..=1.0).contains(&score(k)));
                assert!(k == 0 || score(k) <= score(k - 1), "best first");
                for b in &candidates[..k] {
                    let part = |c: &Value, name: &str| number(&c[name]);
                    let metres = (part(a, "x") - part(b, "x")).hypot(part(a, "y") - part(b, "y"));
                    let degrees = angle(part(a, "heading_deg"), part(b, "heading_deg"));
                    assert!(metres >= 0.999 || degrees >= 20.0, "{metres} m, {degrees} degrees");
                }
            }
            let margin = number(&found["margin"]);
            assert!((margin - (score(0) - score(1))).abs() < 2e-6, "margin {margin}");
        }
    }
}

#[test]
fn noise_follows_its_seed() {
    let folder = Folder::new();
    let run = |options: &str| folder.json(&format!("{LOCALIZE} {POSE} {options}"))["candidates"].clone();
    let clean = run("");
    assert_eq!(clean, run("--noise 0 --seed 5"), "no noise, whatever the seed");
    let noisy = run("--noise 1 --seed 5");
    assert_eq!(noisy, run("--noise 1 --seed 5"));
    assert_ne!(noisy, run("--noise 1 --seed 6"));
    assert!(number(&noisy[0]["score"]) < number(&clean[0]["score"]));
}

#[test]
fn the_prefilter_scores_fewer() {
    let folder = Folder::new();
    let all = folder.json(&format!("{LOCALIZE} {POSE}"));
    let filtered = folder.json(&format!("{LOCALIZE} {POSE} --prefilter 200"));
    assert_eq!(filtered["exhaustive"], false, "what was left out might have won");
    assert!(number(&filtered["scored"]) <= number(&all["scored"]));
    assert!(number(&filtered["score"]) <= number(&all["score"]));
    let metres = (number(&filtered["x"]) - 13.37).hypot(number(&filtered["y"]) - 3.68);
    assert!(metres <= 0.75, "off by {metres} m");
    // With capacity for all candidates the filter changes nothing.
    let kept = folder.json(&format!("{LOCALIZE} {POSE} --prefilter 1000000"));
    assert_eq!(kept["candidates"], all["candidates"]);
}

#[test]
fn weights_change_the_score() {
    let folder = Folder::new();
    let run = |weights: &str| folder.json(&format!("{LOCALIZE} {POSE} --weights {weights}"))["score"].clone();
    assert_eq!(run("16,16,16,16,16"), run("1,1,1,1,1"), "weights are relative");
    assert_ne!(run("16,16,16,16,16"), run("0,16,0,0,0"));
}

#[test]
fn compare_is_in_bounds() {
    let folder = Folder::new();
    for line in ["compare --poses 40", "compare sample.png --poses 40 --seed 9"] {
        let result = folder.json(line);
        assert_eq!(result["in_bounds"], true);
        let stages = result["stages"].as_array().unwrap();
        assert!(stages.len() >= 9, "march, five channels, spectrum, similarity: {}", stages.len());
        for stage in stages {
            assert_eq!(stage["in_bounds"], true, "{stage}");
            assert!(number(&stage["compared"]) > 0.0, "{stage}");
        }
    }
}

#[test]
fn the_demo_finds_itself_and_draws_the_report() {
    let folder = Folder::new();
    let ran = folder.run("demo --out report --json demo.json");
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""));
    assert!(ran.stdout.contains("found"), "{}", ran.stdout);
    let result: Value = serde_json::from_slice(&folder.read("demo.json")).unwrap();
    assert!(number(&result["position_error_m"]) <= 0.75);
    assert!(number(&result["heading_error_deg"]) <= 5.0);
    let ([x, y], heading) = FRAME_POSE;
    let seen = &result["seen"];
    assert!((number(&seen["x"]) - x).hypot(number(&seen["y"]) - y) < 0.5, "{seen}");
    assert!(angle(number(&seen["heading_deg"]), heading) < 3.0, "{seen}");
    assert!(number(&result["seen_probability"]) > 0.9);
    let html = String::from_utf8(folder.read("report/report.html")).unwrap();
    for name in ["map", "cam0", "cam1", "panorama", "descriptor"] {
        assert!(html.contains(&format!("seen/{name}.png")), "{name} is missing in the report");
    }
    let pictures =
        ["rays", "polar", "profile", "descriptor", "correlation", "hits-polar", "hits-linear", "site-map"];
    for name in pictures {
        assert!(html.contains(&format!("{name}.png")), "{name} is missing in the report");
        let file = folder.read(&format!("report/{name}.png"));
        assert!(file.len() > 5_000, "{name}: {} bytes", file.len());
        let image = image::load_from_memory(&file).unwrap();
        assert!(image.width() >= 400 && image.height() >= 200, "{name}");
    }
    // The other pictures are complete, and no temporary file is left.
    let drawn = |p: &&PathBuf| p.starts_with(folder.path("report")) && p.is_file();
    for path in folder.names().iter().filter(drawn) {
        let other = ["report.html", "seen/sample.site", "seen/calibration.yaml"]
            .iter()
            .any(|name| path.ends_with(name));
        assert!(other || image::open(path).is_ok(), "{}", path.display());
    }
}

#[test]
fn help_and_version_succeed() {
    let folder = Folder::new();
    for line in ["--help", "--version", "describe --help", "map build --help", "localize --help"] {
        let ran = folder.run(line);
        assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""), "{line}");
        assert!(ran.stdout.contains("compass"), "{line}: {}", ran.stdout);
    }
}

#[test]
fn packed_frames_are_means_with_their_lenses() {
    let folder = Folder::new();
    let ([x, y], heading) = FRAME_POSE;
    let frames = sample_frames(&Pose::looking(0, [x, y, 1.6], heading, 4.0, 187.0), (184, 180));
    let cameras = folder.write_frames(&frames);
    let told = "--mount inverted --camera-height 1.6 --time-ns -7 --size 92x90";
    let result = folder.json(&format!("pack {cameras} {told} --out both.shot"));
    assert_eq!((number(&result["cameras"]), number(&result["width"])), (2.0, 92.0));
    let bytes = folder.read("both.shot");
    assert_eq!(number(&result["bytes"]), bytes.len() as f64);
    let shot = Shot::new(&bytes).unwrap();
    shot.verify().unwrap();
    let header = shot.header();
    assert_eq!((header.time_ns, header.height_m), (-7, Some(1.6)));
    assert_eq!(header.up, Bearing::y());
    assert_eq!(header.rig, Calibration::nominal().rig([Some((92, 90)); 2]).unwrap());
    for (image, frame) in shot.images().iter().zip(frames) {
        let (gray, excluded) = image.unwrap();
        let large = Frame::from_rgb(frame).unwrap();
        for (x, y) in (0..90).flat_map(|y| (0..92).map(move |x| (x, y))) {
            let block = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| (2 * x + i, 2 * y + j));
            let sum: u32 =
                block.iter().map(|(x, y)| u32::from(large.gray().row(*y as usize)[*x as usize])).sum();
            let found = gray.row(y as usize)[x as usize];
            assert!((f64::from(sum) / 4.0 - f64::from(found)).abs() <= 1.5, "{x}, {y}: {found}, {sum} / 4");
            assert!(!excluded.get(x, y), "{x}, {y}: nothing is left out unless somebody says so");
        }
    }
    let alone = folder.json("pack --calib rig.yaml --cam1 cam1.png --up 0,1,0.1 --size 92x90 --out one.shot");
    assert_eq!(number(&alone["cameras"]), 1.0);
    let bytes = folder.read("one.shot");
    let shot = Shot::new(&bytes).unwrap();
    assert!(shot.images()[0].is_none() && shot.header().height_m.is_none());
    assert_eq!(shot.header().up, Bearing::new(0.0, 1.0, 0.1));
}
