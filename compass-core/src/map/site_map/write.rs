//! The writer of a site map.

use super::{
    CELL_BYTES, HEADER_BYTES, LAYER_BYTES, MAGIC, PackedScan, SIGNATURE_BYTES, SKETCH_BYTES, TRAILER_BYTES,
    VERSION,
};
use crate::base::crc::{CRC32, Sink, Summed};
use crate::map::plan::PlanGrid;

/// The header of a site map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Number of candidates.
    pub candidates: u32,
    /// Layers per candidate, 1 or 2.
    pub layers: u8,
    /// Grid of the plan: resolution and origin.
    pub grid: PlanGrid,
    /// Spacing of the candidates in millimetres.
    pub spacing_mm: u32,
    /// Width and height of the plan in cells.
    pub plan_size: [u32; 2],
    /// Checksum of the packed plan that layer 0 was cast from.
    pub plan_checksum: u32,
}

impl Header {
    /// Length of the whole map in bytes; `None` above the range of `usize`.
    #[must_use]
    pub fn map_bytes(&self) -> Option<usize> {
        let record = CELL_BYTES + usize::from(self.layers) * LAYER_BYTES;
        let records = usize::try_from(self.candidates).ok()?.checked_mul(record)?;
        records.checked_add(HEADER_BYTES + TRAILER_BYTES)
    }

    fn to_bytes(self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        let mut at = 0;
        let mut put = |field: &[u8]| {
            if let Some(slot) = bytes.get_mut(at..at + field.len()) {
                slot.copy_from_slice(field);
            }
            at += field.len();
        };
        put(&MAGIC);
        put(&VERSION.to_le_bytes());
        put(&[self.layers, 0]);
        put(&self.candidates.to_le_bytes());
        put(&self.grid.resolution_nm.to_le_bytes());
        put(&self.spacing_mm.to_le_bytes());
        put(&self.grid.origin.x.to_bits().to_le_bytes());
        put(&self.grid.origin.y.to_bits().to_le_bytes());
        put(&self.plan_size[0].to_le_bytes());
        put(&self.plan_size[1].to_le_bytes());
        put(&self.plan_checksum.to_le_bytes());
        let (body, crc) = bytes.split_at_mut(HEADER_BYTES - 4);
        crc.copy_from_slice(&CRC32.checksum(body).to_le_bytes());
        bytes
    }
}

/// Writes a site map: [`Writer::new`] writes the header, [`Writer::candidate`] one candidate, [`Writer::finish`] the
/// checksum.
///
/// # Formats
/// The [site map](super).
///
/// # Cost
/// Bytes are passed to the sink once, in order; nothing is buffered.
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
/// let mut writer = Writer::new(File(Vec::new()), &header)?;
/// writer.candidate([2, 2], &[layer_of(&scan)])?;
/// let File(map_bytes) = writer.finish()?;
/// assert_eq!(Some(map_bytes.len()), header.map_bytes());
/// assert_eq!(SiteMap::new(&map_bytes)?.position(0), Some(plan.cell_centre(2, 2)));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Writer<S>(Summed<S>);

impl<S: Sink> Writer<S> {
    /// Writes the header. [`Header::candidates`] candidates must follow; a different number is detected by the reader, not
    /// here.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn new(sink: S, header: &Header) -> Result<Self, S::Error> {
        let mut out = Summed::new(sink);
        out.append(&header.to_bytes())?;
        Ok(Self(out))
    }

    /// Appends one candidate: its plan cell (column from the west, row from the south) and one scan per layer, cast with
    /// heading 0.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn candidate(&mut self, cell: [u16; 2], layers: &[Layer]) -> Result<(), S::Error> {
        self.0.append(&cell[0].to_le_bytes())?;
        self.0.append(&cell[1].to_le_bytes())?;
        for layer in layers {
            self.0.append(&layer.0)?;
        }
        Ok(())
    }

    /// Writes the checksum and returns the sink.
    ///
    /// # Errors
    /// The error of the sink.
    pub fn finish(self) -> Result<S, S::Error> {
        self.0.finish()
    }
}

/// A layer of a candidate, in the format of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layer([u8; LAYER_BYTES]);

impl Layer {
    /// A layer from a scan cast with heading 0, its signature and its sketch: see
    /// [`layer_of`](crate::descriptor::layer_of).
    #[must_use]
    pub fn new(scan: &PackedScan, signature: &[u8; SIGNATURE_BYTES], sketch: &[u8; SKETCH_BYTES]) -> Self {
        let mut bytes = [0; LAYER_BYTES];
        for (byte, value) in bytes.iter_mut().zip(signature.iter().chain(sketch).chain(&scan.0)) {
            *byte = *value;
        }
        Self(bytes)
    }
}
