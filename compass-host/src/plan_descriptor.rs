//! The descriptor at a pose in a plan, with its ranges and hit types.

use crate::compare::float_levels;
use crate::reference;
use compass_core::base::num::BINS;
use compass_core::base::scan::{Hit, Scan};
use compass_core::descriptor::{CHANNELS, Descriptor};

/// Range, hit type and channels of one pose; bin j points along heading + j degrees, counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanDescriptor {
    /// Range by bin, metres.
    pub range_m: [f64; BINS],
    /// Hit type by bin.
    pub hit: [Hit; BINS],
    /// The channels of the descriptor, each value from 0 to 1.
    pub channels: [[f64; BINS]; CHANNELS],
}

/// Key figures of a [`PlanDescriptor`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stats {
    /// Shortest range, metres.
    pub range_min_m: f64,
    /// Longest range, metres.
    pub range_max_m: f64,
    /// Bins that hit glazing.
    pub window_bins: usize,
    /// Bins without a hit within range.
    pub open_bins: usize,
    /// Runs of equal hit type around the circle, at least 1.
    pub segments: usize,
    /// Mean of |dr/dtheta|, metres per degree.
    pub gradient_mean_m: f64,
}

impl From<&Scan> for PlanDescriptor {
    /// Computes it with the fixed-point core.
    fn from(scan: &Scan) -> Self {
        Self {
            range_m: scan.steps.map(|s| f64::from(s) * reference::march::STEP_M),
            hit: scan.hit,
            channels: float_levels(&Descriptor::from(scan)),
        }
    }
}

impl From<&reference::Scan> for PlanDescriptor {
    /// Computes it with the float reference.
    fn from(scan: &reference::Scan) -> Self {
        Self { range_m: scan.range_m, hit: scan.hit, channels: reference::descriptor(scan) }
    }
}

impl PlanDescriptor {
    /// |dr/dtheta| per bin by central difference, in metres per degree.
    #[must_use]
    pub fn gradient_m(&self) -> [f64; BINS] {
        std::array::from_fn(|j| {
            (self.range_m[(j + 1) % BINS] - self.range_m[(j + BINS - 1) % BINS]).abs() / 2.0
        })
    }

    /// The key figures.
    #[must_use]
    pub fn stats(&self) -> Stats {
        let count = |hit: Hit| self.hit.iter().filter(|&&h| h == hit).count();
        let changes = (0..BINS).filter(|&j| self.hit[j] != self.hit[(j + 1) % BINS]).count();
        Stats {
            range_min_m: self.range_m.iter().copied().fold(f64::MAX, f64::min),
            range_max_m: self.range_m.iter().copied().fold(0.0, f64::max),
            window_bins: count(Hit::Window),
            open_bins: count(Hit::Open),
            segments: changes.max(1),
            gradient_mean_m: self.gradient_m().iter().sum::<f64>() / BINS as f64,
        }
    }
}

/// The name of a hit type in JSON.
#[must_use]
pub const fn hit_name(hit: Hit) -> &'static str {
    match hit {
        Hit::Wall => "wall",
        Hit::Window => "window",
        Hit::Open => "open",
    }
}
