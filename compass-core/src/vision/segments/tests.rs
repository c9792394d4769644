use super::*;
use proptest::prelude::*;
use std::vec::Vec;

struct Buffers {
    cells: Vec<u16>,
    smoothed: Vec<u8>,
    trail: Vec<u32>,
}

impl Buffers {
    fn new(width: u32, height: u32) -> Self {
        // Initial contents must be ignored.
        Self {
            cells: std::vec![0x5a5a; pixels(width, height)],
            smoothed: std::vec![77; pixels(width, height)],
            trail: std::vec![u32::MAX; trail_len(width, height)],
        }
    }

    fn workspace(&mut self) -> Workspace<'_> {
        Workspace { cells: &mut self.cells, smoothed: &mut self.smoothed, trail: &mut self.trail }
    }
}

fn find(
    pixels: &[u8],
    width: u32,
    height: u32,
    mask: Option<&BitMask<'_>>,
    capacity: usize,
) -> (Vec<Segment>, bool) {
    let image = GrayImage::new(pixels, width, height).unwrap();
    let mut found = std::vec![Segment::default(); capacity];
    let mut buffers = Buffers::new(width, height);
    let detected =
        detect(&image, mask, &Parameters::default(), &mut buffers.workspace(), &mut found).unwrap();
    found.truncate(detected.count);
    (found, detected.truncated)
}

/// A bright rectangle on dark ground, its sides on the borders between pixels.
fn rectangle(width: u32, height: u32, [x0, y0, x1, y1]: [u32; 4]) -> Vec<u8> {
    let inside = |x, y| (x0..x1).contains(&x) && (y0..y1).contains(&y);
    (0..height).flat_map(|y| (0..width).map(move |x| if inside(x, y) { 200 } else { 50 })).collect()
}

#[test]
fn a_rectangle_has_four_sides() {
    let image = rectangle(160, 120, [40, 30, 120, 90]);
    let (found, truncated) = find(&image, 160, 120, None, 100);
    assert!(!truncated);
    assert_eq!(found.len(), 4, "{found:?}");
    for (vertical, at) in [(true, 39.5), (true, 119.5), (false, 29.5), (false, 89.5)] {
        let side = found.iter().find(|s| {
            let (a, b) = if vertical { (s.x1, s.x2) } else { (s.y1, s.y2) };
            (a - at).abs() <= 0.6 && (b - at).abs() <= 0.6
        });
        let side = side.unwrap_or_else(|| panic!("no side at {at}: {found:?}"));
        let length = (side.x2 - side.x1).hypot(side.y2 - side.y1);
        let whole = if vertical { 60.0 } else { 80.0 };
        assert!((whole - 8.0..=whole + 2.0).contains(&length), "{side:?}");
    }
}

#[test]
fn no_segment_lies_outside_the_mask() {
    let image = rectangle(160, 120, [40, 30, 120, 90]);
    let mut bits = std::vec![0_u8; BitMask::row_bytes(160) * 120];
    for y in 0..120 {
        bits[y * 20..y * 20 + 10].fill(0xff);
    }
    let mask = BitMask::new(&bits, 160, 120).unwrap();
    let (found, _) = find(&image, 160, 120, Some(&mask), 100);
    assert!(!found.is_empty());
    assert!(found.iter().all(|s| s.x1.max(s.x2) < 80.5), "{found:?}");
}

#[test]
fn flat_and_tiny_images_have_no_segment() {
    for (width, height) in [(1, 1), (2, 2), (3, 3), (4, 1), (1, 60), (16, 16), (65, 3)] {
        for level in [0, 255] {
            let (found, truncated) = find(&std::vec![level; pixels(width, height)], width, height, None, 4);
            assert!(found.is_empty() && !truncated, "{width} x {height}");
        }
    }
}

#[test]
fn a_full_list_sets_truncated() {
    let image = rectangle(160, 120, [40, 30, 120, 90]);
    for capacity in 0..4 {
        let (found, truncated) = find(&image, 160, 120, None, capacity);
        assert!(found.len() == capacity && truncated, "{capacity}");
    }
}

#[test]
fn rejects_sizes_that_do_not_match() {
    let image = rectangle(64, 64, [8, 8, 40, 40]);
    let view = GrayImage::new(&image, 64, 64).unwrap();
    let p = Parameters::default();
    let mut short = Buffers::new(64, 63);
    assert_eq!(detect(&view, None, &p, &mut short.workspace(), &mut []), Err(SegmentsError::Workspace));
    let bits = [0xff; 8 * 63];
    let mask = BitMask::new(&bits, 64, 63).unwrap();
    let mut buffers = Buffers::new(64, 64);
    assert_eq!(detect(&view, Some(&mask), &p, &mut buffers.workspace(), &mut []), Err(SegmentsError::Mask));
    let wide = std::vec![0; 8193];
    let view = GrayImage::new(&wide, 8193, 1).unwrap();
    assert_eq!(detect(&view, None, &p, &mut buffers.workspace(), &mut []), Err(SegmentsError::Size));
}

#[test]
fn workspace_takes_3_bytes_per_pixel() {
    let bytes = workspace_bytes(1472, 1440) as f64 / pixels(1472, 1440) as f64;
    assert!((3.0..3.1).contains(&bytes), "{bytes}");
    assert!(workspace_bytes(368, 360) < 430_000);
}

/// Images with dense edges: noise of varied contrast, stripes of varied period and slant, concentric rings.
fn texture() -> impl Strategy<Value = (u32, u32, Vec<u8>)> {
    (1_u32..90, 1_u32..90, any::<u32>(), 0_u32..4, 1_u32..64).prop_map(
        |(width, height, seed, kind, scale)| {
            let mut state = seed | 1;
            let mut noise = move || {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                state
            };
            let at = |i: u32| {
                let (x, y) = (i % width, i / width);
                match kind {
                    0 => noise() as u8,
                    1 => (noise() % scale * 4) as u8,
                    2 => {
                        if (x * 3 + y * scale / 8) / scale % 2 == 0 {
                            220
                        } else {
                            20
                        }
                    }
                    _ => ((x * x + y * y) / scale % 256) as u8,
                }
            };
            (width, height, (0..width * height).map(at).collect())
        },
    )
}

proptest! {
    #[test]
    fn segments_of_any_image_lie_in_it((width, height, image) in texture()) {
        let (found, _) = find(&image, width, height, None, 500);
        for s in &found {
            for (v, side) in [(s.x1, width), (s.x2, width), (s.y1, height), (s.y2, height)] {
                prop_assert!(v > -2.0 && v < side as f32 + 1.0, "{:?}", s);
            }
            prop_assert!(s.score > 0);
        }
        let (again, _) = find(&image, width, height, None, 500);
        prop_assert_eq!(found, again);
    }
}
