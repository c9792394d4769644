//! The golden checksums of `compass-core`, and what each stage costs on the board.
#![no_std]
#![no_main]

use compass_firmware::{counter::Counter, stack};
use compass_golden::{Inputs, STAGES, Workspace};
use core::hint::black_box;
use cortex_m_rt::entry;
use semihosting::{println, process};

#[entry]
fn main() -> ! {
    // Static: the high-water mark of the stack is to be that of the stages.
    let workspace = cortex_m::singleton!(: Workspace = Workspace::new()).expect("taken once");
    let counter = Counter::start();
    for stage in STAGES {
        let run = black_box(stage.run);
        let ((), instructions) = counter.count(|| run(&Inputs::SAMPLE, workspace));
        println!("check {} {:#010x}", stage.name, (stage.checksum)(workspace));
        println!("insns {} {instructions}", stage.name);
    }
    println!("stack {}", stack::high_water_mark());
    process::exit(0)
}
