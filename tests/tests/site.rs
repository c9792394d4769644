//! Site files from end to end: building, joining, printing and searching.

use compass_core::base::num::Turn;
use compass_core::base::scan::Scan;
use compass_core::map::site::{Floor, Site};
use compass_core::map::site_map::{PackedScan, SiteMap};
use compass_tests::{Folder, POSE, compass, number, sample_map, sample_site};
use image::{GrayImage, Luma};
use serde_json::Value;

/// The scans of a layer, by candidate.
fn scans(map: &SiteMap<'_>, layer: usize) -> Vec<Scan> {
    let unpack = |record: compass_core::map::site_map::Record<'_>| {
        let mut scan = Scan::OPEN;
        record.layer(layer).unwrap().scan(&mut scan);
        scan
    };
    map.iter().map(unpack).collect()
}

/// Draws a room of 8 m x 6 m with thick walls, an alcove and a pier into `name`.
fn draw_room(folder: &Folder, name: &str) {
    let solid = |x: u32, y: u32| {
        let inside = (30..770).contains(&x) && (30..570).contains(&y);
        let alcove = (770..850).contains(&x) && (100..220).contains(&y);
        !(inside || alcove) || ((500..560).contains(&x) && (300..340).contains(&y))
    };
    let building = |x: u32, y: u32| (40..940).contains(&x) && (40..640).contains(&y);
    let dark = |x: u32, y: u32| building(x, y) && solid(x - 40, y - 40);
    let image = GrayImage::from_fn(980, 680, |x, y| Luma([if dark(x, y) { 0 } else { 255 }]));
    image.save(folder.path(name)).unwrap();
}

#[test]
fn the_layers_are_plan_and_structure() {
    let site = Site::new(sample_site()).unwrap();
    let floor = site.floor(0).unwrap();
    assert_eq!((site.len(), floor.name(), floor.layers()), (1, "sample", 2));
    let plain = SiteMap::new(sample_map()).unwrap();
    let drawn = scans(floor.map(), 0);
    assert!(drawn == scans(&plain, 0), "a second layer changes nothing of the first");

    let structure = scans(floor.map(), 1);
    let (plan, mut cast, mut kept) = (floor.plan(1).unwrap(), Scan::OPEN, Scan::OPEN);
    for (index, (drawn, structure)) in drawn.iter().zip(&structure).enumerate() {
        // The structure only lacks walls, and its layer is cast from its own plan.
        assert!(structure.steps.iter().zip(&drawn.steps).all(|(s, d)| s >= d), "candidate {index}");
        plan.scan(floor.map().position(index).unwrap(), Turn::ZERO, &mut cast).unwrap();
        PackedScan::new(&cast).unpack(&mut kept);
        assert!(kept == *structure, "candidate {index}");
    }
    assert!(drawn != structure, "the sample building has partitions");
}

#[test]
fn the_bytes_are_the_same_for_any_number_of_threads() {
    let folder = Folder::new();
    for threads in ["1", "3"] {
        let mut command = std::process::Command::new(compass());
        command.args(["map", "build", "sample.png", "--out", threads]);
        command.current_dir(folder.path("")).env("RAYON_NUM_THREADS", threads);
        assert!(command.output().unwrap().status.success());
        assert!(folder.read(threads) == sample_site(), "{threads} threads");
    }
}

#[test]
fn one_layer_where_there_is_no_structure() {
    let folder = Folder::new();
    draw_room(&folder, "room.png");
    for (options, why) in [
        ("sample.png --layers 1", "as asked"),
        ("sample.png --thickness 4", "no wall is 4 m thick"),
        ("sample.png --structure", "all of the plan is structure"),
        ("room.png", "all of the plan is structure"),
    ] {
        let line = format!("map build {options} --spacing 1 --out one.site");
        assert_eq!(folder.json(&line)["layers"], 1, "{options}");
        let ran = folder.run(&line);
        assert!(ran.stdout.contains("1 layer (") && ran.stdout.contains(why), "{options}: {}", ran.stdout);
        let bytes = folder.read("one.site");
        let floor = Site::new(&bytes).unwrap().floor(0).unwrap();
        assert!(floor.layers() == 1 && floor.plan(1).is_none(), "{options}");
    }
    let two = folder.run("map build sample.png --spacing 1 --out two.site");
    assert!(two.stdout.contains(" 2 layers,"), "{}", two.stdout);
}

#[test]
fn a_site_tells_what_is_in_it() {
    let folder = Folder::new();
    let info = folder.json("map info sample.site");
    let floors = info["floors"].as_array().unwrap();
    assert_eq!((floors.len(), &floors[0]["name"]), (1, &Value::from("sample")));
    let site = Site::new(sample_site()).unwrap();
    let floor = site.floor(0).unwrap();
    assert_eq!(number(&floors[0]["map_bytes"]), floor.map().as_bytes().len() as f64);
    let plans: Vec<_> = [0, 1].iter().map(|&layer| floor.plan(layer).unwrap().as_bytes().len()).collect();
    assert_eq!(floors[0]["plan_bytes"], Value::from(plans));
    assert_eq!(number(&info["bytes"]), sample_site().len() as f64);

    // A plain site map is one floor without name and plan; everything else is the same.
    let plain = folder.json("map info sample.map");
    assert_eq!(plain["floors"][0]["name"], Value::Null);
    assert_eq!(plain["floors"][0]["plan_bytes"], Value::Array(Vec::new()));
    for part in
        ["candidates", "spacing_m", "resolution_m", "origin", "plan_size_px", "plan_checksum", "x", "y"]
    {
        assert_eq!(plain[part], info[part], "{part}");
        assert_eq!(info[part], floors[0][part], "{part}");
    }
}

#[test]
fn a_pose_is_found_on_a_site_as_on_its_map() {
    let folder = Folder::new();
    let line = |map: &str| format!("localize --map {map} --from-plan sample.png {POSE} --noise 1 --seed 3");
    let (site, plain) = (folder.json(&line("sample.site")), folder.json(&line("sample.map")));
    for part in ["x", "y", "heading_deg", "score", "margin", "candidates", "scored", "exhaustive"] {
        assert_eq!(site[part], plain[part], "{part}");
    }
    assert!(site.get("floor").is_none(), "one floor needs no name");
}

#[test]
fn joined_floors_are_distinguished() {
    let folder = Folder::new();
    draw_room(&folder, "room.png");
    let built = folder.json("map build room.png --name Dachgeschoß --out attic.site");
    let joined = folder.json("map join sample.site attic.site --out both.site");
    assert_eq!(joined["floors"], serde_json::json!(["sample", "Dachgeschoß"]));
    let bytes = folder.read("both.site");
    assert_eq!(number(&joined["bytes"]), bytes.len() as f64);

    let attic_bytes = folder.read("attic.site");
    let attic = Site::new(&attic_bytes).unwrap().floor(0).unwrap();
    let both: Vec<Floor<'_>> = Site::new(&bytes).unwrap().floors().collect();
    assert!(both[1].map().as_bytes() == attic.map().as_bytes(), "floors are taken as they are");
    assert!(both[1].plan(0).unwrap().as_bytes() == attic.plan(0).unwrap().as_bytes());

    let info = folder.json("map info both.site");
    assert_eq!(info["floors"][1]["candidates"], built["candidates"]);
    assert_eq!(info["candidates"], info["floors"][0]["candidates"]);
    for (plan, at, name) in
        [("sample.png", POSE, "sample"), ("room.png", "--at 2.6,2.2 --heading 31", "Dachgeschoß")]
    {
        let line = format!("localize --map both.site --from-plan {plan} {at}");
        let found = folder.json(&line);
        assert_eq!(found["floor"], name);
        let candidates = found["candidates"].as_array().unwrap();
        assert!((2..=10).contains(&candidates.len()));
        assert_eq!(candidates[0]["floor"], name);
        assert!(candidates.iter().all(|pose| pose["floor"].is_string()));
        assert!(candidates.is_sorted_by(|a, b| number(&a["score"]) >= number(&b["score"])));
        let margin = number(&candidates[0]["score"]) - number(&candidates[1]["score"]);
        assert!((number(&found["margin"]) - margin).abs() < 2e-6);
        assert!(number(&found["position_error_m"]) <= 0.75, "{found}");
        assert!(folder.run(&line).stdout.contains(name));
    }
}
