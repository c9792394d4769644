//! How strong the upright edges are in each direction: corners of rooms, door frames, the ends of walls.
//!
//! An upright edge at a column of the panorama separates the columns to its right from those to its left at all elevations.
//! Bands of elevation are summed by the logarithm of their significance, so that a long edge counts more than a strong one.

use crate::base::circle::Circle;
use crate::base::num::BINS;
use crate::base::order;
use crate::vision::panorama::{BOTTOM_DEG, Resolution};
use micromath::F32Ext;

/// Elevation of the upper border of the first band and the height of a band, degrees.
const TOP_DEG: i32 = 15;
const BAND_DEG: i32 = 5;
const BANDS: i32 = 8;
const _: () = assert!(TOP_DEG - BAND_DEG * BANDS >= BOTTOM_DEG, "bands lie in the panorama");
/// Variance of a mean that noise alone has, squared gray levels.
const NOISE_VARIANCE: f32 = 1.0;
/// Angle on either side of a direction within which its edge may lie, halves of a degree.
const REACH_HALVES: usize = 3;
/// Classes of strength.
pub(crate) const CLASSES: usize = 6;

/// The class of the strongest upright edge near each direction within the frame: 1 for the weakest sixth of directions to 6
/// for the strongest, 0 where nothing is seen.
#[inline(always)]
pub(super) fn classes(gray: &[u8], resolution: Resolution) -> [u8; BINS] {
    let (per_degree, columns) = (resolution.per_degree(), resolution.columns());
    let mut strengths = [0.0; Resolution::FINE.columns()];
    for (border, slot) in strengths.iter_mut().enumerate().take(columns) {
        *slot = strength(gray, border, resolution);
    }
    // The border between two columns that lies at a bin, and those around it.
    let strongest = |bin: usize| {
        let border = (BINS + 180 - bin) * per_degree;
        let reach = REACH_HALVES * per_degree / 2;
        let around = (border - reach..=border + reach).filter_map(|border| strengths.get(border % columns));
        around.fold(0.0, |most: f32, strength| most.max(*strength))
    };
    classify(&Circle::from_fn(strongest))
}

#[expect(clippy::cast_possible_truncation, reason = "classes are at most 6")]
fn classify(strengths: &Circle<f32>) -> [u8; BINS] {
    let mut sorted = *strengths.bins();
    order::sort_by_key(&mut sorted, |strength| strength.to_bits());
    let unseen = sorted.iter().take_while(|strength| **strength <= 0.0).count();
    let seen = (BINS - unseen).max(1);
    let class = |strength: &f32| {
        let below = sorted.partition_point(|other| other < strength).saturating_sub(unseen);
        if *strength <= 0.0 { 0 } else { (1 + below * CLASSES / seen).min(CLASSES) as u8 }
    };
    core::array::from_fn(|bin| class(&strengths.get(bin)))
}

/// Strength of the edge at the left border of a column.
#[inline(always)]
fn strength(gray: &[u8], border: usize, resolution: Resolution) -> f32 {
    let (rows, columns, width) = (resolution.rows(), resolution.columns(), resolution.per_degree());
    let column = |offset: usize| {
        let from = (border + offset + columns - width) % columns * rows;
        gray.get(from..from + rows).unwrap_or_default()
    };
    let mut sum = 0.0;
    for band in 0..BANDS {
        let from = resolution.row_of(TOP_DEG - BAND_DEG * band);
        let to = resolution.row_of(TOP_DEG - BAND_DEG * (band + 1));
        let mut differences = [0_i16; BAND_DEG as usize * Resolution::FINE.per_degree()];
        let mut least = [u8::MAX; BAND_DEG as usize * Resolution::FINE.per_degree()];
        for offset in 0..2 * width {
            let sign = if offset < width { -1 } else { 1 };
            let levels = column(offset).get(from..to).unwrap_or_default();
            for ((difference, least), level) in differences.iter_mut().zip(&mut least).zip(levels) {
                *difference += sign * i16::from(*level);
                *least = (*least).min(*level);
            }
        }
        let (mut n, mut whole, mut squares) = (0, 0, 0);
        for (difference, least) in differences.iter().zip(least).take(to - from) {
            if least > 0 {
                n += 1;
                whole += i32::from(*difference);
                squares += i32::from(*difference) * i32::from(*difference);
            }
        }
        if n > 0 {
            let (n, width) = (n as f32, width as f32);
            let mean = whole as f32 / (n * width);
            let variance = (squares as f32 / (n * width * width) - mean * mean).max(0.0);
            sum += F32Ext::ln(1.0 + mean.abs() * inverse_root(variance / n + NOISE_VARIANCE));
        }
    }
    sum
}

/// `1 / sqrt(value)` within 0.5 %: a step of Newton's method from micromath's estimate.
#[inline(always)]
fn inverse_root(value: f32) -> f32 {
    let estimate = F32Ext::invsqrt(value);
    estimate * (1.5 - 0.5 * value * estimate * estimate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_roots_are_within_their_bound() {
        for k in 1..4000_u16 {
            let value = 1.0 + f32::from(k) * f32::from(k) / 1000.0;
            let error = inverse_root(value) * value.sqrt() - 1.0;
            assert!(error.abs() < 0.005, "{value}: {error}");
        }
    }
}
