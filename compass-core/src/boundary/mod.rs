//! How far the walls are: where they meet the floor and the ceiling, in every direction.
//!
//! frames -> edges on a raster of azimuth and log range, floor and ceiling -> support by neighbouring azimuths:
//! [`Survey`] -> [`Ranges`]: per azimuth, the likelihood of the wall standing at each of a ladder of ranges.
//!
//! Ranges are counted in camera heights ([`Ranges::row`] brings the height in), and the height of the ceiling as a
//! multiple of it: those at which most directions see both boundaries at one range. Furniture and people
//! hide the floor more often than the ceiling, floor joints are no walls, and walls that the plan lacks are seen too:
//! therefore nothing is decided here, and no range is ever impossible.
//!
//! The weights are those of a conditional logit over the rungs of a direction, fitted to simulated frames of two
//! floors (`docs/design.md` says how).

mod evidence;
mod polar;
mod support;
mod survey;

pub use evidence::{Range, Ranges};
pub use survey::{MAX_CEILINGS, Survey};

use crate::camera::Rig;
use crate::num::BINS;
use crate::raster::GrayImage;
use crate::windows::level::{Level, Red};

/// Rungs of the ladder in camera heights.
pub const RUNGS: usize = 90;
/// Floor and ceiling.
const SURFACES: usize = 2;
/// Natural logarithm of the ratio of neighbouring rungs: 71 of them make 0.4 m to 30 m (6.3 % each).
pub const RUNG: f32 = 0.060_809_69;
/// Log of the nearer end of rung 0, in camera heights: the middle of rung [`LEAD`] is 0.4 m for [`NOMINAL_HEIGHT_M`].
const DEEPEST: f32 = -1.321_756 - (LEAD as f32 + 0.5) * RUNG;
/// Rungs below the one of 0.4 m at the nominal height.
const LEAD: usize = 9;
/// Height, in metres, that rungs are counted for: others are shifts.
pub const NOMINAL_HEIGHT_M: f32 = 1.5;
/// Least and largest height of the camera that can be told or tried, metres.
pub const HEIGHTS_M: [f32; 2] = [0.55, 2.4];

/// Bytes of [`Buffers::edges`] and of [`Buffers::support`].
pub const CELLS: usize = SURFACES * RUNGS * BINS;

/// Share of the edges that are within [`EDGE_LEVELS`] of those that exact projection gives, in millionths.
pub const EDGES_PPM: u32 = 900_000;
/// Gray levels by which such edges may differ.
pub const EDGE_LEVELS: u8 = 2;
/// Bound of the differences to real-valued evidence of the same edges, and to real-valued likelihoods of the same
/// evidence, nats.
pub const EVIDENCE_ERROR: f32 = 0.25;

/// Memory lent to a [`Surveyor`]; what it holds before does not matter.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// [`CELLS`] bytes.
    pub edges: &'a mut [u8],
    /// [`CELLS`] bytes.
    pub support: &'a mut [u8],
}

/// Measures ranges in the frames of a rig, one camera after the other.
#[derive(Debug)]
pub struct Surveyor<'a, 'r> {
    buffers: Buffers<'a>,
    rig: &'r Rig,
    level: Level,
}

impl<'a, 'r> Surveyor<'a, 'r> {
    /// Begins a pair of frames; `rig` has the cameras that will be given, and no others. `None` if a buffer is too
    /// short.
    #[must_use]
    pub fn new(mut buffers: Buffers<'a>, rig: &'r Rig, level: Level) -> Option<Self> {
        buffers.edges = buffers.edges.get_mut(..CELLS)?;
        buffers.support = buffers.support.get_mut(..CELLS)?;
        buffers.edges.fill(0);
        Some(Self { buffers, rig, level })
    }

    /// Adds what one camera sees: its smoothed frame.
    ///
    /// # Cost
    /// Per surface two looks a bin of 91 samples, each a mean of at most 4.
    pub fn add(&mut self, camera: usize, image: &GrayImage<'_>, red: Red<'_>) {
        polar::draw(self.buffers.edges, self.rig, camera, self.level, (image, red));
    }

    /// Turns what was seen into evidence, in the lent [`Buffers::support`].
    ///
    /// # Cost
    /// Passes over the [`CELLS`], seven for the support of a cell by its neighbours.
    #[must_use]
    pub fn finish(self) -> Survey<'a> {
        let Buffers { edges, support } = self.buffers;
        let known = support::known(edges);
        support::normalize(edges);
        support::gather(edges, support);
        Survey::of(support, known)
    }
}

/// The shift in rungs of a camera height in metres: 0 for [`NOMINAL_HEIGHT_M`], bounded by [`HEIGHTS_M`].
#[must_use]
pub fn height_rungs(height_m: f32) -> i8 {
    let bounded = if height_m >= HEIGHTS_M[0] { height_m.min(HEIGHTS_M[1]) } else { HEIGHTS_M[0] };
    libm::roundf(libm::logf(bounded / NOMINAL_HEIGHT_M) / RUNG) as i8
}

/// The height in metres that a shift in rungs stands for; [`height_rungs`] is within half a rung of it: 3 %.
#[must_use]
pub fn height_m(rungs: i8) -> f32 {
    NOMINAL_HEIGHT_M * libm::expf(f32::from(rungs) * RUNG)
}

#[cfg(test)]
mod tests;
