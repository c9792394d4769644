//! The raster of surface, log range and azimuth that boundaries are sought on.

#[cfg(doc)]
use crate::base::ladder::NOMINAL_HEIGHT_M;
use crate::base::ladder::{NEAREST_LOG, RUNG};
use crate::base::num::{BINS, count_as_i32};

/// Rows of a surface: log range in units of the height of the camera below the ceiling or above the floor, in steps of half
/// a rung, nearest first.
pub const ROWS: usize = 181;
/// Number of surfaces: floor, ceiling.
pub(super) const SURFACES: usize = 2;
/// Rungs below rung 0 of the range ladder, for [`NOMINAL_HEIGHT_M`].
pub(super) const LEAD: usize = 9;
/// Natural logarithm of the range of row 0 in units of the height: for [`NOMINAL_HEIGHT_M`] rung 0 of the range ladder is
/// row `2 LEAD + 1`.
pub(super) const DEEPEST: f32 = NEAREST_LOG - (LEAD as f32 + 0.5) * RUNG;
/// The row of rung 0 of the range ladder for [`NOMINAL_HEIGHT_M`]; those of the next rungs are every second row.
pub const NOMINAL_ROW: usize = 2 * LEAD + 1;
/// Cells of both surfaces: floor first, then by row and bin.
pub const CELLS: usize = SURFACES * ROWS * BINS;

/// The row of a rung of the range ladder for a height in rungs, or `None` outside the raster.
#[must_use]
pub(crate) fn row_of(rung: i32, height: i32) -> Option<usize> {
    half_row_of(2 * rung, height)
}

/// The row of half a rung of the range ladder for a height in rungs, or `None` outside the raster.
#[must_use]
pub(crate) fn half_row_of(half_rungs: i32, height: i32) -> Option<usize> {
    let row = half_rungs + 2 * (count_as_i32(LEAD) - height) + 1;
    usize::try_from(row).ok().filter(|row| *row < ROWS)
}
