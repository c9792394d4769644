//! How the pipeline works, and what that costs.

use super::error::{Error, Field};
use crate::pose::Headings;
#[cfg(doc)]
use crate::pose::MAX_POOL;
use crate::pose::locate::Effort;
use crate::vision::camera::Rig;
use crate::vision::panorama::Resolution;

/// Where smoothed frames come from: windows in large frames are sought in them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Smoothing {
    /// Frames are taken as they are.
    Off,
    /// Each stage smooths its frames anew: no memory beside that of other stages.
    Again,
    /// Those of the detector are kept: a byte a pixel of both cameras. The same bits as [`Again`](Self::Again).
    Kept,
}

/// How the pipeline works. Start from a preset and change what differs.
///
/// What settings cost and find, on 114 pairs of frames (80 simulated, 8 rendered by another program, 26 of real rooms and of
/// a photorealistic flat), the camera's height unknown, and known: found within 1 m and 30 degrees; of those with a
/// probability above one half, how many are right. `docs/measured.md` has each set by itself.
///
/// | settings | frames | RAM | found | right of those sure | instructions, Cortex-M7 |
/// |---|---|---|---|---|---|
/// | [`FULL`](Self::FULL) | as recorded | 9.2 MB | 77, 87 | 70 of 88, 80 of 89 | |
/// | [`FULL`](Self::FULL) | 368 x 360 | 1463 KiB | 71, 82 | 65 of 75, 68 of 76 | |
/// | [`BOARD`](Self::BOARD) | 368 x 360 | 419 KiB | 72, 69 | 65 of 76, 58 of 64 | see `targets/README.md` |
/// | [`BOARD`](Self::BOARD), [`Smoothing::Off`] | 368 x 360 | 419 KiB | 70, 67 | 64 of 79, 59 of 67 | 12.3 M less |
/// | [`BOARD`](Self::BOARD), `lens_field_mask` | 368 x 360 | 435 KiB | 72, 67 | 62 of 71, 58 of 63 | |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Finest cells of the panorama; lenses of fewer than 3 pixels a degree have [`Resolution::COARSE`] in any case.
    pub panorama: Resolution,
    /// Room for segments of each frame, 1 to 65536; if there are more, the first ones found.
    pub segments: usize,
    /// Room for near-vertical segments of both frames, 1 to 65536.
    pub vertical_segments: usize,
    /// Room for pairs of edges that may be windows, 1 to 65536.
    pub boxes: usize,
    /// Room for windows all around, 1 to 65536.
    pub windows: usize,
    /// Whether frames are smoothed where windows are sought: 12 million instructions for two frames of 368 x 360 on a
    /// Cortex-M7, and two to three more pairs of a hundred found.
    pub smoothing: Smoothing,
    /// Whether segments are sought within 95 degrees of the optical axis alone: a bit of memory a pixel.
    pub lens_field_mask: bool,
    /// Largest angle between a segment and the vertical that it points to, degrees, 0.1 to 45; 2,
    /// and 3 for coarse lenses, if `None`.
    pub inlier_tolerance_deg: Option<f32>,
    /// Headings at which candidates are scored.
    pub headings: Headings,
    /// Poses that the search keeps for refinement, 64 to [`MAX_POOL`].
    pub pool: usize,
    /// Work of the search where the camera's height is not known.
    pub effort: Effort,
    /// Work of the search where it is.
    pub effort_at_known_height: Effort,
}

impl Settings {
    /// What pays on a computer: all that helps.
    pub const FULL: Self = Self {
        panorama: Resolution::FINE,
        segments: 8192,
        vertical_segments: 2048,
        boxes: 8192,
        windows: 256,
        smoothing: Smoothing::Kept,
        lens_field_mask: true,
        inlier_tolerance_deg: None,
        headings: Headings::N90,
        pool: 512,
        effort: Effort::FULL,
        effort_at_known_height: Effort::FULL,
    };

    /// What pays on a microcontroller with 512 KiB of RAM, for frames of 368 x 360 pixels.
    pub const BOARD: Self = Self {
        panorama: Resolution::COARSE,
        segments: 512,
        vertical_segments: 256,
        boxes: 1024,
        windows: 64,
        smoothing: Smoothing::Again,
        lens_field_mask: false,
        inlier_tolerance_deg: None,
        headings: Headings::N40,
        pool: 64,
        effort: Effort::SOME,
        effort_at_known_height: Effort::LITTLE,
    };

    /// Whether each field is in its range.
    pub(super) fn check_ranges(&self) -> Result<(), Error> {
        let counts = [
            (Field::Segments, self.segments),
            (Field::VerticalSegments, self.vertical_segments),
            (Field::Boxes, self.boxes),
            (Field::Windows, self.windows),
        ];
        for (field, count) in counts {
            in_range(field, count)?;
        }
        in_range(Field::Pool, self.pool)?;
        if self.inlier_tolerance_deg.is_some_and(|degrees| !(0.1..=45.0).contains(&degrees)) {
            return Err(refused(Field::InlierToleranceDeg));
        }
        [self.effort, self.effort_at_known_height].iter().try_for_each(check_effort)
    }

    /// The same, with counts that are too large cut down: the memory of settings that are refused has a size too.
    pub(super) const fn bounded(&self) -> Self {
        const fn cut(field: Field, count: usize) -> usize {
            let [_, most] = field.range();
            if count > most { most } else { count }
        }
        Self {
            segments: cut(Field::Segments, self.segments),
            vertical_segments: cut(Field::VerticalSegments, self.vertical_segments),
            boxes: cut(Field::Boxes, self.boxes),
            windows: cut(Field::Windows, self.windows),
            pool: cut(Field::Pool, self.pool),
            ..*self
        }
    }

    /// The work of the search.
    pub(super) const fn effort(&self, is_height_known: bool) -> Effort {
        if is_height_known { self.effort_at_known_height } else { self.effort }
    }

    /// What the settings allow and the coarsest camera holds.
    pub(super) fn resolution(&self, rig: &Rig) -> Resolution {
        let coarse = rig.views().any(|(_, view)| Resolution::of(view) == Resolution::COARSE);
        if coarse { Resolution::COARSE } else { self.panorama }
    }

    /// Largest angle between a segment and the vertical that it points to, degrees.
    pub(super) fn tolerance_deg(&self, resolution: Resolution) -> f32 {
        self.inlier_tolerance_deg.unwrap_or(if resolution == Resolution::COARSE { 3.0 } else { 2.0 })
    }
}

const fn refused(field: Field) -> Error {
    Error::Setting { field, range: field.range() }
}

fn in_range(field: Field, value: usize) -> Result<(), Error> {
    let [least, most] = field.range();
    if (least..=most).contains(&value) { Ok(()) } else { Err(refused(field)) }
}

fn check_effort(effort: &Effort) -> Result<(), Error> {
    in_range(Field::RefinedPoses, effort.refined_poses)?;
    in_range(Field::RefinedFully, effort.refined_fully)?;
    in_range(Field::Rays, effort.rays)
}
