//! The golden checksums of `compass-core`, and what each stage costs on the board.
#![no_std]
#![no_main]

use compass_firmware::{counter::Counter, stack};
use compass_golden::{Eyes, Inputs, STAGES, Workspace};
use core::hint::black_box;
use cortex_m_rt::entry;
use semihosting::{println, process};

#[entry]
fn main() -> ! {
    // Static, and never on its way there on the stack: the high-water mark is to be that of the stages.
    static mut WORKSPACE: Workspace = Workspace::new();
    let counter = Counter::start();
    for stage in STAGES {
        let run = black_box(stage.run);
        let ((), instructions) = counter.count(|| run(&Inputs::SAMPLE, WORKSPACE));
        println!("check {} {:#010x}", stage.name, (stage.checksum)(WORKSPACE));
        println!("insns {} {instructions}", stage.name);
    }
    println!("ram eyes {}", size_of::<Eyes>());
    println!("stack {}", stack::high_water_mark());
    process::exit(0)
}
