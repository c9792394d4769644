//! The writer of a site file.

use super::layout::{Cursor, ENTRY_BYTES, Entry, HEADER_BYTES, NAME_BYTES, SUMMED_BYTES, header_checksum};
use super::{Floor, MAGIC, MAX_FLOORS, SiteError, VERSION};
use crate::base::crc::{Sink, Summed};

/// Writes a site file from complete floors.
///
/// # Formats
/// The [site file](super).
///
/// # Cost
/// Bytes are passed to the sink once, in order; 1.5 KiB of stack for the entries.
///
/// ```
/// # use compass_core::map::plan::{PlanGrid, pack};
/// # use compass_core::{BitMask, Point};
/// # let (walls, windows) = ([0b11111, 0b10001, 0b00001, 0b10001, 0b11111], [0, 0, 0b10000, 0, 0]);
/// # let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
/// # let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
/// # let mut bytes = [0; 256];
/// # let plan = pack(&walls, &windows, grid, &mut bytes)?;
/// # use compass_core::descriptor::layer_of;
/// # use compass_core::map::site_map::{Header, Sink, SiteMap, Writer};
/// # use compass_core::{Scan, Turn};
/// # struct File(Vec<u8>);
/// # impl Sink for File {
/// #     type Error = core::convert::Infallible;
/// #     fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
/// #         self.0.extend_from_slice(bytes);
/// #         Ok(())
/// #     }
/// # }
/// # let (plan_size, plan_checksum) = ([5, 5], plan.checksum());
/// # let header = Header { candidates: 1, layers: 1, grid, spacing_mm: 100, plan_size, plan_checksum };
/// # let mut scan = Scan::OPEN;
/// # plan.scan(plan.cell_centre(2, 2), Turn::ZERO, &mut scan)?;
/// # let mut writer = Writer::new(File(Vec::new()), &header)?;
/// # writer.candidate([2, 2], &[layer_of(&scan)])?;
/// # let File(map_bytes) = writer.finish()?;
/// # use compass_core::Site;
/// # use compass_core::map::site::{self, Floor};
/// let floors = [Floor::new("ground", SiteMap::new(&map_bytes)?, plan, None)?];
/// let writer = site::Writer::new(&floors)?;
/// let File(site_bytes) = writer.write(File(Vec::new()))?;
/// assert_eq!(site_bytes.len(), writer.site_bytes());
/// assert_eq!(Site::new(&site_bytes)?.len(), 1);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Writer<'f, 'a> {
    floors: &'f [Floor<'a>],
    site_bytes: usize,
}

impl<'f, 'a> Writer<'f, 'a> {
    /// A writer for these floors.
    ///
    /// # Errors
    /// [`SiteError::Floors`] for 0 or more than [`MAX_FLOORS`] floors, [`SiteError::SameName`] for two floors of one name,
    /// [`SiteError::Length`] for 4 GiB or more.
    #[expect(clippy::cast_possible_truncation, reason = "at most 32 floors")]
    pub fn new(floors: &'f [Floor<'a>]) -> Result<Self, SiteError> {
        if !(1..=MAX_FLOORS).contains(&floors.len()) {
            return Err(SiteError::Floors);
        }
        let mut cursor = Cursor::new(floors.len());
        for (number, floor) in floors.iter().enumerate() {
            if floors.iter().take(number).any(|before| before.name() == floor.name()) {
                return Err(SiteError::SameName(number as u8));
            }
            for part in floor.parts() {
                u32::try_from(part.len()).ok().and_then(|len| cursor.place(len)).ok_or(SiteError::Length)?;
            }
        }
        Ok(Self { floors, site_bytes: cursor.site_bytes().ok_or(SiteError::Length)? })
    }

    /// Length of the site file in bytes.
    #[must_use]
    pub const fn site_bytes(&self) -> usize {
        self.site_bytes
    }

    /// Writes the site and returns the sink.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn write<S: Sink>(&self, sink: S) -> Result<S, S::Error> {
        let mut entries = [[0; ENTRY_BYTES]; MAX_FLOORS];
        let mut cursor = Cursor::new(self.floors.len());
        for (entry, floor) in entries.iter_mut().zip(self.floors) {
            *entry = entry_of(floor, &mut cursor);
        }
        let entries = entries.get(..self.floors.len()).unwrap_or_default();
        let mut out = Summed::new(sink);
        out.append(&header(entries))?;
        out.append(entries.as_flattened())?;
        for part in self.floors.iter().flat_map(Floor::parts) {
            out.append(part)?;
            out.append(Cursor::padding(part.len()))?;
        }
        out.finish()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "at most 32 floors")]
fn header(entries: &[Entry]) -> [u8; HEADER_BYTES] {
    let mut bytes = [0; HEADER_BYTES];
    let (summed, crc) = bytes.split_at_mut(SUMMED_BYTES);
    let fields = MAGIC.into_iter().chain(VERSION.to_le_bytes()).chain([entries.len() as u8]);
    for (byte, value) in summed.iter_mut().zip(fields) {
        *byte = value;
    }
    crc.copy_from_slice(&header_checksum(summed, entries).to_le_bytes());
    bytes
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "names have at most 23 bytes, parts fewer than 2^32: checked by `Writer::new`"
)]
fn entry_of(floor: &Floor<'_>, cursor: &mut Cursor) -> Entry {
    let mut entry = [0; ENTRY_BYTES];
    let (name, parts) = entry.split_at_mut(NAME_BYTES);
    // At most 23 bytes: checked by `Floor::new`.
    let field = core::iter::once(floor.name().len() as u8).chain(floor.name().bytes());
    for (byte, value) in name.iter_mut().zip(field) {
        *byte = value;
    }
    for (field, part) in parts.as_chunks_mut::<8>().0.iter_mut().zip(floor.parts()) {
        // At most 4 GiB in total: checked by `Writer::new`.
        let len = part.len() as u32;
        let [o0, o1, o2, o3] = cursor.place(len).unwrap_or(0).to_le_bytes();
        let [l0, l1, l2, l3] = len.to_le_bytes();
        *field = [o0, o1, o2, o3, l0, l1, l2, l3];
    }
    entry
}
