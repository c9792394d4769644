//! Disturbance of a scan, to test the matching on imperfect queries.

use compass_core::base::num::BINS;
use compass_core::base::scan::{Hit, MAX_STEPS, Scan};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Relative standard deviation of ranges per unit of level.
pub const RANGE_SHARE: f64 = 0.03;
/// Share of flipped hit types per unit of level.
pub const HIT_SHARE: f64 = 0.05;
/// Occluders per unit of level.
pub const OCCLUDERS: f64 = 2.0;

/// Disturbs a scan. At level 1 ranges get 3 % of Gaussian noise, 5 % of the bins swap wall and window,
/// and two occluders of 10 to 35 degrees stand 1 to 2.2 m away; other levels scale all three.
///
/// Open bins keep their range. The same seed gives the same scan.
pub fn disturb(scan: &mut Scan, level: f64, seed: u64) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    for (steps, hit) in scan.steps.iter_mut().zip(&mut scan.hit) {
        // The sum of twelve uniform numbers: close to a Gaussian, and the same on every machine.
        let gauss: f64 = (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mistaken = rng.random::<f64>() < HIT_SHARE * level;
        if *hit == Hit::Open {
            continue;
        }
        let range = f64::from(*steps) * (1.0 + RANGE_SHARE * level * gauss);
        *steps = range.round().clamp(1.0, f64::from(MAX_STEPS)) as u16;
        if mistaken {
            *hit = if *hit == Hit::Wall { Hit::Window } else { Hit::Wall };
        }
    }
    for _ in 0..(OCCLUDERS * level).round() as usize {
        let (start, width) = (rng.random_range(0..BINS), rng.random_range(10..=35));
        let distance = rng.random_range(50..=110);
        for bin in (start..start + width).map(|bin| bin % BINS) {
            if scan.steps[bin] > distance {
                (scan.steps[bin], scan.hit[bin]) = (distance, Hit::Wall);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_disturbs_about_as_much_as_it_says() {
        let clean = Scan { steps: [500; BINS], hit: [Hit::Wall; BINS] };
        let mut none = clean;
        disturb(&mut none, 0.0, 1);
        assert_eq!(clean, none);
        let (mut flipped, mut near) = (0, 0);
        for seed in 0..50 {
            let mut scan = clean;
            disturb(&mut scan, 1.0, seed);
            flipped += scan.count(Hit::Window);
            near += scan.steps.iter().filter(|&&s| s <= 110).count();
        }
        assert!((600..1100).contains(&flipped), "5 % of 18,000 bins less the occluded: {flipped}");
        assert!((1500..2600).contains(&near), "two occluders of 22 bins: {near}");
    }
}
