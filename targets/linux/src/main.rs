//! Prints the golden checksums, one `check NAME 0xXXXXXXXX` line per stage.
//!
//! Run on the host this gives the lines that every other target must repeat.

use compass_golden::{Inputs, Workspace};

fn main() {
    let mut workspace = Box::new(Workspace::new());
    compass_golden::run(&Inputs::SAMPLE, &mut workspace, &mut |name, checksum| {
        println!("check {name} {checksum:#010x}");
    });
}
