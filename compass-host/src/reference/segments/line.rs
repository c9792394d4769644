//! A straight line through pixels, least squares.

use super::gradient::{Axis, Pixel};

/// `normal . p + offset = 0`, with a unit normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) normal: [f64; 2],
    offset: f64,
}

impl Line {
    /// Signed distance in pixels.
    fn height(&self, p: [f64; 2]) -> f64 {
        self.normal[0] * p[0] + self.normal[1] * p[1] + self.offset
    }

    /// Distance of a pixel in pixels.
    pub(super) fn distance(&self, pixel: Pixel) -> f64 {
        self.height(pixel.map(f64::from)).abs()
    }

    /// Foot of a pixel on the line.
    pub(super) fn project(&self, pixel: Pixel) -> [f64; 2] {
        let p = pixel.map(f64::from);
        let height = self.height(p);
        [p[0] - height * self.normal[0], p[1] - height * self.normal[1]]
    }

    /// Unit vector from the tail to the head.
    pub(super) fn direction(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
    }
}

/// Exact sums over pixels for a regression of the cross coordinate on the main one.
/// Ordinary, not total least squares: only the cross coordinate is assumed to have errors.
/// Ordinary, not total least squares: only the cross coordinate is taken to err.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) axis: Axis,
    pub(super) count: i64,
    main: i64,
    cross: i64,
    main_cross: i64,
    main_main: i64,
}

impl Fit {
    /// Sums over a window; the axis is the longer extent between its ends.
    pub(super) fn new(window: &[Pixel]) -> Self {
        let axis = match (window.first(), window.last()) {
            (Some(a), Some(b)) => Axis::of_extent(f64::from(b[0] - a[0]), f64::from(b[1] - a[1])),
            _ => Axis::Horizontal,
        };
        let mut fit = Self { axis, count: 0, main: 0, cross: 0, main_cross: 0, main_main: 0 };
        window.iter().for_each(|&pixel| fit.add(pixel));
        fit
    }

    /// Adds a pixel.
    pub(super) fn add(&mut self, pixel: Pixel) {
        self.change(pixel, 1);
    }

    /// Removes a pixel.
    pub(super) fn remove(&mut self, pixel: Pixel) {
        self.change(pixel, -1);
    }

    fn change(&mut self, pixel: Pixel, sign: i64) {
        let (main, cross) = (i64::from(pixel[self.axis.main()]), i64::from(pixel[self.axis.cross()]));
        self.count += sign;
        self.main += sign * main;
        self.cross += sign * cross;
        self.main_cross += sign * main * cross;
        self.main_main += sign * main * main;
    }

    /// The line, directed from `tail` to `head`; `None` while the pixels are degenerate.
    pub(super) fn line(&self, tail: Pixel, head: Pixel) -> Option<Line> {
        let spread = self.count * self.main_main - self.main * self.main;
        if self.count < 2 || spread <= 0 {
            return None;
        }
        let slope = (self.count * self.main_cross - self.main * self.cross) as f64 / spread as f64;
        let intercept = (self.cross as f64 - slope * self.main as f64) / self.count as f64;
        let norm = slope.hypot(1.0);
        let mut normal = [0.0; 2];
        normal[self.axis.main()] = slope / norm;
        normal[self.axis.cross()] = -1.0 / norm;
        let along = f64::from(head[1] - tail[1]) * normal[0] - f64::from(head[0] - tail[0]) * normal[1];
        let sign = if along < 0.0 { -1.0 } else { 1.0 };
        Some(Line { normal: normal.map(|n| sign * n), offset: sign * intercept / norm })
    }
}

/// Mean squared distance of pixels from a line, in pixels squared.
pub(super) fn mean_square(line: &Line, pixels: &[Pixel]) -> f64 {
    pixels.iter().map(|&p| line.distance(p).powi(2)).sum::<f64>() / pixels.len() as f64
}
