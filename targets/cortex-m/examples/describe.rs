//! The surroundings of a place, from a building in flash: 360 rays, and their descriptor.
#![no_std]
#![no_main]

use compass_core::{Descriptor, Hit, Metres, Point, Scan, Site, Turn};
use compass_firmware::files::refuse;
use cortex_m_rt::entry;
use semihosting::{println, process};

static BUILDING: &[u8] = include_bytes!("../../../tests/vectors/sample.site");

/// The position, and the direction of bin 0.
const AT: Point = Point::new(Metres::lit("13.37"), Metres::lit("3.68"));
const HEADING: Turn = Turn::from_ratio(74, 360);

#[entry]
fn main() -> ! {
    static mut SCAN: Scan = Scan::OPEN;
    static mut DESCRIPTOR: Descriptor = Descriptor::ZERO;
    let site = Site::new(BUILDING).unwrap_or_else(|error| refuse("building", &error));
    let Some(plan) = site.floor(0).and_then(|floor| floor.plan(0)) else { refuse("building", &"no plan") };
    plan.scan(AT, HEADING, SCAN).unwrap_or_else(|error| refuse("place", &error));
    DESCRIPTOR.fill(SCAN);
    println!("window bins {} of 360", SCAN.count(Hit::Window));
    for bin in (0..360).step_by(90) {
        let channels = DESCRIPTOR.levels.each_ref().map(|channel| channel[bin]);
        println!("bin {bin}: {channels:.3?}");
    }
    process::exit(0)
}
