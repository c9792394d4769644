//! Files of the machine that the emulator or the debugger runs on, read through semihosting into memory beside the
//! image's own.
//!
//! They stand in for a product's flash, or for its cameras.

use core::ffi::CStr;
use core::fmt::Display;
use core::slice;
use semihosting::experimental::env::{self, Args};
use semihosting::fs::File;
use semihosting::io::Read;
use semihosting::{eprintln, process};

/// Bytes of the command line.
const LINE_BYTES: usize = 1024;

/// Ends the program with exit status 2, for bad input.
pub fn refuse(what: &str, why: &dyn Display) -> ! {
    eprintln!("{what}: {why}");
    process::exit(2)
}

/// The words of the command line; the first is the image's own name.
pub fn arguments() -> Args<LINE_BYTES> {
    env::args().unwrap_or_else(|error| refuse("the command line cannot be read", &Debugged(error)))
}

/// Reads a file to the front of `memory`; returns it and the rest. A relative path starts at the working directory.
///
/// Not inlined, so that its buffer for the name is not on the caller's stack.
#[inline(never)]
pub fn read<'a>(path: &str, memory: &'a mut [u8]) -> (&'a [u8], &'a mut [u8]) {
    let mut name = [0; LINE_BYTES];
    if let Some(name) = name.get_mut(..path.len()) {
        name.copy_from_slice(path.as_bytes());
    }
    let Ok(name) = CStr::from_bytes_until_nul(&name) else { refuse(path, &"the path is too long") };
    let mut file = File::open(name).unwrap_or_else(|error| refuse(path, &Debugged(error)));
    let length = file.metadata().unwrap_or_else(|error| refuse(path, &Debugged(error))).len();
    let most = memory.len();
    let split = usize::try_from(length).ok().and_then(|length| memory.split_at_mut_checked(length));
    let Some((bytes, rest)) = split else {
        refuse(path, &format_args!("{length} bytes do not fit the {most} that are left"))
    };
    file.read_exact(bytes).unwrap_or_else(|error| refuse(path, &Debugged(error)));
    (bytes, rest)
}

/// Displays a value that only implements `Debug`.
struct Debugged<T>(T);

impl<T: core::fmt::Debug> Display for Debugged<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

unsafe extern "C" {
    static mut _external_start: u8;
    static mut _external_end: u8;
}

/// The board's external memory, which holds no section: for files.
///
/// # Safety
/// May be called once.
#[must_use]
pub unsafe fn external() -> &'static mut [u8] {
    let (start, end) = (&raw mut _external_start, &raw const _external_end);
    // SAFETY: the memory map reserves these bytes, any value is a byte, and by contract there is no other reference.
    unsafe { slice::from_raw_parts_mut(start, end as usize - start as usize) }
}
