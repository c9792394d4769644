//! Heights of camera and ceiling: prior, estimate, and memory over a sequence of frames.
//!
//! Heights are quantized like ranges, in rungs of 6.3 %: an estimate is within half a rung, 3 %, of the optimum.

use crate::base::ladder::{HEIGHTS_M, RUNG, height_m, height_rungs};
use crate::base::order;
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

/// Prior knowledge of the heights of camera and ceiling.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeightPrior {
    camera_m: Option<f32>,
    ceiling: Option<i8>,
}

impl HeightPrior {
    /// Neither height is known: both are searched.
    pub const UNKNOWN: Self = Self { camera_m: None, ceiling: None };

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
        Self { camera_m: Some(height_m(camera)), ceiling: Some(heights.ceiling) }
    }

    /// Height of the camera above the floor, metres, if it is known.
    #[must_use]
    pub const fn camera_m(&self) -> Option<f32> {
        self.camera_m
    }

    /// Logarithm of (ceiling above the camera) / (camera above the floor), in rungs, if it is known.
    pub(crate) const fn ceiling_rungs(&self) -> Option<i8> {
        self.ceiling
    }

    /// Height of the camera in rungs, if it is known.
    pub(crate) fn camera_rungs(&self) -> Option<i8> {
        self.camera_m.map(height_rungs)
    }
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
