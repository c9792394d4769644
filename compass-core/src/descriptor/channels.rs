//! The 5 x 360 descriptor of a scan (paper: multi-channel scene signature).
//!
//! Channels 0 to 3 are rational in whole march steps and rounded once to [`ChannelValue`]: within 2^-14 of the real value.
//! Channel 4 is a square root: within 2^-13.

use crate::base::num::{BINS, ChannelValue};
use crate::base::scan::{Hit, MAX_STEPS, STEPS_PER_METRE, Scan};

/// Number of channels.
pub const CHANNELS: usize = 5;

/// The channels of a descriptor, in the paper's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// Range r / 30 m.
    Range = 0,
    /// Hit type: 1.0 wall, 0.5 window, 0.0 open.
    HitType = 1,
    /// min(|dr/dtheta| / 5 m, 1): central difference of the range per bin.
    Gradient = 2,
    /// Proximity 1 / (1 + r), r in metres.
    Proximity = 3,
    /// Standard deviation of r over the bins j-5..=j+5, divided by 10 m; at most 1.5.
    Deviation = 4,
}

impl Channel {
    /// All channels in order.
    pub const ALL: [Self; CHANNELS] =
        [Self::Range, Self::HitType, Self::Gradient, Self::Proximity, Self::Deviation];
}

/// Accuracy bound of a channel value against the real-valued descriptor of the same ranges: 2^-9.
pub const LEVEL_ERROR: ChannelValue = ChannelValue::from_bits(1 << 5);

/// Half width in bins of the window of [`Channel::Deviation`].
pub const DEVIATION_REACH: usize = 5;
/// Width of that window in bins.
#[expect(clippy::cast_possible_truncation, reason = "the value is 11")]
const WINDOW: u32 = 2 * DEVIATION_REACH as u32 + 1;

/// Five channels of 360 circular bins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// `levels[channel][bin]`; bin j looks along heading + j degrees, counter-clockwise.
    pub levels: [[ChannelValue; BINS]; CHANNELS],
}

impl Default for Descriptor {
    fn default() -> Self {
        Self::ZERO
    }
}

impl Descriptor {
    /// All zero, to be filled by [`Descriptor::fill`].
    pub const ZERO: Self = Self { levels: [[ChannelValue::ZERO; BINS]; CHANNELS] };

    /// Computes the descriptor of a scan.
    ///
    /// # Formats
    /// Ranges in march steps of 0.02 m, 1 to 1500; channel values in I2F14, within [0, 1], [`Channel::Deviation`] within
    /// [0, 1.5].
    ///
    /// # Accuracy
    /// Within 2^-14 of the real value, [`Channel::Deviation`] within 2^-13 (test `every_channel_is_within_its_bound`).
    ///
    /// # Cost
    /// Linear in the bins: two divisions per bin for range and proximity, one for the gradient, a square root and a
    /// division for the deviation, whose sums are running sums. Cortex-M7: `descriptor` in `targets/budget.txt`.
    ///
    /// # References
    /// The paper's multi-channel scene signature.
    ///
    /// ```
    /// use compass_core::descriptor::{Channel, Descriptor};
    /// use compass_core::{Hit, Scan};
    ///
    /// // Walls at 3 m all around.
    /// let mut descriptor = Descriptor::ZERO;
    /// descriptor.fill(&Scan { steps: [150; 360], hit: [Hit::Wall; 360] });
    /// let value = |channel| descriptor.channel(channel)[0].to_num::<f32>();
    /// assert_eq!((value(Channel::HitType), value(Channel::Gradient)), (1.0, 0.0));
    /// assert!((value(Channel::Range) - 0.1).abs() < 1e-4);
    /// assert_eq!(value(Channel::Proximity), 0.25);
    /// ```
    pub fn fill(&mut self, scan: &Scan) {
        let [range, hit_type, gradient, proximity, deviation] = &mut self.levels;
        for (level, &steps) in range.iter_mut().zip(&scan.steps) {
            *level = ratio(u32::from(steps), u32::from(MAX_STEPS));
        }
        for (level, &hit) in hit_type.iter_mut().zip(&scan.hit) {
            *level = hit_level(hit);
        }
        fill_gradient(gradient, &scan.steps);
        for (level, &steps) in proximity.iter_mut().zip(&scan.steps) {
            let metre = u32::from(STEPS_PER_METRE);
            *level = ratio(metre, metre + u32::from(steps));
        }
        fill_deviation(deviation, &scan.steps);
    }

    /// The values of a channel.
    #[must_use]
    pub const fn channel(&self, channel: Channel) -> &[ChannelValue; BINS] {
        let [range, hit_type, gradient, proximity, deviation] = &self.levels;
        match channel {
            Channel::Range => range,
            Channel::HitType => hit_type,
            Channel::Gradient => gradient,
            Channel::Proximity => proximity,
            Channel::Deviation => deviation,
        }
    }
}

impl From<&Scan> for Descriptor {
    fn from(scan: &Scan) -> Self {
        let mut descriptor = Self::default();
        descriptor.fill(scan);
        descriptor
    }
}

/// The channel value of a hit type (paper: 1.0 wall, 0.5 window, 0.0 open).
#[must_use]
pub const fn hit_level(hit: Hit) -> ChannelValue {
    match hit {
        Hit::Wall => ChannelValue::ONE,
        Hit::Window => ChannelValue::from_bits(ChannelValue::ONE.to_bits() / 2),
        Hit::Open => ChannelValue::ZERO,
    }
}

/// numerator / denominator as a channel value, rounded to the nearest; the quotient must be below 2.
#[expect(
    clippy::cast_possible_truncation,
    reason = "quotients are below 2, so that 14 fractional bits fit 16 bits"
)]
const fn ratio(numerator: u32, denominator: u32) -> ChannelValue {
    ChannelValue::from_bits((((numerator << 14) + denominator / 2) / denominator) as i16)
}

/// min(|r[j+1] - r[j-1]| / 2 / 5 m, 1): the difference in steps divided by 500.
fn fill_gradient(levels: &mut [ChannelValue; BINS], steps: &[u16; BINS]) {
    let saturated = 500;
    let after = steps.iter().cycle().skip(1);
    let before = steps.iter().cycle().skip(BINS - 1);
    for (level, (&a, &b)) in levels.iter_mut().zip(after.zip(before)) {
        *level = ratio(u32::from(a.abs_diff(b)).min(saturated), saturated);
    }
}

/// Standard deviation from running sums over the circular window: sqrt(n sum(r^2) - sum(r)^2) / n.
fn fill_deviation(levels: &mut [ChannelValue; BINS], steps: &[u16; BINS]) {
    let (mut sum, mut squares) = (0_u32, 0_u32);
    let first = BINS - DEVIATION_REACH;
    for &s in steps.iter().cycle().skip(first).take(WINDOW as usize) {
        sum += u32::from(s);
        squares += u32::from(s) * u32::from(s);
    }
    let entering = steps.iter().cycle().skip(DEVIATION_REACH + 1);
    let leaving = steps.iter().cycle().skip(first);
    for (level, (&new, &old)) in levels.iter_mut().zip(entering.zip(leaving)) {
        *level = deviation(sum, squares);
        sum = sum + u32::from(new) - u32::from(old);
        squares = squares + u32::from(new) * u32::from(new) - u32::from(old) * u32::from(old);
    }
}

/// The standard deviation of 11 ranges as a channel value, from sum and sum of squares in steps.
fn deviation(sum: u32, squares: u32) -> ChannelValue {
    // 121 variance, at most 121 * 750^2 < 2^26.1: four more bits fit.
    let spread = (WINDOW * squares - sum * sum) << 4;
    // 4 * 11 * standard deviation in steps, over 44 * 500 steps (10 m).
    ratio(spread.isqrt(), 4 * WINDOW * 10 * u32::from(STEPS_PER_METRE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn scans() -> impl Strategy<Value = Scan> {
        proptest::collection::vec((1u16..=MAX_STEPS, 0u8..3), BINS).prop_map(|bins| {
            let mut scan = Scan::OPEN;
            for (j, (steps, hit)) in bins.into_iter().enumerate() {
                scan.hit[j] = [Hit::Open, Hit::Window, Hit::Wall][usize::from(hit)];
                scan.steps[j] = if hit == 0 { MAX_STEPS } else { steps };
            }
            scan
        })
    }

    /// The channels straight from their definition, in f64.
    fn expected(scan: &Scan, j: usize) -> [f64; CHANNELS] {
        let r = |i: isize| f64::from(scan.steps[(j as isize + i).rem_euclid(360) as usize]) * 0.02;
        let window: Vec<f64> = (-5..=5).map(r).collect();
        let mean = window.iter().sum::<f64>() / 11.0;
        let variance = window.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 11.0;
        let hit = match scan.hit[j] {
            Hit::Wall => 1.0,
            Hit::Window => 0.5,
            Hit::Open => 0.0,
        };
        let gradient = ((r(1) - r(-1)).abs() / 2.0 / 5.0).min(1.0);
        [r(0) / 30.0, hit, gradient, 1.0 / (1.0 + r(0)), variance.sqrt() / 10.0]
    }

    proptest! {
        #[test]
        fn every_channel_is_within_its_bound(scan in scans()) {
            let descriptor = Descriptor::from(&scan);
            for j in 0..BINS {
                for (channel, expected) in Channel::ALL.into_iter().zip(expected(&scan, j)) {
                    let bound = if channel == Channel::Deviation { 2f64.powi(-13) } else { 2f64.powi(-14) };
                    let got = descriptor.channel(channel)[j].to_num::<f64>();
                    prop_assert!((got - expected).abs() <= bound, "{channel:?} bin {j}: {got} {expected}");
                }
            }
        }

        #[test]
        fn rotation_of_the_scan_rotates_the_descriptor(scan in scans(), by in 0usize..360) {
            let mut turned = scan;
            turned.steps.rotate_left(by);
            turned.hit.rotate_left(by);
            let mut descriptor = Descriptor::from(&scan);
            for channel in &mut descriptor.levels {
                channel.rotate_left(by);
            }
            prop_assert_eq!(descriptor, Descriptor::from(&turned));
        }
    }

    #[test]
    fn extremes_do_not_overflow() {
        let mut scan = Scan::OPEN;
        for j in (0..BINS).step_by(2) {
            scan.steps[j] = 1;
            scan.hit[j] = Hit::Wall;
        }
        let descriptor = Descriptor::from(&scan);
        let deviation = descriptor.channel(Channel::Deviation)[0].to_num::<f64>();
        assert!((1.49..1.5).contains(&deviation), "{deviation}");
        assert_eq!(Descriptor::from(&Scan::OPEN).channel(Channel::Range)[7], ChannelValue::ONE);
    }
}
