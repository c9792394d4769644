//! Line segments by edge drawing (the paper's detector: ELSED, Suarez, Buenaposada and Baumela, Pattern Recognition
//! 2022), including the quirks of its published program that affect the output.
//!
//! An image is blurred and differentiated; walks along the edges start from anchors; a window of a walk
//! that is straight becomes a segment, which grows at its head, then at its tail, and jumps over gaps;
//! walk left over is drawn again; last, segments that too many gradients disagree with are rejected.
//!
//! Coordinates are pixels, pixel centres at integers, y down.

mod gradient;
mod jump;
mod line;
mod options;
mod traced;
mod validate;
mod walk;

pub use gradient::{blur, gradient};
pub use options::{Options, Segment};

use gradient::Field;
use walk::Drawing;

/// Segments of a gray image in order of completion; none when the buffer is too short.
#[must_use]
pub fn detect(gray: &[u8], width: usize, height: usize, options: &Options) -> Vec<Segment> {
    let Some(field) = Field::new(gray, width, height, options.gradient_threshold) else { return Vec::new() };
    let drawing = Drawing::new(&field, options);
    // Validated at the end: a later segment may have claimed pixels.
    drawing
        .segments
        .iter()
        .filter_map(|traced| validate::validate(&field, options, &drawing, traced))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const SIZE: [usize; 2] = [120, 100];
    /// Left, right, top and bottom of the rectangle, in pixels.
    const SIDES: [usize; 4] = [30, 90, 25, 75];

    fn rectangle() -> Vec<u8> {
        let [left, right, top, bottom] = SIDES;
        let gray = |x, y| match (left..=right).contains(&x) && (top..=bottom).contains(&y) {
            false => 50,
            // A pixel that the side halves: the edge runs through pixel centres.
            true if x == left || x == right || y == top || y == bottom => 125,
            true => 200,
        };
        (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| gray(x, y))).collect()
    }

    #[test]
    fn a_rectangle_has_its_four_sides() {
        let found = detect(&rectangle(), SIZE[0], SIZE[1], &Options::default());
        for (i, side) in SIDES.into_iter().enumerate() {
            let across = i / 2;
            let on_side = |p: [f64; 2]| (p[across] - side as f64).abs() < 0.5;
            let extent = |s: &Segment| (s.end[1 - across] - s.start[1 - across]).abs();
            let (low, high) = if across == 0 { (SIDES[2], SIDES[3]) } else { (SIDES[0], SIDES[1]) };
            let longest = found.iter().filter(|s| on_side(s.start) && on_side(s.end)).map(extent);
            let missing = (high - low) as f64 - longest.fold(0.0, f64::max);
            assert!(missing < 6.0, "side {i} lacks {missing} px: {found:?}");
        }
    }

    #[test]
    fn every_segment_lies_on_a_side() {
        for s in detect(&rectangle(), SIZE[0], SIZE[1], &Options::default()) {
            let near = |p: [f64; 2], i: usize| (p[i / 2] - SIDES[i] as f64).abs() < 0.5;
            assert!((0..4).any(|i| near(s.start, i) && near(s.end, i)), "{s:?}");
        }
    }

    #[test]
    fn images_without_edges_have_no_segments() {
        let none = |width, height, gray| {
            detect(&vec![gray; width * height], width, height, &Options::default()).is_empty()
        };
        assert!(
            [(0, 0), (0, 5), (5, 0), (1, 1), (3, 3), (1, 90), (90, 1), (64, 64)].map(|(w, h)| none(w, h, 90))
                == [true; 8]
        );
        assert!(detect(&[0, 255, 0, 255, 0, 255, 0, 255, 0], 3, 3, &Options::default()).is_empty());
    }

    #[test]
    fn a_short_buffer_is_no_image() {
        assert!(detect(&[0; 99], 10, 10, &Options::default()).is_empty());
        assert!(detect(&[0; 99], usize::MAX, 2, &Options::default()).is_empty());
        assert!(blur(&[0; 99], 10, 10).is_empty() && gradient(&[0; 99], usize::MAX, 3).0.is_empty());
    }

    #[test]
    fn noise_and_odd_options_do_not_panic() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        let odd = Options {
            gradient_threshold: 0,
            anchor_threshold: i32::MAX,
            scan_interval: 0,
            minimum_length: 3,
            fit_error: 9.0,
            outlier_limit: 0,
            window_slide: 9,
            jump_lengths: vec![-5, 0, 1, 2],
            eigenvalue_ratio: 0.0,
            jump_angle_deg: 90.0,
            validate: false,
            ..Options::default()
        };
        let smooth =
            Options { gradient_threshold: 1, fit_error: 5.0, inlier_distance: 4.0, ..Options::default() };
        for size in [2, 3, 4, 5, 7, 16, 33, 64, 121] {
            let noise: Vec<u8> = (0..size * (size + 3)).map(|_| random.random()).collect();
            for options in [&Options::default(), &odd, &smooth] {
                for s in detect(&noise, size, size + 3, options) {
                    assert!(s.start.iter().chain(&s.end).all(|v| v.is_finite()), "{s:?}");
                }
            }
        }
    }

    #[test]
    fn blur_spreads_a_point_and_keeps_a_plane() {
        let mut gray = vec![0; 49];
        gray[24] = 255;
        let out = blur(&gray, 7, 7);
        // 255 * 104 * 104 / 65536 = 42.08, with 62 in place of one 104 25.09, of both 14.96.
        assert_eq!([out[24], out[25], out[17], out[16]], [42, 25, 25, 15]);
        assert_eq!(blur(&[77; 6], 2, 3), [77; 6]);
    }

    #[test]
    fn gradient_of_a_ramp() {
        let ramp: Vec<u8> = (0..25).map(|i| 10 * (i % 5) as u8 + 3 * (i / 5) as u8).collect();
        let (dx, dy) = gradient(&ramp, 5, 5);
        assert_eq!((dx[12], dy[12]), (80, 24));
        // The repeated border halves the difference.
        assert_eq!((dx[10], dy[2]), (40, 12));
    }
}
