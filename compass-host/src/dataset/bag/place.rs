//! Where in a file messages are, and what takes them.

use std::io::Read;

/// Where in a file a message is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    /// The `id` of its row.
    Row(i64),
    /// The byte where its record or chunk begins, and how many messages of the chunk come before it.
    Record { offset: u64, before: u32 },
}

/// What takes the messages of a file: the number of the topic, the place and the message, of which it need not read
/// all. Says what is wrong with one.
pub(super) type Take<'a> = dyn FnMut(usize, Place, &mut dyn Read) -> Result<(), String> + 'a;
