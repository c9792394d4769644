//! The rasters of surface, log range and azimuth that boundaries are sought on.

#[cfg(doc)]
use crate::base::ladder::NOMINAL_HEIGHT_M;
use crate::base::ladder::{NEAREST_LOG, RUNG};
use crate::base::num::{BINS, count_as_i32};

/// Rows of the raster of gray levels, for each surface: log range in units of the height of the camera above the floor or of
/// the ceiling above the camera, in steps of half a rung, nearest first.
pub const ROWS: usize = 181;
/// Rungs of evidence, for each surface: every second row of the raster, from the second on.
pub const RUNGS: usize = ROWS / 2;
/// Number of surfaces: floor, ceiling.
pub(super) const SURFACES: usize = 2;
/// The rung of evidence of the first range, 0.4 m, for [`NOMINAL_HEIGHT_M`].
pub const NOMINAL_RUNG: usize = 9;
/// Natural logarithm of the range of row 0 in units of the height.
pub(super) const DEEPEST: f32 = NEAREST_LOG - (NOMINAL_RUNG as f32 + 0.5) * RUNG;
/// Cells of the raster: floor first, then by row and bin.
pub const RASTER_CELLS: usize = SURFACES * ROWS * BINS;
/// Cells of evidence: floor first, then by rung and bin.
pub const CELLS: usize = SURFACES * RUNGS * BINS;

/// The rung of evidence of a rung of the range ladder for a height in rungs; `None` outside.
#[must_use]
pub(crate) fn rung_of(range_rung: i32, height: i32) -> Option<usize> {
    let rung = range_rung - height + count_as_i32(NOMINAL_RUNG);
    usize::try_from(rung).ok().filter(|rung| *rung < RUNGS)
}

/// The row of the raster of a rung of evidence.
#[must_use]
pub(super) const fn row_of(rung: usize) -> usize {
    2 * rung + 1
}
