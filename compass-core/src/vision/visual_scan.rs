//! The scan seen by the cameras: the most likely range and hit type per bin, input of the paper's descriptor.

use crate::base::circle::Circle;
use crate::base::confidence::Confidence;
use crate::base::num::{BINS, truncate_to_u8, truncate_to_u16};
use crate::base::scan::{Hit, MAX_RANGE_M, MAX_STEPS, STEPS_PER_METRE, Scan};
use crate::vision::boundary::RangeLikelihoods;
use crate::vision::windows::WindowEvidence;

/// The most likely range and hit type of every bin, with their confidence.
///
/// `height` is the camera height as a [shift in rungs](crate::base::ladder::height_rungs). A bin without a range takes that
/// of the nearest bin that has one, with confidence 0, so that channels of differences between neighbours see no jump.
#[must_use]
pub fn scan(ranges: &RangeLikelihoods, height: i8, windows: &WindowEvidence) -> (Scan, Confidence) {
    let mut scan = Scan::OPEN;
    let mut confidence = [0; BINS];
    let found = Circle::from_fn(|bin| ranges.range(bin, height));
    let seen = windows.hit.iter().zip(windows.confidence.sixteenths());
    let rays = scan.steps.iter_mut().zip(&mut scan.hit).zip(&mut confidence);
    for (bin, (((steps, hit), confidence), (seen_hit, certainty))) in rays.zip(seen).enumerate() {
        let Some(range) = nearest(&found, bin) else { continue };
        let open = range.metres >= MAX_RANGE_M;
        *steps = if open { MAX_STEPS } else { steps_of(range.metres) };
        *hit = if open { Hit::Open } else { *seen_hit };
        if found.get(bin).is_some() {
            let sixteenths = truncate_to_u8(libm::roundf(16.0 * range.confidence));
            *confidence = if *certainty == 0 { sixteenths } else { sixteenths.max(1) };
        }
    }
    (scan, Confidence::new(&confidence))
}

/// The value of a bin, or of the nearest bin that has one.
fn nearest<T: Copy>(found: &Circle<Option<T>>, bin: usize) -> Option<T> {
    (0..=BINS / 2).find_map(|distance| found.get(bin + distance).or_else(|| found.get(bin + BINS - distance)))
}

fn steps_of(metres: f32) -> u16 {
    truncate_to_u16(libm::roundf(metres * f32::from(STEPS_PER_METRE))).clamp(1, MAX_STEPS)
}
