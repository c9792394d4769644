//! Heights of the camera and of the ceiling: what is known of them, what was found, and what a sequence has shown.
//!
//! Heights are counted as ranges are, in rungs of 6.3 %: what is found is within half a rung, 3 %, of the best.

use crate::base::ladder::{RUNG, height_m, height_rungs};
use crate::base::order;
use heapless::Vec;

/// As many sure frames tell the heights.
const TELLING: usize = 9;
/// Heights this many rungs apart are the same: 13 %.
const ALIKE: u8 = 2;

/// The height of the camera above the floor, and that of the ceiling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heights {
    /// The camera's.
    pub(super) camera: i8,
    /// By how many rungs the ceiling is higher above the camera than the floor is below it.
    pub(super) ceiling: i8,
}

impl Heights {
    /// From what [`to_rungs`](Self::to_rungs) gave.
    #[must_use]
    pub const fn from_rungs([camera, ceiling]: [i8; 2]) -> Self {
        Self { camera, ceiling }
    }

    /// Both as steps of 6.3 %, for keeping them exactly: the camera's from 1.5 m, and by how many the ceiling is higher
    /// above the camera than the floor is below it.
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

/// What is known of the heights before anything is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeightPrior {
    camera_m: Option<f32>,
    ceiling: Option<i8>,
}

impl HeightPrior {
    /// Nothing is known: both are searched.
    pub const UNKNOWN: Self = Self { camera_m: None, ceiling: None };

    /// The camera's height above the floor is known, metres, bounded by
    /// [`HEIGHTS_M`](crate::base::ladder::HEIGHTS_M).
    #[must_use]
    pub const fn camera(metres: f32) -> Self {
        Self { camera_m: Some(metres), ..Self::UNKNOWN }
    }

    /// Both are known, as from an earlier [`Fix`](super::Fix).
    #[must_use]
    pub fn both(heights: Heights) -> Self {
        Self { camera_m: Some(heights.camera_m()), ceiling: Some(heights.ceiling) }
    }

    /// The camera's height above the floor, metres, if it is known.
    #[must_use]
    pub const fn camera_m(&self) -> Option<f32> {
        self.camera_m
    }

    /// By how many rungs the ceiling is known to be higher above the camera than the floor is below it.
    pub(crate) const fn ceiling_rungs(&self) -> Option<i8> {
        self.ceiling
    }

    /// The camera's height in rungs.
    pub(crate) fn camera_rungs(&self) -> Option<i8> {
        self.camera_m.map(height_rungs)
    }
}

/// The heights of camera and ceiling in the last sure frames of a sequence.
///
/// Whoever carries the cameras keeps their height, and a storey its ceiling. Single frames that are wrong have wrong
/// heights as well, so that those of the sure ones tell when to search again.
#[derive(Debug, Clone, Default)]
pub struct HeightMemory {
    /// The oldest first.
    last: Vec<Heights, TELLING>,
}

impl HeightMemory {
    /// Nothing is known.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: Vec::new() }
    }

    /// Takes in the heights of a sure frame.
    pub fn learn(&mut self, heights: Heights) {
        if self.last.is_full() {
            self.last.rotate_left(1);
            self.last.truncate(TELLING - 1);
        }
        // There is room for one.
        let _ = self.last.push(heights);
    }

    /// The median of each; unknown before the first sure frame.
    #[must_use]
    pub fn prior(&self) -> HeightPrior {
        self.medians().map_or(HeightPrior::UNKNOWN, HeightPrior::both)
    }

    /// Whether heights are those of the sequence, to 13 %, or nothing is known.
    #[must_use]
    pub fn is_like(&self, heights: Heights) -> bool {
        self.medians().is_none_or(|median| {
            median.camera.abs_diff(heights.camera) <= ALIKE
                && median.ceiling.abs_diff(heights.ceiling) <= ALIKE
        })
    }

    fn medians(&self) -> Option<Heights> {
        Some(Heights { camera: self.median(|h| h.camera)?, ceiling: self.median(|h| h.ceiling)? })
    }

    fn median(&self, which: impl Fn(&Heights) -> i8) -> Option<i8> {
        let mut values: Vec<i8, TELLING> = Vec::new();
        for value in self.last.iter().map(which) {
            // As many places as heights.
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
