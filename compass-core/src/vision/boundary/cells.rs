//! The raster of surface, log range and azimuth that boundaries are sought on.

#[cfg(doc)]
use super::Buffers;
#[cfg(doc)]
use crate::base::ladder::NOMINAL_HEIGHT_M;
use crate::base::ladder::{NEAREST_LOG, RUNG};
use crate::base::num::BINS;

/// Rungs of the raster: log range in units of the camera height.
pub const RUNGS: usize = 90;
/// Number of surfaces: floor, ceiling.
pub(super) const SURFACES: usize = 2;
/// Natural logarithm of the near end of rung 0 in units of the camera height: for [`NOMINAL_HEIGHT_M`] the middle of rung
/// [`LEAD`] is rung 0 of the range ladder.
pub(super) const DEEPEST: f32 = NEAREST_LOG - (LEAD as f32 + 0.5) * RUNG;
/// Rungs below rung 0 of the range ladder, for the nominal height.
pub(super) const LEAD: usize = 9;
/// Bytes of [`Buffers::edges`] and of [`Buffers::support`].
pub const CELLS: usize = SURFACES * RUNGS * BINS;
