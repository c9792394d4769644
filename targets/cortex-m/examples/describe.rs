//! What surrounds a place, from a plan in flash: 360 rays, and their descriptor.
#![no_std]
#![no_main]

use compass_core::descriptor::Descriptor;
use compass_core::base::num::{Metres, Point, Turn};
use compass_core::map::plan::Plan;
use compass_core::base::scan::{Hit, Scan};
use compass_firmware::files::refuse;
use cortex_m_rt::entry;
use semihosting::{println, process};

/// A packed plan, as a site file holds one for each layer of a floor.
static PLAN: &[u8] = include_bytes!("../../../tests/vectors/sample_plan.bin");

/// Where it is that one stands, and the direction of bin 0.
const AT: Point = Point::new(Metres::lit("13.37"), Metres::lit("3.68"));
const HEADING: Turn = Turn::from_ratio(74, 360);

#[entry]
fn main() -> ! {
    static mut SCAN: Scan = Scan::OPEN;
    static mut DESCRIPTOR: Descriptor = Descriptor::ZERO;
    let plan = Plan::new(PLAN).unwrap_or_else(|error| refuse("plan", &error));
    plan.scan(AT, HEADING, SCAN).unwrap_or_else(|error| refuse("place", &error));
    DESCRIPTOR.fill(SCAN);
    println!("window bins {} of 360", SCAN.count(Hit::Window));
    for bin in (0..360).step_by(90) {
        let channels = DESCRIPTOR.levels.each_ref().map(|channel| channel[bin]);
        println!("bin {bin}: {channels:.3?}");
    }
    process::exit(0)
}
