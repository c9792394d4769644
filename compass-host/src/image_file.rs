//! Decodes image files to 8-bit gray or RGB; transparency is blended with white.

use crate::guard::{GAVE_UP, guarded};
use crate::input;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::error::ImageError;
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use thiserror::Error;

/// Longest side of an image, in pixels.
pub const MAX_SIDE: u32 = 65_535;

/// Why an image could not be read: one line that names the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImageFileError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The content of the file is not a usable image.
    #[error("{}: {problem}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: DecodeError,
    },
}

/// Why bytes are not a usable image.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The bytes are not a PNG, JPEG, WebP, PGM, BMP or TIFF image.
    #[error("not a PNG, JPEG, WebP, PGM, BMP or TIFF image")]
    NotAnImage,
    /// The image is of a kind that the decoder does not know, as a TIFF image with a palette.
    #[error("this kind of image is not read (save it as an RGB PNG): {reason}")]
    Unsupported {
        /// The decoder's message, in one line.
        reason: String,
    },
    /// The bytes start as an image but cannot be decoded, as in a truncated file.
    #[error("damaged or truncated image: {reason}")]
    Damaged {
        /// The decoder's message, in one line.
        reason: String,
    },
    /// A side of the image is 0 or longer than [`MAX_SIDE`].
    #[error("{width} x {height} pixels; each side must be 1 to 65535")]
    Size {
        /// Pixels along x.
        width: u32,
        /// Pixels along y.
        height: u32,
    },
    /// The image has more pixels than [`input::limits`] allow.
    #[error(
        "{width} x {height} pixels are more than the limit of {limit}; --raise-limits {} raises it",
        (u64::from(*width) * u64::from(*height)).div_ceil((*limit).max(1))
    )]
    TooManyPixels {
        /// Pixels along x.
        width: u32,
        /// Pixels along y.
        height: u32,
        /// The most that are read.
        limit: u64,
    },
}

/// Bytes of the largest pixel: four samples of 16 bits.
const MAX_PIXEL_BYTES: u64 = 8;

/// The samples of a decoded image, top row first.
#[derive(Debug)]
pub struct Pixels {
    /// Pixels along x, 1..=65535.
    pub width: u32,
    /// Pixels along y, 1..=65535.
    pub height: u32,
    /// The samples.
    pub samples: Samples,
}

/// Gray stays gray: such an image has no red, and is classified faster.
#[derive(Debug, PartialEq, Eq)]
pub enum Samples {
    /// One byte per pixel.
    Gray(Vec<u8>),
    /// Three bytes per pixel.
    Rgb(Vec<u8>),
}

impl Pixels {
    /// The colour of all pixels, if they have only one.
    #[must_use]
    pub fn only_colour(&self) -> Option<[u8; 3]> {
        match &self.samples {
            Samples::Gray(gray) => {
                let first = *gray.first()?;
                gray.iter().all(|&v| v == first).then_some([first; 3])
            }
            Samples::Rgb(rgb) => {
                let first = *rgb.first_chunk::<3>()?;
                rgb.as_chunks::<3>().0.iter().all(|&v| v == first).then_some(first)
            }
        }
    }
}

/// Decodes the image at `path`, of at most `max_pixels`; the extension is ignored. It is turned as its orientation in EXIF
/// or TIFF says.
///
/// # Errors
/// [`ImageFileError`] for a file that is missing, not an image, damaged, truncated or too large.
pub fn read(path: &Path, max_pixels: u64) -> Result<Pixels, ImageFileError> {
    let bytes = input::read(path, input::limits().image_bytes)
        .map_err(|source| ImageFileError::Read { path: path.to_path_buf(), source })?;
    decode(&bytes, max_pixels).map_err(|problem| ImageFileError::Decode { path: path.to_path_buf(), problem })
}

/// Decodes the bytes of an image file, of at most `max_pixels`: a header that claims more is refused before it is believed.
///
/// # Errors
/// [`DecodeError`] for bytes that are not an image, damaged, truncated or too large.
pub fn decode(bytes: &[u8], max_pixels: u64) -> Result<Pixels, DecodeError> {
    let big_tiff = BIG_TIFF.iter().any(|magic| bytes.starts_with(magic)).then_some(ImageFormat::Tiff);
    let format = big_tiff.or_else(|| image::guess_format(bytes).ok()).ok_or(DecodeError::NotAnImage)?;
    if !format.reading_enabled() {
        return Err(DecodeError::NotAnImage);
    }
    if format == ImageFormat::Jpeg && !jpeg_is_ended(bytes) {
        return jpeg_without_end(bytes, max_pixels);
    }
    decode_as(format, bytes, max_pixels)
}

/// Decodes an image of a format; a panic of its decoder is damage.
fn decode_as(format: ImageFormat, bytes: &[u8], max_pixels: u64) -> Result<Pixels, DecodeError> {
    let gave_up = || Err(DecodeError::Damaged { reason: GAVE_UP.to_owned() });
    guarded(|| decode_unguarded(format, bytes, max_pixels)).unwrap_or_else(gave_up)
}

fn decode_unguarded(format: ImageFormat, bytes: &[u8], max_pixels: u64) -> Result<Pixels, DecodeError> {
    let damaged = |error: ImageError| {
        let reason = one_line(&error.to_string());
        match error {
            ImageError::Unsupported(_) => DecodeError::Unsupported { reason },
            _ => DecodeError::Damaged { reason },
        }
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(max_pixels.saturating_mul(MAX_PIXEL_BYTES));
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    check_size(width, height, max_pixels)?;
    // An orientation that cannot be read is none, as to viewers.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    image.apply_orientation(orientation);
    let (width, height) = (image.width(), image.height());
    Ok(Pixels { width, height, samples: samples(image) })
}

/// Decodes a JPEG image that lacks its end marker, as some cameras leave it off: it is whole if its pixels do not depend
/// on what follows.
fn jpeg_without_end(bytes: &[u8], max_pixels: u64) -> Result<Pixels, DecodeError> {
    let reason = "the JPEG data stops before its end marker".to_owned();
    // A last byte 0xff is half a marker.
    let bytes = bytes.strip_suffix(&[0xff]).unwrap_or(bytes);
    let ended = |filling: u8| {
        decode_as(ImageFormat::Jpeg, &[bytes, &[filling; JPEG_FILLING], &JPEG_END].concat(), max_pixels)
    };
    match (ended(0x00), ended(0x5a)) {
        (Ok(a), Ok(b)) if a.samples == b.samples => Ok(a),
        _ => Err(DecodeError::Damaged { reason }),
    }
}

/// Whether both sides of an image are within the supported range, and its pixels within a limit.
pub(crate) fn check_size(width: u32, height: u32, limit: u64) -> Result<(), DecodeError> {
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(DecodeError::Size { width, height });
    }
    if u64::from(width) * u64::from(height) > limit {
        return Err(DecodeError::TooManyPixels { width, height, limit });
    }
    Ok(())
}

/// A message joined into one line.
pub(crate) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// How TIFF files with 64-bit offsets start, in either byte order.
const BIG_TIFF: [&[u8]; 2] = [b"II\x2b\0", b"MM\0\x2b"];

/// The end marker of a JPEG image.
const JPEG_END: [u8; 2] = [0xff, 0xd9];

/// Bytes that stand for missing ones; enough to show in the first block that lacks its data.
const JPEG_FILLING: usize = 256;

/// Whether an end marker follows the last scan; the decoder itself fills missing data with gray.
fn jpeg_is_ended(bytes: &[u8]) -> bool {
    let marker = |code: u8| bytes.windows(2).rposition(|pair| pair == [0xff, code]);
    marker(JPEG_END[1]) > marker(0xda)
}

fn samples(image: DynamicImage) -> Samples {
    match image {
        DynamicImage::ImageLuma8(gray) => Samples::Gray(gray.into_raw()),
        DynamicImage::ImageRgb8(rgb) => Samples::Rgb(rgb.into_raw()),
        other => match (other.color().has_color(), other.color().has_alpha()) {
            (false, false) => Samples::Gray(other.into_luma8().into_raw()),
            (false, true) => Samples::Gray(over_white::<2, 1>(other.into_luma_alpha8().as_raw())),
            (true, false) => Samples::Rgb(other.into_rgb8().into_raw()),
            (true, true) => Samples::Rgb(over_white::<4, 3>(other.into_rgba8().as_raw())),
        },
    }
}

/// Pixels of `N` samples, the last of them alpha, laid over white: `C = N - 1` samples each.
fn over_white<const N: usize, const C: usize>(samples: &[u8]) -> Vec<u8> {
    let mut flat = Vec::with_capacity(samples.len() / N * C);
    for pixel in samples.as_chunks::<N>().0 {
        let alpha = u32::from(pixel[C]);
        for &value in &pixel[..C] {
            let mixed = (u32::from(value) * alpha + 255 * (255 - alpha) + 127) / 255;
            flat.push(u8::try_from(mixed).unwrap_or(u8::MAX));
        }
    }
    flat
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More pixels than any image here has.
    const MANY: u64 = 1_000_000;

    #[test]
    fn a_header_is_not_believed_beyond_the_limit() {
        let mut png = Cursor::new(Vec::new());
        image::GrayImage::new(40, 30).write_to(&mut png, ImageFormat::Png).unwrap();
        let png = png.into_inner();
        assert!(decode(&png, 1200).is_ok());
        let refused = decode(&png, 1199).unwrap_err().to_string();
        assert_eq!(refused, "40 x 30 pixels are more than the limit of 1199; --raise-limits 2 raises it");
    }

    #[test]
    fn alpha_is_laid_over_white() {
        assert_eq!(over_white::<2, 1>(&[0, 0, 0, 255, 100, 128]), [255, 0, 177]);
        assert_eq!(over_white::<4, 3>(&[255, 0, 0, 255, 9, 9, 9, 0]), [255, 0, 0, 255, 255, 255]);
    }

    #[test]
    fn end_marker_must_follow_the_scan() {
        assert!(jpeg_is_ended(&[0xff, 0xda, 1, 2, 0xff, 0xd9]));
        assert!(!jpeg_is_ended(&[0xff, 0xd9, 0xff, 0xda, 1, 2]), "only the thumbnail ends");
        assert!(!jpeg_is_ended(&[0xff, 0xd8]));
    }

    /// A JPEG image of a gradient with detail, gray or in colour.
    fn jpeg(is_gray: bool) -> Vec<u8> {
        let value = |x: u32, y: u32| ((7 * x + 3 * y) % 200 + (x * y) % 50) as u8;
        let picture = image::RgbImage::from_fn(45, 37, |x, y| image::Rgb([value(x, y), value(y, x), 90]));
        let picture = DynamicImage::ImageRgb8(picture);
        let mut bytes = Cursor::new(Vec::new());
        let picture = if is_gray { picture.to_luma8().into() } else { picture };
        picture.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn only_the_end_marker_may_be_missing() {
        for is_gray in [false, true] {
            let whole = jpeg(is_gray);
            let expected = decode(&whole, MANY).unwrap().samples;
            let data = whole.strip_suffix(&JPEG_END).unwrap();
            assert!(decode(data, MANY).unwrap().samples == expected);
            assert!(decode(&[data, &[0xff]].concat(), MANY).unwrap().samples == expected);
            for missing in [8, 20, 60, 200, data.len() / 2] {
                let error = decode(&data[..data.len() - missing], MANY).unwrap_err().to_string();
                assert!(error.contains("stops before its end marker"), "{missing}: {error}");
            }
        }
    }

    /// The picture with an EXIF orientation: its segment follows the start marker.
    fn turned(jpeg: &[u8], orientation: u8) -> Vec<u8> {
        let mut exif = b"\xff\xe1\x00\x22Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
        exif.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
        [&jpeg[..2], &exif, &jpeg[2..]].concat()
    }

    #[test]
    fn images_are_turned_as_they_say() {
        let upright = jpeg(true);
        let plain = decode(&upright, MANY).unwrap();
        let Samples::Gray(plain_gray) = &plain.samples else { panic!("gray") };
        let at = |x: u32, y: u32| plain_gray[(y * plain.width + x) as usize];
        for (orientation, size, corner) in [
            (1, (45, 37), at(0, 0)),
            (3, (45, 37), at(44, 36)),
            (6, (37, 45), at(0, 36)),
            (8, (37, 45), at(44, 0)),
        ] {
            let found = decode(&turned(&upright, orientation), MANY).unwrap();
            assert_eq!((found.width, found.height), size, "{orientation}");
            let Samples::Gray(gray) = found.samples else { panic!("gray") };
            assert_eq!(gray[0], corner, "{orientation}");
        }
    }
}
