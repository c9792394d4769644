//! Views of a site map and its candidates.

use super::packed::{PACKED_SCAN_BYTES, unpack};
use super::{
    CELL_BYTES, HEADER_BYTES, Header, LAYER_BYTES, MAGIC, SIGNATURE_BYTES, SKETCH_BYTES, SiteMapError,
    TRAILER_BYTES, VERSION,
};
use crate::base::crc::CRC32;
use crate::base::num::{Metres, Point};
use crate::base::scan::Scan;
use crate::map::plan::PlanGrid;

/// A site map, borrowed from memory, a mapped file or flash.
#[derive(Debug, Clone, Copy)]
pub struct SiteMap<'a> {
    bytes: &'a [u8],
    header: Header,
    records: &'a [u8],
    record_bytes: usize,
}

/// A candidate of a site map.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    cell: [u16; 2],
    first: LayerView<'a>,
    rest: &'a [u8],
}

/// A layer of a candidate.
#[derive(Debug, Clone, Copy)]
pub struct LayerView<'a>(&'a [u8; LAYER_BYTES]);

impl<'a> SiteMap<'a> {
    /// Views bytes as a site map. Checks header and lengths, not the checksum of the candidates: see [`SiteMap::verify`].
    ///
    /// Damaged candidates are not detected here; they give wrong scans, never a panic.
    ///
    /// # Formats
    /// The [site map](super).
    ///
    /// # Errors
    /// [`SiteMapError`], for the first field that is invalid.
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
    /// let map = SiteMap::new(&map_bytes)?;
    /// assert_eq!(map.len(), 1);
    /// assert_eq!(map.get(0).map(|record| record.cell()), Some([2, 2]));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, SiteMapError> {
        if !bytes.starts_with(&MAGIC) {
            let short = bytes.len() < MAGIC.len() && MAGIC.starts_with(bytes);
            return Err(if short { SiteMapError::Length } else { SiteMapError::Magic });
        }
        let header = read_header(bytes)?;
        let length = header.map_bytes().ok_or(SiteMapError::Candidates)?;
        if bytes.len() != length {
            return Err(SiteMapError::Length);
        }
        let records = bytes.get(HEADER_BYTES..length - TRAILER_BYTES).ok_or(SiteMapError::Length)?;
        let record_bytes = CELL_BYTES + usize::from(header.layers) * LAYER_BYTES;
        Ok(Self { bytes, header, records, record_bytes })
    }

    /// Compares the stored checksum with that of the bytes.
    ///
    /// # Errors
    /// [`SiteMapError::Checksum`] if they differ.
    ///
    /// # Cost
    /// Reads all bytes once.
    pub fn verify(&self) -> Result<(), SiteMapError> {
        let (body, trailer) = self.bytes.split_last_chunk().ok_or(SiteMapError::Length)?;
        if CRC32.checksum(body) == u32::from_le_bytes(*trailer) {
            Ok(())
        } else {
            Err(SiteMapError::Checksum)
        }
    }

    /// The bytes of the map.
    #[must_use]
    pub const fn as_bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The header.
    #[must_use]
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// Number of candidates.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.header.candidates as usize
    }

    /// Always false: [`SiteMap::new`] rejects a map without candidates.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.header.candidates == 0
    }

    /// A candidate by its index; `None` from [`SiteMap::len`] on.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Record<'a>> {
        let start = index.checked_mul(self.record_bytes)?;
        let record = self.records.get(start..start.checked_add(self.record_bytes)?)?;
        let ([x0, x1, y0, y1], rest) = record.split_first_chunk()?;
        let cell = [u16::from_le_bytes([*x0, *x1]), u16::from_le_bytes([*y0, *y1])];
        let (first, rest) = rest.split_first_chunk()?;
        Some(Record { cell, first: LayerView(first), rest })
    }

    /// All candidates in the order of the file.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Record<'a>> + use<'a> {
        let map = *self;
        let empty = Record { cell: [0; 2], first: LayerView(&[0; LAYER_BYTES]), rest: &[] };
        (0..self.len()).map(move |index| map.get(index).unwrap_or(empty))
    }

    /// The position of a candidate in the coordinates of the floor, metres.
    #[must_use]
    pub fn position(&self, index: usize) -> Option<Point> {
        self.get(index).map(|record| self.header.grid.cell_centre(record.cell[0], record.cell[1]))
    }
}

impl<'a> Record<'a> {
    /// Plan cell: column from the west, row from the south.
    #[must_use]
    pub const fn cell(&self) -> [u16; 2] {
        self.cell
    }

    /// A layer: 0 plan, 1 structure; `None` for a layer that the map does not have.
    #[must_use]
    pub fn layer(&self, number: usize) -> Option<LayerView<'a>> {
        match number.checked_sub(1) {
            None => Some(self.first),
            Some(behind) => self.rest.as_chunks().0.get(behind).map(LayerView),
        }
    }

    /// Layer 0: the plan as drawn.
    #[must_use]
    pub const fn plan_layer(&self) -> LayerView<'a> {
        self.first
    }

    /// Unpacks the scan of layer 0, cast with heading 0.
    pub fn scan(&self, out: &mut Scan) {
        self.first.scan(out);
    }
}

impl<'a> LayerView<'a> {
    /// The bytes of the transition signature.
    #[must_use]
    pub fn signature_bytes(&self) -> &'a [u8; SIGNATURE_BYTES] {
        self.0.first_chunk().unwrap_or(&[0; SIGNATURE_BYTES])
    }

    /// The bytes of the sketch.
    #[must_use]
    pub fn sketch_bytes(&self) -> &'a [u8; SKETCH_BYTES] {
        self.0.get(SIGNATURE_BYTES..).and_then(<[u8]>::first_chunk).unwrap_or(&[0; SKETCH_BYTES])
    }

    /// The bytes of the packed scan.
    pub(crate) fn packed(&self) -> Option<&'a [u8; PACKED_SCAN_BYTES]> {
        self.0.last_chunk()
    }

    /// Unpacks the scan, cast with heading 0.
    pub fn scan(&self, out: &mut Scan) {
        if let Some(packed) = self.packed() {
            unpack(packed, out);
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "fields of 16 and 8 bits at the beginning of the words read"
)]
fn read_header(bytes: &[u8]) -> Result<Header, SiteMapError> {
    let header: &[u8; HEADER_BYTES] = bytes.first_chunk().ok_or(SiteMapError::Length)?;
    let u32_at = |at: usize| {
        let field = header.get(at..).and_then(<[u8]>::first_chunk);
        field.map(|b| u32::from_le_bytes(*b)).ok_or(SiteMapError::Length)
    };
    let i64_at = |at: usize| {
        let field = header.get(at..).and_then(<[u8]>::first_chunk);
        field.map(|b| Metres::from_bits(i64::from_le_bytes(*b))).ok_or(SiteMapError::Length)
    };
    let version = u32_at(8)? as u16;
    if version != VERSION {
        return Err(SiteMapError::Version(version));
    }
    let (body, crc) = header.split_last_chunk().ok_or(SiteMapError::Length)?;
    if CRC32.checksum(body) != u32::from_le_bytes(*crc) {
        return Err(SiteMapError::HeaderChecksum);
    }
    let grid = PlanGrid { resolution_nm: u32_at(16)?, origin: Point::new(i64_at(24)?, i64_at(32)?) };
    let found = Header {
        layers: u32_at(10)? as u8,
        candidates: u32_at(12)?,
        grid,
        spacing_mm: u32_at(20)?,
        plan_size: [u32_at(40)?, u32_at(44)?],
        plan_checksum: u32_at(48)?,
    };
    if !(1..=2).contains(&found.layers) {
        return Err(SiteMapError::Layers);
    }
    if found.candidates == 0 {
        return Err(SiteMapError::Candidates);
    }
    if !crate::map::plan::RESOLUTION_NM.contains(&grid.resolution_nm) {
        return Err(SiteMapError::Resolution);
    }
    Ok(found)
}
