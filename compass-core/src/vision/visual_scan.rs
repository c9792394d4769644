//! What both cameras see as a scan: the likeliest range and hit type in every direction, of which the paper's descriptor is made.

use crate::base::circle::Circle;
use crate::base::confidence::Confidence;
use crate::base::num::BINS;
use crate::base::scan::{Hit, MAX_RANGE_M, MAX_STEPS, STEPS_PER_METRE, Scan};
use crate::vision::boundary::RangeLikelihoods;
use crate::vision::windows::WindowEvidence;

/// The likeliest range and hit type of every direction, and how sure they are: what the paper's descriptor is made of.
///
/// Where no range is known the one of the nearest direction that has one stands in, with confidence 0, so that the
/// channels that look at neighbouring bins see no jump.
#[must_use]
pub fn scan(ranges: &RangeLikelihoods, height: i8, sighting: &WindowEvidence) -> (Scan, Confidence) {
    let mut scan = Scan::OPEN;
    let mut confidence = [0; BINS];
    let found = Circle::from_fn(|bin| ranges.range(bin, height));
    let seen = sighting.hit.iter().zip(sighting.confidence.sixteenths());
    let rays = scan.steps.iter_mut().zip(&mut scan.hit).zip(&mut confidence);
    for (bin, (((steps, hit), confidence), (looks, sure))) in rays.zip(seen).enumerate() {
        let Some(range) = nearest(&found, bin) else { continue };
        let open = range.metres >= MAX_RANGE_M;
        *steps = if open { MAX_STEPS } else { steps_of(range.metres) };
        *hit = if open { Hit::Open } else { *looks };
        if found.get(bin).is_some() {
            let sixteenths = libm::roundf(16.0 * range.confidence) as u8;
            *confidence = if *sure == 0 { sixteenths } else { sixteenths.max(1) };
        }
    }
    (scan, Confidence::new(&confidence))
}

/// What was found in a bin, or in the nearest one that has something.
fn nearest<T: Copy>(found: &Circle<Option<T>>, bin: usize) -> Option<T> {
    (0..=BINS / 2).find_map(|distance| found.get(bin + distance).or_else(|| found.get(bin + BINS - distance)))
}

fn steps_of(metres: f32) -> u16 {
    (libm::roundf(metres * f32::from(STEPS_PER_METRE)) as u16).clamp(1, MAX_STEPS)
}
