//! `--min-thickness`, from end to end: a drawing with text and lines in it, and the picture of a school.

use compass_host::plan_import::{Imported, PlanNote, PlanOptions, PlanRaster, import, load};
use compass_tests::{Folder, numbers};
use image::{DynamicImage, GrayImage, ImageFormat, Luma};
use std::io::Cursor;
use std::path::Path;

/// 12 m x 8 m at 0.02 m a pixel.
const SIZE: (u32, u32) = (600, 400);
const DESCRIBE: &str = "describe plan.png --resolution 0.02 --at 3,3 --heading 20 --json -";

/// An outer wall of 0.3 m and a partition of 0.12 m with a doorway; pixels from the top left.
fn is_wall(x: u32, y: u32) -> bool {
    let outer = (20..580).contains(&x) && (20..380).contains(&y);
    let inner = (35..565).contains(&x) && (35..365).contains(&y);
    (outer && !inner) || (inner && (300..306).contains(&x) && !(100..145).contains(&y))
}

/// Lines of 2 pixels: a word, a chain of dimensions, a door and its arc, a table.
fn is_ink(x: u32, y: u32) -> bool {
    let line = |from: [u32; 2], to: [u32; 2]| {
        (from[0]..=to[0] + 1).contains(&x) && (from[1]..=to[1] + 1).contains(&y)
    };
    let frame = |[x0, y0, x1, y1]: [u32; 4]| {
        line([x0, y0], [x1, y0])
            || line([x0, y1], [x1, y1])
            || line([x0, y0], [x0, y1])
            || line([x1, y0], [x1, y1])
    };
    let word = (0..6).any(|n| frame([100 + 14 * n, 180, 108 + 14 * n, 192]));
    let arc = x > 305 && (100..146).contains(&y) && {
        let from_hinge = f64::from(x - 305).hypot(f64::from(145 - y));
        (from_hinge - 45.0).abs() < 1.0
    };
    word || arc
        || line([306, 144], [350, 144])
        || line([20, 60], [579, 60])
        || line([100, 35], [100, 364])
        || frame([420, 200, 500, 245])
}

fn png(is_dark: impl Fn(u32, u32) -> bool) -> Vec<u8> {
    let image = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([if is_dark(x, y) { 0 } else { 255 }]));
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageLuma8(image).write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn ranges(folder: &Folder, options: &str) -> Vec<f64> {
    let ran = folder.run(&format!("{DESCRIBE} {options}"));
    assert_eq!(ran.status, Some(0), "{}", ran.stderr);
    numbers(&serde_json::from_str::<serde_json::Value>(&ran.stdout).unwrap()["range_m"])
}

#[test]
fn text_and_lines_leave_the_ranges_alone() {
    let folder = Folder::new();
    folder.write("plan.png", &png(is_wall));
    let bare = ranges(&folder, "");
    assert_eq!(ranges(&folder, "--min-thickness 0.1"), bare, "walls alone are not changed");
    folder.write("plan.png", &png(|x, y| is_wall(x, y) || is_ink(x, y)));
    let drawn = ranges(&folder, "");
    let hidden = drawn.iter().zip(&bare).filter(|(drawn, bare)| *bare - *drawn > 0.1).count();
    assert!(hidden > 180, "lines hide the walls of {hidden} bins");
    // Where a line meets a wall up to half of the thickness may stay of it.
    let found = ranges(&folder, "--min-thickness 0.1");
    let worst = found.iter().zip(&bare).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst <= 0.1, "{worst} m");
    let said = folder.run(&format!("{DESCRIBE} --min-thickness 0.1")).stderr;
    let named = "note: plan.png: strokes thinner than 0.1 m removed: ";
    assert!(said.contains(named) && said.contains(" % of the wall pixels (pieces: "), "{said}");
}

#[test]
fn thickness_that_leaves_nothing_or_means_nothing() {
    let folder = Folder::new();
    folder.write("plan.png", &png(is_ink));
    for (thickness, named) in [
        ("0.1", "plan.png: no walls: no stroke is 0.1 m thick"),
        ("0", "plan.png: least thickness is 0; metres from 1.5 pixels to 2 m are accepted"),
        ("-1", "least thickness is -1"),
        ("0.029", "least thickness is 0.029"),
        ("2.1", "least thickness is 2.1"),
        ("nan", "'nan' is not a finite number"),
    ] {
        let ran = folder.run(&format!("{DESCRIBE} --min-thickness {thickness}"));
        assert!(ran.status == Some(2) && ran.stderr.contains(named), "{thickness}: {}", ran.stderr);
    }
}

/// How many pixels of a box are wall; pixels from the top left.
fn walls_in(plan: &PlanRaster, [x0, y0, x1, y1]: [u32; 4]) -> usize {
    let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| plan.is_wall(x, plan.height - 1 - y)).count()
}

#[test]
fn the_picture_of_a_school_keeps_its_walls_alone() {
    let Some(data) = std::env::var_os("COMPASS_DATA") else {
        println!("skipped: COMPASS_DATA is not set");
        return;
    };
    let mut options = PlanOptions::new(Path::new(&data).join("plans/school_floor0.png"));
    // A door has 22 pixels.
    options.resolution_m = Some(0.04);
    let drawn = load(&options).unwrap();
    options.min_thickness_m = Some(0.2);
    let Imported { plan, notes, .. } = import(&options).unwrap();
    println!("{}", notes[0]);
    let [PlanNote::Cleaned { percent, pieces, cavities, .. }] = notes[..] else { panic!("{notes:?}") };
    // Measured: 14 % in 441 pieces.
    assert!((10..=18).contains(&percent) && pieces > 300 && cavities == 0);
    // Two pixels of a line that meets a wall stay, so the places keep clear of walls.
    for (name, place) in [
        ("Aula", [905, 505, 945, 522]),
        ("Foyer", [540, 608, 580, 628]),
        ("Kursraum", [330, 500, 400, 520]),
        ("a stair", [1070, 656, 1122, 706]),
        ("the arc of a door", [385, 740, 410, 753]),
        ("a doorway", [193, 757, 206, 769]),
        ("the doorway of a double door", [534, 223, 538, 262]),
    ] {
        let (before, after) = (walls_in(&drawn, place), walls_in(&plan, place));
        assert!(before > 10 && after == 0, "{name}: {before} pixels before, {after} after");
    }
    for (name, place) in [
        ("the north wall", [330, 57, 480, 64]),
        ("a partition", [330, 326, 470, 332]),
        ("the west wall", [318, 70, 324, 500]),
    ] {
        let all = ((place[2] - place[0]) * (place[3] - place[1])) as usize;
        assert_eq!(walls_in(&plan, place), all, "{name}");
    }
}
