//! What 360 rays meet: range and hit type per bin.
//!
//! Bin j looks along heading + j degrees, counter-clockwise. Ranges are whole march steps of
//! 0.02 m, as the paper's ray march finds them, so they carry no rounding.

use crate::base::num::BINS;

/// March step in millimetres (paper: 0.02 m).
pub const STEP_MM: u32 = 20;

/// Largest range in steps (paper: `r_max` = 30 m).
pub const MAX_STEPS: u16 = 1500;

/// March steps per metre.
pub const STEPS_PER_METRE: u16 = (1000 / STEP_MM) as u16;

/// Largest range in metres.
pub const MAX_RANGE_M: f32 = MAX_STEPS as f32 / STEPS_PER_METRE as f32;

/// What a ray met first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Hit {
    /// Nothing within [`MAX_STEPS`], or the ray left the plan.
    #[default]
    Open,
    /// Glazing.
    Window,
    /// A wall.
    Wall,
}

/// Range and hit type of 360 rays.
///
/// An [`Hit::Open`] bin always has the range [`MAX_STEPS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// Range per bin in steps of 0.02 m, 1..=1500.
    pub steps: [u16; BINS],
    /// Hit type per bin.
    pub hit: [Hit; BINS],
}

impl Scan {
    /// A scan that meets nothing anywhere.
    pub const OPEN: Self = Self { steps: [MAX_STEPS; BINS], hit: [Hit::Open; BINS] };

    /// All bytes zero: what workspaces begin with, so that statics need no initial image.
    pub(crate) const BLANK: Self = Self { steps: [0; BINS], hit: [Hit::Open; BINS] };

    /// The number of bins with this hit type.
    #[must_use]
    pub fn count(&self, hit: Hit) -> usize {
        self.hit.iter().filter(|&&h| h == hit).count()
    }

    /// The number of runs of equal hit type around the circle; 1 when all bins agree.
    ///
    /// The paper calls these the segments of the hit-type channel.
    #[must_use]
    pub fn segments(&self) -> usize {
        let mut changes = 0;
        let mut before = self.hit.last().copied().unwrap_or_default();
        for &hit in &self.hit {
            changes += usize::from(hit != before);
            before = hit;
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
