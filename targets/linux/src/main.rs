//! Prints the golden checksums, one `check NAME 0xXXXXXXXX` line per stage.
//!
//! On the host it prints the lines that every other target must reproduce.

use compass_golden::{Inputs, Report, Workspace};
use std::sync::Mutex;

struct Lines;

impl Report for Lines {
    fn check(&mut self, name: &'static str, checksum: u32) {
        println!("check {name} {checksum:#010x}");
    }
}

fn main() {
    static WORKSPACE: Mutex<Workspace> = Mutex::new(Workspace::new());
    let mut workspace = WORKSPACE.lock().expect("nobody else holds it");
    compass_golden::run(&Inputs::SAMPLE, &mut workspace, &mut Lines);
}
