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

/// Receives the messages of a file: the index of the topic, the place and the message, which it may read in part.
/// Returns an error message for an invalid one.
pub(super) type Take<'a> = dyn FnMut(usize, Place, &mut dyn Read) -> Result<(), String> + 'a;
