//! Statistics of boxes and of the frame, from a grid of samples.

use super::parameters::BLACK;
use crate::base::raster::GrayImage;

/// Largest number of sample points along a side of a box.
const POINTS: u32 = 24;
/// Number of bins of the histograms of brightness and texture.
pub(super) const BINS: usize = 64;

/// A half-open box: columns `x0..x1`, rows `y0..y1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Area {
    pub(super) x0: u16,
    pub(super) y0: u16,
    pub(super) x1: u16,
    pub(super) y1: u16,
}

/// At most [`POINTS`] positions, evenly spaced within `start..end`.
pub(super) fn grid(start: u16, end: u16) -> impl Iterator<Item = u32> {
    let span = u32::from(end.saturating_sub(start));
    let points = span.min(POINTS);
    (0..points).map(move |k| u32::from(start) + (2 * k + 1) * span / (2 * points))
}

/// Sums over the sample points of a box, except `points` over scene pixels alone.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Samples {
    points: u32,
    lit: u32,
    brightness: u32,
    texture: u32,
}

impl Samples {
    /// Samples an area. Brightness and texture outside the image are not counted.
    pub(super) fn take(image: &GrayImage<'_>, area: Area) -> Self {
        let mut samples = Self::default();
        for y in grid(area.y0, area.y1) {
            let rows = rows_around(image, y);
            for x in grid(area.x0, area.x1) {
                samples.points += 1;
                let Some((level, gradient)) = pixel(rows, x as usize) else { continue };
                if level > BLACK {
                    samples.lit += 1;
                    samples.brightness += u32::from(level);
                    samples.texture += gradient;
                }
            }
        }
        samples
    }

    /// Whether at least half of the samples are scene pixels.
    pub(super) fn mostly_lit(&self) -> bool {
        self.lit > 0 && 2 * self.lit >= self.points
    }

    /// Mean brightness in 1/16 gray level, rounded down.
    pub(super) fn brightness_16(&self) -> u32 {
        16 * self.brightness / self.lit.max(1)
    }

    /// Mean texture |dx| + |dy| in 1/16 gray level, rounded down.
    pub(super) fn texture_16(&self) -> u32 {
        16 * self.texture / self.lit.max(1)
    }
}

/// The rows `y` - 1, `y` and `y` + 1; empty outside the image.
pub(super) fn rows_around<'a>(image: &GrayImage<'a>, y: u32) -> [&'a [u8]; 3] {
    let y = y as usize;
    [y.checked_sub(1).map_or(&[][..], |above| image.row(above)), image.row(y), image.row(y + 1)]
}

/// Gray level and gradient |dx| + |dy| of column `x` of the middle row: differences of the neighbours on both sides.
pub(super) fn pixel(rows: [&[u8]; 3], x: usize) -> Option<(u8, u32)> {
    let level = rows[1].get(x).copied()?;
    let at = |row: &[u8], x: usize| row.get(x).copied().unwrap_or(level);
    let left = x.checked_sub(1).map_or(level, |x| at(rows[1], x));
    let dx = left.abs_diff(at(rows[1], x + 1));
    let dy = at(rows[0], x).abs_diff(at(rows[2], x));
    Some((level, u32::from(dx) + u32::from(dy)))
}

/// The percentile of a histogram: the lowest bin with at least `percent` percent of the counts at or below it.
#[expect(clippy::cast_possible_truncation, reason = "the value is 63")]
pub(super) fn percentile(bins: &[u32; BINS], percent: u8) -> u32 {
    let total: u64 = bins.iter().map(|&n| u64::from(n)).sum();
    let wanted = (total * u64::from(percent.min(100))).div_ceil(100);
    let mut below = 0_u64;
    for (bin, &n) in (0..).zip(bins) {
        below += u64::from(n);
        if below >= wanted {
            return bin;
        }
    }
    BINS as u32 - 1
}
