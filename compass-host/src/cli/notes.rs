//! Lines on standard error.

use compass_host::output::printable;
use std::io::Write as _;

/// Says what a user should know although the work is done.
pub(super) fn note(text: &str) {
    line(&format!("note: {text}"));
}

/// Writes a line to standard error; that nobody can read it there is no error.
pub(super) fn line(text: &str) {
    let _ = writeln!(std::io::stderr(), "compass: {}", printable(text));
}
