//! Prints the golden checksums, one `check NAME 0xXXXXXXXX` line per stage.
//!
//! Run on the host this gives the lines that every other target must repeat.

use compass_golden::{Inputs, Workspace};
use std::sync::Mutex;

fn main() {
    static WORKSPACE: Mutex<Workspace> = Mutex::new(Workspace::new());
    let mut workspace = WORKSPACE.lock().expect("nobody else holds it");
    compass_golden::run(&Inputs::SAMPLE, &mut workspace, &mut |name, checksum| {
        println!("check {name} {checksum:#010x}");
    });
}
