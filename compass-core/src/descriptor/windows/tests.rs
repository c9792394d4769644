use super::*;
use crate::vision::segments;
use proptest::prelude::*;
use std::vec::Vec;

/// Sizes of a workspace's edges, its proposals and the list of windows.
type Capacity = (usize, usize, usize);
const AMPLE: Capacity = (512, 2048, 64);

struct Outcome {
    found: Found,
    windows: Vec<ImageWindow>,
    proposals: Vec<Proposal>,
}

fn run(
    image: &GrayImage<'_>,
    colour: Option<&RgbImage<'_>>,
    segments: &[Segment],
    capacity: Capacity,
) -> Outcome {
    // Former contents of the buffers must not matter.
    let junk = Edge { x: 9, y0: 1, y1: 900, length: 77 };
    let mut rows = std::vec![Row::default(); image.height() as usize];
    let mut columns = std::vec![7; image.width() as usize];
    let mut edges = std::vec![junk; capacity.0];
    let mut proposals = std::vec![Proposal::default(); capacity.1];
    let mut windows = std::vec![ImageWindow::default(); capacity.2];
    let mut workspace =
        Workspace { rows: &mut rows, columns: &mut columns, edges: &mut edges, proposals: &mut proposals };
    let found = find(image, colour, segments, &Parameters::default(), &mut workspace, &mut windows).unwrap();
    windows.truncate(found.count);
    proposals.truncate(found.proposals);
    Outcome { found, windows, proposals }
}

fn segments_of(image: &GrayImage<'_>) -> Vec<Segment> {
    let (width, height) = (image.width(), image.height());
    let mut cells = std::vec![0; segments::pixels(width, height)];
    let mut smoothed = std::vec![0; segments::pixels(width, height)];
    let mut trail = std::vec![0; segments::trail_len(width, height)];
    let mut workspace = segments::Workspace { cells: &mut cells, smoothed: &mut smoothed, trail: &mut trail };
    let mut found = std::vec![Segment::default(); 2000];
    let detected =
        segments::detect(image, None, &segments::Parameters::default(), &mut workspace, &mut found).unwrap();
    found.truncate(detected.count);
    found
}

/// Left column, top row, width and height of the windows in a wall 1472 pixels wide.
const WINDOWS: [[u32; 4]; 3] = [[240, 400, 140, 300], [560, 380, 180, 320], [980, 420, 90, 260]];
/// Floor and ceiling meet the wall here.
const WALL: (u32, u32) = (300, 800);

/// A level within 0..n that looks random.
fn noise(x: u32, y: u32, n: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    (h ^ (h >> 13)) % n
}

/// A gray wall between darker floor and ceiling in a circle, with windows that show a restless outside.
fn scene(scale: u32) -> (Vec<u8>, u32, u32) {
    let (width, height) = (1472 / scale, 1440 / scale);
    let level = |px: u32, py: u32| {
        let (x, y) = (px * scale, py * scale);
        let (dx, dy) = (x.abs_diff(736), y.abs_diff(720));
        if dx * dx + dy * dy > 720 * 720 {
            return 0;
        }
        let within =
            |&[left, top, w, h]: &[u32; 4]| (left..left + w).contains(&x) && (top..top + h).contains(&y);
        let ground = if WINDOWS.iter().any(within) {
            // Faint patches of eight pixels, too weak for segments, and grain.
            200 + noise(x / 8, y / 8, 3) * 3 + noise(px, py, 7)
        } else if (WALL.0..WALL.1).contains(&y) {
            110 + noise(px, py, 3)
        } else {
            70 + noise(px, py, 3)
        };
        ground as u8
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| level(x, y))).collect();
    (pixels, width, height)
}

#[track_caller]
fn expect_windows(found: &[ImageWindow], scale: u32, expected: &[[u32; 4]]) {
    let mut found = found.to_vec();
    found.sort_by_key(|w| w.x0);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (w, &[x, y, width, height]) in found.iter().zip(expected) {
        let seen = [w.x0, w.y0, w.x1, w.y1].map(|v| u32::from(v) * scale);
        let far = seen.iter().zip([x, y, x + width, y + height]).any(|(a, b)| a.abs_diff(b) > 16);
        assert!(!far, "{w:?} for {:?}", [x, y, width, height]);
    }
}

#[test]
fn a_wall_with_three_windows() {
    for scale in [1, 2] {
        let (pixels, width, height) = scene(scale);
        let image = GrayImage::new(&pixels, width, height).unwrap();
        let outcome = run(&image, None, &segments_of(&image), AMPLE);
        expect_windows(&outcome.windows, scale, &WINDOWS);
        let (top, bottom) = outcome.found.band;
        assert!(u32::from(top) * scale < 480 && u32::from(bottom) * scale > 560, "{:?}", outcome.found);
        assert!(!outcome.found.truncated);
        let wall = |r: Rejection| matches!(r, Rejection::Dark | Rejection::LowContrast);
        let dull = outcome.proposals.iter().filter(|p| p.rejection.is_some_and(wall)).count();
        assert!(dull > 0, "the wall between windows: {:?}", outcome.proposals);
    }
}

#[test]
fn red_boxes_are_rejected() {
    let (pixels, width, height) = scene(2);
    let image = GrayImage::new(&pixels, width, height).unwrap();
    // The middle window's box is a vest.
    let vest = |x: u32| (280..370).contains(&x);
    let samples: Vec<u8> = (0..width * height)
        .flat_map(|at| if vest(at % width) { [230, 60, 40] } else { [pixels[at as usize]; 3] })
        .collect();
    let colour = RgbImage::new(&samples, width, height).unwrap();
    let outcome = run(&image, Some(&colour), &segments_of(&image), AMPLE);
    expect_windows(&outcome.windows, 2, &[WINDOWS[0], WINDOWS[2]]);
    assert!(outcome.proposals.iter().any(|p| p.rejection == Some(Rejection::Red)));
}

#[test]
fn full_buffers_are_reported() {
    let (pixels, width, height) = scene(2);
    let image = GrayImage::new(&pixels, width, height).unwrap();
    let segments = segments_of(&image);
    for capacity in [(3, 2048, 64), (512, 2, 64), (512, 2048, 2), (0, 0, 0)] {
        let outcome = run(&image, None, &segments, capacity);
        assert!(outcome.found.truncated, "{capacity:?}");
        assert!(outcome.windows.len() <= capacity.2);
    }
    // Rejected proposals that do not fit change nothing.
    let all = run(&image, None, &segments, AMPLE);
    let passed = |p: &&Proposal| p.rejection.is_none_or(|r| r >= Rejection::Periphery);
    let needed = all.proposals.iter().filter(passed).count();
    assert!(needed < all.proposals.len());
    let tight = run(&image, None, &segments, (512, needed, 64));
    assert!(!tight.found.truncated);
    assert_eq!(tight.windows, all.windows);
}

#[test]
fn empty_and_noisy_images_do_not_panic() {
    for (width, height) in [(1, 1), (2, 3), (64, 48), (320, 300)] {
        for level in [0, 12, 13, 255] {
            let pixels = std::vec![level; (width * height) as usize];
            let image = GrayImage::new(&pixels, width, height).unwrap();
            let outcome = run(&image, None, &segments_of(&image), AMPLE);
            assert_eq!((outcome.found.count, outcome.found.truncated), (0, false));
        }
        let grain: Vec<u8> = (0..width * height).map(|at| noise(at % width, at / width, 256) as u8).collect();
        let image = GrayImage::new(&grain, width, height).unwrap();
        run(&image, None, &segments_of(&image), AMPLE);
    }
}

#[test]
fn wrong_sizes_are_rejected() {
    let image = GrayImage::new(&[0; 12], 4, 3).unwrap();
    let colour = RgbImage::new(&[0; 36], 3, 4).unwrap();
    let (mut rows, mut columns) = ([Row::default(); 3], [0; 4]);
    let mut workspace =
        Workspace { rows: &mut rows, columns: &mut columns, edges: &mut [], proposals: &mut [] };
    let defaults = Parameters::default();
    let refused = find(&image, Some(&colour), &[], &defaults, &mut workspace, &mut []);
    assert_eq!(refused, Err(PaperError::Colour));
    workspace.columns = &mut [];
    assert_eq!(find(&image, None, &[], &defaults, &mut workspace, &mut []), Err(PaperError::Workspace));
}

#[test]
fn short_and_inclined_segments_are_ignored() {
    let defaults = Parameters::default();
    let upright = |x2: f32, y2: f32| {
        let segment = Segment { x1: 100.0, y1: 100.0, x2, y2, score: 0 };
        Edge::upright(&segment, &defaults).is_some()
    };
    assert!(upright(100.0, 129.0) && upright(100.0, 71.0) && !upright(100.0, 128.0));
    // 29 and 31 degrees.
    assert!(!upright(187.5, 148.5) && upright(185.7, 151.5));
    assert!(!upright(100.0, f32::NAN) && !upright(100.0, f32::INFINITY) && !upright(100.0, -40.0));
}

#[test]
fn the_worse_of_two_overlapping_proposals_is_suppressed() {
    let passed = |x0, x1, score| {
        let window = ImageWindow { x0, y0: 0, x1, y1: 10, score };
        Proposal { window, rejection: None }
    };
    // Intersection over union with the first: 5 / 15, 4 / 16, and 1 / 3 with one already gone.
    let mut proposals = [passed(5, 15, 30), passed(0, 10, 50), passed(6, 16, 20), passed(11, 21, 10)];
    suppress::suppress(&Parameters::default(), &mut proposals);
    let outcome = proposals.map(|p| (p.window.x0, p.rejection));
    let gone = Some(Rejection::Suppressed);
    assert_eq!(outcome, [(0, None), (5, gone), (6, None), (11, gone)]);
}

#[test]
fn a_window_at_the_rim_is_rejected() {
    let (pixels, width, height) = scene(2);
    let image = GrayImage::new(&pixels, width, height).unwrap();
    let (mut rows, mut columns) = (std::vec![Row::default(); 720], std::vec![0; 736]);
    let lens = band::lens(&image, &mut rows, &mut columns);
    let rejected = |x0, x1| {
        let window = ImageWindow { x0, y0: 340, x1, y1: 380, score: 1 };
        let mut proposals = [Proposal { window, rejection: None }];
        suppress::reject(&image, None, &lens, &Parameters::default(), &mut proposals);
        proposals[0].rejection
    };
    // The circle spans columns 8 to 728; 95 % of its radius, 26 to 710.
    assert_eq!((rejected(34, 60), rejected(680, 700)), (None, None));
    assert_eq!(rejected(18, 60), Some(Rejection::Periphery));
    assert_eq!(rejected(680, 720), Some(Rejection::Periphery));
}

fn any_segment() -> impl Strategy<Value = Segment> {
    let ends = prop_oneof![
        8 => (-5.0_f32..70.0, -5.0_f32..70.0, -5.0_f32..70.0, -5.0_f32..70.0),
        2 => (0.0_f32..60.0, 0.0_f32..1.0).prop_map(|(x, d)| (x, 2.0, x + d, 50.0)),
        1 => (any::<f32>(), any::<f32>(), any::<f32>(), any::<f32>()),
    ];
    ends.prop_map(|(x1, y1, x2, y2)| Segment { x1, y1, x2, y2, score: 1 })
}

proptest! {
    #[test]
    fn proptest_windows_lie_within_the_image(
        width in 1_u32..70,
        height in 1_u32..70,
        pixels in prop::collection::vec(any::<u8>(), 70 * 70 * 3),
        segments in prop::collection::vec(any_segment(), 0..60),
        capacity in (0_usize..40, 0_usize..200, 0_usize..20),
        odd in any::<[u16; 6]>(),
        percent in any::<[u8; 7]>(),
    ) {
        let image = GrayImage::new(&pixels, width, height).unwrap();
        let colour = RgbImage::new(&pixels, width, height).unwrap();
        let outcome = run(&image, Some(&colour), &segments, capacity);
        for w in &outcome.windows {
            prop_assert!(w.x0 < w.x1 && u32::from(w.x1) <= width && w.y0 < w.y1 && u32::from(w.y1) <= height);
        }
        let parameters = Parameters {
            band_percentile: percent[0], slope: odd[0], min_length: odd[1] % 64, gap: odd[2],
            min_width: odd[3] % 64, max_width: odd[4], shared_percent: percent[1],
            brightness_percentile: percent[2], min_flank: odd[5], contrast_percent: percent[3],
            overlap_percent: percent[4], red_percent: percent[5], radius_percent: percent[6],
        };
        let (mut rows, mut columns) = ([Row::default(); 70], [0; 70]);
        let mut edges = std::vec![Edge::default(); capacity.0];
        let mut proposals = std::vec![Proposal::default(); capacity.1];
        let mut windows = std::vec![ImageWindow::default(); capacity.2];
        let mut workspace = Workspace {
            rows: &mut rows, columns: &mut columns, edges: &mut edges, proposals: &mut proposals,
        };
        let found = find(&image, None, &segments, &parameters, &mut workspace, &mut windows).unwrap();
        prop_assert!(found.count <= windows.len() && found.proposals <= proposals.len());
    }
}
