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
///
/// # Formats
/// Log-likelihood ratios and log odds to a [`Scan`] in march steps of 0.02 m and a [`Confidence`] in sixteenths. Ranges of 30
/// m and more are [`Hit::Open`].
///
/// # Cost
/// A search over the 90 rungs per bin, and at most 360 look-ups for each bin without a range.
///
/// # References
/// The paper: the descriptor is made of such a scan.
///
/// ```
/// use compass_core::Hit;
/// use compass_core::base::num::CellNats;
/// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS, RangeLikelihoods};
/// use compass_core::vision::visual_scan::scan;
/// use compass_core::vision::windows::WindowEvidence;
///
/// // A boundary of floor and wall at rung 30 in all directions, 1.44 m away, of which bins 0 to 9 are not seen.
/// let mut cells = vec![CellNats::ZERO; CELLS];
/// for rung in 0..RUNGS {
///     cells[rung * 360 + 10..(rung + 1) * 360].fill(CellNats::from_num(if rung == 30 { 6 } else { -7 }));
/// }
/// let mut ranges = RangeLikelihoods::EMPTY;
/// BoundaryEvidence::new(&cells).unwrap().ranges(0, &mut ranges);
/// let windows = WindowEvidence { hit: [Hit::Wall; 360], ..WindowEvidence::NOTHING };
/// let (scan, confidence) = scan(&ranges, 0, &windows);
/// assert_eq!((scan.steps[0], scan.steps[90], scan.hit[90]), (72, 72, Hit::Wall));
/// assert_eq!((confidence.sixteenths()[0], confidence.sixteenths()[90]), (0, 16));
/// ```
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
