//! Boxes: pairs of edges, scored as windows by cues inside and beside them.

use super::edges::{Edge, FINE};
use super::tuning::{
    BIAS, BOX_KNOWN_TENTHS, CONTRAST, FLANK_EIGHTHS, FLANK_KNOWN_TENTHS, HIGH_DEG, INSIDE_HALVES, LEAST_ROWS,
    LINTEL, LOW_DEG, NARROW_HALVES, NARROW_LOG2, NARROWEST_DEG, NAT, OUTSIDE_HALVES, SHARED_DEG, TEXTURE,
    WIDE_HALVES, WIDE_LOG2,
};
use crate::base::num::{LogOdds, LogWeight, count_as_i32, index_of, log_odds};
use crate::vision::panorama::{Resolution, TOP_DEG};
use bytemuck::{Pod, Zeroable};

/// Largest number of columns sampled of a box or of a flank.
const MOST_COLUMNS: usize = 32;
/// Largest number of rows searched for lintel or sill, at the finest resolution.
const MOST_ROWS: usize = (OUTSIDE_HALVES + INSIDE_HALVES) * 4 / 2;

/// A box in the panorama: columns `start..end` (`end` may exceed the number of columns: azimuth wraps), rows
/// `top..bottom`, and its score as a window.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct WindowBox {
    pub(super) start: u16,
    pub(super) end: u16,
    pub(super) top: u16,
    pub(super) bottom: u16,
    pub(super) score: LogOdds,
    /// Index of the next box in the list of a column.
    pub(super) next: u16,
}

impl WindowBox {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self { start: 0, end: 0, top: 0, bottom: 0, score: LogOdds::ZERO, next: 0 };

    /// First column and the one after the last, clockwise; the latter may exceed the number of columns.
    #[must_use]
    pub const fn columns(&self) -> [u16; 2] {
        [self.start, self.end]
    }

    /// First row and the one after the last, downwards.
    #[must_use]
    pub const fn rows(&self) -> [u16; 2] {
        [self.top, self.bottom]
    }

    /// Log odds that the box is a window.
    #[must_use]
    pub const fn score(&self) -> LogOdds {
        self.score
    }

    pub(super) fn width(&self) -> usize {
        usize::from(self.end - self.start)
    }
}

/// The planes of a panorama.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planes<'a> {
    pub(super) rank: &'a [u8],
    pub(super) texture: &'a [u8],
    pub(super) resolution: Resolution,
}

/// Sums over a region of the planes.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    cells: u32,
    known: u32,
    rank: u32,
    texture: u32,
}

impl Sums {
    /// Mean rank and texture in 1/16 of a level.
    #[expect(clippy::cast_possible_truncation, reason = "the mean of bytes, in 1/16")]
    fn means(&self) -> (i32, i32) {
        let mean = |sum: u32| (u64::from(sum) * 16 / u64::from(self.known.max(1))) as i32;
        (mean(self.rank), mean(self.texture))
    }
}

impl Planes<'_> {
    /// Cells of a column between two rows; `column` may be up to twice the number of columns. A conditional subtraction
    /// wraps it, because a division would cost more than the cells.
    #[inline(always)]
    fn column<'p>(&self, plane: &'p [u8], column: usize, rows: &core::ops::Range<usize>) -> &'p [u8] {
        let columns = self.resolution.columns();
        let column = if column < columns { column } else { column - columns };
        let start = column * self.resolution.rows();
        plane.get(start + rows.start..start + rows.end).unwrap_or(&[])
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "a column has at most 260 rows")]
    fn sums(&self, rows: &core::ops::Range<usize>, columns: core::ops::Range<usize>) -> Sums {
        let mut sums = Sums::default();
        for column in sampled(columns) {
            let rank = self.column(self.rank, column, rows);
            sums.cells += rank.len() as u32;
            sums.rank += total(rank);
            sums.known += rank.len() as u32 - unknown(rank);
            sums.texture += total(self.column(self.texture, column, rows));
        }
        sums
    }
}

/// Columns sampled of a range: all of a narrow range, at most [`MOST_COLUMNS`] at an even stride of a wide one.
fn sampled(columns: core::ops::Range<usize>) -> core::iter::StepBy<core::ops::Range<usize>> {
    let step = columns.len().div_ceil(MOST_COLUMNS).max(1);
    columns.step_by(step)
}

/// Sum of all cells, by groups of 16 and 8 that compile to one vector instruction each.
#[inline(always)]
fn total(cells: &[u8]) -> u32 {
    let (sixteens, rest) = cells.as_chunks::<16>();
    let (eights, rest) = rest.as_chunks::<8>();
    let mut sum = 0;
    for part in sixteens {
        sum += u32::from(part.iter().map(|cell| u16::from(*cell)).sum::<u16>());
    }
    for part in eights {
        sum += u32::from(part.iter().map(|cell| u16::from(*cell)).sum::<u16>());
    }
    sum + rest.iter().map(|cell| u32::from(*cell)).sum::<u32>()
}

/// Number of unknown cells.
#[inline(always)]
fn unknown(cells: &[u8]) -> u32 {
    let (sixteens, rest) = cells.as_chunks::<16>();
    let mut sum = 0;
    for part in sixteens {
        sum += u32::from(part.iter().map(|cell| u8::from(*cell == 0)).sum::<u8>());
    }
    sum + rest.iter().map(|cell| u32::from(*cell == 0)).sum::<u32>()
}

/// The scored box between two edges; `None` if its shape is not that of a window or too much of it is unknown.
#[inline(always)]
pub(super) fn propose(planes: &Planes<'_>, left: &Edge, right: &Edge) -> Option<WindowBox> {
    let per_degree = planes.resolution.per_degree_i32();
    let round = |fine: i32| (fine + FINE / 2).div_euclid(FINE);
    let (start, end) = (round(left.x), round(right.x));
    let (top, bottom) = (left.top.max(right.top), left.bottom.min(right.bottom));
    let shorter = (left.bottom - left.top).min(right.bottom - right.top);
    let row_of = |elevation: i32| (TOP_DEG - elevation) * per_degree * FINE;
    if (left.rim && right.rim)
        || bottom - top < (shorter / 2).max(SHARED_DEG * per_degree * FINE)
        || top > row_of(HIGH_DEG)
        || bottom < row_of(LOW_DEG)
        || end - start < NARROWEST_DEG * per_degree
    {
        return None;
    }
    let (top, bottom) = (round(top).max(0), round(bottom).min(count_as_i32(planes.resolution.rows())));
    if bottom - top < LEAST_ROWS {
        return None;
    }
    scored(planes, index_of(start), index_of(end), index_of(top), index_of(bottom))
}

#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "columns are below 2^12 and rows below 2^9")]
fn scored(planes: &Planes<'_>, start: usize, end: usize, top: usize, bottom: usize) -> Option<WindowBox> {
    let (width, height) = (end - start, bottom - top);
    let inside = planes.sums(&(top..bottom), start..end);
    if 10 * inside.known < BOX_KNOWN_TENTHS * inside.cells {
        return None;
    }
    let (rank, texture) = inside.means();
    let (flank_rank, flank_texture) = flanks(planes, start..end, &(top..bottom))?;
    let (lintel, lintel_row) = strongest_row(planes, start..end, above(planes, top, height));
    let (sill, sill_row) = strongest_row(planes, start..end, below(planes, bottom, height));
    let borders =
        (lintel + sill).cast_signed() * NAT / (2 * 255 * count_as_i32(sampled(start..end).len())).max(1);
    let per_level = |difference: i32| difference * NAT / (255 * 16);
    let octaves = log2_ratio(width as u32, height as u32);
    let wide = (octaves - WIDE_LOG2).max(0);
    let narrow = (NARROW_LOG2 - octaves).max(0);
    let cues = LINTEL * borders
        + CONTRAST * per_level(rank - flank_rank)
        + TEXTURE * per_level(texture - flank_texture)
        - WIDE_HALVES * wide / 2
        - NARROW_HALVES * narrow / 2;
    let score = LogWeight::from_bits(cues) + BIAS;
    Some(WindowBox {
        start: start as u16,
        end: end as u16,
        top: top.min(lintel_row) as u16,
        bottom: bottom.max(sill_row + 1) as u16,
        score: log_odds(score),
        next: u16::MAX,
    })
}

/// Mean rank of the flanks of a box, and the larger mean texture of the two; `None` if both are mostly unknown.
#[inline(always)]
fn flanks(
    planes: &Planes<'_>,
    columns: core::ops::Range<usize>,
    rows: &core::ops::Range<usize>,
) -> Option<(i32, i32)> {
    let per_degree = planes.resolution.per_degree();
    let [least, most] = FLANK_EIGHTHS.map(|eighths| (eighths * per_degree).div_ceil(8));
    let width = columns.len().div_ceil(2).max(least).min(most);
    // Leave a gap of one cell to the edge.
    let left = columns.start + planes.resolution.columns() - 1 - width;
    let right = columns.end + 1;
    // An array, because a closure would not be inlined here.
    let sides = [planes.sums(rows, left..left + width), planes.sums(rows, right..right + width)];
    let (mut rank, mut texture, mut seen) = (0, i32::MIN, 0);
    for side in sides.iter().filter(|side| 10 * side.known > FLANK_KNOWN_TENTHS * side.cells) {
        let (side_rank, side_texture) = side.means();
        rank += side_rank;
        texture = texture.max(side_texture);
        seen += 1;
    }
    (seen > 0).then(|| (rank / seen, texture))
}

/// Rows searched inside a box from its top and from its bottom.
fn inner(planes: &Planes<'_>, height: usize) -> usize {
    (INSIDE_HALVES * planes.resolution.per_degree() / 2).min(height / 4)
}

/// Rows searched for the lintel.
fn above(planes: &Planes<'_>, top: usize, height: usize) -> core::ops::Range<usize> {
    let outside = OUTSIDE_HALVES * planes.resolution.per_degree() / 2;
    top.saturating_sub(outside)..top + inner(planes, height)
}

/// Rows searched for the sill.
fn below(planes: &Planes<'_>, bottom: usize, height: usize) -> core::ops::Range<usize> {
    let outside = OUTSIDE_HALVES * planes.resolution.per_degree() / 2;
    bottom - inner(planes, height)..(bottom + outside).min(planes.resolution.rows())
}

/// The row with the largest texture across some columns: its sum, and the row.
#[inline(always)]
fn strongest_row(
    planes: &Planes<'_>,
    columns: core::ops::Range<usize>,
    rows: core::ops::Range<usize>,
) -> (u32, usize) {
    let mut totals = [0_u16; MOST_ROWS];
    for column in sampled(columns) {
        // The sum of 32 columns of at most 255 fits.
        for (total, cell) in totals.iter_mut().zip(planes.column(planes.texture, column, &rows)) {
            *total = total.wrapping_add(u16::from(*cell));
        }
    }
    let mut best = (0, rows.start);
    for (total, row) in totals.iter().zip(rows) {
        if *total > best.0 {
            best = (*total, row);
        }
    }
    (u32::from(best.0), best.1)
}

/// log2(a / b) in 1/256, clamped to -5 to 4.
fn log2_ratio(a: u32, b: u32) -> i32 {
    (log2(a.max(1)) - log2(b.max(1))).clamp(-5 * NAT, 4 * NAT)
}

/// log2 in 1/256, rounded down, by repeated squaring.
#[expect(clippy::cast_possible_truncation, reason = "mantissas are below 2^16")]
fn log2(value: u32) -> i32 {
    let whole = value.ilog2();
    // Q15, 1 <= mantissa < 2.
    let mut mantissa = (u64::from(value) << 15 >> whole) as u32;
    let mut log = whole.cast_signed();
    for _ in 0..8 {
        mantissa = (mantissa * mantissa) >> 15;
        let bit = mantissa >> 16;
        log = 2 * log + bit.cast_signed();
        mantissa >>= bit;
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log2_is_within_a_256th() {
        for value in 1..5000_u32 {
            let exact = f64::from(value).log2() * 256.0;
            assert!((f64::from(log2(value)) - exact).abs() <= 1.05, "{value}: {} {exact}", log2(value));
        }
    }
}
