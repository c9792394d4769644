//! A scan: range and hit type of 360 rays.
//!
//! Bin j looks along heading + j degrees, counter-clockwise. Ranges are whole march steps of
//! 0.02 m, the step of the paper's ray march: they are exact.

use crate::base::num::BINS;

/// March step in millimetres (paper: 0.02 m).
pub const STEP_MM: u32 = 20;

/// Largest range in steps (paper: `r_max` = 30 m).
pub const MAX_STEPS: u16 = 1500;

/// March steps per metre.
#[expect(clippy::cast_possible_truncation, reason = "1000 / 20 is 50")]
pub const STEPS_PER_METRE: u16 = (1000 / STEP_MM) as u16;

/// Largest range in metres.
pub const MAX_RANGE_M: f32 = MAX_STEPS as f32 / STEPS_PER_METRE as f32;

/// Type of a ray's first hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Hit {
    /// No hit within [`MAX_STEPS`], or the ray left the plan.
    #[default]
    Open,
    /// Glazing.
    Window,
    /// A wall.
    Wall,
}

/// Range and hit type of 360 rays.
///
/// A bin of type [`Hit::Open`] always has the range [`MAX_STEPS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// Range per bin in steps of 0.02 m, 1..=1500.
    pub steps: [u16; BINS],
    /// Hit type per bin.
    pub hit: [Hit; BINS],
}

impl Scan {
    /// A scan without a hit.
    pub const OPEN: Self = Self { steps: [MAX_STEPS; BINS], hit: [Hit::Open; BINS] };

    /// All bytes zero: the initial value of workspaces, so that statics need no image in flash.
    pub(crate) const BLANK: Self = Self { steps: [0; BINS], hit: [Hit::Open; BINS] };

    /// The number of bins with this hit type.
    ///
    /// ```
    /// use compass_core::{Hit, Scan};
    ///
    /// assert_eq!(Scan::OPEN.count(Hit::Open), 360);
    /// ```
    #[must_use]
    pub fn count(&self, hit: Hit) -> usize {
        self.hit.iter().filter(|&&h| h == hit).count()
    }

    /// The number of runs of equal hit type around the circle; 1 when all bins agree.
    ///
    /// The paper calls these the segments of the hit-type channel.
    ///
    /// ```
    /// use compass_core::{Hit, Scan};
    ///
    /// let mut scan = Scan::OPEN;
    /// (scan.hit[359], scan.hit[0]) = (Hit::Wall, Hit::Wall);
    /// assert_eq!(scan.segments(), 2, "a run across bin 0 is one run");
    /// ```
    #[must_use]
    pub fn segments(&self) -> usize {
        let mut changes = 0;
        let mut previous = self.hit.last().copied().unwrap_or_default();
        for &hit in &self.hit {
            changes += usize::from(hit != previous);
            previous = hit;
        }
        changes.max(1)
    }
}

impl Default for Scan {
    fn default() -> Self {
        Self::OPEN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_count_circular_runs() {
        let mut scan = Scan::OPEN;
        assert_eq!(scan.segments(), 1);
        scan.hit[359] = Hit::Wall;
        scan.hit[0] = Hit::Wall;
        assert_eq!(scan.segments(), 2, "a run across bin 0 is one run");
        scan.hit[100] = Hit::Window;
        assert_eq!(scan.segments(), 4);
        assert_eq!(scan.count(Hit::Wall), 2);
        assert_eq!(scan.count(Hit::Open), 357);
    }
}
