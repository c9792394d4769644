//! Shared by the images for (emulated) Cortex-M boards: printing, counting, stack use, exit status.
//!
//! # Report
//! One fact per line on standard output, through semihosting:
//!
//! | line | meaning |
//! |---|---|
//! | `check NAME 0xXXXXXXXX` | checksum of a stage's output; equal on every target |
//! | `insns NAME N` | instructions the stage executed, exact ([`counter`]) |
//! | `stack NAME N` | deepest stack while the stage ran, bytes, its callers from `main` on included ([`stack`]) |
//! | `flash PART N` | bytes of code, and of constants without the sample ([`image`]) |
//! | `ram PURPOSE N` | bytes of RAM |
//!
//! A panic or a hard fault prints its cause to standard error and ends the emulator with status 101.
#![no_std]

pub mod counter;
pub mod files;
pub mod image;
pub mod sample;
pub mod stack;

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::{eprintln, process};

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    eprintln!("{info}");
    process::exit(101)
}

// SAFETY: runs once, on the stack of the faulting code, and does not return to it.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    panic!("hard fault: {frame:?}")
}
