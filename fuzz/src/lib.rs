//! What the fuzz targets share: a small building, edits of valid files, and files in memory.

use compass_core::base::crc::Sink;
use compass_core::vision::camera::{Camera, Equidistant, View};
use compass_core::vision::shot;
use compass_core::{Bearing, BitMask, GrayImage, Intrinsics, Rig};
use std::path::PathBuf;
use std::sync::OnceLock;

/// Pixels of a frame.
pub const SIZE: [u16; 2] = [48, 40];

/// The site file of the sample building.
pub fn site() -> &'static [u8] {
    include_bytes!("../../tests/vectors/sample.site")
}

/// Bytes in memory.
#[derive(Debug, Default)]
struct Bytes(Vec<u8>);

impl Sink for Bytes {
    type Error = std::convert::Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

/// A rig of two lenses back to back.
pub fn rig() -> Rig {
    let [width, height] = SIZE;
    let [cx, cy] = SIZE.map(|side| f32::from(side) / 2.0 - 0.5);
    let intrinsics = Intrinsics { fx: 14.0, fy: 14.0, cx, cy };
    let camera = Camera::Equidistant(Equidistant::new(intrinsics).expect("a lens"));
    let front = View::new(camera, width, height);
    let mut back = front;
    // Half a turn about y.
    (back.rotation[(0, 0)], back.rotation[(2, 2)]) = (-1.0, -1.0);
    Rig::new([Some(front), Some(back)]).expect("a rig")
}

/// Packed frames of that rig.
pub fn shot() -> Vec<u8> {
    let [width, height] = SIZE.map(u32::from);
    let gray: Vec<u8> =
        (0..width * height).map(|at| if at / width < height / 2 { 40 } else { 200 }).collect();
    let mask = vec![0; BitMask::row_bytes(width) * height as usize];
    let image = || {
        let gray = GrayImage::new(&gray, width, height).expect("a frame");
        (gray, BitMask::new(&mask, width, height).expect("a mask"))
    };
    let header = shot::Header { time_ns: 1, rig: rig(), up: Bearing::y(), height_m: Some(1.5) };
    let writer = shot::Writer::new(&header, [Some(image()), Some(image())]).expect("a shot");
    let Ok(Bytes(bytes)) = writer.write(Bytes::default());
    bytes
}

/// A valid file with bytes overwritten, and cut off or not: of each six bytes four are the place, two what is written.
pub fn edited(valid: &[u8], edits: &[u8]) -> Vec<u8> {
    let mut bytes = valid.to_vec();
    let (edits, rest) = edits.as_chunks::<6>();
    for [a, b, c, d, low, high] in edits {
        let at = u32::from_le_bytes([*a, *b, *c, *d]) as usize % bytes.len().max(1);
        for (byte, value) in bytes.iter_mut().skip(at).zip([low, high]) {
            *byte = *value;
        }
    }
    if let [a, b, c, ..] = rest {
        bytes.truncate(u32::from_le_bytes([*a, *b, *c, 0]) as usize);
    }
    bytes
}

const CRC32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Makes the checksums of headers right, which a reader checks first: those of a site, of its maps, and of a shot.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    match bytes.first_chunk::<8>() {
        Some(b"CMPSSITE") => {
            let floors = bytes.get(10).copied().unwrap_or_default().into();
            for floor in 0..floors {
                let at = 16 + 48 * floor + 24;
                let map =
                    bytes.get(at..at + 4).and_then(<[u8]>::first_chunk).map(|at| u32::from_le_bytes(*at));
                if let Some(header) =
                    map.and_then(|map| bytes.get_mut(map as usize..)).and_then(|map| map.get_mut(..56))
                {
                    seal(header);
                }
            }
            if let Some((header, entries)) = bytes.split_at_mut_checked(16)
                && let Some(entries) = entries.get(..48 * floors)
            {
                let mut digest = CRC32.digest();
                digest.update(&header[..12]);
                digest.update(entries);
                header[12..].copy_from_slice(&digest.finalize().to_le_bytes());
            }
        }
        Some(b"CMPSSHOT") => {
            if let Some(header) = bytes.get_mut(..216) {
                seal(header);
            }
        }
        _ => {
            if let Some(header) = bytes.get_mut(..56) {
                seal(header);
            }
        }
    }
    bytes
}

/// Writes the checksum of a header into its last four bytes.
fn seal(header: &mut [u8]) {
    if let Some((body, crc)) = header.split_last_chunk_mut() {
        *crc = CRC32.checksum(body).to_le_bytes();
    }
}

/// A file in memory with these bytes; one of a name at a time. `COMPASS_FUZZ_FOLDER` names the folder.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        if let Some(folder) = std::env::var_os("COMPASS_FUZZ_FOLDER") {
            return folder.into();
        }
        let shared = PathBuf::from("/dev/shm");
        let parent = if shared.is_dir() { shared } else { std::env::temp_dir() };
        let folder = parent.join(format!("compass-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    });
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("a file");
    path
}
