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

mod block;
mod cells;
mod evidence;
mod logarithms;
mod logit;
mod polar;
mod ranges;
mod region;
mod tuning;

pub(crate) use cells::rung_of;
pub use cells::{CELLS, NOMINAL_RUNG, RASTER_CELLS, ROWS, RUNGS};
pub use evidence::BoundaryEvidence;
pub use ranges::{RangeEstimate, RangeLikelihoods};
pub(crate) use tuning::CEILING_SHIFT;

use crate::base::num::{BINS, CellNats};
use crate::base::raster::GrayImage;
use crate::vision::camera::Rig;
use crate::vision::level_frame::LevelFrame;
use crate::vision::projector::CameraView;
use crate::vision::sample::ExclusionMask;
use bytemuck::{Pod, Zeroable};

/// Share, in millionths, of the gray levels of the raster within [`GRAY_LEVELS`] of those of exact projection.
pub const GRAY_PPM: u32 = 900_000;
/// Bound of the difference of such gray levels.
pub const GRAY_LEVELS: u8 = 2;
/// Share, in millionths, of the evidence within [`EVIDENCE_ERROR`] of `f64` evidence of the same raster.
pub const EVIDENCE_PPM: u32 = 990_000;
/// Bound, in nats, of the difference of such evidence.
pub const EVIDENCE_ERROR: f32 = 0.25;

/// Memory lent to a [`BoundaryFinder`]; its initial contents are ignored.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// Gray levels of the raster: [`RASTER_CELLS`] bytes.
    pub gray: &'a mut [u8],
    /// Working memory.
    pub work: &'a mut Work,
    /// The result: [`CELLS`] values.
    pub evidence: &'a mut [CellNats],
}

/// Working memory of a [`BoundaryFinder`]; any bytes.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Work {
    logit: logit::Work,
    /// By surface and row, a bit for each bin that camera 1 sees.
    owner: [[u8; polar::OWNER_BYTES]; cells::SURFACES * ROWS],
    padding: [u8; 2],
}

impl Default for Work {
    fn default() -> Self {
        Zeroable::zeroed()
    }
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
        buffers.gray = buffers.gray.get_mut(..RASTER_CELLS)?;
        buffers.evidence = buffers.evidence.get_mut(..CELLS)?;
        buffers.gray.fill(0);
        buffers.work.owner.as_flattened_mut().fill(0);
        Some(Self { buffers, rig, level })
    }

    /// Adds the frame of one camera. Ignores a camera that the rig lacks.
    ///
    /// # Cost
    /// Per surface and bin 181 rows, each the mean of at most 4 pixel samples.
    #[inline(always)]
    pub fn add(&mut self, camera: usize, image: &GrayImage<'_>, excluded: ExclusionMask<'_>) {
        let seen = CameraView { rig: self.rig, camera, level: self.level, image, excluded };
        polar::draw(self.buffers.gray, &mut self.buffers.work.owner, &seen);
    }

    /// Computes the evidence from the gray levels of all frames added, in the lent [`Buffers::evidence`].
    ///
    /// # Cost
    /// For each of the [`CELLS`], 70 additions and products, and 6 table look-ups for each of 5 slopes.
    #[must_use]
    #[inline(always)]
    pub fn finish(self) -> BoundaryEvidence<'a> {
        let Buffers { gray, work, evidence } = self.buffers;
        work.logit.logarithms.fill();
        let (floor, ceiling) = gray.split_at_checked(ROWS * BINS).unwrap_or_default();
        let region = region::ratios(floor, ceiling);
        let owners = work.owner.split_at_checked(ROWS).unwrap_or_default();
        let weighings = [
            (
                logit::Surface { gray: floor, owner: owners.0 },
                &[tuning::FLOOR_BY_REGION, tuning::FLOOR][..],
                (tuning::FLOOR_TOLERANCE.0, &tuning::FLOOR_TOLERANCE.1[..]),
            ),
            (
                logit::Surface { gray: ceiling, owner: owners.1 },
                &[tuning::CEILING][..],
                (tuning::CEILING_TOLERANCE.0, &tuning::CEILING_TOLERANCE.1[..]),
            ),
        ];
        for ((surface, variants, tolerance), cells) in
            weighings.into_iter().zip(evidence.chunks_exact_mut(RUNGS * BINS))
        {
            let weighing = logit::Weighing { variants, region: &region, tolerance };
            work.logit.weigh(&surface, &weighing, cells);
        }
        BoundaryEvidence::of(evidence)
    }
}

#[cfg(test)]
mod tests;
