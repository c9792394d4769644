//! The visual descriptor of a pair of frames: range in metres, hit type and confidence, by direction.

use crate::locator::Seen;
use compass_core::HeightPrior;
use compass_core::base::confidence::Confidence;
use compass_core::base::ladder::{HEIGHTS_M, height_m, height_rungs};
use compass_core::base::num::BINS;
use compass_core::base::scan::{Hit, Scan};
use compass_core::vision::boundary::{RangeEstimate, RangeLikelihoods};
use compass_core::vision::visual_scan;
use compass_core::vision::windows::WindowEvidence;

/// Assumed height of a room, metres, from which the camera height follows when it is not given: typical of offices and
/// flats.
pub const ROOM_M: f32 = 2.75;

/// Height of cam0 above the floor, and that of the ceiling, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Height {
    /// Height of cam0, metres.
    pub camera_m: f32,
    /// Height of the ceiling, metres.
    pub ceiling_m: f32,
    /// Whether the camera height was given; else the room is assumed to be [`ROOM_M`] high.
    pub given: bool,
}

impl Height {
    /// The given height, or the one for which the room is [`ROOM_M`] high, clamped to [`HEIGHTS_M`].
    #[must_use]
    pub fn new(given_m: Option<f32>, ranges: &RangeLikelihoods) -> Self {
        let whole = 1.0 + ranges.ceiling_ratio();
        let camera_m = given_m.unwrap_or_else(|| (ROOM_M / whole).clamp(HEIGHTS_M[0], HEIGHTS_M[1]));
        Self { camera_m, ceiling_m: camera_m * whole, given: given_m.is_some() }
    }

    /// The height in rungs of range, rounded.
    #[must_use]
    pub fn rungs(&self) -> i8 {
        height_rungs(self.camera_m)
    }

    /// The ratio of the height to that of [`Self::rungs`].
    fn rest(&self) -> f32 {
        self.camera_m / height_m(self.rungs())
    }
}

/// Range and hit type in every direction, bin j at heading + j degrees, counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct VisualDescriptor {
    /// The heights that the ranges depend on.
    pub height: Height,
    /// Likeliest range in metres and its confidence; `None` where neither floor nor ceiling was observed.
    pub ranges: [Option<RangeEstimate>; BINS],
    /// Hit type; `None` out of view of both cameras.
    pub hit: [Option<Hit>; BINS],
    /// The input of the paper's descriptor: unknown ranges are those of the nearest direction.
    pub scan: Scan,
    /// Confidence of the bins of `scan`.
    pub confidence: Confidence,
}

impl VisualDescriptor {
    /// The descriptor of one pair of frames.
    #[must_use]
    pub fn of(seen: &mut Seen<'_, '_>, known: HeightPrior) -> Self {
        let windows = seen.window_evidence().clone();
        let mut ranges = Box::new(RangeLikelihoods::EMPTY);
        seen.range_likelihoods(known, &mut ranges);
        Self::new(&ranges, &windows, known.camera_m())
    }

    /// The descriptor from the evidence of one pair of frames; `height_m` is the height of cam0 above the floor, if
    /// known.
    #[must_use]
    pub fn new(ranges: &RangeLikelihoods, windows: &WindowEvidence, height_m: Option<f32>) -> Self {
        let height = Height::new(height_m, ranges);
        let (rungs, rest) = (height.rungs(), height.rest());
        let (scan, confidence) = visual_scan::scan(ranges, rungs, windows);
        // The core counts heights in rungs; the ratio corrects its rounding.
        let exact = |range: RangeEstimate| RangeEstimate { metres: range.metres * rest, ..range };
        let known = windows.confidence.sixteenths();
        Self {
            height,
            ranges: std::array::from_fn(|bin| ranges.range(bin, rungs).map(exact)),
            hit: std::array::from_fn(|bin| (known[bin] > 0).then_some(scan.hit[bin])),
            scan,
            confidence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::base::ladder::RUNG;

    #[test]
    fn unknown_height_assumes_the_default_room() {
        let height = Height::new(None, &RangeLikelihoods::EMPTY);
        assert_eq!((height.camera_m, height.ceiling_m, height.given), (1.375, 2.75, false));
        let told = Height::new(Some(1.87), &RangeLikelihoods::EMPTY);
        assert_eq!((told.camera_m, told.ceiling_m, told.given), (1.87, 3.74, true));
        for camera_m in [0.55, 0.986, 1.5, 1.87, 2.4] {
            let told = Height::new(Some(camera_m), &RangeLikelihoods::EMPTY);
            assert!((told.rest().ln() / RUNG).abs() <= 0.5001, "{camera_m}");
        }
    }

    #[test]
    fn of_nothing_seen_nothing_is_known() {
        let seen = VisualDescriptor::new(&RangeLikelihoods::EMPTY, &WindowEvidence::NOTHING, None);
        assert!(seen.ranges.iter().all(Option::is_none) && seen.hit.iter().all(Option::is_none));
        assert_eq!(seen.confidence, Confidence::new(&[0; BINS]));
    }
}
