//! What a user should know although the work is done.

/// Writes a line to standard error.
pub(super) fn note(text: &str) {
    eprintln!("compass: note: {text}");
}
