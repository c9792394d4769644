//! Blur, Sobel gradient, edge axes and anchors.

use super::options::Options;

/// A pixel as column and row.
pub(super) type Pixel = [i32; 2];

/// Blur weights in 1/256: five taps of a Gaussian of sigma 1 pixel, rounded so that they sum to 256.
const BLUR: [u32; 5] = [14, 62, 104, 62, 14];

/// The dominant direction of an edge, as an index into a [`Pixel`] of its main coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// Along x.
    Horizontal = 0,
    /// Along y.
    Vertical = 1,
}

impl Axis {
    /// Horizontal where the extent in x is the larger or both are equal.
    pub(super) fn of_extent(dx: f64, dy: f64) -> Self {
        if dx.abs() >= dy.abs() { Self::Horizontal } else { Self::Vertical }
    }

    /// Index of the coordinate along the edge.
    pub(super) fn main(self) -> usize {
        self as usize
    }

    /// Index of the coordinate across the edge.
    pub(super) fn cross(self) -> usize {
        1 - self as usize
    }

    /// Unit step along the axis: forward is right or down.
    pub(super) fn unit(self, forward: bool) -> Pixel {
        let mut unit = [0, 0];
        unit[self.main()] = if forward { 1 } else { -1 };
        unit
    }
}

/// Gradient of an image.
#[derive(Debug)]
pub(super) struct Field {
    width: i32,
    height: i32,
    dx: Vec<i16>,
    dy: Vec<i16>,
    /// `|dx| + |dy|`, 0 below the threshold.
    magnitude: Vec<i32>,
}

impl Field {
    /// `None` when the image is empty, larger than the buffer, or too large for 32-bit indices.
    pub(super) fn new(gray: &[u8], width: usize, height: usize, threshold: i32) -> Option<Self> {
        let count = width.checked_mul(height).filter(|&n| n > 0 && n <= i32::MAX as usize)?;
        let (dx, dy) = gradient(&blur(gray.get(..count)?, width, height), width, height);
        let sum = |(&x, &y): (&i16, &i16)| i32::from(x).abs() + i32::from(y).abs();
        let magnitude = dx.iter().zip(&dy).map(sum).map(|m| if m < threshold { 0 } else { m }).collect();
        Some(Self { width: width as i32, height: height as i32, dx, dy, magnitude })
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> Pixel {
        [self.width, self.height]
    }

    /// The index of a pixel in the buffers; `None` outside the image.
    pub(super) fn index(&self, [x, y]: Pixel) -> Option<usize> {
        let inside = (0..self.width).contains(&x) && (0..self.height).contains(&y);
        inside.then(|| y as usize * self.width as usize + x as usize)
    }

    /// Thresholded magnitude, 0 outside the image.
    pub(super) fn magnitude(&self, pixel: Pixel) -> i32 {
        self.index(pixel).map_or(0, |i| self.magnitude[i])
    }

    /// Raw gradient in gray levels times 8; outside the image that of the nearest pixel.
    pub(super) fn gradient(&self, [x, y]: Pixel) -> [f64; 2] {
        let nearest = [x.clamp(0, self.width - 1), y.clamp(0, self.height - 1)];
        self.index(nearest).map_or([0.0; 2], |i| [f64::from(self.dx[i]), f64::from(self.dy[i])])
    }

    /// Raw gradient between pixels, bilinear.
    pub(super) fn gradient_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (x - column, y - row);
        let corner = |i, j| self.gradient([column as i32 + i, row as i32 + j]);
        let mix = |p: [f64; 2], q: [f64; 2], t: f64| [0, 1].map(|k| p[k] + (q[k] - p[k]) * t);
        mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
    }

    /// Edge axis of a pixel; a tie is vertical.
    pub(super) fn axis(&self, pixel: Pixel) -> Axis {
        let [dx, dy] = self.gradient(pixel);
        if dx.abs() >= dy.abs() { Axis::Vertical } else { Axis::Horizontal }
    }

    /// Local maxima across their edge, in drawing order.
    ///
    /// Without any, the threshold is halved repeatedly down to 0, so that faint images are drawn as well.
    pub(super) fn anchors(&self, options: &Options) -> Vec<Pixel> {
        let mut threshold = options.anchor_threshold.max(0);
        loop {
            let anchors = self.anchors_above(threshold, options.scan_interval);
            if !anchors.is_empty() || threshold == 0 {
                return anchors;
            }
            threshold /= 2;
        }
    }

    fn anchors_above(&self, threshold: i32, interval: usize) -> Vec<Pixel> {
        let interval = interval.max(1);
        let mut anchors = Vec::new();
        // Column by column: the order decides which of two crossing edges is drawn through.
        for x in (1..self.width - 1).step_by(interval) {
            for y in (1..self.height - 1).step_by(interval) {
                let (centre, axis) = (self.magnitude([x, y]), self.axis([x, y]));
                let [sides_x, sides_y] = axis.unit(true);
                let (before, after) = ([x - sides_y, y - sides_x], [x + sides_y, y + sides_x]);
                let floor = self.magnitude(before).max(self.magnitude(after)).saturating_add(threshold);
                if centre > 0 && centre >= floor {
                    anchors.push([x, y]);
                }
            }
        }
        anchors
    }
}

/// Blurs with a separable 5x5 kernel of sigma 1 pixel, mirroring at the border without repeating it.
///
/// The horizontal sum keeps its 16 bits; one rounding follows the vertical sum, so the result is
/// bit-exact with the usual 8-bit fixed-point filter. Empty when `gray` is too short.
#[must_use]
pub fn blur(gray: &[u8], width: usize, height: usize) -> Vec<u8> {
    if !fits(gray, width, height) {
        return Vec::new();
    }
    let at = |x: usize, y: usize| u32::from(gray[y * width + x]);
    let mut rows = vec![0_u32; width * height];
    for y in 0..height {
        for x in 0..width {
            rows[y * width + x] = (0..5).map(|k| BLUR[k] * at(mirror(x, k, width), y)).sum();
        }
    }
    let mut out = vec![0; width * height];
    for y in 0..height {
        for x in 0..width {
            let sum: u32 = (0..5).map(|k| BLUR[k] * rows[mirror(y, k, height) * width + x]).sum();
            out[y * width + x] = ((sum + 32768) >> 16) as u8;
        }
    }
    out
}

/// Whether a buffer holds an image of this size.
fn fits(buffer: &[u8], width: usize, height: usize) -> bool {
    width > 0 && width.checked_mul(height).is_some_and(|count| count <= buffer.len())
}

/// Index of tap `k` of five about `centre`, mirrored into `0..size`.
fn mirror(centre: usize, k: usize, size: usize) -> usize {
    let last = size as i64 - 1;
    if last == 0 {
        return 0;
    }
    // The mirrored image repeats every 2 * last pixels.
    let phase = (centre as i64 + k as i64 - 2).rem_euclid(2 * last);
    phase.min(2 * last - phase) as usize
}

/// 3x3 Sobel derivatives in x and y, unnormalised, the border pixel repeated.
///
/// Empty when `blurred` is too short.
#[must_use]
pub fn gradient(blurred: &[u8], width: usize, height: usize) -> (Vec<i16>, Vec<i16>) {
    if !fits(blurred, width, height) {
        return (Vec::new(), Vec::new());
    }
    let at = |x: usize, y: usize| i16::from(blurred[y * width + x]);
    let (mut dx, mut dy) = (vec![0; width * height], vec![0; width * height]);
    for y in 0..height {
        let (up, down) = (y.saturating_sub(1), (y + 1).min(height - 1));
        for x in 0..width {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
            let column = |c| at(c, up) + 2 * at(c, y) + at(c, down);
            let row = |r| at(left, r) + 2 * at(x, r) + at(right, r);
            dx[y * width + x] = column(right) - column(left);
            dy[y * width + x] = row(down) - row(up);
        }
    }
    (dx, dy)
}
