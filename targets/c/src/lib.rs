//! COMPASS for C and C++: the functions of `include/compass.h`, which documents them, over `compass_core::locator`.
//!
//! | file | owns |
//! |---|---|
//! | `functions` | the exported functions: checks of pointers, nothing else |
//! | `compass` | the object: the locator in the caller's memory, and what was last seen with it |
//! | `failure` | why a call was refused: its code and its sentence |
//! | `types`, `settings`, `prior` | the structs of the header, and how they become what the core knows |
//! | `status` | the codes and their sentences |
//!
//! Numbers that come from C are checked before they become an enum or a `bool`. Pointers are read and written here alone,
//! and references to what lies behind them end with the call, except for the memory and the sites, which are lent as long
//! as the object is used.
#![cfg_attr(target_os = "none", no_std)]

mod compass;
mod failure;
mod functions;
mod prior;
mod settings;
mod status;
mod types;

pub use compass::{COMPASS_ALIGNMENT, COMPASS_MEMORY_368X360, Compass};
pub use functions::*;
pub use prior::{
    COMPASS_LEAST_CAMERA_HEIGHT_M, COMPASS_MOST_CAMERA_HEIGHT_M, CompassHeightKind, CompassHeights,
    CompassPrior, CompassUpKind,
};
pub use settings::{CompassEffort, CompassPreset, CompassSettings, CompassSmoothing};
pub use status::CompassStatus;
pub use types::*;

/// The core does not panic; that this library links without a way to is not shown yet.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
