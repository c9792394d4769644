//! The heights that a sequence has shown so far.

use super::locate::HeightPrior;
use crate::base::order;
use heapless::Vec;

/// So many sure frames tell the heights.
const TELLING: usize = 9;
/// Heights this many rungs apart are the same: 13 %.
const ALIKE: u8 = 2;

/// The heights of camera and ceiling in the last sure frames.
///
/// Whoever carries the cameras keeps their height, and a storey its ceiling. Single frames that are wrong have wrong
/// heights as well, so that those of the sure ones tell when to look again.
#[derive(Debug, Clone, Default)]
pub struct HeightMemory {
    /// Camera and ceiling, in rungs, the oldest first.
    last: Vec<[i8; 2], TELLING>,
}

impl HeightMemory {
    /// Nothing is known.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: Vec::new() }
    }

    /// Takes in the heights of camera and ceiling of a sure frame, as a [`Fix`](crate::pose::locate::Fix) has them.
    pub fn learn(&mut self, height: i8, ceiling: i8) {
        if self.last.is_full() {
            self.last.rotate_left(1);
            self.last.truncate(TELLING - 1);
        }
        // There is room for one.
        let _ = self.last.push([height, ceiling]);
    }

    /// The median of each; unknown before the first sure frame.
    #[must_use]
    pub fn room(&self) -> HeightPrior {
        HeightPrior { height: self.median(0), ceiling: self.median(1) }
    }

    /// Whether heights are as usual, to 13 %, or nothing is known.
    #[must_use]
    pub fn is_like(&self, height: i8, ceiling: i8) -> bool {
        let HeightPrior { height: usual, ceiling: above } = self.room();
        usual.is_none_or(|usual| usual.abs_diff(height) <= ALIKE)
            && above.is_none_or(|usual| usual.abs_diff(ceiling) <= ALIKE)
    }

    fn median(&self, which: usize) -> Option<i8> {
        let mut values: Vec<i8, TELLING> = Vec::new();
        for value in self.last.iter().filter_map(|heights| heights.get(which)) {
            // As many places as heights.
            let _ = values.push(*value);
        }
        order::sort_by_key(&mut values, |value| *value);
        values.get(values.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_follow_the_last_frames() {
        let mut usual = HeightMemory::new();
        assert_eq!(usual.room(), HeightPrior::default());
        assert!(usual.is_like(-10, 20), "nothing is unusual yet");
        usual.learn(3, -8);
        assert_eq!(usual.room(), HeightPrior { height: Some(3), ceiling: Some(-8) });
        usual.learn(4, -9);
        usual.learn(-12, 20);
        assert_eq!(
            usual.room(),
            HeightPrior { height: Some(3), ceiling: Some(-8) },
            "an outlier changes nothing"
        );
        assert!(usual.is_like(5, -10) && !usual.is_like(6, -8) && !usual.is_like(3, -5));
        (0..9).for_each(|_| usual.learn(-5, 7));
        assert_eq!(usual.room(), HeightPrior { height: Some(-5), ceiling: Some(7) });
    }
}
