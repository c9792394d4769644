//! Sobel gradient, thresholded.

use super::cell::{MAGNITUDE_SHIFT, VERTICAL};
use crate::raster::BitMask;

/// Fills the cells of one row from the smoothed rows above, at and below it.
///
/// Magnitudes below `threshold` become 0, and so do the first and the last cell: walks end there.
#[inline(always)]
pub(super) fn gradient_row([above, row, below]: [&[u8]; 3], threshold: u16, cells: &mut [u16]) {
    let Some(n) = cells.len().checked_sub(2) else { return cells.fill(0) };
    if above.len() < n + 2 || row.len() < n + 2 || below.len() < n + 2 {
        return;
    }
    let (a0, a1, a2) = (&above[..n], &above[1..=n], &above[2..n + 2]);
    let (b0, b2) = (&row[..n], &row[2..n + 2]);
    let (c0, c1, c2) = (&below[..n], &below[1..=n], &below[2..n + 2]);
    for (i, cell) in cells[1..=n].iter_mut().enumerate() {
        let at = |r: &[u8]| i16::from(r[i]);
        let (falling, rising) = (at(c2) - at(a0), at(a2) - at(c0));
        let dx = (falling + rising + 2 * (at(b2) - at(b0))).unsigned_abs();
        let dy = (falling - rising + 2 * (at(c1) - at(a1))).unsigned_abs();
        let magnitude = dx + dy;
        let kept = if magnitude < threshold { 0 } else { magnitude };
        let axis = if dx >= dy { VERTICAL } else { 0 };
        *cell = kept << MAGNITUDE_SHIFT | axis;
    }
    cells[0] = 0;
    cells[n + 1] = 0;
}

/// Clears the cells of row `y` outside `mask`, without branches: eight cells make a vector.
#[inline(always)]
pub(super) fn mask_row(mask: &BitMask<'_>, y: u32, cells: &mut [u16]) {
    let clear = |bits: u8, cells: &mut [u16]| {
        for (bit, cell) in cells.iter_mut().enumerate() {
            *cell &= (u16::from(bits) >> bit & 1).wrapping_neg();
        }
    };
    let (eights, rest) = cells.as_chunks_mut::<8>();
    let mut bytes = mask.row(y).iter();
    for (cells, bits) in eights.iter_mut().zip(&mut bytes) {
        clear(*bits, cells);
    }
    clear(bytes.next().copied().unwrap_or(0), rest);
}
