//! The region cue of the floor: which gray levels are more frequent near the camera's feet than around the horizon.
//!
//! The boundary of the floor parts cells that look like the floor near the camera from cells that look like the walls
//! around the horizon. Where floor and walls look alike, the ratio of their frequencies is 1 and the cue is silent.

use super::cells::{DEEPEST, ROWS};
use super::tuning::{ABOVE_DEG, BASE_DENSITY, BELOW_DEG, MOST_REGION, NEAR_DEG};
use crate::base::ladder::RUNG;
use crate::base::num::{BINS, count_as_i32, round_to_i16};
use micromath::F32Ext;

/// Gray levels of a bin of a histogram.
const STEP: usize = 22;
const HISTOGRAM: usize = 12;

/// Log-likelihood ratio of "floor" against "wall", 1/256 nat, by gray level; 0 for level 0, which is unknown.
pub(super) fn ratios(floor: &[u8], ceiling: &[u8]) -> [i16; 256] {
    let near = histogram(&[(floor, NEAR_DEG)]);
    let far = histogram(&[(floor, BELOW_DEG), (ceiling, ABOVE_DEG)]);
    let of_bin = |bin: usize| {
        let density =
            |histogram: &[f32; HISTOGRAM]| histogram.get(bin).copied().unwrap_or(0.0) + BASE_DENSITY;
        F32Ext::ln(density(&near) / density(&far)).clamp(-MOST_REGION, MOST_REGION)
    };
    core::array::from_fn(|gray| {
        if gray == 0 {
            return 0;
        }
        // Linear between the middles of the bins.
        let position = 2 * gray + STEP;
        let (above, fraction) = (position / (2 * STEP), position % (2 * STEP));
        let [below, above] = [above.saturating_sub(1), above.min(HISTOGRAM - 1)].map(of_bin);
        round_to_i16(256.0 * (below + (above - below) * fraction as f32 / (2 * STEP) as f32))
    })
}

/// Smoothed histogram of the gray levels between elevations, which sums to 1; rows count by the angle they extend over.
fn histogram(surfaces: &[(&[u8], [f32; 2])]) -> [f32; HISTOGRAM] {
    let mut counts = [0_u32; HISTOGRAM];
    for (gray, degrees) in surfaces {
        for (row, gray) in gray.chunks_exact(BINS).enumerate().take(ROWS) {
            let cot = libm::expf(DEEPEST + row as f32 * (RUNG / 2.0));
            let elevation = libm::atanf(1.0 / cot).to_degrees();
            if !(degrees[0]..=degrees[1]).contains(&elevation) {
                continue;
            }
            // Extent of the row in elevation, d(elevation) / du = cot / (1 + cot^2).
            let weight = crate::base::num::saturate_to_u32(count_as_i32(
                crate::base::num::truncate_to_index(256.0 * cot / (1.0 + cot * cot)),
            ));
            for level in gray.iter().filter(|level| **level > 0) {
                if let Some(count) = counts.get_mut(usize::from(*level) / STEP) {
                    *count += weight;
                }
            }
        }
    }
    let whole = counts.iter().sum::<u32>().max(1) as f32;
    core::array::from_fn(|bin| {
        let at = |bin: usize| counts.get(bin).copied().unwrap_or(0) as f32;
        (at(bin.wrapping_sub(1)) + 2.0 * at(bin) + at(bin + 1)) / (4.0 * whole)
    })
}
