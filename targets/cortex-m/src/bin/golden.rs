//! The golden checksums of `compass-core`, and what each stage costs on the board.
#![no_std]
#![no_main]

use compass_firmware::{counter::Counter, image, stack};
use compass_golden::{Inputs, POSE, POSE_RAM, RAM, STAGES, Workspace, input_bytes};
use core::hint::black_box;
use cortex_m_rt::entry;
use semihosting::{println, process};

#[entry]
fn main() -> ! {
    // Static, and never on its way there on the stack, which is to be that of the stages.
    static mut WORKSPACE: Workspace = Workspace::new();
    let counter = Counter::start();
    let mut deepest = 0;
    for stage in STAGES {
        let run = black_box(stage.run);
        let (((), instructions), stack) = stack::below(|| counter.count(|| run(&Inputs::SAMPLE, WORKSPACE)));
        if POSE.contains(&stage.name) {
            deepest = deepest.max(stack);
        }
        println!("check {} {:#010x}", stage.name, (stage.checksum)(WORKSPACE));
        println!("insns {} {instructions}", stage.name);
        println!("stack {} {stack}", stage.name);
    }
    let image = image::sizes();
    println!("flash code {}", image.code);
    println!("flash constants {}", image.constants - input_bytes());
    for (purpose, bytes) in RAM {
        println!("ram {purpose} {bytes}");
    }
    println!("ram static {}", image.variables);
    println!("ram pose {}", POSE_RAM + deepest);
    process::exit(0)
}
