//! The site map: candidate positions of a floor with their scans. Read in place, written through a [`Sink`].
//!
//! # Format
//! All numbers are little-endian.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 8 | magic `CMPSMAP1` |
//! | 8 | 2 | version, 1 |
//! | 10 | 1 | layers per candidate, 1 or 2 |
//! | 11 | 1 | reserved, 0 |
//! | 12 | 4 | number of candidates |
//! | 16 | 4 | cell side of the plan in nanometres |
//! | 20 | 4 | candidate spacing in millimetres |
//! | 24 | 8 | x of the origin of the plan, bits of [`Metres`](crate::base::num::Metres) |
//! | 32 | 8 | y of the origin |
//! | 40 | 4 | width of the plan in cells |
//! | 44 | 4 | height of the plan in cells |
//! | 48 | 4 | checksum of the packed plan that layer 0 was cast from |
//! | 52 | 4 | CRC-32 (ISO-HDLC) of bytes 0..52 |
//! | 56 | n (4 + 445 layers) | candidates |
//! | end - 4 | 4 | CRC-32 of all bytes before it |
//!
//! A candidate is its plan cell (column, row from the south, 2 bytes each), then per layer:
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 16 | [`Signature`](crate::descriptor::signature::Signature) |
//! | 16 | 24 | [`Sketch`](crate::descriptor::sketch::Sketch) |
//! | 40 | 405 | [`PackedScan`], cast with heading 0 |
//!
//! Layer 0 is cast from the plan as drawn. Layer 1, if present, is cast from the structure alone: the building before
//! its fit-out.

mod packed;
mod view;
mod write;

pub use crate::base::crc::Sink;
pub(crate) use packed::{LADDER, ladder_code};
pub use packed::{PACKED_SCAN_BYTES, PackedScan};
pub use view::{LayerView, Record, SiteMap};
pub use write::{Header, Layer, Writer};

use core::fmt;

const MAGIC: [u8; 8] = *b"CMPSMAP1";
const VERSION: u16 = 1;
const HEADER_BYTES: usize = 56;
const TRAILER_BYTES: usize = 4;
const CELL_BYTES: usize = 4;
/// Length of a transition signature.
pub const SIGNATURE_BYTES: usize = 16;
/// Length of a sketch.
pub const SKETCH_BYTES: usize = 24;
/// Length of one layer of a candidate.
pub const LAYER_BYTES: usize = SIGNATURE_BYTES + SKETCH_BYTES + PACKED_SCAN_BYTES;

/// Errors of reading a site map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SiteMapError {
    /// The bytes do not begin with the magic of a site map.
    Magic,
    /// The version of the format is not supported.
    Version(u16),
    /// The checksum of the header does not match.
    HeaderChecksum,
    /// The number of layers is neither 1 nor 2.
    Layers,
    /// The number of candidates is zero or exceeds the address range.
    Candidates,
    /// The resolution lies outside 0.001 m to 4 m per cell.
    Resolution,
    /// The number of bytes does not match the header.
    Length,
    /// The checksum of the map does not match.
    Checksum,
}

impl fmt::Display for SiteMapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("site map magic is missing: not a site map"),
            Self::Version(v) => write!(f, "site map version is {v}, this program reads {VERSION}"),
            Self::HeaderChecksum => {
                f.write_str("site map header checksum does not match: the header is damaged")
            }
            Self::Layers => f.write_str("site map layer count is neither 1 nor 2"),
            Self::Candidates => f.write_str("site map candidate count is zero or too large"),
            Self::Resolution => f.write_str("site map resolution is outside 0.001 to 4 m per cell"),
            Self::Length => f.write_str(
                "site map length does not match its header: the file is truncated or has more behind it",
            ),
            Self::Checksum => f.write_str("site map checksum does not match: the candidates are damaged"),
        }
    }
}

impl core::error::Error for SiteMapError {}

#[cfg(test)]
mod tests;
