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
//! | 1 | lens: 1 [`KannalaBrandt`], 2 [`Eucm`], 3 [`Equidistant`] |
//! | 2 to 5 | fx, fy, cx, cy |
//! | 6 to 9 | k1 to k4, or alpha and beta |
//! | 10 to 18 | rotation of its bearings into camera 0, row by row |
//! | 19 to 21 | position in camera 0, metres |
//!
//! The header is followed by the gray levels of each camera, row by row from the top, and its mask in the layout of
//! [`BitMask`]; the last 4 bytes are the CRC-32 of all bytes before them.

mod layout;
mod write;

pub use write::Writer;

use crate::base::crc::CRC32;
use crate::base::ladder::HEIGHTS_M;
use crate::base::raster::{BitMask, GrayImage};
use crate::vision::camera::{Bearing, CameraError, Rig};
use core::fmt;
use layout::{HEADER_BYTES, Words};

#[cfg(doc)]
use crate::vision::camera::{Equidistant, Eucm, KannalaBrandt};

/// Error of reading or writing a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ShotError {
    /// The bytes do not start with the magic of a shot.
    Magic,
    /// The format version is this one, not the supported one.
    Version(u32),
    /// The checksum of the header does not match it.
    HeaderChecksum,
    /// The up vector is 0 or not finite.
    Up,
    /// The height of the camera is outside [`HEIGHTS_M`].
    Height,
    /// The number of a camera's lens model is unknown.
    Lens(u32),
    /// A lens or the rig is invalid.
    Camera(CameraError),
    /// An image is missing, differs in size from its view, or belongs to a camera that the rig lacks.
    Image,
    /// The number of bytes differs from that of the header.
    Length,
    /// The checksum of the whole shot does not match.
    Checksum,
}

impl fmt::Display for ShotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("shot magic is missing: not a file of packed frames"),
            Self::Version(v) => write!(f, "shot version is {v}, this program reads {}", layout::VERSION),
            Self::HeaderChecksum => f.write_str("shot header checksum does not match: the header is damaged"),
            Self::Up => f.write_str("shot up vector is 0 or not finite"),
            Self::Height => {
                let [least, most] = HEIGHTS_M;
                write!(f, "shot camera height is outside {least} to {most} m")
            }
            Self::Lens(number) => write!(f, "shot lens number {number} is unknown"),
            Self::Camera(error) => error.fmt(f),
            Self::Image => f.write_str("shot images do not match the rig's cameras"),
            Self::Length => f.write_str(
                "shot length does not match its header: the file is truncated or has trailing bytes",
            ),
            Self::Checksum => f.write_str("shot checksum does not match: the file is damaged"),
        }
    }
}

impl core::error::Error for ShotError {}

/// Metadata of a shot: all but its images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// Time stamp, nanoseconds since an arbitrary epoch.
    pub time_ns: i64,
    /// The cameras, at the resolution of the images.
    pub rig: Rig,
    /// Approximate up vector in camera 0, of any length above 0.
    pub up: Bearing,
    /// Height of camera 0 above the floor in metres, within [`HEIGHTS_M`], if it is known.
    pub height_m: Option<f32>,
}

impl Header {
    fn check(&self) -> Result<(), ShotError> {
        let length = self.up.norm_squared();
        if !(length > 0.0 && length.is_finite()) {
            return Err(ShotError::Up);
        }
        let [least, most] = HEIGHTS_M;
        let good = self.height_m.is_none_or(|height| (least..=most).contains(&height));
        if good { Ok(()) } else { Err(ShotError::Height) }
    }
}

/// Gray levels, and the mask of red pixels.
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
