//! `--inside` and `--region`, from end to end: plans that do not show where candidates are.

use compass_core::map::site::Site;
use compass_tests::Folder;
use image::{DynamicImage, GrayImage, ImageFormat, Luma};
use std::io::Cursor;

/// Plans of 20 m x 15 m at 0.05 m a pixel, the south-west corner at (-3, -2).
const SIZE: (u32, u32) = (400, 300);
const SCALE: &str = "--resolution 0.05 --origin=-3,-2";

/// Whether a place is in a rectangle; metres from the south-west corner, as all of the drawings.
fn within([x0, y0, x1, y1]: [f64; 4], x: f64, y: f64) -> bool {
    (x0..x1).contains(&x) && (y0..y1).contains(&y)
}

/// The outline of a rectangle, 0.2 m thick.
fn outline([x0, y0, x1, y1]: [f64; 4], x: f64, y: f64) -> bool {
    within([x0, y0, x1, y1], x, y) && !within([x0 + 0.2, y0 + 0.2, x1 - 0.2, y1 - 0.2], x, y)
}

fn plan(is_wall: impl Fn(f64, f64) -> bool) -> Vec<u8> {
    let metres = |pixel: u32| (f64::from(pixel) + 0.5) * 0.05;
    let image = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Luma([if is_wall(metres(x), metres(SIZE.1 - 1 - y)) { 0 } else { 255 }])
    });
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageLuma8(image).write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// 16 m x 11 m, open to the south.
fn hall(x: f64, y: f64) -> bool {
    outline([2.0, 2.0, 18.0, 13.0], x, y) && y > 2.5
}

/// The same with a gate of 14 m in the south.
fn gate(x: f64, y: f64) -> bool {
    outline([2.0, 2.0, 18.0, 13.0], x, y) && !within([3.0, 1.0, 17.0, 3.0], x, y)
}

/// Two walls that meet, 0.3 m thick.
fn terrace(x: f64, y: f64) -> bool {
    within([2.0, 2.0, 16.0, 2.3], x, y) || within([2.0, 2.0, 2.3, 12.0], x, y)
}

/// Two rooms with a door between them, which is open, and a closed one.
fn rooms(x: f64, y: f64) -> bool {
    let walls =
        [[2.0, 2.0, 7.0, 8.0], [6.8, 2.0, 12.0, 8.0], [11.8, 2.0, 17.0, 8.0]].map(|room| outline(room, x, y));
    walls.contains(&true) && !within([6.5, 4.0, 7.5, 5.0], x, y)
}

/// Positions of the candidates in map metres.
fn candidates(folder: &Folder, plan: &str, options: &str) -> Vec<(f64, f64)> {
    let line = format!("map build {plan} {SCALE} --out floor.site {options}");
    let ran = folder.run(&line);
    assert_eq!((ran.status, ran.stderr.as_str()), (Some(0), ""), "{line}");
    let bytes = folder.read("floor.site");
    let floor = Site::new(&bytes).unwrap().floor(0).unwrap();
    let metres = |pixel: u16, origin: f64| (f64::from(pixel) + 0.5) * 0.05 + origin;
    floor
        .map()
        .iter()
        .map(|record| (metres(record.cell()[0], -3.0), metres(record.cell()[1], -2.0)))
        .collect()
}

fn refused(folder: &Folder, line: &str, named: &[&str]) {
    let ran = folder.run(line);
    assert_eq!((ran.status, ran.stdout.as_str()), (Some(2), ""), "{line}: {}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 1, "{line}: {}", ran.stderr);
    for name in named {
        assert!(ran.stderr.contains(name), "{line}: no '{name}' in {}", ran.stderr);
    }
}

#[test]
fn open_places_are_built_with_a_region() {
    let folder = Folder::new();
    for (name, drawn) in [("hall", hall as fn(f64, f64) -> bool), ("gate", gate), ("terrace", terrace)] {
        folder.write("plan.png", &plan(drawn));
        let build = format!("map build plan.png {SCALE} --out floor.site");
        refused(&folder, &build, &["plan.png", "no interior", "--inside X,Y", "--region X0,Y0,X1,Y1"]);
        let open = format!("{build} --inside 5,4");
        refused(&folder, &open, &["plan.png", "5,4 is not enclosed", "--region X0,Y0,X1,Y1"]);
        assert!(!folder.path("floor.site").exists(), "{name}");
        // 4 m x 3 m beside the west wall, whose inner side is at -0.8 or -0.7.
        let found = candidates(&folder, "plan.png", "--region=-0.5,1,3.5,4");
        assert_eq!(found.len(), 8 * 6, "{name}");
        assert!(found.iter().all(|&(x, y)| within([-0.5, 1.0, 3.5, 4.0], x, y)), "{name}: {found:?}");
        let two = candidates(&folder, "plan.png", "--region=-0.5,1,3.5,4 --region 10,4,8,2");
        assert_eq!(two.len(), 8 * 6 + 4 * 4, "{name}");
        std::fs::remove_file(folder.path("floor.site")).unwrap();
    }
}

#[test]
fn a_gate_can_be_closed_by_its_width() {
    let folder = Folder::new();
    folder.write("plan.png", &plan(gate));
    let found = candidates(&folder, "plan.png", "--inside 7,7 --max-gap 15");
    assert!(found.len() > 400, "{}", found.len());
    assert!(found.iter().all(|&(x, y)| within([-1.0, 0.0, 15.0, 11.0], x, y)), "all in the hall");
}

#[test]
fn a_point_is_what_can_be_reached_from_it() {
    let folder = Folder::new();
    folder.write("plan.png", &plan(rooms));
    let rooms = |options: &str| {
        let found = candidates(&folder, "plan.png", options);
        let in_room = |x0: f64, x1: f64| found.iter().any(|&(x, _)| (x0..x1).contains(&x));
        [in_room(-1.0, 4.0), in_room(4.0, 9.0), in_room(9.0, 14.0)]
    };
    assert_eq!(rooms(""), [true, true, true]);
    assert_eq!(rooms("--inside 1,3"), [true, true, false], "through the open door");
    assert_eq!(rooms("--inside 11,3"), [false, false, true]);
    assert_eq!(rooms("--inside 1,3 --inside 11,3"), [true, true, true]);
    assert_eq!(rooms("--inside 11,3 --region 0,2,2,4"), [true, false, true]);
}

#[test]
fn structure_is_told_where_the_inside_is() {
    let folder = Folder::new();
    folder.write("plan.png", &plan(hall));
    let describe = format!("describe plan.png {SCALE} --at 5,5 --structure 0.2 --json -");
    refused(&folder, &describe, &["plan.png", "no interior", "--region"]);
    refused(&folder, &format!("{describe} --inside 5,5"), &["plan.png", "not enclosed"]);
    let told = folder.run(&format!("{describe} --region=-0.5,1,14,10"));
    assert_eq!((told.status, told.stderr.as_str()), (Some(0), ""));
}

#[test]
fn places_that_cannot_be_inside() {
    let folder = Folder::new();
    folder.write("plan.png", &plan(rooms));
    for (options, named) in [
        ("--inside=-1,3", "-1,3 is on a wall or glazing"),
        ("--inside 1,3 --inside 4,10", "4,10 is not enclosed"),
        ("--inside 17.5,3", "17.5,3 is off the plan, which spans x -3.00 to 17.00 m, y -2.00 to 13.00 m"),
        ("--region 17,0,30,9", "17,0,30,9 is off the plan"),
        ("--region 1,1,1,5", "1,1,1,5 is not a rectangle"),
        ("--region=-0.95,1,-0.85,3", "has no free place"),
        ("--inside 1", "'1' is not two numbers X,Y"),
        ("--inside 1,nan", "'1,nan' is not two numbers X,Y"),
    ] {
        let line = format!("map build plan.png {SCALE} --out floor.site {options}");
        let ran = folder.run(&line);
        assert!(ran.status == Some(2) && ran.stderr.contains(named), "{line}: {}", ran.stderr);
        assert!(!folder.path("floor.site").exists(), "{line}");
    }
    let line = format!("map build plan.png {SCALE} --out floor.site --region 1,2,3");
    let ran = folder.run(&line);
    assert!(ran.stderr.contains("'1,2,3' is not two opposite corners X0,Y0,X1,Y1"), "{}", ran.stderr);
}
