//! COMPASS for C and C++: the functions of `include/compass.h`, which documents them, on top of `compass-board`.
//!
//! Pointers become references here and nowhere else. What the caller of a function owes is said once, in the header's
//! words: pointers that are not null point to as much as their type or the length beside them says, and one
//! thread at a time uses a [`Compass`].
#![cfg_attr(target_os = "none", no_std)]

mod compass;
mod types;

pub use compass::Compass;
pub use types::{
    COMPASS_BINS, COMPASS_MAX_LAYERS, COMPASS_MAX_POSES, COMPASS_STEP_MM, CompassCamera, CompassEstimate,
    CompassFix, CompassFrame, CompassMotion, CompassPose, CompassRoom, CompassScan, CompassStatus,
};

/// The core does not panic; that this library links without a way to is not shown yet.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
