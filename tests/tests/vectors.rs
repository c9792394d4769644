//! The sample files that all targets compute on are what the current code makes of the sample building.
//!
//! `targets/golden` bakes `vectors/` into its images. `REGENERATE=1 cargo test -p compass-tests --test vectors`
//! rewrites the files.

use compass_core::num::{Point, Turn};
use compass_core::plan::{Frame, Plan, pack, packed_len};
use compass_core::raster::BitMask;
use compass_core::scan::Scan;
use compass_core::site_map::{Header, Layer, Sink, SiteMap, Writer};
use compass_host::interior::{self, InteriorOptions};
use compass_host::sample;
use std::convert::Infallible;
use std::path::Path;

const RESOLUTION_NM: u32 = 10_000_000;
const SPACING_MM: u32 = 1000;
const CLEARANCE_M: f64 = 0.2;
/// Both files lie in the repository.
const MOST_BYTES: usize = 400_000;

struct Bytes(Vec<u8>);

impl Sink for Bytes {
    type Error = Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Infallible> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

/// The packed plan of the sample building, and a site map of it.
fn sample() -> (Vec<u8>, Vec<u8>) {
    let building = sample::building();
    let mask = |bits| BitMask::new(bits, building.width, building.height).unwrap();
    let (walls, windows) = (mask(&building.walls), mask(&building.windows));
    let frame = Frame { resolution_nm: RESOLUTION_NM, origin: Point::default() };
    let mut plan_bytes = vec![0; packed_len(&walls, &windows).unwrap()];
    let plan = pack(&walls, &windows, frame, &mut plan_bytes).unwrap();

    let interior =
        interior::find(&walls, &windows, sample::RESOLUTION_M, &InteriorOptions::default()).unwrap();
    let spacing_m = f64::from(SPACING_MM) / 1000.0;
    let candidates = interior.candidates(&walls, &windows, spacing_m, CLEARANCE_M).unwrap();
    let map_bytes = site_map(&plan, &candidates);
    (plan_bytes, map_bytes)
}

fn site_map(plan: &Plan<'_>, candidates: &[[u16; 2]]) -> Vec<u8> {
    let header = Header {
        candidates: u32::try_from(candidates.len()).unwrap(),
        layers: 1,
        frame: plan.frame(),
        spacing_mm: SPACING_MM,
        plan_size: [plan.width(), plan.height()],
        // The packed plan's own checksum field.
        plan_checksum: u32::from_le_bytes(plan.as_bytes()[44..48].try_into().unwrap()),
    };
    let Ok(mut writer) = Writer::new(Bytes(Vec::new()), &header);
    let mut scan = Scan::OPEN;
    for &cell in candidates {
        plan.scan(plan.cell_centre(cell[0], cell[1]), Turn::ZERO, &mut scan).unwrap();
        let Ok(()) = writer.candidate(cell, &[Layer::new(&scan)]);
    }
    let Ok(Bytes(bytes)) = writer.finish();
    bytes
}

fn compare(name: &str, bytes: &[u8]) {
    assert!(bytes.len() < MOST_BYTES, "{name} has {} bytes", bytes.len());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors").join(name);
    if std::env::var_os("REGENERATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
    }
    println!("{name}: {} bytes", bytes.len());
    let committed = std::fs::read(&path).unwrap_or_default();
    // Not assert_eq: it would print both.
    let first = committed.iter().zip(bytes).position(|(a, b)| a != b);
    assert!(
        committed == bytes,
        "{name} ({} bytes) is not what the code makes ({} bytes), first at byte {first:?}: \
         if that is meant, REGENERATE=1 cargo test -p compass-tests --test vectors",
        committed.len(),
        bytes.len()
    );
}

#[test]
fn committed_samples_are_current() {
    let (plan, map) = sample();
    Plan::new(&plan).unwrap().verify().unwrap();
    let site_map = SiteMap::new(&map).unwrap();
    site_map.verify().unwrap();
    println!("{} candidates", site_map.len());
    compare("sample_plan.bin", &plan);
    compare("sample_map.bin", &map);
}
