//! Where things lie in a site, for reader and writer alike.

use crate::base::crc::CRC32;

/// Bytes before the entries.
pub(super) const HEADER_BYTES: usize = 16;
/// Bytes of the header that its checksum covers, beside the entries.
pub(super) const SUMMED_BYTES: usize = HEADER_BYTES - 4;
pub(super) const NAME_BYTES: usize = 1 + super::MAX_NAME_BYTES;
/// Parts of a floor: its map and up to two plans.
pub(super) const PARTS: usize = 3;
pub(super) const ENTRY_BYTES: usize = NAME_BYTES + 8 * PARTS;
const TRAILER_BYTES: usize = 4;
const ALIGNMENT: u32 = 8;

/// The entry of a floor.
pub(super) type Entry = [u8; ENTRY_BYTES];

/// The checksum of the header's first bytes and the entries.
pub(super) fn header_checksum(header: &[u8], entries: &[Entry]) -> u32 {
    let mut digest = CRC32.digest();
    digest.update(header);
    digest.update(entries.as_flattened());
    digest.finalize()
}

/// Lays parts out one behind the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cursor {
    end: u32,
}

impl Cursor {
    /// Begins behind the entries of so many floors, at most 32.
    pub(super) const fn new(floors: usize) -> Self {
        Self { end: (HEADER_BYTES + ENTRY_BYTES * floors) as u32 }
    }

    /// The offset of a part of so many bytes; `None` when the format cannot count that far.
    pub(super) fn place(&mut self, len: u32) -> Option<u32> {
        let offset = self.aligned()?;
        self.end = offset.checked_add(len)?;
        Some(offset)
    }

    /// Bytes of a site that ends here; `None` when it is more than format or machine can count.
    pub(super) fn site_bytes(self) -> Option<usize> {
        usize::try_from(self.aligned()?).ok()?.checked_add(TRAILER_BYTES)
    }

    /// Where the next part, or the last checksum, begins.
    const fn aligned(self) -> Option<u32> {
        self.end.checked_next_multiple_of(ALIGNMENT)
    }

    /// Zeros that must follow a part of so many bytes.
    pub(super) fn padding(len: usize) -> &'static [u8] {
        const ZEROS: [u8; ALIGNMENT as usize] = [0; ALIGNMENT as usize];
        let over = len % ZEROS.len();
        ZEROS.get(over..).filter(|_| over > 0).unwrap_or_default()
    }
}
