//! Upright edges of the images against jumps and corners of the plan.

use crate::base::circle::Circle;
use crate::base::num::{BINS, Nats};
use crate::base::scan::Scan;

/// Smallest jump of the logarithm of the range between neighbouring rays, and its least ratio to those on either side.
const JUMP: f32 = 0.12;
const JUMP_RATIO: f32 = 1.5;
/// Smallest change of the slope of the logarithm of the range, between neighbouring bins, at a corner.
const CORNER: f32 = 0.015;
/// Log-likelihood ratios by the class of the strongest edge, of a jump and of a corner, against all directions.
const JUMP_NATS: [Nats; 7] = [
    Nats::ZERO,
    Nats::lit("-1.61"),
    Nats::lit("-1.25"),
    Nats::lit("-0.51"),
    Nats::lit("-0.56"),
    Nats::lit("0.48"),
    Nats::lit("1.19"),
];
const CORNER_NATS: [Nats; 7] = [
    Nats::ZERO,
    Nats::lit("-0.08"),
    Nats::lit("-0.38"),
    Nats::lit("-0.38"),
    Nats::lit("-0.03"),
    Nats::lit("0.24"),
    Nats::lit("0.50"),
];
/// Weight of the sum.
const WEIGHT: i32 = 2;

/// Log-likelihood ratio of the upright edges seen, by class, at a pose of which `scan` is cast.
pub(super) fn score(scan: &Scan, classes: &[u8; BINS]) -> Nats {
    let logs = Circle::from_fn(|bin| libm::logf(f32::from(scan.steps.get(bin).copied().unwrap_or(1).max(1))));
    let rise = Circle::from_fn(|bin| logs.get(bin + 1) - logs.get(bin));
    let is_jump = Circle::from_fn(|bin| {
        let beside = rise.get(bin + BINS - 1).abs().max(rise.get(bin + 1).abs());
        rise.get(bin).abs() > JUMP + JUMP_RATIO * beside
    });
    let mut sum = Nats::ZERO;
    for (bin, class) in classes.iter().enumerate() {
        let class = usize::from(*class);
        let jumps = [bin, bin + BINS - 1].map(|bin| is_jump.get(bin));
        let nats = if jumps[0] || jumps[1] {
            &JUMP_NATS
        } else if (rise.get(bin) - rise.get(bin + BINS - 1)).abs() > CORNER {
            &CORNER_NATS
        } else {
            continue;
        };
        sum += nats.get(class).copied().unwrap_or(Nats::ZERO);
    }
    sum * WEIGHT
}
