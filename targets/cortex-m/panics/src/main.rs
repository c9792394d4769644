//! An image of `compass-core` that links only if nothing in it can panic.
//!
//! It refers to every public entry point that computes, for arguments of any value, with the profile of the firmware,
//! and its panic handler calls a function that does not exist. It is never run.
//!
//! With the feature `locate` it links nevertheless; the source files named in the image are then those with a
//! remaining panic. With `plant` there is one.
#![no_std]
#![no_main]

mod entries;

use core::hint::black_box;
use core::panic::PanicInfo;

/// The entry point for the linker.
#[unsafe(no_mangle)]
extern "C" fn _start() {
    black_box(&entries::ALL);
    #[cfg(feature = "plant")]
    black_box(planted as fn(Option<u32>) -> u32);
}

#[cfg(feature = "plant")]
fn planted(value: Option<u32>) -> u32 {
    value.unwrap()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    #[cfg(feature = "locate")]
    black_box(info.location());
    #[cfg(not(feature = "locate"))]
    {
        let _ = info;
        unsafe extern "C" {
            safe fn compass_core_can_panic() -> !;
        }
        compass_core_can_panic()
    }
    #[cfg(feature = "locate")]
    loop {}
}
