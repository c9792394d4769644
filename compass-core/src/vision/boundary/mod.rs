//! Ranges of walls, from the boundaries between wall and floor and between wall and ceiling.
//!
//! frames -> gray levels on a raster of azimuth and log range, one for floor and one for ceiling -> oriented, signed edges ->
//! [`BoundaryEvidence`]: per surface, azimuth and range rung the log-likelihood ratio of a boundary -> for two heights,
//! [`RangeLikelihoods`].
//!
//! 1. Differences of gray levels along the range axis, over one and four rows, keep their sign and are averaged over seven
//!    bins along several slopes: texture cancels, a faint but long edge between floor and wall remains.
//! 2. Strength (relative to the surface's own edges) and significance of these means, for the floor also whether the nearer
//!    side looks like the floor at the camera's feet and the farther one like the walls, make a conditional logit over the rungs
//!    and slopes of a direction.
//! 3. Its probabilities are spread by the tolerance of plans: walls are thicker than drawn and have skirting boards.
//!
//! Ranges are in units of the camera height for the floor and of the ceiling's height above the camera for the ceiling: the
//! surfaces are independent sources, and no height is decided here. Furniture and people hide the floor, and walls that the
//! plan lacks are seen too: an outlier rate keeps every range possible.
//!
//! # Accuracy
//! Logarithms and exponentials come from tables whose entries micromath computes: its relative error, below 0.003, is far
//! below their quantum of 1/64.
//!
//! # References
//! The logit: D. L. `McFadden`, "Conditional Logit Analysis of Qualitative Choice Behavior", 1974. `docs/design.md` describes
//! the features and their weights.

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
/// Gray levels to [`CellNats`] per surface, rung and bin.
///
/// # Accuracy
/// Ranges of a synthetic room are a rung, 6 %, short, because the tolerance expects the edge beyond the drawn wall: median
/// error below 6 %, 90th percentile below 10 % (test `ranges_of_a_room_are_found_level_and_tilted`). [`GRAY_PPM`] and [`EVIDENCE_PPM`] bound the rounding, which `compass
/// compare` checks.
///
/// # Cost
/// Measured as `ranges` in `targets/budget.txt`.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Bearing, Camera, CameraError, ExclusionMask, GrayImage, Intrinsics, Rig, View};
/// # use compass_core::base::num::CellNats;
/// # use compass_core::vision::boundary::{BoundaryFinder, Buffers, CELLS, RASTER_CELLS, Work};
/// # use compass_core::vision::level_frame::LevelFrame;
/// // A blank frame of camera 0, which looks ahead.
/// let intrinsics = Intrinsics { fx: 10.0, fy: 10.0, cx: 19.5, cy: 19.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 40, 40);
/// let (rig, level) = (Rig::new([Some(view), None])?, LevelFrame::new(&-Bearing::y()).unwrap());
/// let (mut gray, mut work) = (vec![0; RASTER_CELLS], Box::<Work>::default());
/// let mut cells = vec![CellNats::ZERO; CELLS];
/// let buffers = Buffers { gray: &mut gray, work: &mut work, evidence: &mut cells };
/// let mut finder = BoundaryFinder::new(buffers, &rig, level).unwrap();
/// finder.add(0, &GrayImage::new(&[99; 1600], 40, 40).unwrap(), ExclusionMask::Unknown);
/// let evidence = finder.finish();
/// assert!(evidence.known()[0] && !evidence.known()[180]);
/// // No range of a blank wall is much likelier than another.
/// assert!(evidence.cells().iter().all(|ratio| *ratio < 1));
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
    /// For each of the [`CELLS`], 70 additions and products, and 6 table look-ups for each of 3 slopes.
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
