//! A shot: the frames of a rig at one instant as a byte format, with exclusion masks, lenses, up vector and camera height.
//!
//! It is all the input that a board needs beside the [site](crate::map::site), and is read in place. Frames are gray; of
//! the colours only red is used, as a mask of one bit per pixel.
//!
//! # Format, version 1
//! Little-endian words of 4 bytes, floats as `f32`; absent values are 0.
//!
//! | word | field |
//! |---:|---|
//! | 0, 1 | magic `CMPSSHOT` |
//! | 2 | version |
//! | 3, 4 | time in nanoseconds, signed |
//! | 5 to 7 | approximate up vector in camera 0, of any length above 0 |
//! | 8 | height of camera 0 above the floor in metres, 0 if unknown |
//! | 9 to 30 | camera 0 |
//! | 31 to 52 | camera 1 |
//! | 53 | CRC-32 of the words before |
//!
//! | word of a camera | field |
//! |---:|---|
//! | 0 | width in pixels + 65536 times the height; 0 if the rig lacks the camera |
//! | 1 | lens: 1 [`KannalaBrandt`], 2 [`Eucm`], 3 [`Equidistant`], 4 [`DoubleSphere`] |
//! | 2 to 5 | fx, fy, cx, cy |
//! | 6 to 9 | k1 to k4, alpha and beta, or xi and alpha |
//! | 10 to 18 | rotation of its bearings into camera 0, row by row |
//! | 19 to 21 | position in camera 0, metres |
//!
//! The header is followed by the gray levels of each camera, row by row from the top, and its mask in the layout of
//! [`BitMask`]; the last 4 bytes are the CRC-32 of all bytes before them.

mod error;
mod header;
mod layout;
mod write;

pub use error::ShotError;
pub use header::Header;
pub use write::Writer;

use crate::base::crc::CRC32;
use crate::base::raster::{BitMask, GrayImage};
use layout::{HEADER_BYTES, Words};

#[cfg(doc)]
use crate::vision::camera::{DoubleSphere, Equidistant, Eucm, KannalaBrandt};

/// Gray levels, and the exclusion mask.
pub type Image<'a> = (GrayImage<'a>, BitMask<'a>);

/// A shot, borrowed from memory, a mapped file or flash.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    bytes: &'a [u8],
    header: Header,
    images: [Option<Image<'a>>; 2],
}

impl<'a> Shot<'a> {
    /// Views bytes as a shot. Validates length and header, including the header's checksum; [`Shot::verify`] checks that of
    /// the whole.
    ///
    /// # Errors
    /// [`ShotError`] names the invalid field.
    ///
    /// # Cost
    /// Reads the header; images are views, not copies.
    ///
    /// ```
    /// use compass_core::vision::shot::{Shot, ShotError};
    ///
    /// assert_eq!(Shot::new(b"CMPSSITE").unwrap_err(), ShotError::Magic);
    /// assert_eq!(Shot::new(b"CMPSSHOT").unwrap_err(), ShotError::Length);
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, ShotError> {
        if !bytes.starts_with(&layout::MAGIC) {
            let short = bytes.len() < layout::MAGIC.len() && layout::MAGIC.starts_with(bytes);
            return Err(if short { ShotError::Length } else { ShotError::Magic });
        }
        let (header, mut rest) = bytes.split_first_chunk::<HEADER_BYTES>().ok_or(ShotError::Length)?;
        let header = Words::from_bytes(header).header()?;
        header.check()?;
        let mut images = [None; 2];
        for (number, view) in header.rig.views() {
            let image = image(&mut rest, view.width.into(), view.height.into()).ok_or(ShotError::Length)?;
            images.get_mut(number).ok_or(ShotError::Image)?.replace(image);
        }
        // The rest is the checksum of the whole.
        if rest.len() == size_of::<u32>() {
            Ok(Self { bytes, header, images })
        } else {
            Err(ShotError::Length)
        }
    }

    /// Verifies the checksum of the whole shot; reads all bytes. [`Writer`] has an example.
    ///
    /// # Errors
    /// [`ShotError::Checksum`].
    pub fn verify(&self) -> Result<(), ShotError> {
        let (body, crc) = self.bytes.split_last_chunk().ok_or(ShotError::Length)?;
        if CRC32.checksum(body) == u32::from_le_bytes(*crc) { Ok(()) } else { Err(ShotError::Checksum) }
    }

    /// The metadata.
    #[must_use]
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// The images by camera number; `None` for a camera that the rig lacks.
    #[must_use]
    pub const fn images(&self) -> &[Option<Image<'a>>; 2] {
        &self.images
    }
}

/// Splits an image off the front of the bytes.
fn image<'a>(bytes: &mut &'a [u8], width: u32, height: u32) -> Option<Image<'a>> {
    let pixels = width.checked_mul(height)?;
    let (gray, rest) = bytes.split_at_checked(usize::try_from(pixels).ok()?)?;
    let mask_bytes = BitMask::row_bytes(width).checked_mul(usize::try_from(height).ok()?)?;
    let (mask, rest) = rest.split_at_checked(mask_bytes)?;
    *bytes = rest;
    Some((GrayImage::new(gray, width, height).ok()?, BitMask::new(mask, width, height).ok()?))
}

#[cfg(test)]
mod tests;
