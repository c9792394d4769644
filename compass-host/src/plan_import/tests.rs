//! Import of whole files.

use std::io::Cursor;
use std::time::Instant;

use image::codecs::jpeg::JpegEncoder;
use image::{GrayAlphaImage, GrayImage, ImageFormat, Luma, LumaA, Rgb, RgbImage, Rgba, RgbaImage};
use tempfile::TempDir;

use super::*;

const WHITE: [u8; 3] = [255; 3];
const BLACK: [u8; 3] = [0; 3];
const RED: [u8; 3] = [255, 0, 0];

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn fill(image: &mut RgbImage, [x0, y0, x1, y1]: [u32; 4], colour: [u8; 3]) {
    for y in y0..y1 {
        for x in x0..x1 {
            image.put_pixel(x, y, Rgb(colour));
        }
    }
}

/// A room with walls of 3 to 10 pixels and windows of 5, at `k` times the size, shifted by `shift`.
fn room(k: u32, shift: u32) -> RgbImage {
    let mut image = RgbImage::from_pixel(160 * k, 120 * k, Rgb(WHITE));
    let mut draw = |edges: [u32; 4], colour| fill(&mut image, edges.map(|v| v * k + shift), colour);
    draw([10, 10, 150, 20], BLACK);
    draw([10, 10, 17, 110], BLACK);
    draw([10, 105, 150, 110], BLACK);
    draw([145, 10, 150, 110], BLACK);
    draw([80, 20, 83, 70], BLACK);
    draw([83, 60, 120, 66], BLACK);
    for [x0, y0, x1, y1] in [[30, 10, 60, 20], [90, 105, 130, 110], [145, 31, 150, 77], [80, 33, 83, 52]] {
        draw([x0, y0, x1, y1], WHITE);
    }
    draw([30, 13, 60, 18], RED);
    draw([90, 105, 130, 110], RED);
    draw([145, 31, 150, 77], RED);
    draw([79, 33, 84, 52], RED);
    image
}

/// The room drawn at four times the size, off the pixel grid by `shift` quarters, and averaged.
fn smooth_room(shift: u32) -> RgbImage {
    let large = room(4, shift);
    RgbImage::from_fn(160, 120, |x, y| {
        let mean = |c: usize| {
            let sum: u32 =
                (0..16).map(|i| u32::from(large.get_pixel(4 * x + i % 4, 4 * y + i / 4).0[c])).sum();
            (sum / 16) as u8
        };
        Rgb([mean(0), mean(1), mean(2)])
    })
}

/// The effect of 4:2:0 coding on colour: chroma averaged over 2 x 2 pixels, luma kept.
fn coarse_chroma(image: &RgbImage) -> RgbImage {
    let ycc = |p: &Rgb<u8>| {
        let [r, g, b] = p.0.map(f64::from);
        let y = 0.299 * r + 0.587 * g + 0.114 * b;
        [y, 0.564 * (b - y), 0.713 * (r - y)]
    };
    RgbImage::from_fn(image.width(), image.height(), |x, y| {
        let block =
            [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(u, v)| ycc(image.get_pixel((x & !1) + u, (y & !1) + v)));
        let mean = |c: usize| block.iter().map(|p| p[c]).sum::<f64>() / 4.0;
        let (luma, cb, cr) = (ycc(image.get_pixel(x, y))[0], mean(1), mean(2));
        Rgb([luma + 1.402 * cr, luma - 0.344 * cb - 0.714 * cr, luma + 1.772 * cb].map(|v| v.round() as u8))
    })
}

fn jpeg(image: &RgbImage, quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(image).unwrap();
    bytes
}

fn png(image: &image::DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn import(bytes: &[u8]) -> Result<PlanRaster, PlanImportError> {
    let folder = folder();
    let path = folder.path().join("plan.img");
    std::fs::write(&path, bytes).unwrap();
    load(&PlanOptions::new(path))
}

fn complaint(result: Result<PlanRaster, PlanImportError>) -> String {
    let message = result.unwrap_err().to_string();
    assert!(!message.contains('\n'), "one line: {message}");
    message
}

/// Whether `is` holds somewhere within one pixel of (x, y).
fn near(plan: &PlanRaster, x: u32, y: u32, is: impl Fn(&PlanRaster, u32, u32) -> bool) -> bool {
    (0..9).any(|i| is(plan, (x + i % 3).wrapping_sub(1), (y + i / 3).wrapping_sub(1)))
}

/// The crisp room, and the one shifted by a pixel when the drawing lies between the two and touches both.
fn truths(shift: u32) -> Vec<PlanRaster> {
    (0..=shift.min(1)).map(|on| import(&png(&room(1, on).into())).unwrap()).collect()
}

/// Every pixel found lies within one pixel of one that the drawing touches; every pixel in all of `truths` lies within
/// one pixel of one found; and where all are solid, so is the result.
fn assert_same_but_rims(found: &PlanRaster, truths: &[PlanRaster], what: &str) {
    let truth = &truths[0];
    for y in 0..truth.height {
        for x in 0..truth.width {
            for (is, kind) in [(PlanRaster::is_wall as Is, "wall"), (PlanRaster::is_window, "window")] {
                let right = !is(found, x, y) || truths.iter().any(|truth| near(truth, x, y, is));
                assert!(right, "{what}: false {kind} at {x},{y}");
                let seen = !truths.iter().all(|truth| is(truth, x, y)) || near(found, x, y, is);
                assert!(seen, "{what}: missed {kind} at {x},{y}");
                let inside = truths.iter().all(|truth| !near(truth, x, y, |plan, u, v| !is(plan, u, v)));
                assert!(!inside || is(found, x, y), "{what}: hole in {kind} at {x},{y}");
            }
        }
    }
}

type Is = fn(&PlanRaster, u32, u32) -> bool;

/// No wall along glazing: beside the long sides of a window, two pixels from its ends, no pixel is wall.
fn assert_no_wall_along_windows(found: &PlanRaster, what: &str) {
    for (xs, ys) in [(32..58, 100..110), (92..128, 7..18), (142..153, 45..87), (76..87, 70..85)] {
        for (x, y) in ys.flat_map(|y| xs.clone().map(move |x| (x, y))) {
            assert!(!found.is_wall(x, y), "{what}: wall along a window at {x},{y}");
        }
    }
}

#[test]
fn crisp_plan_is_read_to_the_pixel() {
    let image = room(1, 0);
    let plan = import(&png(&image.clone().into())).unwrap();
    for (x, y, pixel) in image.enumerate_pixels() {
        let south = 119 - y;
        assert_eq!(plan.is_wall(x, south), pixel.0 == BLACK, "wall {x},{y}");
        assert_eq!(plan.is_window(x, south), pixel.0 == RED, "window {x},{y}");
    }
    assert_eq!((plan.width, plan.height, plan.resolution_m, plan.origin), (160, 120, 0.01, [0.0; 2]));
    assert_eq!(plan.resolution_nm(), 10_000_000);
    assert!(plan.walls_mask().get(10, 119 - 10) && !plan.walls_mask().get(10, 119 - 9));
    assert!(plan.windows_mask().get(30, 119 - 13));
}

#[test]
fn smoothed_and_compressed_plans_differ_by_rims_only() {
    for shift in 0..4 {
        let smooth = smooth_room(shift);
        let files = [
            ("png", png(&smooth.clone().into())),
            ("jpeg 75", jpeg(&smooth, 75)),
            ("4:2:0", png(&coarse_chroma(&smooth).into())),
            ("4:2:0 jpeg 75", jpeg(&coarse_chroma(&smooth), 75)),
            ("crisp jpeg 75", jpeg(&room(1, 0), 75)),
            ("crisp 4:2:0", png(&coarse_chroma(&room(1, 0)).into())),
        ];
        for (what, bytes) in files {
            let what = format!("{what}, shift {shift}");
            let found = import(&bytes).unwrap();
            assert_same_but_rims(&found, &truths(shift), &what);
            assert_no_wall_along_windows(&found, &what);
        }
    }
}

#[test]
fn every_colour_type_reads_the_same() {
    let dark = |x: u32, y: u32| x == 2 && y == 0;
    let gray = GrayImage::from_fn(11, 3, |x, y| Luma([if dark(x, y) { 0 } else { 255 }]));
    // Transparent black is paper.
    let gray_alpha = GrayAlphaImage::from_fn(11, 3, |x, y| LumaA([0, if dark(x, y) { 255 } else { 0 }]));
    let rgba = RgbaImage::from_fn(11, 3, |x, y| Rgba([0, 0, 0, if dark(x, y) { 255 } else { 0 }]));
    let base = image::DynamicImage::from(gray);
    let images = [
        base.to_luma16().into(),
        base.to_rgb8().into(),
        base.to_rgb16().into(),
        gray_alpha.into(),
        rgba.into(),
        base,
    ];
    for image in images {
        let plan = import(&png(&image)).unwrap();
        let bits: Vec<(u32, u32)> =
            (0..33).map(|i| (i % 11, i / 11)).filter(|&(x, y)| plan.occupied(x, y)).collect();
        assert_eq!(bits, [(2, 2)], "{:?}: top row becomes row 2", image.color());
        assert!(plan.is_wall(2, 2));
    }
}

#[test]
fn every_format_is_read() {
    let image = image::DynamicImage::from(room(1, 0));
    for format in [ImageFormat::Png, ImageFormat::Bmp, ImageFormat::Tiff, ImageFormat::Pnm] {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        assert!(import(bytes.get_ref()).unwrap().is_window(30, 119 - 13), "{format:?}");
    }
    assert!(import(b"P2\n2 1\n100\n0 100\n").unwrap().is_wall(0, 0), "ascii PGM");
    assert!(!import(b"P2\n2 1\n100\n0 100\n").unwrap().is_wall(1, 0), "maxval 100 is white");
}

#[test]
fn pair_takes_the_difference_for_glazing() {
    let folder = folder();
    let [plan, walls] = ["plan.png", "walls.png"].map(|name| folder.path().join(name));
    let mut image = RgbImage::from_pixel(20, 6, Rgb(WHITE));
    fill(&mut image, [0, 2, 20, 4], BLACK);
    let mut bare = image.clone();
    fill(&mut bare, [5, 2, 9, 4], WHITE);
    fill(&mut bare, [12, 2, 15, 4], WHITE);
    fill(&mut image, [12, 2, 15, 4], [255, 100, 100]);
    image::DynamicImage::from(image).save(&plan).unwrap();
    image::DynamicImage::from(bare).to_luma8().save(&walls).unwrap();
    let found = load(&PlanOptions { walls: Some(walls), ..PlanOptions::new(plan) }).unwrap();
    let row: String = (0..20)
        .map(|x| match (found.is_wall(x, 2), found.is_window(x, 2)) {
            (true, false) => '#',
            (false, true) => 'W',
            _ => '?',
        })
        .collect();
    assert_eq!(row, "#####WWWW###WWW#####");
}

#[test]
fn smoothed_pair_differs_by_rims_only() {
    let folder = folder();
    for shift in 0..4 {
        let [plan, walls] = ["plan.jpg", "walls.jpg"].map(|name| folder.path().join(name));
        let image = smooth_room(shift);
        let mut bare = image.clone();
        // Red to white: red pixels have full R, so R alone shows the walls.
        bare.pixels_mut().for_each(|p| p.0 = [p.0[0]; 3]);
        let black = image::DynamicImage::from(RgbImage::from_fn(160, 120, |x, y| {
            Rgb([image.get_pixel(x, y).0[1]; 3])
        }));
        std::fs::write(&plan, jpeg(&black.to_rgb8(), 75)).unwrap();
        std::fs::write(&walls, jpeg(&bare, 75)).unwrap();
        let found = load(&PlanOptions { walls: Some(walls), ..PlanOptions::new(plan) }).unwrap();
        assert_same_but_rims(&found, &truths(shift), &format!("pair, shift {shift}"));
        assert_no_wall_along_windows(&found, "pair");
    }
}

#[test]
fn pair_of_two_sizes_is_refused() {
    let folder = folder();
    let [plan, walls] = ["plan.png", "walls.png"].map(|name| folder.path().join(name));
    room(1, 0).save(&plan).unwrap();
    RgbImage::new(7, 9).save(&walls).unwrap();
    let message = complaint(load(&PlanOptions { walls: Some(walls), ..PlanOptions::new(plan) }));
    assert!(message.contains("walls.png: 7 x 9 pixels, but"), "{message}");
    assert!(message.contains("plan.png has 160 x 120"), "{message}");
}

fn ros_map(folder: &TempDir, negate: u8, shades: &[u8]) -> PathBuf {
    let width = u32::try_from(shades.len()).unwrap();
    GrayImage::from_raw(width, 1, shades.to_vec()).unwrap().save(folder.path().join("map.pgm")).unwrap();
    let path = folder.path().join("map.yaml");
    let text = format!(
        "image: map.pgm\nresolution: 0.05\norigin: [-3.5, 2.25, 0.0]\nnegate: {negate}\noccupied_thresh: 0.65\n"
    );
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn ros_map_uses_its_own_thresholds() {
    let folder = folder();
    let walls = |plan: &PlanRaster| (0..6).filter(|&x| plan.is_wall(x, 0)).collect::<Vec<_>>();
    let shades = [0, 89, 90, 165, 166, 255];
    let plan = load(&PlanOptions::new(ros_map(&folder, 0, &shades))).unwrap();
    assert_eq!(walls(&plan), [0, 1]);
    assert_eq!((plan.resolution_m, plan.origin), (0.05, [-3.5, 2.25]));
    let path = ros_map(&folder, 1, &shades);
    assert_eq!(walls(&load(&PlanOptions::new(&path)).unwrap()), [4, 5]);
    let options = PlanOptions { resolution_m: Some(0.1), origin: Some([1.0, 2.0]), ..PlanOptions::new(path) };
    let plan = load(&options).unwrap();
    assert_eq!((plan.resolution_m, plan.origin), (0.1, [1.0, 2.0]), "options override the description");
}

#[test]
fn bad_resolutions_and_origins_are_named() {
    let folder = folder();
    let path = folder.path().join("plan.png");
    room(1, 0).save(&path).unwrap();
    for (value, shown) in
        [(0.0, "0"), (-0.5, "-0.5"), (f64::NAN, "NaN"), (f64::INFINITY, "inf"), (4.5, "4.5")]
    {
        let options = PlanOptions { resolution_m: Some(value), ..PlanOptions::new(&path) };
        let message = complaint(load(&options));
        assert!(message.contains(&format!("plan.png: resolution is {shown};")), "{message}");
    }
    let options = PlanOptions { origin: Some([1.0, f64::NAN]), ..PlanOptions::new(&path) };
    assert!(complaint(load(&options)).contains("origin is 1,NaN;"));
    for edge in [0.001, 4.0] {
        let options = PlanOptions { resolution_m: Some(edge), ..PlanOptions::new(&path) };
        assert_eq!(f64::from(load(&options).unwrap().resolution_nm()), edge * 1e9);
    }
}

#[test]
fn files_that_are_no_plan_are_named() {
    let message = complaint(load(&PlanOptions::new("/nowhere/plan.png")));
    assert!(message.starts_with("/nowhere/plan.png: cannot be read: "), "{message}");
    assert!(complaint(import(b"hello, this is text")).contains("plan.img: not a PNG"));
    assert!(complaint(import(b"")).contains("not a PNG"));
    assert!(complaint(import(b"GIF89a\x01\x00\x01\x00")).contains("plan.img: this is a GIF image"));
    assert!(complaint(import(b"ISO-10303-21;\nHEADER;")).contains("plan.img: this is an IFC"));
    let grey = RgbImage::from_pixel(9, 9, Rgb([200, 200, 199]));
    assert!(complaint(import(&png(&grey.into()))).contains("every pixel is #c8c8c7"));
    let black = GrayImage::from_pixel(9, 9, Luma([0]));
    assert!(complaint(import(&png(&black.into()))).contains("every pixel is #000000"));
    let mut red_only = RgbImage::from_pixel(20, 20, Rgb(WHITE));
    fill(&mut red_only, [3, 3, 9, 9], RED);
    assert!(complaint(import(&png(&red_only.into()))).contains("no walls"));
    let wide = GrayImage::from_fn(65_536, 1, |x, _| Luma([(x % 256) as u8]));
    assert!(complaint(import(&png(&wide.into()))).contains("65536 x 1 pixels"));
}

#[test]
fn truncated_files_are_refused() {
    let image = room(1, 0);
    let mut files = vec![png(&image.clone().into()), jpeg(&image, 90)];
    for format in [ImageFormat::Bmp, ImageFormat::Tiff, ImageFormat::Pnm] {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        files.push(bytes.into_inner());
    }
    for bytes in files {
        for part in [60, bytes.len() / 2, bytes.len() * 9 / 10] {
            let message = complaint(import(&bytes[..part]));
            assert!(message.contains("damaged or truncated"), "{part} of {}: {message}", bytes.len());
        }
    }
}

#[test]
fn drawing_keeps_the_masks_disjoint() {
    let mut plan = PlanRaster::empty(10, 4, 0.05, [1.0, 2.0]);
    plan.set_wall(9, 3);
    plan.set_window(9, 3);
    plan.set_window(8, 0);
    plan.set_wall(8, 0);
    plan.set_wall(10, 0);
    plan.set_window(0, 4);
    assert!(plan.is_window(9, 3) && !plan.is_wall(9, 3));
    assert!(plan.is_wall(8, 0) && !plan.is_window(8, 0) && plan.occupied(8, 0));
    assert_eq!(plan.walls, [0, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(plan.windows, [0, 0, 0, 0, 0, 0, 0, 2]);
    assert!(plan.walls_mask().get(8, 0) && plan.windows_mask().get(9, 3));
    plan.walls.clear();
    assert!(!plan.is_wall(8, 0), "a short vector reads as unset");
}

/// Run by hand: `cargo test --release -p compass-host large_plans -- --ignored --nocapture`.
#[test]
#[ignore = "takes seconds and prints times"]
fn large_plans_import_quickly() {
    let (width, height) = (7351, 4206);
    let gray =
        GrayImage::from_fn(width, height, |x, y| Luma([if x % 300 < 8 || y % 400 < 8 { 0 } else { 255 }]));
    let base = image::DynamicImage::from(gray);
    for (what, bytes) in
        [("gray", png(&base)), ("rgb", png(&base.to_rgb8().into())), ("rgb jpeg", jpeg(&base.to_rgb8(), 75))]
    {
        let start = Instant::now();
        let plan = import(&bytes).unwrap();
        println!("{what}: {} ms", start.elapsed().as_millis());
        assert!(plan.is_wall(0, 100));
    }
}
