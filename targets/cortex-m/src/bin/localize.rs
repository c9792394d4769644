//! From packed frames to a pose, and over several of them to a track, as in a product's firmware.
//!
//! Arguments: a site file, then files of `compass pack`, in order of time. They are read through semihosting into
//! external memory and used there in place; a product has the site in flash (`include_bytes!`, or a slice at the
//! address it was flashed to), and its cameras write into RAM. All other memory is the statics below and the stack.
//!
//! Exit status 0 if all poses are known, 1 if any answer is "I don't know", 2 for bad input.
#![no_std]
#![no_main]

use compass_core::locator::{Error, Picture, Stage, Trace};
use compass_core::map::site::Site;
use compass_core::vision::shot::Shot;
use compass_firmware::counter::{self, Counter, Reading};
use compass_firmware::files::{self, refuse};
use compass_firmware::image;
use compass_firmware::stack;
use compass_golden::Shots;
use core::iter;
use cortex_m_rt::entry;
use semihosting::{println, process};

/// Measures each stage, and prints its cost.
struct Costs {
    counter: Counter,
    start: Option<Reading>,
    instructions: u64,
    /// Maximum over the stages so far.
    stack: usize,
}

impl Trace for Costs {
    fn begin(&mut self, _: Stage) {
        stack::paint();
        self.start = Some(counter::now());
    }

    fn end(&mut self, stage: Stage, _: Picture<'_>) {
        let Some(start) = self.start else { return };
        let (instructions, name) = (self.counter.since(start), stage.name());
        let stack = stack::high_water_mark();
        println!("insns {name} {instructions}");
        println!("stack {name} {stack}");
        self.instructions += instructions;
        self.stack = self.stack.max(stack);
    }
}

#[entry]
fn main() -> ! {
    static mut SHOTS: Shots = Shots::new();
    let arguments = files::arguments();
    let mut paths = (&arguments).skip(1).flatten();
    let mut next = || paths.next().unwrap_or_else(|| refuse("usage", &"-append \"SITE SHOT...\""));
    let (path, first) = (next(), next());
    // SAFETY: it is called once.
    let (bytes, memory) = files::read(path, unsafe { files::external() });
    let site = Site::new(bytes).and_then(|site| site.verify().map(|()| site));
    let site = site.unwrap_or_else(|error| refuse(path, &error));
    let mut costs = Costs { counter: Counter::start(), start: None, instructions: 0, stack: 0 };
    let mut known = true;
    for path in iter::once(first).chain(paths) {
        let (bytes, _) = files::read(path, memory);
        let shot = Shot::new(bytes).and_then(|shot| shot.verify().map(|()| shot));
        let shot = shot.unwrap_or_else(|error| refuse(path, &error));
        println!("shot {path}");
        known &= localize(SHOTS, &site, &shot, &mut costs).unwrap_or_else(|error| refuse(path, &error));
    }
    let image = image::sizes();
    println!("flash code {}", image.code);
    println!("flash constants {}", image.constants);
    println!("ram static {}", image.variables);
    println!("ram stack {}", costs.stack);
    println!("ram pose {}", image.variables + costs.stack);
    process::exit(i32::from(!known))
}

/// Whether the pose of a pair of frames is known.
fn localize(shots: &mut Shots, site: &Site<'_>, shot: &Shot<'_>, costs: &mut Costs) -> Result<bool, Error> {
    costs.instructions = 0;
    let located = match shots.locate(site, shot, costs) {
        Err(error @ Error::Up) => {
            println!("pose none: {error}");
            return Ok(false);
        }
        located => located?,
    };
    println!("insns pose {}", costs.instructions);
    println!("{located}");
    Ok(located.is_known())
}
