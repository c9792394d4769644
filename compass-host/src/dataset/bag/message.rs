//! The messages of cameras and IMUs, in CDR: `sensor_msgs/msg/Image`, `CompressedImage` and `Imu`.

use crate::dataset::imu::Reading;
use crate::image_file::{self, Pixels, Samples};
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
    stamp: Time,
    _frame_id: String,
}

#[derive(Deserialize)]
struct Image<'a> {
    _header: Header,
    height: u32,
    width: u32,
    encoding: String,
    _is_bigendian: u8,
    step: u32,
    data: &'a [u8],
}

#[derive(Deserialize)]
struct CompressedImage<'a> {
    _header: Header,
    _format: String,
    data: &'a [u8],
}

#[derive(Deserialize)]
struct Imu {
    header: Header,
    _orientation: [f64; 4],
    _orientation_covariance: [f64; 9],
    _angular_velocity: [f64; 3],
    _angular_velocity_covariance: [f64; 9],
    linear_acceleration: [f64; 3],
}

/// The time of a message in nanoseconds; needs only the first bytes.
pub(super) fn stamp(mut message: impl Read) -> Result<u64, String> {
    let mut head = [0; STAMP_END];
    message.read_exact(&mut head).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => "a message ends within its header".to_owned(),
        _ => error.to_string(),
    })?;
    nanoseconds(&decode(&head)?)
}

/// An accelerometer reading.
pub(super) fn imu(mut message: impl Read) -> Result<Reading, String> {
    let mut bytes = Vec::new();
    message.read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    let imu: Imu = decode(&bytes)?;
    let acceleration = Vector3::from(imu.linear_acceleration);
    let timestamp_ns = nanoseconds(&imu.header.stamp)?;
    if !acceleration.iter().all(|value| value.is_finite()) {
        return Err(format!("the acceleration at {timestamp_ns} ns is not finite"));
    }
    Ok(Reading { timestamp_ns, acceleration })
}

/// The pixels of an image; alpha is ignored.
pub(super) fn image(message: &[u8]) -> Result<Pixels, String> {
    let Image { height, width, encoding, step, data, .. } = decode(message)?;
    image_file::check_size(width, height).map_err(|error| error.to_string())?;
    let (bytes, order): (usize, [usize; 3]) = match encoding.as_str() {
        "mono8" => (1, [0; 3]),
        "rgb8" => (3, [0, 1, 2]),
        "bgr8" => (3, [2, 1, 0]),
        "rgba8" => (4, [0, 1, 2]),
        "bgra8" => (4, [2, 1, 0]),
        other => {
            return Err(format!("encoding '{other}' is not known, only mono8, rgb8, bgr8, rgba8 and bgra8"));
        }
    };
    let (row, step) = (width as usize * bytes, step as usize);
    if step < row {
        return Err(format!("a step of {step} bytes is too short for {width} pixels in {encoding}"));
    }
    // The last row may lack its padding.
    if data.len() < step * (height as usize - 1) + row {
        return Err(format!("{} bytes of data are too few for {height} rows of {step} bytes", data.len()));
    }
    let rows = data.chunks(step).take(height as usize).map(|padded| &padded[..row]);
    let samples = if bytes == 1 {
        Samples::Gray(rows.flatten().copied().collect())
    } else {
        let pixels = rows.flat_map(|row| row.chunks_exact(bytes));
        Samples::Rgb(pixels.flat_map(|pixel| order.map(|channel| pixel[channel])).collect())
    };
    Ok(Pixels { width, height, samples })
}

/// The pixels of a compressed image; the content decides, not its `format` field.
pub(super) fn compressed_image(message: &[u8]) -> Result<Pixels, String> {
    let CompressedImage { data, .. } = decode(message)?;
    image_file::decode(data).map_err(|error| error.to_string())
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
    use serde::Serialize;

    type Head<'a> = ((i32, u32), &'a str);

    fn message<T: Serialize>(body: &T) -> Vec<u8> {
        [vec![0, 1, 0, 0], cdr_encoding::to_vec::<T, LittleEndian>(body).unwrap()].concat()
    }

    /// Two rows of two pixels, each row followed by a padding byte.
    fn picture(encoding: &str, step: u32, data: &[u8]) -> Vec<u8> {
        let head: Head<'_> = ((5, 7), "cam0");
        message(&(head, 2_u32, 2_u32, encoding, 1_u8, step, data))
    }

    fn samples(encoding: &str, step: u32, data: &[u8]) -> Vec<u8> {
        match image(&picture(encoding, step, data)).unwrap().samples {
            Samples::Gray(samples) | Samples::Rgb(samples) => samples,
        }
    }

    #[test]
    fn pixels_are_gray_or_red_green_blue() {
        assert_eq!(samples("mono8", 3, &[1, 2, 99, 3, 4]), [1, 2, 3, 4]);
        let colours = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
        let swapped = [3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10];
        assert_eq!(samples("rgb8", 6, &colours), colours);
        assert_eq!(samples("bgr8", 6, &colours), swapped);
        let padded: Vec<u8> =
            colours.chunks(6).flat_map(|row| [&row[..3], &[0], &row[3..], &[9, 99, 99]].concat()).collect();
        assert_eq!(samples("rgba8", 10, &padded), colours);
        assert_eq!(samples("bgra8", 10, &padded), swapped);
        let good = picture("mono8", 3, &[1, 2, 99, 3, 4, 99]);
        assert_eq!(stamp(&good[..]).unwrap(), 5_000_000_007);
    }

    #[test]
    fn both_orders_of_bytes_are_read() {
        let head: Head<'_> = ((1, 2), "imu");
        let body = (head, [0.0; 4], [0.0; 9], [0.0; 3], [0.0; 9], [1.0, -2.0, 9.75], [0.0; 9]);
        let expected = Reading { timestamp_ns: 1_000_000_002, acceleration: Vector3::new(1.0, -2.0, 9.75) };
        assert_eq!(imu(&message(&body)[..]).unwrap(), expected);
        let big = [vec![0; 4], cdr_encoding::to_vec::<_, BigEndian>(&body).unwrap()].concat();
        assert_eq!(imu(&big[..]).unwrap(), expected);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (message, named) in [
            (picture("yuv422", 4, &[0; 8]), "encoding 'yuv422'"),
            (picture("mono16", 4, &[0; 8]), "encoding 'mono16'"),
            (picture("rgb8", 5, &[0; 12]), "a step of 5 bytes"),
            (picture("rgb8", 6, &[0; 11]), "11 bytes of data"),
            (picture("rgb8", u32::MAX, &[0; 12]), "12 bytes of data"),
            (picture("mono8", 2, &[0; 4])[..40].to_vec(), "too short or damaged"),
            (vec![0, 1], "too short"),
            (vec![0, 7, 0, 0, 1, 2, 3], "encapsulation [00, 07]"),
        ] {
            let problem = image(&message).unwrap_err();
            assert!(problem.contains(named), "{named}: {problem}");
        }
        let head: Head<'_> = ((5, 7), "cam0");
        let foreign = compressed_image(&message(&(head, "jpeg", &b"GIF89a"[..]))).unwrap_err();
        assert!(foreign.contains("not a PNG, JPEG"), "{foreign}");
        assert!(stamp(&[0, 1, 0, 0, 1][..]).unwrap_err().contains("within its header"));
        let before: Head<'_> = ((-1, 0), "");
        assert!(stamp(&message(&before)[..]).unwrap_err().contains("-1 s"));
    }
}
