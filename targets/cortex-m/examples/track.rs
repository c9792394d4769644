//! Where one is by now: a belief that is carried from frame to frame.
#![no_std]
#![no_main]

use compass_board::{Error, Locator, words};
use compass_core::base::ladder::height_rungs;
use compass_core::pose::locate::{Effort, HeightPrior};
use compass_core::pose::track::{Motion, Track};
use compass_core::vision::panorama::Resolution;
use compass_firmware::files::refuse;
use compass_golden::{Inputs, UP, frames, rig};
use cortex_m_rt::entry;
use semihosting::{println, process};

type Eyes = Locator<[u32; words(368, 360, Resolution::COARSE)]>;

/// Seconds between frames, and how far wheels or legs have come since the frame before: here, nowhere.
const SECONDS: f32 = 0.5;
const MOTION: Motion = Motion { forward_m: 0.0, left_m: 0.0, turn: 0.0 };

fn follow(eyes: &mut Eyes, track: &mut Track) -> Result<(), Error> {
    let layers = [Inputs::SAMPLE.layer()];
    let room = HeightPrior { height: Some(height_rungs(1.6)), ceiling: None };
    for number in 0..3 {
        // The next frames: here, the same again.
        eyes.see(&rig(), &frames(), UP)?;
        let fix = eyes.locate(&layers, room, Effort::on_board(&room))?;
        let since = if number == 0 { (0.0, None) } else { (SECONDS, Some(MOTION)) };
        let Some(now) = eyes.track(track, &layers, &fix, since.0, since.1)? else { continue };
        let at = now.mode.at;
        println!(
            "x {:.2} m, y {:.2} m, probability {:.2}, spread {:.2} m",
            at.x, at.y, now.probability, now.spread_m
        );
    }
    Ok(())
}

#[entry]
fn main() -> ! {
    static mut EYES: Eyes = Locator::new([0; words(368, 360, Resolution::COARSE)]);
    static mut TRACK: Track = Track::new();
    follow(EYES, TRACK).unwrap_or_else(|error| refuse("frames", &error));
    process::exit(0)
}
