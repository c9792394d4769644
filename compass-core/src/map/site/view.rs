//! Views of a site file.

use super::layout::{Cursor, ENTRY_BYTES, Entry, HEADER_BYTES, NAME_BYTES, PARTS, header_checksum};
use super::{Floor, FloorError, MAGIC, MAX_FLOORS, SiteError, VERSION};
use crate::base::crc::CRC32;
use crate::map::plan::Plan;
use crate::map::site_map::SiteMap;

/// All floors of a building, borrowed from memory, a mapped file or flash.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    bytes: &'a [u8],
    entries: &'a [Entry],
}

/// Offset and length.
type Part = [u32; 2];

impl<'a> Site<'a> {
    /// Views bytes as a site. Checks the headers of site, maps and plans and the checksums of the headers;
    /// [`Site::verify`] checks those of the contents.
    ///
    /// # Formats
    /// The [site file](super).
    ///
    /// # Errors
    /// [`SiteError`], for the first field that is invalid.
    ///
    /// # Cost
    /// Reads the headers of all floors, not their contents.
    #[expect(clippy::cast_possible_truncation, reason = "at most 32 floors")]
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
    /// # let floors = [Floor::new("ground", SiteMap::new(&map_bytes)?, plan, None)?];
    /// # let File(site_bytes) = site::Writer::new(&floors)?.write(File(Vec::new()))?;
    /// let site = Site::new(&site_bytes)?;
    /// assert_eq!(site.floor(0).map(|floor| floor.name()), Some("ground"));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, SiteError> {
        if !bytes.starts_with(&MAGIC) {
            let short = bytes.len() < MAGIC.len() && MAGIC.starts_with(bytes);
            return Err(if short { SiteError::Length } else { SiteError::Magic });
        }
        let site = Self { bytes, entries: read_entries(bytes)? };
        site.check_layout()?;
        for (number, entry) in site.entries.iter().enumerate() {
            site.read(entry).map_err(|error| SiteError::Floor(number as u8, error))?;
            // Names are padded with zeros: equal fields are equal names.
            let name = entry.first_chunk::<NAME_BYTES>();
            if site.entries.iter().take(number).any(|before| before.first_chunk() == name) {
                return Err(SiteError::SameName(number as u8));
            }
        }
        Ok(site)
    }

    /// Compares all stored checksums with those of the bytes, including those of maps and plans.
    ///
    /// # Errors
    /// [`SiteError::Floor`] for the map or plan whose checksum differs, else [`SiteError::Checksum`].
    ///
    /// # Cost
    /// Reads all bytes twice.
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
    /// # let floors = [Floor::new("ground", SiteMap::new(&map_bytes)?, plan, None)?];
    /// # let File(site_bytes) = site::Writer::new(&floors)?.write(File(Vec::new()))?;
    /// assert!(Site::new(&site_bytes)?.verify().is_ok());
    /// let mut damaged = site_bytes;
    /// *damaged.last_mut().unwrap() ^= 1;
    /// assert!(Site::new(&damaged)?.verify().is_err());
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn verify(&self) -> Result<(), SiteError> {
        for (number, floor) in (0..).zip(self.floors()) {
            floor.verify().map_err(|error| SiteError::Floor(number, error))?;
        }
        let (body, trailer) = self.bytes.split_last_chunk().ok_or(SiteError::Length)?;
        if CRC32.checksum(body) == u32::from_le_bytes(*trailer) { Ok(()) } else { Err(SiteError::Checksum) }
    }

    /// Number of floors, 1 to [`MAX_FLOORS`].
    #[must_use]
    pub const fn len(&self) -> usize {
        self.entries.len()
    }

    /// Always false: [`Site::new`] rejects a site without floors.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// A floor by its number; `None` from [`Site::len`] on.
    #[must_use]
    pub fn floor(&self, number: usize) -> Option<Floor<'a>> {
        self.read(self.entries.get(number)?).ok()
    }

    /// All floors in the order of the file.
    pub fn floors(&self) -> impl Iterator<Item = Floor<'a>> + use<'a> {
        let site = *self;
        (0..site.len()).filter_map(move |number| site.floor(number))
    }

    /// The bytes of the site.
    #[must_use]
    pub const fn as_bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Checks that the parts are consecutive and fill the file.
    fn check_layout(&self) -> Result<(), SiteError> {
        let mut cursor = Cursor::new(self.entries.len());
        for (number, entry) in (0..).zip(self.entries) {
            for [offset, len] in parts(entry).into_iter().flatten() {
                let expected = cursor.place(len).ok_or(SiteError::Length)?;
                if offset != expected {
                    return Err(SiteError::Floor(number, FloorError::Offset));
                }
            }
        }
        if cursor.site_bytes() == Some(self.bytes.len()) { Ok(()) } else { Err(SiteError::Length) }
    }

    fn read(&self, entry: &'a Entry) -> Result<Floor<'a>, FloorError> {
        let name = read_name(entry).ok_or(FloorError::Name)?;
        let [map, plan, structure] = parts(entry).map(|part| part.and_then(|part| self.part(part)));
        let map = SiteMap::new(map.unwrap_or_default()).map_err(FloorError::Map)?;
        let view = |layer, bytes| Plan::new(bytes).map_err(|error| FloorError::Plan(layer, error));
        let plan = view(0, plan.unwrap_or_default())?;
        let structure = structure.map(|bytes| view(1, bytes)).transpose()?;
        Floor::new(name, map, plan, structure)
    }

    fn part(&self, [offset, len]: Part) -> Option<&'a [u8]> {
        let offset = usize::try_from(offset).ok()?;
        self.bytes.get(offset..offset.checked_add(usize::try_from(len).ok()?)?)
    }
}

fn read_entries(bytes: &[u8]) -> Result<&[Entry], SiteError> {
    let (header, rest) = bytes.split_first_chunk::<HEADER_BYTES>().ok_or(SiteError::Length)?;
    let (summed, crc) = header.split_last_chunk().ok_or(SiteError::Length)?;
    let &[.., v0, v1, floors, _] = summed else { return Err(SiteError::Length) };
    let version = u16::from_le_bytes([v0, v1]);
    if version != VERSION {
        return Err(SiteError::Version(version));
    }
    let floors = usize::from(floors);
    if !(1..=MAX_FLOORS).contains(&floors) {
        return Err(SiteError::Floors);
    }
    let entries = rest.get(..ENTRY_BYTES * floors).ok_or(SiteError::Length)?.as_chunks().0;
    if header_checksum(summed, entries) != u32::from_le_bytes(*crc) {
        return Err(SiteError::HeaderChecksum);
    }
    Ok(entries)
}

fn read_name(entry: &Entry) -> Option<&str> {
    let (&len, rest) = entry.first_chunk::<NAME_BYTES>()?.split_first()?;
    let (name, padding) = rest.split_at_checked(usize::from(len))?;
    let name = padding.iter().all(|&byte| byte == 0).then_some(name)?;
    core::str::from_utf8(name).ok()
}

/// The parts of a floor; a field of zeros is an absent part.
fn parts(entry: &Entry) -> [Option<Part>; PARTS] {
    let mut found = [None; PARTS];
    let fields = entry.get(NAME_BYTES..).unwrap_or_default().as_chunks::<8>().0;
    for (part, &[o0, o1, o2, o3, l0, l1, l2, l3]) in found.iter_mut().zip(fields) {
        let field = [u32::from_le_bytes([o0, o1, o2, o3]), u32::from_le_bytes([l0, l1, l2, l3])];
        *part = Some(field).filter(|field| *field != [0; 2]);
    }
    found
}
