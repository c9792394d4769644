//! From packed frames to a pose, and along a row of them to a track: what a product's firmware does.
//!
//! Arguments: a site file, then files of `compass pack`, in the order in which they were taken. They are read through
//! semihosting into external memory and used there in place; a product has the site in flash (`include_bytes!`, or a
//! slice at the address it was flashed to), and lets its cameras write into RAM. All else is the statics below and the
//! stack.
//!
//! Exit status 0 if all poses are known, 1 if of one the answer is "I don't know", 2 for bad input.
#![no_std]
#![no_main]

use compass_board::Error;
use compass_core::pose::FloorLayer;
use compass_core::vision::shot::Shot;
use compass_core::map::site::{MAX_FLOORS, Site};
use compass_firmware::counter::Counter;
use compass_firmware::files::{self, refuse};
use compass_firmware::{image, stack};
use compass_golden::{Chain, Meter};
use core::iter;
use cortex_m_rt::entry;
use heapless::Vec;
use semihosting::{println, process};

/// Layers of all floors.
const MAX_SHEETS: usize = 2 * MAX_FLOORS;

/// Counts each step, and prints what it took.
struct Steps {
    counter: Counter,
    instructions: u64,
    /// Most of any step so far, that of its callers included.
    stack: usize,
}

impl Meter for Steps {
    fn step<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let ((value, instructions), stack) = stack::below(|| self.counter.count(work));
        println!("insns {name} {instructions}");
        println!("stack {name} {stack}");
        self.instructions += instructions;
        self.stack = self.stack.max(stack::depth() + stack);
        value
    }
}

#[entry]
fn main() -> ! {
    static mut CHAIN: Chain = Chain::new();
    static mut SHEETS: Vec<FloorLayer<'static>, MAX_SHEETS> = Vec::new();
    let arguments = files::arguments();
    let mut paths = (&arguments).skip(1).flatten();
    let mut next = || paths.next().unwrap_or_else(|| refuse("usage", &"-append \"SITE SHOT...\""));
    let (path, first) = (next(), next());
    // SAFETY: the only call.
    let (bytes, memory) = files::read(path, unsafe { files::external() });
    let site = Site::new(bytes).and_then(|site| site.verify().map(|()| site));
    let site = site.unwrap_or_else(|error| refuse(path, &error));
    SHEETS.extend(compass_board::layers(&site));
    let mut steps = Steps { counter: Counter::start(), instructions: 0, stack: 0 };
    let mut known = true;
    for path in iter::once(first).chain(paths) {
        let (bytes, _) = files::read(path, memory);
        let shot = Shot::new(bytes).and_then(|shot| shot.verify().map(|()| shot));
        let shot = shot.unwrap_or_else(|error| refuse(path, &error));
        println!("shot {path}");
        known &= localize(CHAIN, SHEETS, &shot, &mut steps).unwrap_or_else(|error| refuse(path, &error));
    }
    let image = image::sizes();
    println!("flash code {}", image.code);
    println!("flash constants {}", image.constants);
    println!("ram static {}", image.variables);
    println!("ram stack {}", steps.stack);
    println!("ram pose {}", image.variables + steps.stack);
    process::exit(i32::from(!known))
}

/// Whether the pose of what the cameras took is known.
fn localize(
    chain: &mut Chain,
    layers: &[FloorLayer<'_>],
    shot: &Shot<'_>,
    steps: &mut Steps,
) -> Result<bool, Error> {
    steps.instructions = 0;
    let found = match chain.run(layers, shot, steps) {
        Err(error @ Error::Up) => {
            println!("pose none: {error}");
            return Ok(false);
        }
        found => found?,
    };
    println!("insns pose {}", steps.instructions);
    println!("{found}");
    Ok(found.is_known())
}
