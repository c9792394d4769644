//! Heights of camera and ceiling: prior, estimate, and memory over a sequence of frames.
//!
//! Heights are quantized like ranges, in rungs of 6.3 %: an estimate is within half a rung, 3 %, of the optimum.

use crate::base::ladder::{HEIGHTS_M, NOMINAL_HEIGHT_M, RUNG, height_m, height_rungs};
use crate::base::num::{CellNats, Nats, round_to_i8};
use crate::base::order;
use core::ops::Range;
use heapless::Vec;

/// Number of frames whose heights are remembered; the medians over them are the prior.
const REMEMBERED: usize = 9;
/// Largest difference, in rungs of 6.3 %, of heights that agree: 13 %.
const TOLERANCE_RUNGS: u8 = 2;

/// The height of the camera above the floor, and that of the ceiling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heights {
    /// Camera above the floor, in rungs from 1.5 m.
    pub(super) camera: i8,
    /// Logarithm of (ceiling above the camera) / (camera above the floor), in rungs.
    pub(super) ceiling: i8,
}

impl Heights {
    /// Inverse of [`to_rungs`](Self::to_rungs).
    #[must_use]
    pub const fn from_rungs([camera, ceiling]: [i8; 2]) -> Self {
        Self { camera, ceiling }
    }

    /// Both heights in rungs of 6.3 %, for lossless storage: the camera's above the floor, from 1.5 m; and the logarithm
    /// of the ratio (ceiling above the camera) / (camera above the floor).
    #[must_use]
    pub const fn to_rungs(self) -> [i8; 2] {
        [self.camera, self.ceiling]
    }

    /// Height of the camera above the floor, metres.
    #[must_use]
    pub fn camera_m(self) -> f32 {
        height_m(self.camera)
    }

    /// Height of the ceiling above the floor, metres.
    #[must_use]
    pub fn ceiling_m(self) -> f32 {
        self.camera_m() * (1.0 + libm::expf(f32::from(self.ceiling) * RUNG))
    }
}

/// Smallest and largest height of a ceiling above the floor, metres, unless more is known: rooms of homes and offices.
pub const CEILING_M: [f32; 2] = [2.15, 3.7];
/// Smallest height of a ceiling above the camera, metres.
const LEAST_ABOVE_M: f32 = 0.6;
/// Smallest and largest camera height that a search tries, metres, and that a refinement tries.
const SEARCHED_M: [f32; 2] = [0.8, 2.1];
const REFINED_M: [f32; 2] = [0.7, 2.15];

/// Usual heights of a camera above the floor and of a ceiling above the floor, metres; and the standard deviations of their
/// logarithms. Wide: they decide only between poses that the images leave open.
const USUAL_CAMERA: [f32; 2] = [1.3, 0.35];
const USUAL_CEILING: [f32; 2] = [2.65, 0.2];
/// Nats of evidence that count as one independent one: the errors of neighbouring bins are correlated.
const CORRELATION: f32 = 10.0;

/// Prior knowledge of the heights of camera and ceiling.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeightPrior {
    camera_m: Option<f32>,
    ceiling: Option<i8>,
    ceiling_m: [f32; 2],
}

impl Default for HeightPrior {
    fn default() -> Self {
        Self::UNKNOWN
    }
}

impl HeightPrior {
    /// Neither height is known: both are searched, the ceiling's within [`CEILING_M`].
    pub const UNKNOWN: Self = Self { camera_m: None, ceiling: None, ceiling_m: CEILING_M };

    /// The height of the camera above the floor is known, metres. Values outside
    /// [`HEIGHTS_M`] are clamped to it; NaN is unknown.
    #[must_use]
    pub const fn camera(metres: f32) -> Self {
        if metres.is_nan() {
            return Self::UNKNOWN;
        }
        Self { camera_m: Some(metres.clamp(HEIGHTS_M[0], HEIGHTS_M[1])), ..Self::UNKNOWN }
    }

    /// Both heights are known, for instance from an earlier [`Fix`](super::Fix).
    #[must_use]
    pub fn both(heights: Heights) -> Self {
        let [least, most] = HEIGHTS_M.map(height_rungs);
        let camera = heights.camera.clamp(least, most);
        Self { camera_m: Some(height_m(camera)), ceiling: Some(heights.ceiling), ..Self::UNKNOWN }
    }

    /// The same with other bounds of the height of the ceiling above the floor, metres: of halls, or of a storey whose height
    /// the plan gives. Bounds are ordered and clamped to 1 to 12 m; NaN is the default.
    #[must_use]
    pub fn with_ceiling_between(self, [least, most]: [f32; 2]) -> Self {
        let bound = |bound: f32, default: f32| if bound.is_nan() { default } else { bound.clamp(1.0, 12.0) };
        let (least, most) = (bound(least, CEILING_M[0]), bound(most, CEILING_M[1]));
        Self { ceiling_m: [least.min(most), most.max(least)], ..self }
    }

    /// Height of the camera above the floor, metres, if it is known.
    #[must_use]
    pub const fn camera_m(&self) -> Option<f32> {
        self.camera_m
    }

    /// Logarithm of (ceiling above the camera) / (camera above the floor), in rungs, if it is known.
    #[cfg(any(test, feature = "introspect"))]
    pub(crate) const fn ceiling_rungs(&self) -> Option<i8> {
        self.ceiling
    }

    /// Height of the camera in rungs, if it is known.
    pub(crate) fn camera_rungs(&self) -> Option<i8> {
        self.camera_m.map(height_rungs)
    }
}

/// Heights of camera and ceiling that a search tries, in rungs of 6.3 % from 1.5 m: the camera's above the floor, and the
/// ceiling's above the camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeightGrid {
    cameras: Vec<i8, { Self::CAMERAS }>,
    ceilings: Vec<i8, { Self::CEILINGS }>,
    /// For each camera height, the first of the ceilings that leave a room within bounds, and the first beyond.
    rooms: Vec<[u8; 2], { Self::CAMERAS }>,
    /// Log prior of each camera height.
    priors: Vec<CellNats, { Self::CAMERAS }>,
}

impl HeightGrid {
    /// Largest number of camera heights.
    pub const CAMERAS: usize = 26;
    /// Largest number of ceilings.
    pub const CEILINGS: usize = 32;

    /// The grid of the search: every second rung, or the known camera height.
    #[must_use]
    pub fn coarse(prior: &HeightPrior) -> Self {
        Self::new(prior, SEARCHED_M, 2, 0)
    }

    /// The grid of refinement: every rung. A known camera height is tried with a rung to either side, because plan scales and
    /// measurements err.
    #[must_use]
    pub fn fine(prior: &HeightPrior) -> Self {
        Self::new(prior, REFINED_M, 1, 1)
    }

    fn new(prior: &HeightPrior, cameras_m: [f32; 2], step: usize, beside: i8) -> Self {
        let [least, most] = cameras_m.map(rungs);
        let known = prior.camera_rungs();
        let (cameras, step_of_cameras) =
            known.map_or((least..=most, step), |known| (known - beside..=known + beside, 1));
        let mut grid =
            Self { cameras: Vec::new(), ceilings: Vec::new(), rooms: Vec::new(), priors: Vec::new() };
        for camera in cameras.step_by(step_of_cameras) {
            let _ = grid.cameras.push(camera);
        }
        let lowest = grid.cameras.first().map_or(NOMINAL_HEIGHT_M, |camera| height_m(*camera));
        let above = match (known, prior.ceiling) {
            (Some(camera), Some(ratio)) => {
                let above = camera.saturating_add(ratio);
                above.saturating_sub(1)..=above.saturating_add(1)
            }
            _ => rungs(LEAST_ABOVE_M)..=rungs((prior.ceiling_m[1] - lowest).max(LEAST_ABOVE_M)),
        };
        let count = usize::from(above.end().abs_diff(*above.start())) + 1;
        let step = if prior.ceiling.is_some() { 1 } else { step.max(count.div_ceil(Self::CEILINGS)) };
        for above in above.step_by(step) {
            let _ = grid.ceilings.push(above);
        }
        for camera in &grid.cameras {
            let prior =
                if known.is_some() { CellNats::ZERO } else { log_prior(height_m(*camera), USUAL_CAMERA) };
            let _ = grid.priors.push(prior);
        }
        for camera in &grid.cameras {
            let rooms =
                if prior.ceiling.is_some() { 0..grid.ceilings.len() } else { grid.within(*camera, prior) };
            // Bounds are at most `CEILINGS`, and there are as many rooms as cameras.
            let _ =
                grid.rooms.push([rooms.start, rooms.end].map(|bound| u8::try_from(bound).unwrap_or(u8::MAX)));
        }
        grid
    }

    /// The ceilings for a camera height that leave a room within bounds; at least one.
    fn within(&self, camera: i8, prior: &HeightPrior) -> Range<usize> {
        let camera_m = height_m(camera);
        let [least, most] = prior.ceiling_m.map(|bound| rungs((bound - camera_m).max(LEAST_ABOVE_M)));
        let start = self.ceilings.iter().take_while(|above| **above < least).count();
        let start = start.min(self.ceilings.len().saturating_sub(1));
        let end = self.ceilings.iter().take_while(|above| **above <= most).count();
        start..end.max(start + 1)
    }

    /// Heights of the camera above the floor.
    #[must_use]
    pub fn cameras(&self) -> &[i8] {
        &self.cameras
    }

    /// Log prior of one of the [`cameras`](Self::cameras): 0 for one that is known.
    #[must_use]
    pub fn camera_prior(&self, camera: usize) -> CellNats {
        self.priors.get(camera).copied().unwrap_or(CellNats::ZERO)
    }

    /// Log prior of a pair of heights: of one of the [`cameras`](Self::cameras) and a ceiling above it.
    #[must_use]
    pub fn prior(&self, [camera, above]: [i8; 2]) -> Nats {
        let at = self.cameras.iter().position(|height| *height == camera);
        let room = log_prior(height_m(camera) + height_m(above), USUAL_CEILING);
        Nats::from(at.map_or(CellNats::ZERO, |at| self.camera_prior(at))) + Nats::from(room)
    }

    /// Heights of the ceiling above the camera.
    #[must_use]
    pub fn ceilings(&self) -> &[i8] {
        &self.ceilings
    }

    /// Whether each camera height has two ceilings or more.
    pub(super) fn has_many_ceilings(&self) -> bool {
        self.rooms.iter().all(|[start, end]| end.saturating_sub(*start) > 1)
    }

    /// The [`ceilings`](Self::ceilings) that go with one of the [`cameras`](Self::cameras).
    #[must_use]
    pub fn rooms(&self, camera: usize) -> Range<usize> {
        self.rooms.get(camera).map_or(0..0, |[start, end]| usize::from(*start)..usize::from(*end))
    }
}

/// Log density of a height, relative to that of the usual one.
fn log_prior(height_m: f32, [usual_m, deviation]: [f32; 2]) -> CellNats {
    let z = libm::logf(height_m / usual_m) / deviation;
    CellNats::from_bits(round_to_i8(-16.0 * CORRELATION / 2.0 * z * z))
}

/// A height in rungs from 1.5 m.
fn rungs(height_m: f32) -> i8 {
    round_to_i8(libm::logf(height_m / NOMINAL_HEIGHT_M) / RUNG)
}

/// Heights of camera and ceiling in the last 9 [sure](super::Fix::is_sure) frames of a sequence.
///
/// Both heights hardly change within a sequence, and a frame that is localized wrongly usually has wrong heights too.
/// The medians over the sure frames are therefore a prior for the next frame, and a test of its result.
///
/// ```
/// use compass_core::pose::heights::{HeightMemory, Heights};
///
/// let mut memory = HeightMemory::new();
/// // Two frames at 1.5 m, one at 1.5 m and 10 rungs: the median is 1.5 m.
/// for rungs in [0, 10, 0] {
///     memory.learn(Heights::from_rungs([rungs, 0]));
/// }
/// assert_eq!(memory.prior().camera_m(), Some(1.5));
/// assert!(!memory.is_like(Heights::from_rungs([10, 0])));
/// ```
#[derive(Debug, Clone, Default)]
pub struct HeightMemory {
    /// Oldest first.
    last: Vec<Heights, REMEMBERED>,
}

impl HeightMemory {
    /// An empty memory.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: Vec::new() }
    }

    /// Adds the heights of a sure frame; the oldest of 9 is dropped.
    pub fn learn(&mut self, heights: Heights) {
        if self.last.is_full() {
            self.last.rotate_left(1);
            self.last.truncate(REMEMBERED - 1);
        }
        // Never full here: an element was dropped above.
        let _ = self.last.push(heights);
    }

    /// The medians of both heights; [`HeightPrior::UNKNOWN`] before the first sure frame.
    #[must_use]
    pub fn prior(&self) -> HeightPrior {
        self.medians().map_or(HeightPrior::UNKNOWN, HeightPrior::both)
    }

    /// Whether both heights agree with the medians within 13 %; true before the first sure frame.
    #[must_use]
    pub fn is_like(&self, heights: Heights) -> bool {
        self.medians().is_none_or(|median| {
            median.camera.abs_diff(heights.camera) <= TOLERANCE_RUNGS
                && median.ceiling.abs_diff(heights.ceiling) <= TOLERANCE_RUNGS
        })
    }

    fn medians(&self) -> Option<Heights> {
        Some(Heights { camera: self.median(|h| h.camera)?, ceiling: self.median(|h| h.ceiling)? })
    }

    fn median(&self, which: impl Fn(&Heights) -> i8) -> Option<i8> {
        let mut values: Vec<i8, REMEMBERED> = Vec::new();
        for value in self.last.iter().map(which) {
            // Same capacity as `last`: never full.
            let _ = values.push(value);
        }
        order::sort_by_key(&mut values, |value| *value);
        values.get(values.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights(camera: i8, ceiling: i8) -> Heights {
        Heights { camera, ceiling }
    }

    #[test]
    fn priors_are_clamped_to_the_heights_that_are_searched() {
        let metres = |prior: HeightPrior| prior.camera_m();
        assert_eq!(metres(HeightPrior::camera(f32::NAN)), None);
        assert_eq!(
            [-3.0, 1.6, 1e9].map(|m| metres(HeightPrior::camera(m))),
            [Some(0.55), Some(1.6), Some(2.4)]
        );
        let high = metres(HeightPrior::both(heights(127, 0))).unwrap();
        assert!((2.4..2.5).contains(&high), "{high}");
    }

    #[test]
    fn metres_and_rungs_are_the_same_heights() {
        for rungs in [[0, 0], [3, -8], [-7, 12]] {
            let heights = Heights::from_rungs(rungs);
            assert_eq!(heights.to_rungs(), rungs);
            let prior = HeightPrior::both(heights);
            assert_eq!((prior.camera_rungs(), prior.ceiling), (Some(rungs[0]), Some(rungs[1])));
        }
        let level = heights(0, 0);
        assert_eq!((level.camera_m(), level.ceiling_m()), (1.5, 3.0));
        assert_eq!(HeightPrior::camera(1.87).camera_m(), Some(1.87));
        assert_eq!(HeightPrior::UNKNOWN.camera_rungs(), None);
    }

    #[test]
    fn medians_follow_the_last_frames() {
        let mut memory = HeightMemory::new();
        assert_eq!(memory.prior(), HeightPrior::UNKNOWN);
        assert!(memory.is_like(heights(-10, 20)), "nothing is unusual yet");
        memory.learn(heights(3, -8));
        assert_eq!(memory.prior(), HeightPrior::both(heights(3, -8)));
        memory.learn(heights(4, -9));
        memory.learn(heights(-12, 20));
        assert_eq!(memory.prior(), HeightPrior::both(heights(3, -8)), "an outlier changes nothing");
        let alike = [heights(5, -10), heights(6, -8), heights(3, -5)].map(|h| memory.is_like(h));
        assert_eq!(alike, [true, false, false]);
        (0..9).for_each(|_| memory.learn(heights(-5, 7)));
        assert_eq!(memory.prior(), HeightPrior::both(heights(-5, 7)));
    }
}
