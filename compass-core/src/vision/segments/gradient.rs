//! Sobel gradient: thresholded magnitudes of whole rows, and both components at single pixels.

use super::cell::{MAGNITUDE_SHIFT, VERTICAL};
use super::walk::{Cells, Position};
use crate::base::raster::BitMask;

/// Computes the cells of one row from the smoothed rows above, at and below it.
///
/// Magnitudes below `threshold` are set to 0, and so are the first and the last cell, so that walks end there.
#[inline(always)]
pub(super) fn gradient_row([above, row, below]: [&[u8]; 3], threshold: u16, cells: &mut [u16]) {
    let [first, cells @ .., last] = cells else { return cells.fill(0) };
    let rows = triples(above).zip(triples(row)).zip(triples(below));
    for (cell, ((above, row), below)) in cells.iter_mut().zip(rows) {
        let [[a0, a1, a2], [b0, _, b2], [c0, c1, c2]] = [above, row, below].map(|row| row.map(i16::from));
        let (falling, rising) = (c2 - a0, a2 - c0);
        let dx = (falling + rising + 2 * (b2 - b0)).unsigned_abs();
        let dy = (falling - rising + 2 * (c1 - a1)).unsigned_abs();
        let magnitude = dx + dy;
        let kept = if magnitude < threshold { 0 } else { magnitude };
        let axis = if dx >= dy { VERTICAL } else { 0 };
        *cell = kept << MAGNITUDE_SHIFT | axis;
    }
    (*first, *last) = (0, 0);
}

/// Windows of three neighbouring cells of a row.
#[inline(always)]
pub(super) fn triples<T: Copy>(row: &[T]) -> impl Iterator<Item = [T; 3]> {
    let from = |start: usize| row.get(start..).unwrap_or_default();
    row.iter().zip(from(1)).zip(from(2)).map(|((a, b), c)| [*a, *b, *c])
}

/// Clears the cells of row `y` outside `mask`, without branches, eight cells per vector.
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

/// Sobel gradient of the smoothed image at a pixel; 0 on the border and outside.
#[inline(always)]
pub(super) fn sobel(smoothed: &[u8], cells: &Cells<'_>, p: Position) -> (i32, i32) {
    let width = cells.width as isize;
    let here = p.y as isize * width + p.x as isize;
    let at = |offset: isize| smoothed.get((here + offset).cast_unsigned()).copied().map_or(0, i32::from);
    if p.x < 1 || p.y < 1 || p.x + 1 >= cells.width || p.y + 1 >= cells.height {
        return (0, 0);
    }
    let falling = at(width + 1) - at(-width - 1);
    let rising = at(1 - width) - at(width - 1);
    (falling + rising + 2 * (at(1) - at(-1)), falling - rising + 2 * (at(width) - at(-width)))
}
