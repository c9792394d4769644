//! Ranges of walls, from the boundaries between wall and floor and between wall and ceiling.
//!
//! frames -> edges on a raster of azimuth and log range, one for floor and one for ceiling -> support by neighbouring
//! azimuths: [`BoundaryEvidence`] -> [`RangeLikelihoods`]: per azimuth, the log-likelihood ratio of a wall at each range
//! rung.
//!
//! Ranges are in units of the camera height, which [`RangeLikelihoods::row`] applies, and the height of the ceiling above
//! the camera is a multiple of it: the vote of all directions gives the multiples at which both boundaries agree on the
//! range. Furniture and people hide the floor more often than the ceiling, floor joints resemble boundaries, and walls that
//! the plan lacks are seen too: therefore this stage makes no decision, and an outlier rate keeps every range possible.
//!
//! The weights are those of a conditional logit over the rungs of a direction, fitted to simulated frames of two floors
//! (`docs/design.md`).

mod cells;
mod evidence;
mod polar;
mod ranges;
mod support;
mod tuning;

pub use cells::{CELLS, RUNGS};
pub use evidence::{BoundaryEvidence, MAX_CEILINGS};
pub use ranges::{RangeEstimate, RangeLikelihoods};

use crate::base::raster::GrayImage;
use crate::vision::camera::Rig;
use crate::vision::level_frame::LevelFrame;
use crate::vision::projector::CameraView;
use crate::vision::sample::ExclusionMask;

/// Share, in millionths, of the edges within [`EDGE_LEVELS`] of those of exact projection.
pub const EDGES_PPM: u32 = 900_000;
/// Bound of the difference of such edges, gray levels.
pub const EDGE_LEVELS: u8 = 2;
/// Bound, in nats, of the difference between evidence and `f64` evidence of the same edges, and between log-likelihood
/// ratios and `f64` ones of the same evidence.
pub const EVIDENCE_ERROR: f32 = 0.25;

/// Memory lent to a [`BoundaryFinder`]; its initial contents are ignored.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// [`CELLS`] bytes.
    pub edges: &'a mut [u8],
    /// [`CELLS`] bytes.
    pub support: &'a mut [u8],
}

/// Finds the boundaries of floor and ceiling in the frames of a rig, added one camera at a time.
///
/// # Formats
/// Gray levels to [`SupportNats`](crate::base::num::SupportNats) per surface, rung and bin.
///
/// # Accuracy
/// Ranges of a synthetic room: median error below 2 %, 90th percentile below 6 %, a rung (test
/// `ranges_of_a_room_are_found_level_and_tilted`). [`EDGES_PPM`] and [`EVIDENCE_ERROR`] bound the rounding, which `compass
/// compare` checks.
///
/// # Cost
/// Measured as `ranges` in `targets/budget.txt`.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Bearing, Camera, CameraError, ExclusionMask, GrayImage, Intrinsics, Rig, View};
/// # use compass_core::vision::boundary::{BoundaryFinder, Buffers, CELLS};
/// # use compass_core::vision::level_frame::LevelFrame;
/// // A blank frame of camera 0, which looks ahead.
/// let intrinsics = Intrinsics { fx: 10.0, fy: 10.0, cx: 19.5, cy: 19.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 40, 40);
/// let (rig, level) = (Rig::new([Some(view), None])?, LevelFrame::new(&-Bearing::y()).unwrap());
/// let buffers = Buffers { edges: &mut vec![0; CELLS], support: &mut vec![0; CELLS] };
/// let mut finder = BoundaryFinder::new(buffers, &rig, level).unwrap();
/// finder.add(0, &GrayImage::new(&[99; 1600], 40, 40).unwrap(), ExclusionMask::Unknown);
/// let evidence = finder.finish();
/// assert!(evidence.known()[0] && !evidence.known()[180]);
/// assert!(evidence.cells().iter().all(|support| *support == 0));
/// # Ok::<(), CameraError>(())
/// ```
#[derive(Debug)]
pub struct BoundaryFinder<'a, 'r> {
    buffers: Buffers<'a>,
    rig: &'r Rig,
    level: LevelFrame,
}

impl<'a, 'r> BoundaryFinder<'a, 'r> {
    /// Starts a pair of frames. `rig` has the cameras whose frames will be added, and no others. `None` if a buffer is too
    /// short.
    #[must_use]
    pub fn new(mut buffers: Buffers<'a>, rig: &'r Rig, level: LevelFrame) -> Option<Self> {
        buffers.edges = buffers.edges.get_mut(..CELLS)?;
        buffers.support = buffers.support.get_mut(..CELLS)?;
        buffers.edges.fill(0);
        Some(Self { buffers, rig, level })
    }

    /// Adds the smoothed frame of one camera. Ignores a camera that the rig lacks.
    ///
    /// # Cost
    /// Per surface and bin two azimuth samples of 91 rung ends, each the mean of at most 4 pixel samples.
    pub fn add(&mut self, camera: usize, image: &GrayImage<'_>, excluded: ExclusionMask<'_>) {
        let seen = CameraView { rig: self.rig, camera, level: self.level, image, excluded };
        polar::draw(self.buffers.edges, &seen);
    }

    /// Computes the evidence from the edges of all frames added, in the lent [`Buffers::support`].
    ///
    /// # Cost
    /// A fixed number of passes over the [`CELLS`], seven of them for the support by neighbours.
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
