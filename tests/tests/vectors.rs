//! The sample files used by all targets match what the current code makes of the sample building.
//!
//! `targets/golden` embeds `vectors/` in its images. `REGENERATE=1 cargo test -p compass-tests --test vectors`
//! rewrites the files.

use compass_core::base::raster::{BitMask, is_red};
use compass_core::map::plan::Plan;
use compass_core::map::site::{Floor, Site, Writer};
use compass_core::map::site_map::SiteMap;
use compass_host::calibration::Calibration;
use compass_host::dataset::tum::Pose;
use compass_host::frame::Frame;
use compass_host::output::Bytes;
use compass_host::sample::FRAME_POSE;
use compass_host::simulate::{Scene, SceneOptions, render};
use compass_host::site::{BuildOptions, build};
use compass_tests::sample_plan;
use std::path::Path;

const SPACING_M: f64 = 1.0;
const CLEARANCE_M: f64 = 0.2;
/// The folder of the files in the repository.
const MOST_BYTES: usize = 640_000;

/// The packed plan of the sample building, and a site map of it.
fn sample() -> (Vec<u8>, Vec<u8>) {
    let (raster, plan) = sample_plan();
    let options = BuildOptions { spacing_m: SPACING_M, clearance_m: CLEARANCE_M, ..BuildOptions::default() };
    let map = build(raster, plan, None, &options).unwrap();
    (plan.as_bytes().to_vec(), map)
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
    // Not `assert_eq`, which would print both.
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
    let floor = Floor::new("ground", SiteMap::new(&map).unwrap(), Plan::new(&plan).unwrap(), None).unwrap();
    println!("{} candidates", floor.map().len());
    let Ok(Bytes(site)) = Writer::new(&[floor]).unwrap().write(Bytes(Vec::new()));
    Site::new(&site).unwrap().verify().unwrap();
    compare("sample.site", &site);
}

/// Width and height of the sample frames.
const FRAME: (u32, u32) = (368, 360);

/// The pose of the sample frames: 1.6 m above the floor, hanging upside down and tilted.
fn frame_pose() -> Pose {
    let ([x, y], heading) = FRAME_POSE;
    Pose::looking(0, [x, y, 1.6], heading, 4.0, 187.0)
}

#[test]
fn committed_frames_are_current() {
    let (raster, _) = sample_plan();
    let rig = Calibration::nominal().rig([Some(FRAME); 2]).unwrap();
    let scene = Scene::new(&SceneOptions::default(), raster);
    for (camera, image) in render(&scene, &rig, &frame_pose()).into_iter().enumerate() {
        let frame = Frame::from_rgb(image.unwrap()).unwrap();
        let name = format!("frame_{}x{}_cam{camera}", FRAME.0, FRAME.1);
        compare(&format!("{name}.gray"), frame.gray().pixels());
        compare(&format!("{name}.red"), &red_mask(&frame));
    }
}

/// The red pixels of a frame, in the layout of `BitMask`: what the stages of the golden vectors exclude.
fn red_mask(frame: &Frame) -> Vec<u8> {
    let row_bytes = BitMask::row_bytes(frame.width());
    let mut mask = vec![0; row_bytes * frame.height() as usize];
    for (at, pixel) in frame.rgb().iter().flat_map(|rgb| rgb.as_chunks::<3>().0).enumerate() {
        let (x, y) = (at % frame.width() as usize, at / frame.width() as usize);
        mask[y * row_bytes + x / 8] |= u8::from(is_red(*pixel)) << (x % 8);
    }
    mask
}
