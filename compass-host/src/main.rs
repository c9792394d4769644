//! The `compass` command.
fn main() {}
