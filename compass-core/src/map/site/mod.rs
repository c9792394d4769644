//! The site file: all floors of a building with their site maps and packed plans, read in place.
//!
//! # Format
//! All numbers are little-endian.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 8 | magic `CMPSSITE` |
//! | 8 | 2 | version, 1 |
//! | 10 | 1 | number of floors n, 1 to 32 |
//! | 11 | 1 | reserved, 0 |
//! | 12 | 4 | CRC-32 (ISO-HDLC) of bytes 0..12 and of the entries |
//! | 16 | 48 n | entries of the floors |
//! | 16 + 48 n | | parts of the floors |
//! | end - 4 | 4 | CRC-32 of all bytes before it |
//!
//! The entry of a floor:
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 1 | length of the name in bytes, 1 to 23 |
//! | 1 | 23 | name, unique in the site: UTF-8 without control characters, then zeros |
//! | 24 | 8 | offset and length of the [site map](crate::map::site_map) |
//! | 32 | 8 | offset and length of the [packed plan](crate::map::plan) of layer 0, whose checksum is in the map |
//! | 40 | 8 | offset and length of the packed plan of layer 1; zeros if the map has one layer |
//!
//! Parts are complete files of their own formats, in the order of the entries and of the fields in them. Each part, and
//! the checksum at the end, begins at the first multiple of 8 bytes behind the part before it; the bytes between are
//! zeros.

mod floor;
mod layout;
mod view;
mod write;

pub use floor::{Floor, FloorError, MAX_NAME_BYTES, is_name};
pub use view::Site;
pub use write::Writer;

use core::fmt;

const MAGIC: [u8; 8] = *b"CMPSSITE";
const VERSION: u16 = 1;
/// Largest number of floors of a site.
pub const MAX_FLOORS: usize = 32;

/// Errors of reading and writing a site. Floors are numbered from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SiteError {
    /// The bytes do not begin with the magic of a site.
    Magic,
    /// The version of the format is not supported.
    Version(u16),
    /// The number of floors is zero or above [`MAX_FLOORS`].
    Floors,
    /// The checksum of header and entries does not match.
    HeaderChecksum,
    /// This floor is invalid.
    Floor(u8, FloorError),
    /// The name of this floor is that of an earlier floor.
    SameName(u8),
    /// The number of bytes does not match the entries, or exceeds the range of the format.
    Length,
    /// The checksum of the file does not match.
    Checksum,
}

impl fmt::Display for SiteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("site magic is missing: not a site file"),
            Self::Version(v) => write!(f, "site version is {v}, this program reads {VERSION}"),
            Self::Floors => write!(f, "site floor count is not 1 to {MAX_FLOORS}"),
            Self::HeaderChecksum => f.write_str("site header checksum does not match: the header is damaged"),
            Self::Floor(floor, error) => write!(f, "floor number {floor} of the site: {error}"),
            Self::SameName(floor) => write!(f, "floor number {floor} of the site has the name of another"),
            Self::Length => f.write_str(
                "site length does not match its header: the file is truncated or has more behind it",
            ),
            Self::Checksum => f.write_str("site checksum does not match: the file is damaged"),
        }
    }
}

impl core::error::Error for SiteError {}

#[cfg(test)]
mod tests;
