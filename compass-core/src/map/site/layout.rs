//! The layout of a site file, shared by reader and writer.

use crate::base::crc::CRC32;

/// Length of the header.
pub(super) const HEADER_BYTES: usize = 16;
/// Length of the part of the header that its checksum covers, together with the entries.
pub(super) const SUMMED_BYTES: usize = HEADER_BYTES - 4;
/// Length of the name field of an entry.
pub(super) const NAME_BYTES: usize = 1 + super::MAX_NAME_BYTES;
/// Number of parts of a floor: a map and up to two plans.
pub(super) const PARTS: usize = 3;
/// Length of an entry.
pub(super) const ENTRY_BYTES: usize = NAME_BYTES + 8 * PARTS;
/// Length of the checksum at the end.
const TRAILER_BYTES: usize = 4;
/// Alignment of the parts.
const ALIGNMENT: u32 = 8;

/// The bytes of the entry of a floor.
pub(super) type Entry = [u8; ENTRY_BYTES];

/// The checksum of the first bytes of the header and of the entries.
pub(super) fn header_checksum(header: &[u8], entries: &[Entry]) -> u32 {
    let mut digest = CRC32.digest();
    digest.update(header);
    digest.update(entries.as_flattened());
    digest.finalize()
}

/// Assigns consecutive offsets to the parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cursor {
    end: u32,
}

impl Cursor {
    /// A cursor behind the entries of a number of floors, at most 32.
    #[expect(clippy::cast_possible_truncation, reason = "at most 32 floors")]
    pub(super) const fn new(floors: usize) -> Self {
        Self { end: (HEADER_BYTES + ENTRY_BYTES * floors) as u32 }
    }

    /// The offset of a part of `len` bytes; `None` above the range of the format.
    pub(super) fn place(&mut self, len: u32) -> Option<u32> {
        let offset = self.aligned()?;
        self.end = offset.checked_add(len)?;
        Some(offset)
    }

    /// Length of a site that ends here; `None` above the range of the format or of `usize`.
    pub(super) fn site_bytes(self) -> Option<usize> {
        usize::try_from(self.aligned()?).ok()?.checked_add(TRAILER_BYTES)
    }

    /// Offset of the next part, or of the checksum at the end.
    const fn aligned(self) -> Option<u32> {
        self.end.checked_next_multiple_of(ALIGNMENT)
    }

    /// The padding behind a part of `len` bytes.
    pub(super) fn padding(len: usize) -> &'static [u8] {
        const ZEROS: [u8; ALIGNMENT as usize] = [0; ALIGNMENT as usize];
        let over = len % ZEROS.len();
        ZEROS.get(over..).filter(|_| over > 0).unwrap_or_default()
    }
}
