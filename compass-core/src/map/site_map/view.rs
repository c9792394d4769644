//! Reading a site map in place.

use super::packed::{PACKED_SCAN_BYTES, unpack};
use super::{
    CELL_BYTES, HEADER_BYTES, Header, LAYER_BYTES, MAGIC, SIGNATURE_BYTES, SKETCH_BYTES, SiteMapError,
    TRAILER_BYTES, VERSION,
};
use crate::base::crc::CRC32;
use crate::base::num::{Metres, Point};
use crate::base::scan::Scan;
use crate::map::plan::Frame;

/// A map of candidate positions, borrowed from memory, a mapped file or flash.
#[derive(Debug, Clone, Copy)]
pub struct SiteMap<'a> {
    bytes: &'a [u8],
    header: Header,
    records: &'a [u8],
    record_bytes: usize,
}

/// One candidate of a map.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    cell: [u16; 2],
    first: LayerView<'a>,
    rest: &'a [u8],
}

/// One layer of a candidate.
#[derive(Debug, Clone, Copy)]
pub struct LayerView<'a>(&'a [u8; LAYER_BYTES]);

impl<'a> SiteMap<'a> {
    /// Views bytes as a site map. Checks the header and the lengths; [`SiteMap::verify`] checks the rest.
    ///
    /// Damaged candidates cannot do harm: they match wrongly, or not at all.
    ///
    /// # Errors
    /// [`SiteMapError`] names the field that is wrong.
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

    /// Compares the checksum of the whole with the bytes (reads all of them).
    ///
    /// # Errors
    /// [`SiteMapError::Checksum`] when they differ.
    pub fn verify(&self) -> Result<(), SiteMapError> {
        let (body, trailer) = self.bytes.split_last_chunk().ok_or(SiteMapError::Length)?;
        if CRC32.checksum(body) == u32::from_le_bytes(*trailer) {
            Ok(())
        } else {
            Err(SiteMapError::Checksum)
        }
    }

    /// The bytes of the map, to be stored as they are.
    #[must_use]
    pub const fn as_bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// What the map says of itself.
    #[must_use]
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// Number of candidates.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.header.candidates as usize
    }

    /// Never true: a map without candidates is refused.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.header.candidates == 0
    }

    /// The candidate of this number.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Record<'a>> {
        let start = index.checked_mul(self.record_bytes)?;
        let record = self.records.get(start..start.checked_add(self.record_bytes)?)?;
        let ([x0, x1, y0, y1], rest) = record.split_first_chunk()?;
        let cell = [u16::from_le_bytes([*x0, *x1]), u16::from_le_bytes([*y0, *y1])];
        let (first, rest) = rest.split_first_chunk()?;
        Some(Record { cell, first: LayerView(first), rest })
    }

    /// All candidates in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Record<'a>> + use<'a> {
        let map = *self;
        let empty = Record { cell: [0; 2], first: LayerView(&[0; LAYER_BYTES]), rest: &[] };
        (0..self.len()).map(move |index| map.get(index).unwrap_or(empty))
    }

    /// The position of a candidate in the map.
    #[must_use]
    pub fn position(&self, index: usize) -> Option<Point> {
        self.get(index).map(|record| self.header.frame.cell_centre(record.cell[0], record.cell[1]))
    }
}

impl<'a> Record<'a> {
    /// Plan cell: column, row from the south.
    #[must_use]
    pub const fn cell(&self) -> [u16; 2] {
        self.cell
    }

    /// The layer of this number; `None` when the map has fewer.
    #[must_use]
    pub fn layer(&self, number: usize) -> Option<LayerView<'a>> {
        match number.checked_sub(1) {
            None => Some(self.first),
            Some(behind) => self.rest.as_chunks().0.get(behind).map(LayerView),
        }
    }

    /// Layer 0.
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

    /// The scan as it is stored.
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
    let frame = Frame { resolution_nm: u32_at(16)?, origin: Point::new(i64_at(24)?, i64_at(32)?) };
    let found = Header {
        layers: u32_at(10)? as u8,
        candidates: u32_at(12)?,
        frame,
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
    if !crate::map::plan::RESOLUTION_NM.contains(&frame.resolution_nm) {
        return Err(SiteMapError::Resolution);
    }
    Ok(found)
}
