//! The pose of two frames, from a building in flash.
#![no_std]
#![no_main]

use compass_core::{
    Bearing, Fix, Frame, GrayImage, HeightPrior, LocateError, Locator, Prior, Settings, Site, UpHint,
};
use compass_firmware::files::refuse;
use compass_firmware::sample::{FRAMES, HEIGHT, WIDTH, rig};
use cortex_m_rt::entry;
use semihosting::{println, process};

static BUILDING: &[u8] = include_bytes!("../../../tests/vectors/sample.site");
const WORDS: usize = Settings::BOARD.memory_words(WIDTH, HEIGHT);

fn locate(site: &Site<'static>, memory: &mut [u32]) -> Result<Fix<'static>, LocateError> {
    let rig = rig().unwrap_or_else(|error| refuse("rig", &error));
    let mut locator: Locator<'_, _> = Locator::new(site, rig, Settings::BOARD, memory)?;
    let frames =
        FRAMES.map(|pixels| GrayImage::new(pixels, WIDTH.into(), HEIGHT.into()).ok().map(Frame::from));
    // The rig hangs upside down, 1.6 m above the floor.
    let prior = Prior::new(UpHint::Up(Bearing::new(0.0, 1.0, 0.0)), HeightPrior::camera(1.6));
    locator.locate(&frames, &prior)
}

#[entry]
fn main() -> ! {
    static mut MEMORY: [u32; WORDS] = [0; WORDS];
    let site = Site::new(BUILDING).unwrap_or_else(|error| refuse("building", &error));
    let fix = locate(&site, MEMORY).unwrap_or_else(|error| refuse("frames", &error));
    let (Some(pose), Some(floor)) = (fix.pose(), fix.floor_name()) else { refuse("frames", &"no pose") };
    let degrees = pose.heading.to_microdegrees() / 1_000_000;
    println!("floor {floor}: x {:.2} m, y {:.2} m, heading {degrees} degrees", pose.at.x, pose.at.y);
    println!("camera {:.2} m above the floor, probability {:.2}", fix.camera_height_m(), fix.probability());
    process::exit(0)
}
