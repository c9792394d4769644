//! The messages of cameras and IMUs, in CDR: those of `sensor_msgs`, and the images of `foxglove_msgs`.

use super::encoding::Encoded;
use super::kind::Kind;
#[cfg(feature = "ros2")]
use crate::frame::Frame;
use crate::image_file::{self, Pixels};
use crate::input::{self, limits};
use byteorder::{BigEndian, LittleEndian};
use nalgebra::Vector3;
use serde::Deserialize;
use std::io::{ErrorKind, Read};

/// Bytes up to the end of the stamp, with which all supported messages begin.
const STAMP_END: usize = 12;

#[derive(Deserialize)]
struct Time {
    sec: i32,
    nanosec: u32,
}

#[derive(Deserialize)]
struct Header {
    _stamp: Time,
    _frame_id: String,
}

#[derive(Deserialize)]
struct Image<'a> {
    _header: Header,
    height: u32,
    width: u32,
    encoding: String,
    is_bigendian: u8,
    step: u32,
    data: &'a [u8],
}

#[derive(Deserialize)]
struct CompressedImage<'a> {
    _header: Header,
    format: String,
    data: &'a [u8],
}

#[derive(Deserialize)]
struct FoxgloveImage<'a> {
    _header: Header,
    width: u32,
    height: u32,
    encoding: String,
    step: u32,
    data: &'a [u8],
}

#[derive(Deserialize)]
struct FoxgloveCompressedImage<'a> {
    _header: Header,
    data: &'a [u8],
    format: String,
}

#[derive(Deserialize)]
struct Imu {
    _header: Header,
    _orientation: [f64; 4],
    _orientation_covariance: [f64; 9],
    _angular_velocity: [f64; 3],
    _angular_velocity_covariance: [f64; 9],
    linear_acceleration: [f64; 3],
}

/// The time in the header of a message, nanoseconds; needs only the first bytes.
pub(super) fn stamp(mut message: impl Read) -> Result<u64, String> {
    let mut head = [0; STAMP_END];
    message.read_exact(&mut head).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => "a message ends within its header".to_owned(),
        _ => error.to_string(),
    })?;
    nanoseconds(&decode(&head)?)
}

/// Longest reading of an IMU, bytes: the name of its frame is all that varies.
const READING_BYTES: u64 = 1 << 16;

/// The time in the header and the acceleration of a reading.
pub(super) fn imu(message: impl Read) -> Result<(u64, Vector3<f64>), String> {
    let bytes = input::unpack(message, READING_BYTES).map_err(|error| error.to_string())?;
    let stamp = stamp(&bytes[..])?;
    let imu: Imu = decode(&bytes)?;
    let acceleration = Vector3::from(imu.linear_acceleration);
    if !acceleration.iter().all(|value| value.is_finite()) {
        return Err("the acceleration is not finite".to_owned());
    }
    Ok((stamp, acceleration))
}

/// The pixels of an image of any kind; what is compressed is recognised by its content, not by its `format` field.
pub(super) fn pixels(kind: Kind, message: &[u8]) -> Result<Pixels, String> {
    match kind {
        Kind::Image => {
            let Image { height, width, encoding, is_bigendian, step, data, .. } = decode(message)?;
            raw((width, height), &encoding, is_bigendian != 0, step, data)
        }
        Kind::FoxgloveImage => {
            let FoxgloveImage { width, height, encoding, step, data, .. } = decode(message)?;
            raw((width, height), &encoding, false, step, data)
        }
        Kind::CompressedImage => {
            let CompressedImage { format, data, .. } = decode(message)?;
            compressed(&format, data)
        }
        Kind::FoxgloveCompressedImage => {
            let FoxgloveCompressedImage { data, format, .. } = decode(message)?;
            compressed(&format, data)
        }
        Kind::Imu | Kind::Video | Kind::Other => Err("is no image".to_owned()),
    }
}

/// Formats of video that some drivers put into messages for images.
const VIDEO: [&str; 5] = ["h264", "h265", "hevc", "vp9", "av1"];

/// The frame of a `CompressedImage`.
#[cfg(feature = "ros2")]
pub(crate) fn compressed_frame(format: &str, data: &[u8]) -> Result<Frame, String> {
    compressed(format, data).map(Frame::from)
}

/// The frame of an `Image`.
#[cfg(feature = "ros2")]
pub(crate) fn raw_frame(
    size: (u32, u32),
    encoding: &str,
    is_bigendian: bool,
    step: u32,
    data: &[u8],
) -> Result<Frame, String> {
    raw(size, encoding, is_bigendian, step, data).map(Frame::from)
}

fn compressed(format: &str, data: &[u8]) -> Result<Pixels, String> {
    image_file::decode(data, limits().frame_pixels).map_err(|error| {
        let is_video = VIDEO.iter().any(|video| format.to_lowercase().contains(video));
        if is_video { format!("its format is '{format}': video is not read") } else { error.to_string() }
    })
}

fn raw(
    (width, height): (u32, u32),
    encoding: &str,
    is_bigendian: bool,
    step: u32,
    data: &[u8],
) -> Result<Pixels, String> {
    image_file::check_size(width, height, limits().frame_pixels).map_err(|error| error.to_string())?;
    Encoded { encoding, width, height, step: step as usize, is_bigendian, data }.pixels()
}

/// A message without its encapsulation header: two bytes for the encoding, two unused.
fn decode<'a, T: Deserialize<'a>>(message: &'a [u8]) -> Result<T, String> {
    let Some((&[kind, order, _, _], body)) = message.split_first_chunk() else {
        return Err("a message is too short for any".to_owned());
    };
    let decoded = match [kind, order] {
        [0, 0] => cdr_encoding::from_bytes::<T, BigEndian>(body),
        [0, 1] => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        other => return Err(format!("encapsulation {other:02x?} is not known, only plain CDR")),
    };
    decoded.map(|(value, _)| value).map_err(|error| format!("a message is too short or damaged: {error}"))
}

fn nanoseconds(Time { sec, nanosec }: &Time) -> Result<u64, String> {
    let seconds = u64::try_from(*sec).map_err(|_| format!("a message has a stamp of {sec} s"))?;
    Ok(seconds * 1_000_000_000 + u64::from(*nanosec))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::Samples;
    use serde::Serialize;

    type Head<'a> = ((i32, u32), &'a str);

    fn message<T: Serialize>(body: &T) -> Vec<u8> {
        [vec![0, 1, 0, 0], cdr_encoding::to_vec::<T, LittleEndian>(body).unwrap()].concat()
    }

    const HEAD: Head<'static> = ((5, 7), "cam0");

    /// Two rows of two gray pixels, each row followed by a padding byte.
    fn picture(kind: Kind) -> Vec<u8> {
        let data = &[1_u8, 2, 99, 3, 4, 99][..];
        match kind {
            Kind::FoxgloveImage => message(&(HEAD, 2_u32, 2_u32, "mono8", 3_u32, data)),
            _ => message(&(HEAD, 2_u32, 2_u32, "mono8", 0_u8, 3_u32, data)),
        }
    }

    #[test]
    fn images_of_every_kind_are_read() {
        let samples = |kind: Kind, message: &[u8]| match pixels(kind, message).unwrap().samples {
            Samples::Gray(samples) | Samples::Rgb(samples) => samples,
        };
        for kind in [Kind::Image, Kind::FoxgloveImage] {
            assert_eq!(stamp(&picture(kind)[..]).unwrap(), 5_000_000_007);
            assert_eq!(samples(kind, &picture(kind)), [1, 2, 3, 4]);
        }
        let pgm = &b"P5 2 1 255\n\x01\x02"[..];
        assert_eq!(samples(Kind::CompressedImage, &message(&(HEAD, "pgm", pgm))), [1, 2]);
        assert_eq!(samples(Kind::FoxgloveCompressedImage, &message(&(HEAD, pgm, "pgm"))), [1, 2]);
    }

    #[test]
    fn both_orders_of_bytes_are_read() {
        let head: Head<'_> = ((1, 2), "imu");
        let body = (head, [0.0; 4], [0.0; 9], [0.0; 3], [0.0; 9], [1.0, -2.0, 9.75], [0.0; 9]);
        let expected = (1_000_000_002, Vector3::new(1.0, -2.0, 9.75));
        assert_eq!(imu(&message(&body)[..]).unwrap(), expected);
        let big = [vec![0; 4], cdr_encoding::to_vec::<_, BigEndian>(&body).unwrap()].concat();
        assert_eq!(imu(&big[..]).unwrap(), expected);
        let nan = (head, [0.0; 4], [0.0; 9], [0.0; 3], [0.0; 9], [1.0, f64::NAN, 9.75], [0.0; 9]);
        assert!(imu(&message(&nan)[..]).unwrap_err().contains("not finite"));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let of = |size: [u32; 2], encoding: &str| {
            message(&(HEAD, size[1], size[0], encoding, 0_u8, 6_u32, &[0_u8; 9][..]))
        };
        for (message, named) in [
            (of([2, 2], "32FC1"), "encoding '32FC1'"),
            (of([2, 2], "rgb8"), "9 bytes of data"),
            (of([0, 2], "rgb8"), "0 x 2 pixels"),
            (picture(Kind::Image)[..40].to_vec(), "too short or damaged"),
            (vec![0, 1], "too short"),
            (vec![0, 7, 0, 0, 1, 2, 3], "encapsulation [00, 07]"),
        ] {
            let problem = pixels(Kind::Image, &message).unwrap_err();
            assert!(problem.contains(named), "{named}: {problem}");
        }
        let foreign = pixels(Kind::CompressedImage, &message(&(HEAD, "jpeg", &b"GIF89a"[..]))).unwrap_err();
        assert!(foreign.contains("not a PNG, JPEG"), "{foreign}");
        let video =
            pixels(Kind::CompressedImage, &message(&(HEAD, "h264", &[0_u8, 0, 0, 1, 9][..]))).unwrap_err();
        assert!(video.contains("'h264': video is not read"), "{video}");
        assert!(stamp(&[0, 1, 0, 0, 1][..]).unwrap_err().contains("within its header"));
        let before: Head<'_> = ((-1, 0), "");
        assert!(stamp(&message(&before)[..]).unwrap_err().contains("-1 s"));
    }
}
