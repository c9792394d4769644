//! Borrowed raster views whose size is checked once, at construction: bit masks, gray and colour images.
//!
//! Row 0 of a plan's mask is the **southernmost** row (y up), so that map coordinates grow with the
//! index; plan importers flip the rows. Row 0 of an image, and of a mask of one, is its top row.

use core::fmt;

/// Error of constructing a raster view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RasterError {
    /// Width or height is 0 or above [`MAX_SIDE`].
    Size,
    /// The slice is shorter than width and height require.
    Length,
}

impl fmt::Display for RasterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Size => "raster side is 0 or above 65535 pixels",
            Self::Length => "raster data is shorter than width and height require",
        })
    }
}

impl core::error::Error for RasterError {}

/// Longest side of a raster in pixels: a position in it fits two `u16`.
pub const MAX_SIDE: u32 = 65_535;

/// One bit per pixel, rows padded to whole bytes, least significant bit first.
///
/// ```
/// use compass_core::BitMask;
///
/// // 9 x 2 pixels, two bytes per row.
/// let mask = BitMask::new(&[0b0000_0001, 0xff, 0, 1], 9, 2)?;
/// assert!(mask.get(0, 0) && !mask.get(1, 0) && mask.get(8, 1));
/// assert_eq!(mask.byte(1, 0), 1, "padding is unset");
/// # Ok::<(), compass_core::base::raster::RasterError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BitMask<'a> {
    bits: &'a [u8],
    width: u32,
    height: u32,
    row_bytes: usize,
}

impl<'a> BitMask<'a> {
    /// Bytes of one row of `width` pixels.
    #[must_use]
    pub const fn row_bytes(width: u32) -> usize {
        width.div_ceil(8) as usize
    }

    /// Views `bits` as a mask of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`RasterError::Size`] for a side of 0 or above [`MAX_SIDE`]; [`RasterError::Length`] when the
    /// slice is too short. A longer slice is accepted.
    pub fn new(bits: &'a [u8], width: u32, height: u32) -> Result<Self, RasterError> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(RasterError::Size);
        }
        let row_bytes = Self::row_bytes(width);
        let needed = row_bytes.checked_mul(height as usize).ok_or(RasterError::Size)?;
        if bits.len() < needed {
            return Err(RasterError::Length);
        }
        Ok(Self { bits, width, height, row_bytes })
    }

    /// Pixels along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Pixels along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The bit at column `x`, row `y`; unset outside the raster.
    #[must_use]
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> bool {
        x < self.width && self.byte(x / 8, y) >> (x % 8) & 1 == 1
    }

    /// The bytes of row `y`, padding bits unchanged; empty outside the mask.
    pub(crate) fn row(&self, y: u32) -> &'a [u8] {
        let start = y as usize * self.row_bytes;
        let row = if y < self.height { self.bits.get(start..start + self.row_bytes) } else { None };
        row.unwrap_or(&[])
    }

    /// Eight bits of row `y` from column `8 * column`; padding and pixels outside the mask are unset.
    #[must_use]
    #[inline]
    pub fn byte(&self, column: u32, y: u32) -> u8 {
        if column as usize >= self.row_bytes || y >= self.height {
            return 0;
        }
        let at = y as usize * self.row_bytes + column as usize;
        let byte = self.bits.get(at).copied().unwrap_or(0);
        let inside = self.width - 8 * column;
        if inside >= 8 { byte } else { byte & ((1 << inside) - 1) }
    }
}

/// An 8-bit gray image, rows without padding, row 0 at the top.
///
/// ```
/// use compass_core::GrayImage;
///
/// let image = GrayImage::new(&[1, 2, 3, 4, 5, 6], 3, 2)?;
/// assert_eq!(image.row(1), [4, 5, 6]);
/// # Ok::<(), compass_core::base::raster::RasterError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct GrayImage<'a> {
    pixels: &'a [u8],
    width: u32,
    height: u32,
}

impl<'a> GrayImage<'a> {
    /// Views `pixels` as an image of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`RasterError::Size`] for a side of 0 or above [`MAX_SIDE`]; [`RasterError::Length`] when the
    /// slice is too short. A longer slice is accepted.
    pub fn new(pixels: &'a [u8], width: u32, height: u32) -> Result<Self, RasterError> {
        let needed = pixel_count(width, height)?;
        let pixels = pixels.get(..needed).ok_or(RasterError::Length)?;
        Ok(Self { pixels, width, height })
    }

    /// Pixels along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Pixels along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Row `y`, `width` pixels; empty outside the image.
    #[must_use]
    #[inline]
    pub fn row(&self, y: usize) -> &'a [u8] {
        let width = self.width as usize;
        if y >= self.height as usize {
            return &[];
        }
        self.pixels.get(y * width..(y + 1) * width).unwrap_or(&[])
    }

    /// All pixels, row by row.
    #[must_use]
    pub const fn pixels(&self) -> &'a [u8] {
        self.pixels
    }
}

/// An 8-bit colour image, red, green, blue interleaved, rows without padding, row 0 at the top.
///
/// ```
/// use compass_core::RgbImage;
///
/// let image = RgbImage::new(&[1, 2, 3, 4, 5, 6], 1, 2)?;
/// assert_eq!(image.pixel(0, 1), [4, 5, 6]);
/// # Ok::<(), compass_core::base::raster::RasterError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct RgbImage<'a> {
    samples: &'a [u8],
    width: u32,
    height: u32,
}

impl<'a> RgbImage<'a> {
    /// Views `samples`, three a pixel, as an image of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`RasterError::Size`] for a side of 0 or above [`MAX_SIDE`]; [`RasterError::Length`] when the
    /// slice is too short. A longer slice is accepted.
    pub fn new(samples: &'a [u8], width: u32, height: u32) -> Result<Self, RasterError> {
        let needed = pixel_count(width, height)?.checked_mul(3).ok_or(RasterError::Size)?;
        let samples = samples.get(..needed).ok_or(RasterError::Length)?;
        Ok(Self { samples, width, height })
    }

    /// Pixels along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Pixels along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Red, green and blue at column `x`, row `y`; black outside the image.
    #[must_use]
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        if x >= self.width || y >= self.height {
            return [0; 3];
        }
        let at = 3 * (y as usize * self.width as usize + x as usize);
        self.samples.get(at..at + 3).and_then(|rgb| rgb.try_into().ok()).unwrap_or([0; 3])
    }
}

/// Whether red dominates a colour, as on helmets and safety vests: R exceeds 1.5 times the larger of G and B, and exceeds
/// it by more than 40 levels.
///
/// ```
/// use compass_core::base::raster::is_red;
///
/// assert!(is_red([200, 40, 50]) && !is_red([200, 190, 180]));
/// ```
#[must_use]
#[inline]
pub const fn is_red([r, g, b]: [u8; 3]) -> bool {
    let (r, other) = (r as u32, if g > b { g as u32 } else { b as u32 });
    r > other + 40 && 2 * r > 3 * other
}

fn pixel_count(width: u32, height: u32) -> Result<usize, RasterError> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(RasterError::Size);
    }
    (width as usize).checked_mul(height as usize).ok_or(RasterError::Size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_read_row_by_row() {
        let gray = GrayImage::new(&[1, 2, 3, 4, 5, 6, 7], 3, 2).unwrap();
        assert_eq!((gray.row(1), gray.row(2)), (&[4, 5, 6][..], &[][..]));
        assert_eq!(GrayImage::new(&[1, 2, 3], 2, 2).unwrap_err(), RasterError::Length);
        let rgb = RgbImage::new(&[1, 2, 3, 4, 5, 6], 1, 2).unwrap();
        assert_eq!((rgb.pixel(0, 1), rgb.pixel(1, 0), rgb.pixel(0, 2)), ([4, 5, 6], [0; 3], [0; 3]));
        assert_eq!(RgbImage::new(&[0; 5], 1, 2).unwrap_err(), RasterError::Length);
    }

    #[test]
    fn safety_gear_is_red_and_walls_are_not() {
        assert!(is_red([200, 40, 50]) && is_red([90, 30, 20]));
        assert!(!is_red([200, 190, 180]) && !is_red([60, 25, 25]) && !is_red([250, 180, 60]));
    }

    #[test]
    fn reads_bits_and_hides_padding() {
        let bits = [0b1111_1101, 0xff, 0x00, 0x01];
        let mask = BitMask::new(&bits, 9, 2).unwrap();
        assert!(mask.get(0, 0));
        assert!(!mask.get(1, 0));
        assert!(mask.get(8, 0));
        assert!(!mask.get(9, 0), "beyond the width");
        assert_eq!(mask.byte(1, 0), 1, "padding bits are dropped");
        assert!(mask.get(8, 1));
        assert!(!mask.get(0, 2), "beyond the height");
    }

    #[test]
    fn refuses_wrong_sizes() {
        assert_eq!(BitMask::new(&[0], 0, 1).unwrap_err(), RasterError::Size);
        assert_eq!(BitMask::new(&[0], 65_536, 1).unwrap_err(), RasterError::Size);
        assert_eq!(BitMask::new(&[0], 9, 1).unwrap_err(), RasterError::Length);
    }
}
