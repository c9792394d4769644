//! The pose of the rig over time: a belief that is carried from frame to frame.
#![no_std]
#![no_main]

use compass_core::{
    Bearing, Frame, GrayImage, HeightPrior, LocateError, Locator, Motion, Settings, Site, Track, UpHint,
};
use compass_firmware::files::refuse;
use compass_firmware::sample::{FRAMES, HEIGHT, WIDTH, rig};
use cortex_m_rt::entry;
use semihosting::{println, process};

static BUILDING: &[u8] = include_bytes!("../../../tests/vectors/sample.site");
const WORDS: usize = Settings::BOARD.memory_words(WIDTH, HEIGHT);
/// Seconds between frames, and the motion by odometry since the frame before: here, none.
const SECONDS: f32 = 0.5;
const MOTION: Motion = Motion { forward_m: 0.0, left_m: 0.0, turn: 0.0 };

fn follow(site: &Site<'static>, memory: &mut [u32], track: &mut Track) -> Result<(), LocateError> {
    let rig = rig().unwrap_or_else(|error| refuse("rig", &error));
    let mut locator: Locator<'_, _> = Locator::new(site, rig, Settings::BOARD, memory)?;
    for number in 0..3 {
        // The next frames: here, the same again.
        let frames =
            FRAMES.map(|pixels| GrayImage::new(pixels, WIDTH.into(), HEIGHT.into()).ok().map(Frame::from));
        let up = UpHint::Up(Bearing::new(0.0, 1.0, 0.0));
        let mut seen = locator.segment(&frames)?.level_near(up)?.see();
        let fix = seen.locate(HeightPrior::camera(1.6));
        let (seconds, motion) = if number == 0 { (0.0, None) } else { (SECONDS, Some(MOTION)) };
        let Some(now) = seen.track(track, &fix, seconds, motion) else { continue };
        let at = now.pose.at;
        println!(
            "x {:.2} m, y {:.2} m, probability {:.2}, spread {:.2} m",
            at.x, at.y, now.probability, now.spread_m
        );
    }
    Ok(())
}

#[entry]
fn main() -> ! {
    static mut MEMORY: [u32; WORDS] = [0; WORDS];
    static mut TRACK: Track = Track::new();
    let site = Site::new(BUILDING).unwrap_or_else(|error| refuse("building", &error));
    follow(&site, MEMORY, TRACK).unwrap_or_else(|error| refuse("frames", &error));
    process::exit(0)
}
