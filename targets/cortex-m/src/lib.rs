//! What the images for (emulated) Cortex-M boards share: printing, counting, stack use, exit status.
//!
//! # Report
//! One fact a line on standard output, through semihosting:
//!
//! | line | meaning |
//! |---|---|
//! | `check NAME 0xXXXXXXXX` | checksum of a stage's output; equal on every target |
//! | `insns NAME N` | instructions the stage executed, exact ([`counter`]) |
//! | `stack N` | bytes of stack used at most since reset ([`stack`]) |
//!
//! A panic or a hard fault prints its cause to standard error and ends the emulator with status 101.
#![no_std]

pub mod counter;
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
