//! Packing of a wall mask and a window mask into a plan.

use super::{
    CRC_AT, HEADER_BYTES, Layout, MAGIC, OCCUPIED, PATTERN_BYTES, Plan, PlanError, PlanGrid, TILE, VERSION,
    checksum,
};
use crate::base::raster::BitMask;

/// Largest distance that an empty tile can hold.
const MAX_DISTANCE: u16 = OCCUPIED - 1;

/// Length in bytes of the packed plan of these masks.
///
/// # Errors
/// [`PlanError::MaskSize`] if the masks differ in size, [`PlanError::Size`] or [`PlanError::Length`] if the format cannot
/// hold them.
///
/// # Cost
/// Reads both masks once.
pub fn packed_len(walls: &BitMask<'_>, windows: &BitMask<'_>) -> Result<usize, PlanError> {
    layout(walls, windows).map(|layout| layout.len)
}

fn layout(walls: &BitMask<'_>, windows: &BitMask<'_>) -> Result<Layout, PlanError> {
    if (walls.width(), walls.height()) != (windows.width(), windows.height()) {
        return Err(PlanError::MaskSize);
    }
    let (tiles_x, tiles_y) = (walls.width().div_ceil(TILE), walls.height().div_ceil(TILE));
    let occupied = (0..tiles_y)
        .map(|ty| (0..tiles_x).filter(|&tx| pattern(walls, windows, tx, ty).is_some()).count())
        .sum::<usize>();
    let occupied = u32::try_from(occupied).map_err(|_| PlanError::Size)?;
    Layout::new(walls.width(), walls.height(), occupied)
}

/// Packs a wall mask and a window mask into `out` and returns a view of the result.
///
/// A cell set in both masks is a wall. `out` may be longer than [`packed_len`]; the rest is not written.
///
/// # Formats
/// Row 0 of the masks is the south, column 0 the west. The result is the [packed plan](super).
///
/// # Errors
/// [`PlanError::MaskSize`] if the masks differ in size, [`PlanError::Size`] or [`PlanError::Length`] if the format cannot
/// hold them, [`PlanError::Resolution`] for a cell side outside 0.001 m to 4 m, [`PlanError::Buffer`] if `out` is shorter
/// than [`packed_len`].
///
/// # Cost
/// Reads both masks twice, and eight neighbours of each tile for the distances.
///
/// # References
/// The two-pass distance transform: A. Rosenfeld, J. L. Pfaltz, "Sequential operations in digital picture
/// processing", J. ACM 13 (4), 1966.
///
/// ```
/// use compass_core::map::plan::{PlanGrid, pack, packed_len};
/// use compass_core::{BitMask, Hit, Point};
///
/// // 5 x 5 cells of 0.1 m: walls around, a window in the east. The lowest bit is the west.
/// let walls = [0b11111, 0b10001, 0b00001, 0b10001, 0b11111];
/// let windows = [0, 0, 0b10000, 0, 0];
/// let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
/// let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
/// let mut bytes = [0; 256];
/// let plan = pack(&walls, &windows, grid, &mut bytes)?;
/// assert_eq!(plan.as_bytes().len(), packed_len(&walls, &windows)?);
/// assert_eq!(plan.hit_at(plan.cell_centre(4, 2)), Some(Hit::Window));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn pack<'a>(
    walls: &BitMask<'_>,
    windows: &BitMask<'_>,
    grid: PlanGrid,
    out: &'a mut [u8],
) -> Result<Plan<'a>, PlanError> {
    let layout = layout(walls, windows)?;
    if !super::RESOLUTION_NM.contains(&grid.resolution_nm) {
        return Err(PlanError::Resolution);
    }
    let bytes = out.get_mut(..layout.len).ok_or(PlanError::Buffer)?;
    let (header, body) = bytes.split_at_mut_checked(HEADER_BYTES).ok_or(PlanError::Buffer)?;
    let (rows, body) = body.split_at_mut_checked(layout.tiles_at - HEADER_BYTES).ok_or(PlanError::Buffer)?;
    let (tiles, patterns) =
        body.split_at_mut_checked(layout.patterns_at - layout.tiles_at).ok_or(PlanError::Buffer)?;

    let (rows, tiles) = (rows.as_chunks_mut::<4>().0, tiles.as_chunks_mut::<2>().0);
    let occupied = write_tiles(walls, windows, rows, tiles, patterns.as_chunks_mut::<PATTERN_BYTES>().0);
    spread_distances(tiles, layout.tiles_x as usize);
    write_header(header, &layout, grid, occupied);
    let crc = checksum(bytes);
    if let Some(field) = bytes.get_mut(CRC_AT..CRC_AT + 4) {
        field.copy_from_slice(&crc.to_le_bytes());
    }
    Plan::with_layout(bytes, layout, grid)
}

/// The bits of one tile, or `None` when it is empty.
fn pattern(walls: &BitMask<'_>, windows: &BitMask<'_>, tx: u32, ty: u32) -> Option<[u8; PATTERN_BYTES]> {
    let mut bits = [0; PATTERN_BYTES];
    let mut any = 0;
    for (row, pair) in (ty * TILE..).zip(bits.as_chunks_mut::<2>().0) {
        let (wall, window) = (walls.byte(tx, row), windows.byte(tx, row));
        *pair = [wall, window & !wall];
        any |= wall | window;
    }
    (any != 0).then_some(bits)
}

/// Fills the row table, the patterns and the entries of occupied tiles; the entries of empty tiles become
/// [`MAX_DISTANCE`]. Returns the number of occupied tiles.
#[expect(clippy::cast_possible_truncation, reason = "a row has at most 8192 tiles")]
fn write_tiles(
    walls: &BitMask<'_>,
    windows: &BitMask<'_>,
    rows: &mut [[u8; 4]],
    tiles: &mut [[u8; 2]],
    patterns: &mut [[u8; PATTERN_BYTES]],
) -> u32 {
    let tiles_x = walls.width().div_ceil(TILE);
    let mut next = 0_u32;
    for ((ty, first), entries) in (0..).zip(rows).zip(tiles.chunks_exact_mut(tiles_x.max(1) as usize)) {
        let row_first = next;
        *first = row_first.to_le_bytes();
        for (tx, entry) in (0..).zip(entries) {
            let value = match pattern(walls, windows, tx, ty) {
                Some(bits) => {
                    if let Some(slot) = patterns.get_mut(next as usize) {
                        *slot = bits;
                    }
                    next += 1;
                    // A row has at most 8192 tiles.
                    OCCUPIED + (next - 1 - row_first) as u16
                }
                None => MAX_DISTANCE,
            };
            *entry = value.to_le_bytes();
        }
    }
    next
}

/// Two-pass chessboard distance transform. The outside of the raster counts as occupied.
fn spread_distances(tiles: &mut [[u8; 2]], tiles_x: usize) {
    let tiles_y = tiles.len() / tiles_x.max(1);
    for y in 0..tiles_y {
        for x in 0..tiles_x {
            relax(tiles, tiles_x, (x, y), [(-1, 0), (-1, -1), (0, -1), (1, -1)]);
        }
    }
    for y in (0..tiles_y).rev() {
        for x in (0..tiles_x).rev() {
            relax(tiles, tiles_x, (x, y), [(1, 0), (1, 1), (0, 1), (-1, 1)]);
        }
    }
}

fn relax(tiles: &mut [[u8; 2]], tiles_x: usize, (x, y): (usize, usize), neighbours: [(isize, isize); 4]) {
    let distance = |entry: u16| if entry >= OCCUPIED { 0 } else { entry };
    let at = y * tiles_x + x;
    let Some(here) = tiles.get(at).map(|e| u16::from_le_bytes(*e)) else { return };
    if here >= OCCUPIED {
        return;
    }
    let nearest = neighbours
        .into_iter()
        .map(|(dx, dy)| {
            let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { return 0 };
            if nx >= tiles_x {
                return 0;
            }
            tiles.get(ny * tiles_x + nx).map_or(0, |e| distance(u16::from_le_bytes(*e)))
        })
        .min()
        .unwrap_or(0);
    let value = here.min((nearest + 1).min(MAX_DISTANCE));
    if let Some(entry) = tiles.get_mut(at) {
        *entry = value.to_le_bytes();
    }
}

fn write_header(header: &mut [u8], layout: &Layout, grid: PlanGrid, occupied: u32) {
    let fields: [&[u8]; 10] = [
        &MAGIC,
        &VERSION.to_le_bytes(),
        &[0; 2],
        &layout.width.to_le_bytes(),
        &layout.height.to_le_bytes(),
        &grid.resolution_nm.to_le_bytes(),
        &grid.origin.x.to_bits().to_le_bytes(),
        &grid.origin.y.to_bits().to_le_bytes(),
        &occupied.to_le_bytes(),
        &[0; 4],
    ];
    let mut rest = header;
    for field in fields {
        let Some((slot, after)) = rest.split_at_mut_checked(field.len()) else { return };
        slot.copy_from_slice(field);
        rest = after;
    }
}
