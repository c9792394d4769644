//! Least-squares line fits to drawn pixels, from exact integer sums.

use super::walk::Position;
use crate::base::num::{count_as_i32, index_of, truncate_to_i32};

/// Largest window, pixels, of the first fit of a line.
pub(super) const WINDOW: usize = 15;
/// Smallest window, pixels.
pub(super) const LEAST_WINDOW: usize = 8;
/// A window is a line if the mean squared distance of its pixels from the fit is below 1/5 px^2: the inverse of that.
const WINDOW_ERROR_INVERSE: i64 = 5;
/// Largest central moment of a window that may be a line; pixels that follow each other stay below 5000. Products of
/// four fit 64 bits.
const MOST_MOMENT: i64 = 1 << 20;
/// Squared inlier tolerance of a line, (1.5 px)^2 in 1/65536 px^2.
const REACH_SQUARED: i64 = 147_456;
/// Cross-axis distance, 1/65536 px, beyond which no pixel is an inlier of a line within 60 degrees of its main axis.
const FAR: i32 = 3 << 16;

/// Sums over the pixels of a sliding window, modulo 2^32: the central moments are exact.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Window {
    x: i32,
    y: i32,
    xx: i32,
    xy: i32,
    yy: i32,
}

impl Window {
    #[inline(always)]
    pub(super) fn add(&mut self, p: Position) {
        self.accumulate(p, 1);
    }

    #[inline(always)]
    pub(super) fn remove(&mut self, p: Position) {
        self.accumulate(p, -1);
    }

    #[inline(always)]
    fn accumulate(&mut self, p: Position, sign: i32) {
        self.x = self.x.wrapping_add(sign * p.x);
        self.y = self.y.wrapping_add(sign * p.y);
        self.xx = self.xx.wrapping_add(sign.wrapping_mul(p.x * p.x));
        self.xy = self.xy.wrapping_add(sign.wrapping_mul(p.x * p.y));
        self.yy = self.yy.wrapping_add(sign.wrapping_mul(p.y * p.y));
    }

    /// Whether the `n` summed pixels, at most [`WINDOW`], lie on a line, by regression on x or, if `steep`, on y.
    #[inline(always)]
    pub(super) fn is_line(&self, n: usize, steep: bool) -> bool {
        let n = count_as_i32(n);
        let central =
            |product: i32, a: i32, b: i32| i64::from(n.wrapping_mul(product).wrapping_sub(a.wrapping_mul(b)));
        let (xx, yy) = (central(self.xx, self.x, self.x), central(self.yy, self.y, self.y));
        let across = central(self.xy, self.x, self.y);
        // A branch may begin with a pixel far from the others.
        if !(0..=MOST_MOMENT).contains(&xx) || !(0..=MOST_MOMENT).contains(&yy) || across.abs() > MOST_MOMENT
        {
            return false;
        }
        let (along, spread) = if steep { (yy, xx) } else { (xx, yy) };
        // Mean squared distance: (spread - across^2 / along) / n^2 * along^2 / (along^2 + across^2).
        let residual = (along * spread - across * across) * along;
        WINDOW_ERROR_INVERSE * residual < i64::from(n * n) * (along * along + across * across)
    }
}

/// A least-squares line v = slope u + offset; u is the main axis (y if steep), v the cross axis.
///
/// Coordinates are relative to `origin`, which keeps the sums small and the fit precise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    origin: Position,
    pub(super) steep: bool,
    n: i32,
    u: i32,
    v: i32,
    uu: i64,
    uv: i64,
    /// Number of pixels at which the next refit is due.
    due: i32,
    /// Slope, 1/65536.
    pub(super) slope: i32,
    /// Offset, 1/65536 px.
    offset: i32,
    /// Squared inlier tolerance along the cross axis, 1/65536 px^2.
    reach: i64,
}

impl Line {
    /// The line through the pixels of a window.
    pub(super) fn through(pixels: impl Iterator<Item = Position>, origin: Position, steep: bool) -> Self {
        let mut line =
            Self { origin, steep, n: 0, u: 0, v: 0, uu: 0, uv: 0, due: 0, slope: 0, offset: 0, reach: 0 };
        for p in pixels {
            line.sum(p, 1);
        }
        line.fit();
        line
    }

    #[inline(always)]
    fn local(&self, p: Position) -> (i32, i32) {
        let (x, y) = (p.x - self.origin.x, p.y - self.origin.y);
        if self.steep { (y, x) } else { (x, y) }
    }

    #[inline(always)]
    fn sum(&mut self, p: Position, sign: i32) {
        let (u, v) = self.local(p);
        self.n += sign;
        self.u += sign * u;
        self.v += sign * v;
        self.uu += i64::from(sign * u * u);
        self.uv += i64::from(sign * u * v);
    }

    /// Fits the line to its sums.
    pub(super) fn fit(&mut self) {
        let n = i64::from(self.n);
        let along = n * self.uu - i64::from(self.u) * i64::from(self.u);
        let across = n * self.uv - i64::from(self.u) * i64::from(self.v);
        // IEEE division: the same bits on every target. Casts saturate; a window with `along` 0 is no line.
        self.slope = truncate_to_i32(across as f32 / along as f32 * 65_536.0);
        let rest = (i64::from(self.v) << 16) - i64::from(self.slope) * i64::from(self.u);
        self.offset = truncate_to_i32(rest as f32 / self.n as f32);
        let tilt = i64::from(self.slope >> 8);
        self.reach = REACH_SQUARED + 9 * tilt * tilt / 4;
        self.due = self.n + 1 + (self.n >> 6);
    }

    /// Adds an inlier; refits the line when due.
    #[inline(always)]
    pub(super) fn add(&mut self, p: Position) {
        self.sum(p, 1);
        if self.n >= self.due {
            self.fit();
        }
    }

    /// Removes an inlier and refits the line.
    pub(super) fn remove(&mut self, p: Position) {
        self.sum(p, -1);
        self.fit();
    }

    /// Whether a pixel is within the inlier tolerance.
    #[inline(always)]
    pub(super) fn takes(&self, p: Position) -> bool {
        let (u, v) = self.local(p);
        let off = (v << 16).wrapping_sub(self.slope.wrapping_mul(u)).wrapping_sub(self.offset);
        let near = off >> 8;
        off.unsigned_abs() < FAR.unsigned_abs() && i64::from(near) * i64::from(near) < self.reach
    }

    /// Cross-axis coordinate at coordinate `u` along the line, 1/65536 px.
    #[inline(always)]
    pub(super) fn across_at(&self, u: i32) -> i32 {
        let (along, across) =
            if self.steep { (self.origin.y, self.origin.x) } else { (self.origin.x, self.origin.y) };
        (across << 16).wrapping_add(self.slope.wrapping_mul(u - along)).wrapping_add(self.offset)
    }

    /// The foot of the perpendicular from a pixel, in pixels of the image.
    pub(super) fn foot(&self, p: Position) -> [f32; 2] {
        let (u, v) = self.local(p);
        let slope = self.slope as f32 / 65_536.0;
        let offset = self.offset as f32 / 65_536.0;
        let along = (u as f32 + slope * (v as f32 - offset)) / (1.0 + slope * slope);
        let across = slope * along + offset;
        let (x, y) = if self.steep { (across, along) } else { (along, across) };
        [self.origin.x as f32 + x, self.origin.y as f32 + y]
    }

    /// Number of pixels fitted.
    pub(super) fn len(&self) -> usize {
        index_of(self.n.max(0))
    }
}
