//! The packed floor plan and the ray march through it.
//!
//! A plan is one byte string that is read in place, from memory, a mapped file or flash. It has tiles of 8 x 8 cells: an
//! empty tile holds its distance to the nearest occupied one, an occupied tile the index of its cells. A storey of
//! 73 x 42 m at 0.01 m per cell takes about 1.3 MB.
//!
//! # Format
//! All numbers are little-endian.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 8 | magic `CMPSPLAN` |
//! | 8 | 2 | version, 1 |
//! | 10 | 2 | reserved, 0 |
//! | 12 | 4 | width in cells |
//! | 16 | 4 | height in cells |
//! | 20 | 4 | cell side in nanometres |
//! | 24 | 8 | x of the outer corner of the bottom-left cell, [`Metres`] bits |
//! | 32 | 8 | y of the same corner |
//! | 40 | 4 | number of occupied tiles |
//! | 44 | 4 | CRC-32 (ISO-HDLC) of everything but this field |
//! | 48 | 4 ty | per tile row, the number of its first occupied tile |
//! | | 2 tx ty | per tile, south to north, west to east: below 256 the chessboard distance in tiles to the nearest occupied tile or to the outside, else 256 + the index of the occupied tile within its row |
//! | | 16 each | occupied tiles: for 8 rows, south to north, a byte of wall bits and one of window bits, west in the lowest bit |

mod march;
mod pack;

pub use march::{AGREEING_RAYS_PPM, MarchError};
pub use pack::{pack, packed_len};

use crate::base::num::{Metres, Point};
use core::fmt;

/// Cells along the side of a tile.
const TILE: u32 = 8;
/// Bytes of the bits of one occupied tile.
const PATTERN_BYTES: usize = 16;
/// Smallest tile entry of an occupied tile.
const OCCUPIED: u16 = 256;
/// Bytes before the row table.
const HEADER_BYTES: usize = 48;
const MAGIC: [u8; 8] = *b"CMPSPLAN";
const VERSION: u16 = 1;
/// Range of the cell side, nanometres. Below 1 mm a march step would exceed 20 cells.
pub(crate) const RESOLUTION_NM: core::ops::RangeInclusive<u32> = 1_000_000..=4_000_000_000;

/// Errors of [`Plan::new`], [`Plan::verify`], [`packed_len`] and [`pack()`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PlanError {
    /// The bytes do not begin with the magic of a plan.
    Magic,
    /// The version of the format is not supported.
    Version(u16),
    /// Width or height is zero or above 65535 cells.
    Size,
    /// The cell side lies outside 0.001 m to 4 m.
    Resolution,
    /// The number of bytes does not match the header.
    Length,
    /// The checksum does not match the bytes.
    Checksum,
    /// Wall mask and window mask differ in size.
    MaskSize,
    /// The buffer is shorter than [`packed_len`].
    Buffer,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("plan magic is missing: not a packed plan"),
            Self::Version(v) => write!(f, "plan version is {v}, this program reads {VERSION}"),
            Self::Size => f.write_str("plan width or height is zero or above 65535 cells"),
            Self::Resolution => f.write_str("plan resolution is outside 0.001 to 4 m per cell"),
            Self::Length => f.write_str("plan length does not match its header"),
            Self::Checksum => f.write_str("plan checksum does not match"),
            Self::MaskSize => f.write_str("wall and window masks differ in size"),
            Self::Buffer => f.write_str("buffer is too small for the packed plan"),
        }
    }
}

impl core::error::Error for PlanError {}

/// The grid of a plan: cell size and position in the coordinates of the floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanGrid {
    /// Side of a cell in nanometres: 1,000,000 to 4,000,000,000 (0.001 m to 4 m).
    pub resolution_nm: u32,
    /// The outer corner of the bottom-left cell.
    pub origin: Point,
}

/// A packed floor plan, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    bytes: &'a [u8],
    rows: &'a [[u8; 4]],
    tiles: &'a [[u8; 2]],
    /// Occupied tiles as 8 rows of (wall byte, window byte).
    patterns: &'a [[u8; 2]],
    tiles_x: u32,
    tiles_y: u32,
    width: u32,
    height: u32,
    grid: PlanGrid,
    /// 1 m in cells, Q32.
    cells_per_metre: u64,
    /// The march step in cells, Q28; at most 20 cells.
    step: i64,
}

impl<'a> Plan<'a> {
    /// Views bytes as a plan. Checks header and lengths, not the checksum: see [`Plan::verify`].
    ///
    /// Damaged contents are not detected here; they give wrong ray hits, never a panic.
    ///
    /// # Formats
    /// The [packed plan](self).
    ///
    /// # Errors
    /// [`PlanError::Length`], [`PlanError::Magic`], [`PlanError::Version`], [`PlanError::Size`] or
    /// [`PlanError::Resolution`], for the first field that is invalid.
    ///
    /// # Cost
    /// Constant: reads the header alone.
    ///
    /// ```
    /// # use compass_core::map::plan::{PlanGrid, pack};
    /// # use compass_core::{BitMask, Point};
    /// # let (walls, windows) = ([0b11111, 0b10001, 0b00001, 0b10001, 0b11111], [0, 0, 0b10000, 0, 0]);
    /// # let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
    /// # let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
    /// # let mut bytes = [0; 256];
    /// # let plan = pack(&walls, &windows, grid, &mut bytes)?;
    /// use compass_core::Plan;
    /// use compass_core::map::plan::PlanError;
    ///
    /// // The packed plan of a mask of 5 x 5 cells.
    /// let bytes = plan.as_bytes();
    /// let plan = Plan::new(bytes)?;
    /// assert_eq!((plan.width(), plan.height()), (5, 5));
    /// assert!(plan.verify().is_ok());
    /// assert_eq!(Plan::new(&bytes[1..]).err(), Some(PlanError::Magic));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, PlanError> {
        let header: &[u8; HEADER_BYTES] = bytes.first_chunk().ok_or(PlanError::Length)?;
        let (magic, rest) = header.split_first_chunk::<8>().ok_or(PlanError::Length)?;
        if *magic != MAGIC {
            return Err(PlanError::Magic);
        }
        let u16_at = |at: usize| rest.get(at..).and_then(<[u8]>::first_chunk).map(|b| u16::from_le_bytes(*b));
        let u32_at = |at: usize| rest.get(at..).and_then(<[u8]>::first_chunk).map(|b| u32::from_le_bytes(*b));
        let i64_at = |at: usize| rest.get(at..).and_then(<[u8]>::first_chunk).map(|b| i64::from_le_bytes(*b));
        let version = u16_at(0).ok_or(PlanError::Length)?;
        if version != VERSION {
            return Err(PlanError::Version(version));
        }
        let field = |v: Option<u32>| v.ok_or(PlanError::Length);
        let (width, height) = (field(u32_at(4))?, field(u32_at(8))?);
        let resolution_nm = field(u32_at(12))?;
        let coordinate = |v: Option<i64>| v.map(Metres::from_bits).ok_or(PlanError::Length);
        let origin = Point::new(coordinate(i64_at(16))?, coordinate(i64_at(24))?);
        let occupied = field(u32_at(32))?;
        let layout = Layout::new(width, height, occupied)?;
        if bytes.len() != layout.len {
            return Err(PlanError::Length);
        }
        let grid = PlanGrid { resolution_nm, origin };
        Self::with_layout(bytes, layout, grid)
    }

    fn with_layout(bytes: &'a [u8], layout: Layout, grid: PlanGrid) -> Result<Self, PlanError> {
        if !RESOLUTION_NM.contains(&grid.resolution_nm) {
            return Err(PlanError::Resolution);
        }
        let part = |from: usize, to: usize| bytes.get(from..to).ok_or(PlanError::Length);
        let resolution = u64::from(grid.resolution_nm);
        Ok(Self {
            bytes,
            rows: part(HEADER_BYTES, layout.tiles_at)?.as_chunks().0,
            tiles: part(layout.tiles_at, layout.patterns_at)?.as_chunks().0,
            patterns: part(layout.patterns_at, layout.len)?.as_chunks().0,
            tiles_x: layout.tiles_x,
            tiles_y: layout.tiles_y,
            width: layout.width,
            height: layout.height,
            grid,
            cells_per_metre: (1_000_000_000 << 32) / resolution,
            step: ((20_000_000_u64 << 28) / resolution).cast_signed(),
        })
    }

    /// The bytes of the packed plan.
    #[must_use]
    pub const fn as_bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The checksum stored in the plan. Site maps refer to their plan by it.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        let stored = self.bytes.get(CRC_AT..).and_then(<[u8]>::first_chunk);
        stored.map_or(0, |bytes| u32::from_le_bytes(*bytes))
    }

    /// Compares the stored checksum with that of the bytes.
    ///
    /// # Errors
    /// [`PlanError::Checksum`] if they differ.
    ///
    /// # Cost
    /// Reads all bytes once.
    pub fn verify(&self) -> Result<(), PlanError> {
        if self.checksum() == checksum(self.bytes) { Ok(()) } else { Err(PlanError::Checksum) }
    }

    /// Width in cells.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in cells.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Resolution and origin.
    #[must_use]
    pub const fn grid(&self) -> PlanGrid {
        self.grid
    }

    /// The centre of a cell in the coordinates of the floor, metres: see [`PlanGrid::cell_centre`].
    #[must_use]
    pub fn cell_centre(&self, column: u16, row: u16) -> Point {
        self.grid.cell_centre(column, row)
    }

    /// Coordinates in cells, Q32, saturating.
    #[expect(clippy::cast_possible_truncation, reason = "clamped to a quarter of 64 bits")]
    fn cells(&self, at: Point) -> (i64, i64) {
        let scale = |v: Metres, origin: Metres| {
            let metres = i128::from(v.to_bits()) - i128::from(origin.to_bits());
            let cells = (metres * i128::from(self.cells_per_metre)) >> 32;
            // A march adds at most 30,000 cells: no overflow from a quarter of the range.
            cells.clamp(i128::from(i64::MIN / 4), i128::from(i64::MAX / 4)) as i64
        };
        (scale(at.x, self.grid.origin.x), scale(at.y, self.grid.origin.y))
    }
}

impl PlanGrid {
    /// The centre of a cell in the coordinates of the floor, metres; column from the west, row from the south.
    ///
    /// # Formats
    /// Rounded to the nearest 2^-32 m, saturating.
    #[must_use]
    pub fn cell_centre(&self, column: u16, row: u16) -> Point {
        // 2 index + 1 half cells in nanometres, to Q32 metres, rounded to the nearest. Quotient and remainder of a half
        // cell are multiplied separately, so that 64 bits suffice.
        let half_cell = u64::from(self.resolution_nm) << 31;
        let (whole, left) = (half_cell / 1_000_000_000, half_cell % 1_000_000_000);
        let along = |index: u16, origin: Metres| {
            let halves = 2 * u64::from(index) + 1;
            let bits = halves * whole + (halves * left + 500_000_000) / 1_000_000_000;
            origin.saturating_add(Metres::from_bits(bits.cast_signed()))
        };
        Point::new(along(column, self.origin.x), along(row, self.origin.y))
    }
}

/// Offsets of the parts of a packed plan.
#[derive(Debug, Clone, Copy)]
struct Layout {
    width: u32,
    height: u32,
    tiles_x: u32,
    tiles_y: u32,
    tiles_at: usize,
    patterns_at: usize,
    len: usize,
}

impl Layout {
    fn new(width: u32, height: u32, occupied: u32) -> Result<Self, PlanError> {
        let side = 1..=crate::base::raster::MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(PlanError::Size);
        }
        let (tiles_x, tiles_y) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let tiles_at = HEADER_BYTES + 4 * tiles_y as usize;
        // At most 8192 x 8192 tiles: 2^27 bytes.
        let patterns_at = tiles_at + 2 * tiles_x as usize * tiles_y as usize;
        let patterns = (occupied as usize).checked_mul(PATTERN_BYTES).ok_or(PlanError::Length)?;
        let len = patterns_at.checked_add(patterns).ok_or(PlanError::Length)?;
        Ok(Self { width, height, tiles_x, tiles_y, tiles_at, patterns_at, len })
    }
}

/// Offset of the checksum field, bytes.
const CRC_AT: usize = 44;

fn checksum(bytes: &[u8]) -> u32 {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(bytes.get(..CRC_AT).unwrap_or_default());
    digest.update(bytes.get(CRC_AT + 4..).unwrap_or_default());
    digest.finalize()
}
