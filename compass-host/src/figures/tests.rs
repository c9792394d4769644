//! Every figure, for a room whose ranges are known in closed form.
//!
//! `COMPASS_FIGURES=DIR cargo test figures` keeps the pictures in DIR for inspection.

use std::path::{Path, PathBuf};

use compass_core::base::scan::Hit;
use image::{Rgb, RgbImage};
use plotters::style::RGBColor;

use super::*;

/// A room of 12 m x 7 m, 0.05 m a pixel, with windows in the north wall and a door in the east wall.
const SIDES: [f64; 2] = [12.0, 7.0];
const PIXEL: f64 = 0.05;
const AT: [f64; 2] = [4.2, 2.6];
const HEADING: f64 = 30.0;

fn is_window_at(x: f64, y: f64) -> bool {
    y > SIDES[1] - 0.2 && (x - 2.0).rem_euclid(3.0) < 1.6
}

fn is_door_at(x: f64, y: f64) -> bool {
    x > SIDES[0] - 0.2 && (3.0..4.5).contains(&y)
}

fn with_plan<T>(use_it: impl FnOnce(&PlanPicture<'_>) -> T) -> T {
    let centre = |n: u32| (f64::from(n) + 0.5) * PIXEL;
    let border = |x: f64, y: f64| x < 0.15 || y < 0.15 || x > SIDES[0] - 0.15 || y > SIDES[1] - 0.15;
    let is_window = |x: u32, y: u32| border(centre(x), centre(y)) && is_window_at(centre(x), centre(y));
    let is_wall = |x: u32, y: u32| {
        let (x, y) = (centre(x), centre(y));
        border(x, y) && !is_window_at(x, y) && !is_door_at(x, y)
    };
    use_it(&PlanPicture {
        width: (SIDES[0] / PIXEL) as u32,
        height: (SIDES[1] / PIXEL) as u32,
        resolution_m: PIXEL,
        origin: [0.0, 0.0],
        is_wall: &is_wall,
        is_window: &is_window,
    })
}

fn scan(heading_deg: f64) -> ([f64; 360], [Hit; 360]) {
    let (mut range_m, mut hit) = ([30.0; 360], [Hit::Open; 360]);
    for bin in 0..360 {
        let (sin, cos) = (heading_deg + bin as f64).to_radians().sin_cos();
        let to = |position: f64, side: f64, along: f64| {
            if along > 0.0 { (side - 0.15 - position) / along } else { (0.15 - position) / along }
        };
        let range = to(AT[0], SIDES[0], cos).min(to(AT[1], SIDES[1], sin));
        let (x, y) = (AT[0] + range * cos, AT[1] + range * sin);
        if is_door_at(x + 0.01, y) {
            continue;
        }
        range_m[bin] = range;
        hit[bin] = if is_window_at(x, y + 0.01) { Hit::Window } else { Hit::Wall };
    }
    (range_m, hit)
}

fn gradient(range_m: &[f64; 360]) -> [f64; 360] {
    std::array::from_fn(|n| (range_m[(n + 1) % 360] - range_m[n]).abs())
}

/// Draws into a folder that is kept on request, and reads the picture back.
fn drawn(name: &str, draw: impl FnOnce(&Path) -> Result<(), FigureError>) -> RgbImage {
    let scratch = tempfile::tempdir().unwrap();
    let folder = std::env::var_os("COMPASS_FIGURES").map_or(scratch.path().to_owned(), PathBuf::from);
    let path = folder.join(name);
    draw(&path).unwrap();
    let picture = image::open(path).unwrap().to_rgb8();
    assert_eq!(picture.width(), WIDTH_PX);
    assert!((400..2000).contains(&picture.height()), "{name}: {}", picture.height());
    assert!(border_is_blank(&picture), "{name} is clipped at its border");
    picture
}

fn border_is_blank(picture: &RgbImage) -> bool {
    let (right, bottom) = (picture.width() - 1, picture.height() - 1);
    picture.enumerate_pixels().all(|(x, y, &pixel)| {
        let inside = x > 2 && y > 2 && x < right - 2 && y < bottom - 2;
        inside || pixel == Rgb([255; 3])
    })
}

fn count(picture: &RgbImage, RGBColor(r, g, b): RGBColor) -> usize {
    picture.pixels().filter(|pixel| pixel.0 == [r, g, b]).count()
}

#[test]
fn rays_show_plan_and_robot() {
    let (range_m, hit) = scan(HEADING);
    let draw = |path: &Path| with_plan(|p| draw_rays(path, p, AT, HEADING, &range_m, &hit));
    let picture = drawn("rays.png", draw);
    assert!(count(&picture, style::PLAN_WALL) > 20_000);
    assert!(count(&picture, WINDOW) > 5_000);
    assert!(count(&picture, style::FOUND) > 400);
}

#[test]
fn polar_fills_each_bin_with_its_colour() {
    let (range_m, hit) = scan(HEADING);
    let picture = drawn("polar.png", |path| draw_polar(path, &range_m, &hit));
    for kind in style::HITS {
        assert!(count(&picture, style::tint(style::hit_colour(kind), 0.25)) > 5_000, "{kind:?}");
    }
    let open = drawn("polar-open.png", |path| draw_polar(path, &[30.0; 360], &[Hit::Open; 360]));
    assert!(count(&open, style::tint(WALL, 0.25)) < 1_000, "no walls");
}

#[test]
fn descriptor_uses_the_whole_colour_scale() {
    let (range_m, hit) = scan(HEADING);
    let steps = gradient(&range_m);
    let kinds = hit.map(|h| match h {
        Hit::Open => 0.0,
        Hit::Window => 0.5,
        Hit::Wall => 1.0,
    });
    let channels = [
        range_m.map(|r| r / 30.0),
        kinds,
        steps.map(|g| (g / 5.0).min(1.0)),
        range_m.map(|r| 1.0 / (1.0 + r)),
        std::array::from_fn(|n| steps[n] / 40.0 + steps[(n + 359) % 360] / 40.0),
    ];
    let picture = drawn("descriptor.png", |path| draw_descriptor(path, &channels));
    for value in [0.0, 0.5, 1.0] {
        assert!(count(&picture, style::viridis(value)) > 500, "{value}");
    }
}

#[test]
fn profile_shades_by_hit_type() {
    let (range_m, hit) = scan(HEADING);
    let steps = gradient(&range_m);
    let picture = drawn("profile.png", |path| draw_profile(path, &range_m, &steps, &hit));
    let windows = count(&picture, style::tint(WINDOW, profile::SHADE));
    let open = count(&picture, style::tint(OPEN, profile::SHADE));
    assert!(windows > open && open > 1_000, "{windows} {open}");
}

#[test]
fn hit_comparisons_show_as_much_agreement_as_there_is() {
    let (_, first) = scan(HEADING);
    let (_, second) = scan(HEADING + 6.0);
    let data = HitComparison {
        first_label: "query (cameras)",
        first: &first,
        second_label: "map",
        second: &second,
        known: None,
        cosine: 0.973,
        centred: -0.412,
    };
    let expected = data.agreeing_bins() as f64 / 360.0;
    assert!((0.5..0.95).contains(&expected), "{expected}");
    type Figure = fn(&Path, &HitComparison<'_>) -> Result<(), FigureError>;
    let figures: [(&str, Figure); 2] =
        [("hits-polar.png", draw_hits_polar), ("hits-linear.png", draw_hits_linear)];
    for (name, draw) in figures {
        let picture = drawn(name, |path| draw(path, &data));
        let (agree, differ) = (count(&picture, AGREE) as f64, count(&picture, DISAGREE) as f64);
        let share = agree / (agree + differ);
        assert!((share - expected).abs() < 0.05, "{name}: {share} for {expected}");
    }
}

#[test]
fn bins_that_were_not_seen_neither_agree_nor_differ() {
    let (_, hit) = scan(HEADING);
    let known = std::array::from_fn(|bin| bin < 270);
    let data = HitComparison {
        first_label: "seen",
        first: &[Hit::Wall; 360],
        second_label: "plan",
        second: &hit,
        known: Some(&known),
        cosine: 1.0,
        centred: 1.0,
    };
    let walls = hit[..270].iter().filter(|&&h| h == Hit::Wall).count();
    assert_eq!((data.known_bins(), data.agreeing_bins()), (270, walls));
    let picture = drawn("hits-half.png", |path| draw_hits_linear(path, &data));
    let strips = (count(&picture, style::UNKNOWN) as f64, count(&picture, AGREE) as f64);
    assert!((strips.0 / strips.1 - 180.0 / walls as f64).abs() < 0.1, "{strips:?} for {walls}");
    for (name, plan) in [("seen.png", None), ("seen-plan.png", Some(&hit))] {
        let picture = drawn(name, |path| draw_seen(path, &hit, &known, plan));
        assert!(count(&picture, style::UNKNOWN) > 20_000 && count(&picture, WINDOW) > 10_000, "{name}");
    }
}

#[test]
fn overlays_keep_frame_and_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.png");
    let pixel = |x: u32, _| if x < 200 { Rgb([10, 200, 90]) } else { Rgb([90; 3]) };
    RgbImage::from_fn(400, 300, pixel).save(&path).unwrap();
    let frame = crate::frame::Frame::read(&path).unwrap();
    let mut layer = Layer::new("windows", DISAGREE, 4.0);
    layer.lines.push(vec![[50.0, 50.0], [350.0, 50.0], [350.0, 250.0]]);
    layer.notes.extend([([50.0, 50.0], "1.5".to_owned()), ([52.0, 50.0], "2.5".to_owned())]);
    let picture = drawn("overlay.png", |path| draw_overlay(path, "A frame", &frame, &[layer]));
    let half = 780 * 1170;
    let green = count(&picture, RGBColor(10, 200, 90));
    assert!(green > half * 9 / 10 && green < half, "{green} of {half}");
    assert!(count(&picture, DISAGREE) > 1_800 * 3);
}

#[test]
fn correlation_draws_every_curve() {
    let bump = |n: usize, at: f64, width: f64| {
        let apart = (n as f64 - at).abs();
        (-(apart.min(360.0 - apart) / width).powi(2)).exp()
    };
    let plain = std::array::from_fn(|n| 0.8 + 0.17 * bump(n, 137.0, 25.0) + 0.06 * bump(n, 310.0, 15.0));
    let centred = std::array::from_fn(|n| 0.9 * bump(n, 139.0, 12.0) + 0.4 * bump(n, 310.0, 9.0) - 0.2);
    let curves = [Curve { label: "plain", score: &plain }, Curve { label: "centred", score: &centred }];
    let picture = drawn("correlation.png", |path| draw_correlation(path, &curves, Shifts::Signed));
    for n in 0..2 {
        assert!(count(&picture, style::Pen::series(n).colour) > 1_000, "curve {n}");
    }
    let edge = std::array::from_fn(|n| bump(n, 0.0, 20.0));
    drawn("correlation-edge.png", |path| {
        draw_correlation(path, &[Curve { label: "plain", score: &edge }], Shifts::Turn)
    });
}

#[test]
fn site_map_marks_poses_and_scores() {
    let grid = (1..23).flat_map(|x| (1..13).map(move |y| [f64::from(x) * 0.5, f64::from(y) * 0.5]));
    let candidates: Vec<[f64; 2]> = grid.collect();
    let scores: Vec<f64> =
        candidates.iter().map(|[x, y]| 1.0 / (1.0 + (x - AT[0]).hypot(y - AT[1]))).collect();
    let pose = |x: f64, y: f64, heading_deg: f64| MapPose { position: [x, y], heading_deg };
    let alternatives = [pose(9.0, 5.0, 210.0), pose(2.0, 5.5, 120.0)];
    let data = SiteMapPicture {
        candidates: &candidates,
        scores: Some(Scores { label: "score", values: &scores }),
        truth: Some(pose(AT[0], AT[1], HEADING)),
        found: Some(pose(AT[0] + 0.12, AT[1] - 0.05, HEADING + 2.5)),
        alternatives: &alternatives,
    };
    let draw = |data| move |path: &Path| with_plan(|plan| draw_site_map(path, plan, &data));
    let picture = drawn("site-map.png", draw(data));
    assert!(count(&picture, style::FOUND) > 300);
    let plain = drawn("site-map-plain.png", draw(SiteMapPicture { scores: None, ..data }));
    assert!(count(&plain, style::MUTED) > 5_000);
    assert!(count(&picture, style::MUTED) < 500, "all candidates have a score");

    let short = SiteMapPicture { scores: Some(Scores { label: "", values: &scores[1..] }), ..data };
    let error = with_plan(|plan| draw_site_map(Path::new("a.png"), plan, &short)).unwrap_err();
    assert_eq!(error.to_string(), "cannot draw a.png: 263 scores for 264 candidates");
}

#[test]
fn a_tall_plan_fits_the_page() {
    let plan = PlanPicture {
        width: 40,
        height: 600,
        resolution_m: 0.1,
        origin: [100.0, -20.0],
        is_wall: &|x, y| x == 0 || y == 0 || x == 39 || y == 599,
        is_window: &|x, y| x == 39 && y % 50 < 25,
    };
    let picture = drawn("tall.png", |path| draw_site_map(path, &plan, &SiteMapPicture::default()));
    assert!(picture.height() > 1_500 && count(&picture, WINDOW) > 100);
}

#[test]
fn error_cdf_draws_every_series() {
    let errors = |scale: f64| -> Vec<f64> {
        (1..200).map(|n| scale * (f64::from(n) / 200.0 / (1.0 - f64::from(n) / 200.0)).powf(0.9)).collect()
    };
    let (good_m, good_deg, mut bad_m, bad_deg) = (errors(0.05), errors(0.3), errors(0.4), errors(1.4));
    bad_m[150..].fill(f64::INFINITY);
    let series = [
        ErrorSeries { label: "single frame", position_m: &bad_m, heading_deg: &bad_deg },
        ErrorSeries { label: "track", position_m: &good_m, heading_deg: &good_deg },
    ];
    let picture = drawn("errors.png", |path| draw_error_cdf(path, &series));
    for n in 0..2 {
        assert!(count(&picture, style::Pen::series(n).colour) > 1_000, "series {n}");
    }
}

#[test]
fn panorama_shows_where_boundaries_are_probable() {
    use compass_core::vision::boundary::{CELLS, RUNGS};
    // Certain at one rung: the floor's at 1.5 times the camera's height, the ceiling's at 3 times its own.
    let mut probability = vec![0.0; CELLS];
    for (surface, ratio) in [(0, 1.5_f64), (1, 3.0)] {
        let rung = 9.0 + (ratio * 1.5 / 0.4).ln() / 0.060_81;
        let from = (surface * RUNGS + rung.round() as usize) * 360;
        probability[from..from + 360].fill(1.0);
    }
    let data = PanoramaPicture {
        ranges: &[None; 360],
        plan: None,
        heights_m: [1.6, 1.1],
        windows: &[],
        probability: Some(&probability),
    };
    let picture = drawn("boundaries.png", |path| draw_panorama(path, &data, |_, _| Some([0x60; 3])));
    // atan(1 / 1.5) is 33.7 degrees, atan(1 / 3) 18.4: a rung is 3.2 degrees of one high, and 1.0 of the other.
    let [floor, ceiling] =
        [RGBColor(0xff, 0x9a, 0x00), RGBColor(0x30, 0xe0, 0xff)].map(|c| count(&picture, c));
    assert!(floor > ceiling && ceiling > 5_000, "{floor} {ceiling}");
}

#[test]
fn panorama_shows_what_was_found_and_planned() {
    let (range_m, _) = scan(HEADING);
    let ranges = std::array::from_fn(|bin| (bin % 90 > 5).then_some([range_m[bin], bin as f64 / 360.0]));
    let data = PanoramaPicture {
        ranges: &ranges,
        plan: Some(&range_m.map(|r| 1.1 * r)),
        heights_m: [1.6, 1.1],
        windows: &[[[170.0, 195.0], [-5.0, 12.0]]],
        probability: None,
    };
    let sky = |_: f32, elevation: f32| (elevation < 0.7).then_some([0x80, 0x90, 0xa0]);
    let picture = drawn("panorama.png", |path| draw_panorama(path, &data, sky));
    for colour in [RGBColor(0xff, 0xf0, 0x30), RGBColor(0xff, 0x40, 0xc8), RGBColor(0x30, 0xb0, 0xff)] {
        assert!(count(&picture, colour) > 1_000, "{colour:?}");
    }
    assert!(count(&picture, RGBColor(0x80, 0x90, 0xa0)) > 500_000);
    assert!(count(&picture, style::UNKNOWN) > 50_000, "above the sky nothing is seen");
}

#[test]
fn descriptors_show_what_is_not_known() {
    let (range_m, _) = scan(HEADING);
    let seen = [range_m.map(|r| if r > 8.0 { f64::NAN } else { r / 30.0 }); 5];
    let pair = [("seen", &seen), ("plan", &[range_m.map(|r| r / 30.0); 5])];
    let picture = drawn("descriptors.png", |path| draw_descriptors(path, &pair));
    assert!(count(&picture, style::MUTED) > 1_000);
}

#[test]
fn an_unwritable_path_is_named_in_one_line() {
    let path = Path::new("no/such/folder/polar.png");
    let message = draw_polar(path, &[1.0; 360], &[Hit::Wall; 360]).unwrap_err().to_string();
    assert!(message.starts_with("cannot write no/such/folder/polar.png: "), "{message}");
    assert_eq!(message.lines().count(), 1);
}
