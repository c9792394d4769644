//! The header of a shot, word by word.

use super::error::{ShotError, VERSION};
use super::header::Header;
use crate::base::crc::CRC32;
use crate::vision::camera::{
    Bearing, Camera, DoubleSphere, Equidistant, Eucm, Intrinsics, KannalaBrandt, Rig, View,
};
use nalgebra::{Matrix3, Vector3};

pub(super) const MAGIC: [u8; 8] = *b"CMPSSHOT";

/// Words of a camera.
const VIEW_WORDS: usize = 22;
/// Words of the header.
const WORDS: usize = 9 + 2 * VIEW_WORDS + 1;
pub(super) const HEADER_BYTES: usize = 4 * WORDS;

const KANNALA_BRANDT: u32 = 1;
const EUCM: u32 = 2;
const EQUIDISTANT: u32 = 3;
const DOUBLE_SPHERE: u32 = 4;

/// The words of a header.
pub(super) struct Words([u32; WORDS]);

impl Words {
    pub(super) fn from_bytes(bytes: &[u8; HEADER_BYTES]) -> Self {
        let mut words = [0; WORDS];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        Self(words)
    }

    pub(super) fn to_bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        for (bytes, word) in bytes.as_chunks_mut().0.iter_mut().zip(&self.0) {
            *bytes = word.to_le_bytes();
        }
        bytes
    }

    #[expect(clippy::cast_possible_truncation, reason = "the two halves of the time stamp")]
    pub(super) fn new(header: &Header) -> Self {
        let mut words = Self([0; WORDS]);
        let Self([m0, m1, version, low, high, x, y, z, height, views @ .., _]) = &mut words;
        [*m0, *m1] = magic();
        *version = VERSION;
        let time = header.time_ns.cast_unsigned();
        [*low, *high] = [time as u32, (time >> 32) as u32];
        [*x, *y, *z] = [header.up.x, header.up.y, header.up.z].map(f32::to_bits);
        *height = header.height_m.unwrap_or(0.0).to_bits();
        for (number, view) in header.rig.views() {
            if let Some(words) = views.as_chunks_mut().0.get_mut(number) {
                *words = view_words(view);
            }
        }
        let checksum = words.checksum();
        let Self([.., crc]) = &mut words;
        *crc = checksum;
        words
    }

    /// Decodes the words.
    pub(super) fn header(&self) -> Result<Header, ShotError> {
        let Self([_, _, version, low, high, x, y, z, height, views @ .., crc]) = self;
        if *version != VERSION {
            return Err(ShotError::Version(*version));
        }
        if *crc != self.checksum() {
            return Err(ShotError::HeaderChecksum);
        }
        let mut rig = [None; 2];
        for (slot, words) in rig.iter_mut().zip(views.as_chunks().0) {
            *slot = view(words)?;
        }
        let height_m = f32::from_bits(*height);
        Ok(Header {
            time_ns: (u64::from(*high) << 32 | u64::from(*low)).cast_signed(),
            rig: Rig::new(rig).map_err(ShotError::Camera)?,
            up: Bearing::new(f32::from_bits(*x), f32::from_bits(*y), f32::from_bits(*z)),
            height_m: (height_m != 0.0).then_some(height_m),
        })
    }

    /// The checksum of all words except the last.
    fn checksum(&self) -> u32 {
        let bytes = self.to_bytes();
        let summed = bytes.split_last_chunk::<4>().map_or(&[][..], |(summed, _)| summed);
        CRC32.checksum(summed)
    }
}

const fn magic() -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = MAGIC;
    [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
}

fn view_words(view: &View) -> [u32; VIEW_WORDS] {
    let mut words = [0; VIEW_WORDS];
    let [size, lens, rest @ ..] = &mut words;
    *size = u32::from(view.height) << 16 | u32::from(view.width);
    let coefficients;
    (*lens, coefficients) = match view.camera {
        Camera::KannalaBrandt(lens) => (KANNALA_BRANDT, lens.coefficients()),
        Camera::Eucm(lens) => (EUCM, [lens.alpha(), lens.beta(), 0.0, 0.0]),
        Camera::Equidistant(_) => (EQUIDISTANT, [0.0; 4]),
        Camera::DoubleSphere(lens) => (DOUBLE_SPHERE, [lens.xi(), lens.alpha(), 0.0, 0.0]),
        // Refused by `Header::check`, and by the reader.
        Camera::Omni(_) => (0, [0.0; 4]),
    };
    let Intrinsics { fx, fy, cx, cy } = view.camera.intrinsics();
    let rotation = view.rotation.transpose();
    let floats = [fx, fy, cx, cy].into_iter().chain(coefficients);
    let floats = floats.chain(rotation.iter().copied()).chain(view.position.iter().copied());
    for (word, float) in rest.iter_mut().zip(floats) {
        *word = float.to_bits();
    }
    words
}

fn view(words: &[u32; VIEW_WORDS]) -> Result<Option<View>, ShotError> {
    let [size, lens, floats @ ..] = words;
    if *size == 0 {
        return Ok(None);
    }
    let [w0, w1, h0, h1] = size.to_le_bytes();
    let [width, height] = [[w0, w1], [h0, h1]].map(u16::from_le_bytes);
    let [fx, fy, cx, cy, k1, k2, k3, k4, place @ ..] = floats.map(f32::from_bits);
    let intrinsics = Intrinsics { fx, fy, cx, cy };
    let camera = match *lens {
        KANNALA_BRANDT => KannalaBrandt::new(intrinsics, [k1, k2, k3, k4]).map(Camera::KannalaBrandt),
        EUCM => Eucm::new(intrinsics, k1, k2).map(Camera::Eucm),
        EQUIDISTANT => Equidistant::new(intrinsics).map(Camera::Equidistant),
        DOUBLE_SPHERE => DoubleSphere::new(intrinsics, k1, k2).map(Camera::DoubleSphere),
        other => return Err(ShotError::Lens(other)),
    };
    let [a, b, c, d, e, f, g, h, i, x, y, z] = place;
    Ok(Some(View {
        rotation: Matrix3::new(a, b, c, d, e, f, g, h, i),
        position: Vector3::new(x, y, z),
        ..View::new(camera.map_err(ShotError::Camera)?, width, height)
    }))
}
