//! Plans as people have them, from end to end: dialects of map descriptions, kinds of images, colours.

use compass_tests::{Folder, Ran, number, numbers};
use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage};
use serde_json::Value;
use std::io::Cursor;

const SIZE: (u32, u32) = (200, 120);
const AT: &str = "--at=-0.5,1.0 --heading 33 --json -";
const HAND_MADE: &str = "--resolution 0.05 --origin=-3,-2";
const YAML: &str =
    "image: m.png\nresolution: 0.05\norigin: [-3.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n";

/// Whether a pixel is wall in the drawing that all inputs here are made from; rows count from the top.
fn is_wall(x: u32, y: u32) -> bool {
    let outline = !(4..196).contains(&x) || !(4..116).contains(&y);
    let partition = (98..102).contains(&x) && !(70..90).contains(&y);
    outline || partition || (is_inside([20, 20, 40, 24], x, y))
}

fn is_inside([x0, y0, x1, y1]: [u32; 4], x: u32, y: u32) -> bool {
    (x0..x1).contains(&x) && (y0..y1).contains(&y)
}

fn drawing(wall: u8, free: u8) -> GrayImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([if is_wall(x, y) { wall } else { free }]))
}

fn coloured(wall: [u8; 3], free: [u8; 3]) -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| Rgb(if is_wall(x, y) { wall } else { free }))
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
    encoded(image, ImageFormat::Png)
}

fn ranges(folder: &Folder, plan: &str, options: &str) -> Vec<f64> {
    numbers(&described(folder, &format!("describe {plan} {AT} {options}"))["range_m"])
}

/// The result of a command that may leave a note.
fn described(folder: &Folder, line: &str) -> Value {
    let Ran { status, stdout, stderr } = folder.run(line);
    assert_eq!(status, Some(0), "{line}: {stderr}");
    assert!(stderr.lines().all(|line| line.starts_with("compass: note: ")), "{line}: {stderr}");
    serde_json::from_str(&stdout).unwrap()
}

/// The ranges of the drawing, dark on light.
fn upright() -> Vec<f64> {
    let folder = Folder::new();
    folder.write("upright.png", &png(drawing(0, 255)));
    let found = ranges(&folder, "upright.png", HAND_MADE);
    assert!(found.iter().all(|range| (0.3..9.0).contains(range)), "walls on all sides");
    found
}

#[test]
fn dialects_of_map_descriptions() {
    let (folder, upright) = (Folder::new(), upright());
    let raw = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let unknown = is_inside([20, 90, 60, 110], x, y);
        Luma([if is_wall(x, y) {
            100
        } else if unknown {
            255
        } else {
            0
        }])
    });
    for (name, image, from, to) in [
        ("quoted", png(drawing(0, 254)), "negate: 0", "negate: \"0\""),
        ("none", png(drawing(0, 254)), "negate: 0\n", ""),
        ("negated", png(drawing(255, 0)), "negate: 0", "negate: 'True'"),
        ("raw", png(raw), "negate: 0", "negate: 0\nmode: raw"),
        ("scale", png(drawing(0, 254)), "negate: 0", "negate: 0\nmode: scale"),
        ("green walls", png(coloured([0, 200, 0], [254; 3])), "", ""),
    ] {
        folder.write("m.png", &image);
        folder.write("map.yaml", YAML.replace(from, to).as_bytes());
        assert_eq!(ranges(&folder, "map.yaml", ""), upright, "{name}");
    }
    folder.write("map.yaml", format!("{YAML}mode: fancy\n").as_bytes());
    let refused = folder.run(&format!("describe map.yaml {AT}"));
    assert!(refused.status == Some(2) && refused.stderr.contains("mode is fancy"), "{}", refused.stderr);
}

#[test]
fn a_turned_map_shows_the_same_walls() {
    let (folder, upright) = (Folder::new(), upright());
    // What the description turns back: the drawing turned clockwise, about the corner that stays in place.
    folder.write("m.png", &png(DynamicImage::ImageLuma8(drawing(0, 254)).rotate90()));
    let turned = YAML.replace("[-3.0, -2.0, 0.0]", "[7.0, -2.0, 1.5707963]");
    folder.write("map.yaml", turned.as_bytes());
    assert_eq!(ranges(&folder, "map.yaml", ""), upright);
    // At another angle about the same corner, from the same place in the drawing.
    folder.write("m.png", &png(drawing(0, 254)));
    let angle = 0.3_f64;
    folder.write("map.yaml", YAML.replace("-2.0, 0.0]", &format!("-2.0, {angle}]")).as_bytes());
    let (u, v) = (2.5, 3.0);
    let (x, y) = (-3.0 + u * angle.cos() - v * angle.sin(), -2.0 + u * angle.sin() + v * angle.cos());
    let heading = 33.0 + angle.to_degrees();
    let found = described(&folder, &format!("describe map.yaml --at={x},{y} --heading {heading} --json -"));
    let found = numbers(&found["range_m"]);
    let close = found.iter().zip(&upright).filter(|(a, b)| (**a - **b).abs() <= 0.1).count();
    assert!(close >= 340, "{close} of 360 within 0.1 m");
}

#[test]
fn a_map_of_another_machine_is_found_beside_its_description() {
    let (folder, upright) = (Folder::new(), upright());
    folder.write("m.png", &png(drawing(0, 254)));
    folder.write("map.yaml", YAML.replace("m.png", "/home/robot/maps/m.png").as_bytes());
    assert_eq!(ranges(&folder, "map.yaml", ""), upright);
    let said = folder.run(&format!("describe map.yaml {AT}")).stderr;
    assert!(said.contains("note: ") && said.contains("/home/robot/maps/m.png does not exist"), "{said}");
}

#[test]
fn an_image_without_its_description_is_noted() {
    let folder = Folder::new();
    folder.write("m.pgm", &encoded(drawing(0, 254), ImageFormat::Pnm));
    folder.write("m.yaml", YAML.replace("m.png", "m.pgm").as_bytes());
    let said = folder.run("describe m.pgm --at 0.5,0.6 --json -").stderr;
    assert!(said.contains("m.yaml beside it says 0.05 m per pixel, 0.01 is taken"), "{said}");
    let told = folder.run(&format!("describe m.pgm {AT} {HAND_MADE}"));
    assert_eq!((told.status, told.stderr.as_str()), (Some(0), ""), "nothing to note when it is told");
}

#[test]
fn kinds_of_images() {
    let (folder, upright) = (Folder::new(), upright());
    folder.write("plan.webp", &encoded(coloured([0; 3], [255; 3]), ImageFormat::WebP));
    assert_eq!(ranges(&folder, "plan.webp", HAND_MADE), upright);
    folder.write("big.tif", &big_tiff(&drawing(0, 255)));
    assert_eq!(ranges(&folder, "big.tif", HAND_MADE), upright);
    folder.write("palette.tif", &palette_tiff(&drawing(0, 1)));
    let refused = folder.run(&format!("describe palette.tif {AT} {HAND_MADE}"));
    assert_eq!(refused.status, Some(2));
    assert!(refused.stderr.contains("palette.tif: this kind of image is not read"), "{}", refused.stderr);
}

/// A gray TIFF image with 64-bit offsets, in one strip without compression.
fn big_tiff(image: &GrayImage) -> Vec<u8> {
    let (width, height) = image.dimensions();
    let mut bytes = b"II\x2b\0\x08\0\0\0".to_vec();
    bytes.extend(16_u64.to_le_bytes());
    let entries = [
        (256_u16, u64::from(width)),
        (257, u64::from(height)),
        (258, 8),
        (259, 1),
        (262, 1),
        (273, 16 + 8 + 9 * 20 + 8),
        (277, 1),
        (278, u64::from(height)),
        (279, u64::from(width * height)),
    ];
    bytes.extend((entries.len() as u64).to_le_bytes());
    for (tag, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(4_u16.to_le_bytes());
        bytes.extend(1_u64.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(0_u64.to_le_bytes());
    bytes.extend(image.as_raw());
    bytes
}

/// A TIFF image whose samples are places in a palette of black and white.
fn palette_tiff(image: &GrayImage) -> Vec<u8> {
    let (width, height) = image.dimensions();
    let palette = 8 + 2 + 10 * 12 + 4;
    let mut bytes = b"II\x2a\0\x08\0\0\0".to_vec();
    let entries = [
        (256_u16, 4_u16, 1, width),
        (257, 4, 1, height),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 3),
        (273, 4, 1, palette + 3 * 512),
        (277, 3, 1, 1),
        (278, 4, 1, height),
        (279, 4, 1, width * height),
        (320, 3, 768, palette),
    ];
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend((count as u32).to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    (0..768_u32).for_each(|at| bytes.extend((if at % 256 == 1 { u16::MAX } else { 0 }).to_le_bytes()));
    bytes.extend(image.as_raw());
    bytes
}

#[test]
fn light_on_dark_is_noted_and_inverted_when_told() {
    let (folder, upright) = (Folder::new(), upright());
    folder.write("plan.png", &png(drawing(255, 1)));
    let build = format!("map build plan.png {HAND_MADE} --out floor.site");
    let refused = folder.run(&build);
    assert_eq!(refused.status, Some(2));
    assert!(refused.stderr.contains("white on dark, add --invert"), "{}", refused.stderr);
    assert_eq!(ranges(&folder, "plan.png", &format!("{HAND_MADE} --invert")), upright);
    let built = folder.run(&format!("{build} --invert"));
    assert_eq!((built.status, built.stderr.as_str()), (Some(0), ""));
}

#[test]
fn colours_mean_what_is_told() {
    let (folder, upright) = (Folder::new(), upright());
    let mut plan = coloured([0; 3], [255; 3]);
    let mut paint = |pixels: [u32; 4], colour| {
        for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
            if is_inside(pixels, x, y) {
                plan.put_pixel(x, y, Rgb(colour));
            }
        }
    };
    // A window in the outline below, a door in the gap of the partition.
    paint([60, 116, 90, 120], [0, 0, 255]);
    paint([98, 70, 102, 90], [255, 0, 0]);
    folder.write("plan.png", &png(plan));
    let hits = |options: &str| {
        let found = described(&folder, &format!("describe plan.png {AT} {HAND_MADE} {options}"));
        let windows = found["hit"].as_array().unwrap().iter().filter(|hit| **hit == "window").count();
        (windows, numbers(&found["range_m"]), number(&found["stats"]["window_bins"]))
    };
    let (red, ..) = hits("");
    let (blue, open, counted) = hits("--glazing-color 0000ff --door-color ff0000");
    assert!(red > 5 && blue > 5 && red != blue, "{red} {blue}");
    assert_eq!((open, counted), (upright, blue as f64), "doors stand open, windows are as far as walls");
    let said = folder.run(&format!("describe plan.png {AT} {HAND_MADE}")).stderr;
    assert!(said.contains("120 pixels are coloured like 0000ff and count as wall"), "{said}");
    let wrong = folder.run(&format!("describe plan.png {AT} --glazing-color blue"));
    assert!(wrong.status == Some(2) && wrong.stderr.contains("'blue' is not a colour"), "{}", wrong.stderr);
}

#[test]
fn two_points_and_their_distance_tell_the_scale() {
    let (folder, upright) = (Folder::new(), upright());
    folder.write("plan.png", &png(drawing(0, 255)));
    let told = "--origin=-3,-2 --scale-points";
    assert_eq!(ranges(&folder, "plan.png", &format!("{told} 4,100,196,100,9.6")), upright);
    assert_eq!(ranges(&folder, "plan.png", &format!("{told} 10,10,40,50,2.5")), upright);
    for (points, named) in [
        ("4,100,4,100,9.6", "a pixel or more apart"),
        ("4,100,196,100,0", "the metres above 0"),
        ("4,100,196,100", "X1,Y1,X2,Y2,METRES"),
        ("4,100,196,100,9.6 --resolution 0.05", "--scale-points and --resolution say the same of an image"),
    ] {
        let refused = folder.run(&format!("describe plan.png {AT} {told} {points}"));
        assert!(refused.status == Some(2) && refused.stderr.contains(named), "{points}: {}", refused.stderr);
    }
}
