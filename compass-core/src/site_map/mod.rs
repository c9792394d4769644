//! The site map.
mod packed;
pub use packed::{PACKED_SCAN_BYTES, PackedScan};
