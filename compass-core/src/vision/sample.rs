//! Bilinear sampling of an image, with excluded pixels.

use crate::base::num::{count_as_i32, index_of};
use crate::base::raster::{BitMask, GrayImage};

/// Fractional bits of a pixel position.
pub(crate) const SUBPIXEL: u32 = 8;

/// Pixels to leave out where windows are sought, as the robot's own parts.
///
/// Samples at excluded pixels are unknown: the panorama treats them as if no camera saw them. A locator seeks the boundaries of
/// floor and ceiling in all pixels.
#[derive(Debug, Clone, Copy)]
pub enum ExclusionMask<'a> {
    /// None are known: no pixel is left out.
    Unknown,
    /// Pixels whose bit is set.
    Mask(BitMask<'a>),
}

impl ExclusionMask<'_> {
    /// Width and height, pixels; `None` without a mask.
    #[must_use]
    pub const fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Unknown => None,
            Self::Mask(mask) => Some([mask.width(), mask.height()]),
        }
    }

    /// Whether the pixel at a position in 1/256 px is excluded.
    #[inline(always)]
    pub(crate) fn at(&self, x: i32, y: i32) -> bool {
        // Negative coordinates become large ones, outside the image too.
        let (x, y) = ((x >> SUBPIXEL).cast_unsigned(), (y >> SUBPIXEL).cast_unsigned());
        match self {
            Self::Unknown => false,
            Self::Mask(mask) => mask.get(x, y),
        }
    }
}

/// The gray level at a position in 1/256 px, 1 to 255; 0 within a pixel of the image border, outside, and where excluded.
#[inline(always)]
pub(crate) fn sample_bilinear(image: &GrayImage<'_>, excluded: ExclusionMask<'_>, x: i32, y: i32) -> u8 {
    let four = around(image, x, y).filter(|_| !excluded.at(x, y));
    four.map_or(0, |four| between(four, x, y))
}

/// The four pixels around a position in 1/256 px: upper left, upper right, lower left, lower right; `None` within a pixel
/// of the image border and outside.
#[inline(always)]
pub(crate) fn around(image: &GrayImage<'_>, x: i32, y: i32) -> Option<[u8; 4]> {
    let (column, row) = (x >> SUBPIXEL, y >> SUBPIXEL);
    let width = image.width() as usize;
    if column < 1 || row < 1 || column + 2 >= count_as_i32(width) || row + 2 >= image.height().cast_signed() {
        return None;
    }
    let start = index_of(row) * width + index_of(column);
    match image.pixels().get(start..start + width + 2) {
        Some([a, b, .., c, d]) => Some([*a, *b, *c, *d]),
        _ => None,
    }
}

/// The gray level between four pixels, interpolated by the fractions of the position, 1 to 255.
#[inline(always)]
#[expect(clippy::cast_sign_loss, reason = "clamped to 1 to 255")]
pub(crate) fn between(four: [u8; 4], x: i32, y: i32) -> u8 {
    let [a, b, c, d] = four.map(i32::from);
    let (wx, wy) = (x & 0xff, y & 0xff);
    let top = (a << 8) + (b - a) * wx;
    let bottom = (c << 8) + (d - c) * wx;
    let gray = ((top << 8) + (bottom - top) * wy + (1 << 15)) >> 16;
    gray.clamp(1, 255) as u8
}
