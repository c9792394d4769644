//! How far the walls are: where they meet the floor and the ceiling, in every direction.
//!
//! frames -> edges on a raster of azimuth and log range, floor and ceiling -> support by neighbouring azimuths:
//! [`BoundaryEvidence`] -> [`RangeLikelihoods`]: per azimuth, the likelihood of the wall standing at each of a ladder of ranges.
//!
//! Ranges are counted in camera heights ([`RangeLikelihoods::row`] brings the height in), and the height of the ceiling as a
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

pub use evidence::{Range, RangeLikelihoods};
pub use survey::{BoundaryEvidence, MAX_CEILINGS};

#[cfg(doc)]
use crate::base::ladder::NOMINAL_HEIGHT_M;
use crate::base::ladder::{NEAREST_LOG, RUNG};
use crate::base::num::BINS;
use crate::base::raster::GrayImage;
use crate::vision::camera::Rig;
use crate::vision::level_frame::LevelFrame;
use crate::vision::projector::CameraView;
use crate::vision::sample::ExclusionMask;

/// Rungs of the ladder in camera heights.
pub const RUNGS: usize = 90;
/// Floor and ceiling.
const SURFACES: usize = 2;
/// Log of the nearer end of rung 0, in camera heights: the middle of rung [`LEAD`] is rung 0 of the range ladder for
/// [`NOMINAL_HEIGHT_M`].
const DEEPEST: f32 = NEAREST_LOG - (LEAD as f32 + 0.5) * RUNG;
/// Rungs below rung 0 of the range ladder at the nominal height.
const LEAD: usize = 9;
/// Bytes of [`Buffers::edges`] and of [`Buffers::support`].
pub const CELLS: usize = SURFACES * RUNGS * BINS;

/// Share of the edges that are within [`EDGE_LEVELS`] of those that exact projection gives, in millionths.
pub const EDGES_PPM: u32 = 900_000;
/// Gray levels by which such edges may differ.
pub const EDGE_LEVELS: u8 = 2;
/// Bound of the differences to real-valued evidence of the same edges, and to real-valued likelihoods of the same
/// evidence, nats.
pub const EVIDENCE_ERROR: f32 = 0.25;

/// Memory lent to a [`BoundaryFinder`]; what it holds before does not matter.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// [`CELLS`] bytes.
    pub edges: &'a mut [u8],
    /// [`CELLS`] bytes.
    pub support: &'a mut [u8],
}

/// Measures ranges in the frames of a rig, one camera after the other.
#[derive(Debug)]
pub struct BoundaryFinder<'a, 'r> {
    buffers: Buffers<'a>,
    rig: &'r Rig,
    level: LevelFrame,
}

impl<'a, 'r> BoundaryFinder<'a, 'r> {
    /// Begins a pair of frames; `rig` has the cameras that will be given, and no others. `None` if a buffer is too
    /// short.
    #[must_use]
    pub fn new(mut buffers: Buffers<'a>, rig: &'r Rig, level: LevelFrame) -> Option<Self> {
        buffers.edges = buffers.edges.get_mut(..CELLS)?;
        buffers.support = buffers.support.get_mut(..CELLS)?;
        buffers.edges.fill(0);
        Some(Self { buffers, rig, level })
    }

    /// Adds what one camera sees: its smoothed frame.
    ///
    /// # Cost
    /// Per surface two looks a bin of 91 samples, each a mean of at most 4.
    pub fn add(&mut self, camera: usize, image: &GrayImage<'_>, red: ExclusionMask<'_>) {
        let seen = CameraView { rig: self.rig, camera, level: self.level, image, excluded: red };
        polar::draw(self.buffers.edges, &seen);
    }

    /// Turns what was seen into evidence, in the lent [`Buffers::support`].
    ///
    /// # Cost
    /// Passes over the [`CELLS`], seven for the support of a cell by its neighbours.
    #[must_use]
    pub fn finish(self) -> BoundaryEvidence<'a> {
        let Buffers { edges, support } = self.buffers;
        let known = support::known(edges);
        support::normalize(edges);
        support::gather(edges, support);
        BoundaryEvidence::of(support, known)
    }
}

#[cfg(test)]
mod tests;
