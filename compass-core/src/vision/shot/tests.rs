use super::*;
use crate::map::site_map::Sink;
use crate::vision::camera::{Bearing, CameraError, Rig};
use crate::vision::camera::{Camera, Eucm, Intrinsics, KannalaBrandt, View};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::vec::Vec;

const WIDTH: u32 = 13;
const HEIGHT: u32 = 7;

struct Bytes(Vec<u8>);

impl Sink for Bytes {
    type Error = core::convert::Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

fn rig() -> Rig {
    let intrinsics = |f: f32| Intrinsics { fx: f, fy: f + 0.5, cx: 6.25, cy: 3.5 };
    let front = KannalaBrandt::new(intrinsics(4.0), [0.024, -0.01, -0.002, 0.0002]).unwrap();
    let back = Eucm::new(intrinsics(5.0), 0.6, 1.1).unwrap();
    let view = |camera| View::new(camera, WIDTH as u16, HEIGHT as u16);
    // A quarter turn: the matrix differs from its transpose.
    let back = View {
        rotation: Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        position: Vector3::new(0.001, -0.002, -0.04),
        ..view(Camera::Eucm(back))
    };
    Rig::new([Some(view(Camera::KannalaBrandt(front))), Some(back)]).unwrap()
}

fn header() -> Header {
    Header { time_ns: -5_000_000_001, rig: rig(), up: Bearing::new(0.0, 2.0, 0.1), height_m: Some(1.6) }
}

/// Gray levels and mask bits that vary over the image.
fn pixels(seed: u8) -> (Vec<u8>, Vec<u8>) {
    let gray = (0..WIDTH * HEIGHT).map(|at| seed.wrapping_add((at as u8).wrapping_mul(3))).collect();
    let mask = (0..2 * HEIGHT).map(|at| seed.wrapping_mul(at as u8 + 1) & 0x1f).collect();
    (gray, mask)
}

fn image<'a>((gray, mask): &'a (Vec<u8>, Vec<u8>)) -> Image<'a> {
    (GrayImage::new(gray, WIDTH, HEIGHT).unwrap(), BitMask::new(mask, WIDTH, HEIGHT).unwrap())
}

fn shot() -> Vec<u8> {
    let data = [pixels(7), pixels(90)];
    let writer = Writer::new(&header(), data.each_ref().map(|data| Some(image(data)))).unwrap();
    let Ok(Bytes(bytes)) = writer.write(Bytes(Vec::new()));
    assert_eq!(bytes.len(), writer.shot_bytes());
    bytes
}

/// Recomputes the header's checksum.
fn seal(bytes: &mut [u8]) {
    let crc = CRC32.checksum(&bytes[..HEADER_BYTES - 4]);
    bytes[HEADER_BYTES - 4..HEADER_BYTES].copy_from_slice(&crc.to_le_bytes());
}

#[test]
fn shots_round_trip() {
    let bytes = shot();
    let shot = Shot::new(&bytes).unwrap();
    shot.verify().unwrap();
    assert_eq!(*shot.header(), header());
    for (image, (gray, mask)) in shot.images().iter().zip([pixels(7), pixels(90)]) {
        let (seen, mask_seen) = image.unwrap();
        assert_eq!(seen.pixels(), gray);
        assert!((0..HEIGHT).all(|y| (0..2).all(|x| mask_seen.byte(x, y) == mask[(2 * y + x) as usize])));
    }
}

#[test]
fn one_camera_without_a_height_round_trips() {
    let view = *rig().view(1).unwrap();
    let header = Header { rig: Rig::new([None, Some(view)]).unwrap(), height_m: None, ..header() };
    let data = pixels(1);
    let writer = Writer::new(&header, [None, Some(image(&data))]).unwrap();
    let Ok(Bytes(bytes)) = writer.write(Bytes(Vec::new()));
    let shot = Shot::new(&bytes).unwrap();
    assert_eq!(*shot.header(), header);
    assert!(shot.images()[0].is_none() && shot.images()[1].is_some());
    assert_eq!(Writer::new(&header, [Some(image(&data)); 2]).unwrap_err(), ShotError::Image);
    assert_eq!(Writer::new(&header, [None; 2]).unwrap_err(), ShotError::Image);
}

#[test]
fn every_truncation_and_every_damaged_byte_is_rejected() {
    let bytes = shot();
    for len in 0..bytes.len() {
        assert_eq!(Shot::new(&bytes[..len]).unwrap_err(), ShotError::Length, "{len} bytes");
    }
    assert_eq!(Shot::new(&[&bytes[..], &[0]].concat()).unwrap_err(), ShotError::Length);
    assert_eq!(Shot::new(b"CMPSSITE").unwrap_err(), ShotError::Magic);
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x20;
        assert!(Shot::new(&damaged).and_then(|shot| shot.verify()).is_err(), "byte {at}");
    }
}

#[test]
fn invalid_fields_with_a_valid_checksum_are_named() {
    let bytes = shot();
    let nan = f32::NAN.to_bits();
    for (word, value, error) in [
        (2, 2, ShotError::Version(2)),
        (5, nan, ShotError::Up),
        (8, 0.1_f32.to_bits(), ShotError::Height),
        (8, nan, ShotError::Height),
        (9, WIDTH, ShotError::Camera(CameraError::Size)),
        (9, u32::MAX, ShotError::Length),
        (10, 9, ShotError::Lens(9)),
        (11, 0, ShotError::Camera(CameraError::Focal)),
        (41, nan, ShotError::Camera(CameraError::NotFinite)),
        (41, 1.0_f32.to_bits(), ShotError::Camera(CameraError::Rotation)),
    ] {
        let mut damaged = bytes.clone();
        damaged[4 * word..][..4].copy_from_slice(&value.to_le_bytes());
        seal(&mut damaged);
        assert_eq!(Shot::new(&damaged).unwrap_err(), error, "word {word}");
    }
    let mut damaged = bytes;
    damaged[20..32].fill(0);
    seal(&mut damaged);
    assert_eq!(Shot::new(&damaged).unwrap_err(), ShotError::Up);
}

proptest! {
    #[test]
    fn no_header_panics(words in prop::collection::vec((0..53_usize, any::<u32>()), 1..6)) {
        let mut bytes = shot();
        for (word, value) in words {
            bytes[4 * word..][..4].copy_from_slice(&value.to_le_bytes());
        }
        seal(&mut bytes);
        if let Ok(shot) = Shot::new(&bytes) {
            prop_assert_eq!(shot.images().iter().flatten().count(), shot.header().rig.views().count());
        }
    }
}
