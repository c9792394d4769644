//! Locations of messages in a file, and the type of their receiver.

use std::io::Read;

/// The location of a message in a file.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    /// The `id` of its row.
    Row(i64),
    /// The byte at which its record or chunk begins, and the number of messages in the chunk before it.
    Record { offset: u64, before: u32 },
}

/// A message in a file.
pub(super) struct Found<'a> {
    /// Index of the topic.
    pub(super) topic: usize,
    pub(super) place: Place,
    /// When it was recorded, nanoseconds.
    pub(super) recorded_ns: u64,
    /// Its bytes, which may be read in part.
    pub(super) bytes: &'a mut dyn Read,
}

/// Receives the messages of a file.
pub(super) type Take<'a> = dyn FnMut(Found<'_>) + 'a;
