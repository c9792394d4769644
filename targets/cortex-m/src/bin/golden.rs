//! The golden checksums of `compass-core`, and the cost of each stage on the board.
#![no_std]
#![no_main]

use compass_firmware::counter::{self, Counter, Reading};
use compass_firmware::image;
use compass_firmware::stack;
use compass_golden::{Inputs, POSE_RAM, POSE_STAGES, RAM, Report, Workspace, input_bytes};
use cortex_m_rt::entry;
use semihosting::{println, process};

/// Measures each stage, and prints its cost.
struct Costs {
    counter: Counter,
    start: Option<Reading>,
    instructions: u64,
    stack: usize,
    /// Deepest stack of the stages from frames to a pose.
    deepest: usize,
}

impl Report for Costs {
    fn begin(&mut self, _: &'static str) {
        stack::paint();
        self.start = Some(counter::now());
    }

    fn end(&mut self, name: &'static str) {
        let Some(start) = self.start else { return };
        self.instructions = self.counter.since(start);
        self.stack = stack::high_water_mark();
        if POSE_STAGES.contains(&name) {
            self.deepest = self.deepest.max(self.stack);
        }
    }

    fn check(&mut self, name: &'static str, checksum: u32) {
        println!("check {name} {checksum:#010x}");
        println!("insns {name} {}", self.instructions);
        println!("stack {name} {}", self.stack);
    }
}

#[entry]
fn main() -> ! {
    // Static and never moved over the stack, whose use is to be that of the stages.
    static mut WORKSPACE: Workspace = Workspace::new();
    let mut costs = Costs { counter: Counter::start(), start: None, instructions: 0, stack: 0, deepest: 0 };
    compass_golden::run(&Inputs::SAMPLE, WORKSPACE, &mut costs);
    let image = image::sizes();
    println!("flash code {}", image.code);
    println!("flash constants {}", image.constants - input_bytes());
    for (purpose, bytes) in RAM {
        println!("ram {purpose} {bytes}");
    }
    println!("ram static {}", image.variables);
    println!("ram pose {}", POSE_RAM + costs.deepest);
    process::exit(0)
}
