//! Where two frames were taken, from a site map and a plan in flash.
#![no_std]
#![no_main]

use compass_board::{Error, Locator, words};
use compass_core::base::ladder::height_rungs;
use compass_core::pose::locate::{Effort, Fix, HeightPrior};
use compass_core::vision::panorama::Resolution;
use compass_firmware::files::refuse;
use compass_golden::{Inputs, UP, frames, rig};
use cortex_m_rt::entry;
use semihosting::{println, process};

type Eyes = Locator<[u32; words(368, 360, Resolution::COARSE)]>;

fn locate(eyes: &mut Eyes) -> Result<Fix, Error> {
    // A product's frames come from its cameras, its lenses from a calibration, its layers from a site file:
    // `compass_board::layers`.
    eyes.see(&rig(), &frames(), UP)?;
    let room = HeightPrior { height: Some(height_rungs(1.6)), ceiling: None };
    eyes.locate(&[Inputs::SAMPLE.layer()], room, Effort::on_board(&room))
}

#[entry]
fn main() -> ! {
    static mut EYES: Eyes = Locator::new([0; words(368, 360, Resolution::COARSE)]);
    let fix = locate(EYES).unwrap_or_else(|error| refuse("frames", &error));
    let Some(best) = fix.answer.best() else { refuse("frames", &"no pose") };
    let degrees = best.heading.to_microdegrees() / 1_000_000;
    println!("x {:.2} m, y {:.2} m, heading {degrees} degrees", best.at.x, best.at.y);
    println!("camera {:.2} m above the floor, probability {:.2}", fix.height_m(), fix.probability());
    process::exit(0)
}
