//! Sampling of an image between its pixels, with pixels that are left out.

use crate::base::raster::{BitMask, GrayImage, RgbImage, is_red};

/// Fraction bits of a position in the image.
pub(crate) const SUBPIXEL: u32 = 8;

/// Where red is, for what is to be left out as safety gear.
#[derive(Debug, Clone, Copy)]
pub enum ExclusionMask<'a> {
    /// Not known: nothing is left out.
    Unknown,
    /// Judged by [`is_red`] from the colours of the image.
    Colours(RgbImage<'a>),
    /// Set where the image is red.
    Mask(BitMask<'a>),
}

impl ExclusionMask<'_> {
    /// At a position in 1/256 px.
    #[inline(always)]
    pub(crate) fn at(&self, x: i32, y: i32) -> bool {
        // What is left of the image or above it lies beyond its other border as well.
        let (x, y) = ((x >> SUBPIXEL) as u32, (y >> SUBPIXEL) as u32);
        match self {
            Self::Unknown => false,
            Self::Colours(image) => is_red(image.pixel(x, y)),
            Self::Mask(mask) => mask.get(x, y),
        }
    }
}

/// The gray level at a position, 1 to 255; 0 within a pixel of the image's border, outside it, or on red.
#[inline(always)]
pub(crate) fn sample_bilinear(image: &GrayImage<'_>, red: ExclusionMask<'_>, x: i32, y: i32) -> u8 {
    let four = around(image, x, y).filter(|_| !red.at(x, y));
    four.map_or(0, |four| between(four, x, y))
}

/// The four pixels around a position; `None` within a pixel of the image's border or outside it.
#[inline(always)]
pub(crate) fn around(image: &GrayImage<'_>, x: i32, y: i32) -> Option<[u8; 4]> {
    let (column, row) = (x >> SUBPIXEL, y >> SUBPIXEL);
    let width = image.width() as usize;
    if column < 1 || row < 1 || column + 2 >= width as i32 || row + 2 >= image.height() as i32 {
        return None;
    }
    let start = row as usize * width + column as usize;
    match image.pixels().get(start..start + width + 2) {
        Some([a, b, .., c, d]) => Some([*a, *b, *c, *d]),
        _ => None,
    }
}

/// The gray level at a position between four pixels, 1 to 255.
#[inline(always)]
pub(crate) fn between(four: [u8; 4], x: i32, y: i32) -> u8 {
    let [a, b, c, d] = four.map(i32::from);
    let (wx, wy) = (x & 0xff, y & 0xff);
    let top = (a << 8) + (b - a) * wx;
    let bottom = (c << 8) + (d - c) * wx;
    let gray = ((top << 8) + (bottom - top) * wy + (1 << 15)) >> 16;
    gray.clamp(1, 255) as u8
}
