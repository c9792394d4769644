//! What both cameras see, put together: range and hit type in every direction, as evidence and as a descriptor.

use crate::boundary::Ranges;
use crate::likelihood::{OPEN_PLANE, RANGES, Table};
use crate::num::BINS;
use crate::scan::{Hit, MAX_STEPS, STEPS_PER_METRE, Scan};
use crate::similarity::Confidence;
use crate::windows::level::Sighting;

/// Share of directions in which what looks like window or wall says nothing of the plan.
const OUTLIERS: f32 = 0.1;
/// Share of directions in which plans have windows.
const WINDOWS: f32 = 0.3;
/// Weight of the hit type beside the range: its bins lie in windows of many bins, so that they err together.
const WEIGHT: f32 = 0.7;
/// Beyond this range, metres, the plan has nothing: [`Hit::Open`].
const FARTHEST_M: f32 = 30.0;

/// Fills a table with the likelihoods of ranges and hit types, for a camera height in
/// [rungs](crate::boundary::height_rungs).
pub fn evidence(ranges: &Ranges, height: i8, sighting: &Sighting, table: &mut Table) {
    let mut window = [0_i32; BINS];
    let mut wall = [0_i32; BINS];
    let known = sighting.confidence.sixteenths();
    for (((window, wall), odds), known) in window.iter_mut().zip(&mut wall).zip(&sighting.evidence).zip(known)
    {
        if *known > 0 {
            [*window, *wall] = hit_ratios(*odds);
        }
    }
    let mut row = [0_i32; BINS];
    for rung in 0..RANGES {
        let range = ranges.row(rung, height);
        for (plane, hit) in [(rung, &wall), (RANGES + rung, &window)] {
            row.iter_mut().zip(range).zip(hit).for_each(|((sum, range), hit)| *sum = i32::from(*range) + hit);
            table.set_plane(plane as u8, &row);
        }
    }
    row.iter_mut().zip(ranges.row(RANGES - 1, height)).for_each(|(value, range)| *value = i32::from(*range));
    table.set_plane(OPEN_PLANE, &row);
}

/// Log-likelihood ratios of a window and of a wall in the plan, 1/16 nat, from the log odds of a window, 1/256 nat.
fn hit_ratios(odds: i16) -> [i32; 2] {
    let window = 1.0 / (1.0 + libm::expf(-f32::from(odds) / 256.0));
    let ratio = |share: f32, usual: f32| {
        let ratio = (1.0 - OUTLIERS) * share / usual + OUTLIERS;
        libm::roundf(16.0 * WEIGHT * libm::logf(ratio)) as i32
    };
    [ratio(window, WINDOWS), ratio(1.0 - window, 1.0 - WINDOWS)]
}

/// The likeliest range and hit type of every direction, and how sure they are: what the paper's descriptor is made of.
///
/// Where no range is known the one of the nearest direction that has one stands in, with confidence 0, so that the
/// channels that look at neighbouring bins see no jump.
#[must_use]
pub fn scan(ranges: &Ranges, height: i8, sighting: &Sighting) -> (Scan, Confidence) {
    let mut scan = Scan::OPEN;
    let mut confidence = [0; BINS];
    let found: [_; BINS] = core::array::from_fn(|bin| ranges.range(bin, height));
    let seen = sighting.hit.iter().zip(sighting.confidence.sixteenths());
    let rays = scan.steps.iter_mut().zip(&mut scan.hit).zip(&mut confidence);
    for (bin, (((steps, hit), confidence), (looks, sure))) in rays.zip(seen).enumerate() {
        let Some(range) = nearest(&found, bin) else { continue };
        let open = range.metres >= FARTHEST_M;
        *steps = if open { MAX_STEPS } else { steps_of(range.metres) };
        *hit = if open { Hit::Open } else { *looks };
        if found.get(bin).is_some_and(Option::is_some) {
            let sixteenths = libm::roundf(16.0 * range.confidence) as u8;
            *confidence = if *sure == 0 { sixteenths } else { sixteenths.max(1) };
        }
    }
    (scan, Confidence::new(&confidence))
}

/// What was found in a bin, or in the nearest one that has something.
fn nearest<T: Copy>(found: &[Option<T>; BINS], bin: usize) -> Option<T> {
    (0..=BINS / 2).find_map(|distance| {
        let at = |bin: usize| found.get(bin % BINS).copied().flatten();
        at(bin + distance).or_else(|| at(bin + BINS - distance))
    })
}

fn steps_of(metres: f32) -> u16 {
    (libm::roundf(metres * f32::from(STEPS_PER_METRE)) as u16).clamp(1, MAX_STEPS)
}
