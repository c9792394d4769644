//! Prediction of a scan from a displaced position, by parallax.
//!
//! The end points of the rays cast from one position are fixed in the plan: from a displaced position they have other
//! directions and ranges. Occlusion is ignored. The prediction costs a fraction of a new cast and is accurate for
//! displacements that are short relative to the ranges.

use super::evidence::EvidenceTable;
use crate::base::num::{BINS, Metres, Point, Turn, degree_sine};
use crate::base::scan::{Hit, MAX_STEPS, STEPS_PER_METRE};
use crate::map::plan::{MarchError, Plan};
use heapless::Vec;

/// Capacity in rays: every fourth of 360.
const MAX_RAYS: usize = BINS / 4;
/// Units of length per march step.
const PARTS: i32 = 16;
/// Largest displacement along an axis, in units of length: 1 m.
const LONGEST: i64 = PARTS as i64 * STEPS_PER_METRE as i64;
/// Fractional bits of sines.
const SINE_BITS: u32 = 14;

/// Sines of 0 to 449 degrees, Q14: those from 90 on are the cosines.
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time")]
static SINES: [i16; BINS + BINS / 4] = {
    let mut sines = [0; BINS + BINS / 4];
    let mut degrees = 0;
    while degrees < sines.len() {
        sines[degrees] = ((degree_sine(degrees) + (1 << 15)) >> 16) as i16;
        degrees += 1;
    }
    sines
};

/// End points of some of the 360 rays cast from a pose.
#[derive(Debug)]
pub(super) struct View {
    heading: Turn,
    stride: usize,
    /// Bin of the first ray.
    first: usize,
    /// Range in march steps and hit type.
    rays: Vec<(u16, Hit), MAX_RAYS>,
}

impl View {
    /// Casts every `stride`-th ray, at most [`MAX_RAYS`].
    pub(super) fn cast(plan: &Plan<'_>, at: Point, heading: Turn, stride: usize) -> Result<Self, MarchError> {
        let mut rays = Vec::new();
        for ray in plan.rays(at, heading, stride)?.take(MAX_RAYS) {
            // Never full: as many were taken as fit.
            let _ = rays.push(ray);
        }
        Ok(Self { heading, stride, first: 0, rays })
    }

    /// The same with all ranges scaled, in percent.
    #[expect(clippy::cast_possible_truncation, reason = "at most MAX_STEPS")]
    pub(super) fn scaled(&self, percent: u16) -> Self {
        let mut scaled =
            Self { heading: self.heading, stride: self.stride, first: self.first, rays: self.rays.clone() };
        for (steps, _) in &mut scaled.rays {
            let range = (u32::from(*steps) * u32::from(percent) + 50) / 100;
            *steps = range.min(MAX_STEPS.into()) as u16;
        }
        scaled
    }

    /// Changes the heading, by whole degrees.
    pub(super) fn turn(&mut self, heading: Turn) {
        self.first = (self.first + BINS - (heading - self.heading).to_bin()) % BINS;
        self.heading = heading;
    }

    /// Predicted scores at a displaced position and at headings around that of the view, in steps of 1 degree.
    ///
    /// `aside` is the displacement `[x, y]` in map axes, each clamped to +-1 m. Scores are scaled to 360 bins, the bits of
    /// [`CastNats`](crate::base::num::CastNats).
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "strides are at most 360"
    )]
    pub(super) fn scores<const HEADINGS: usize>(
        &self,
        table: &EvidenceTable,
        aside: [Metres; 2],
    ) -> [i32; HEADINGS] {
        let mut scores = [0; HEADINGS];
        let aside = self.along_heading(aside);
        let mut bin = self.first;
        for &(steps, hit) in &self.rays {
            let (seen_in, steps) = seen(aside, bin, steps);
            table.between(steps, hit).add_around(seen_in, &mut scores);
            bin += self.stride;
            bin -= if bin < BINS { 0 } else { BINS };
        }
        scores.map(|score| score * self.stride as i32)
    }

    /// A displacement in map axes as `[forward, left]`, in units of length.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "components of a vector of at most 800 along each axis"
    )]
    fn along_heading(&self, aside: [Metres; 2]) -> [i32; 2] {
        let [x, y] = aside.map(|part| (((part.to_bits() >> 16) * LONGEST) >> 16).clamp(-LONGEST, LONGEST));
        let (cos, sin) = self.heading.cos_sin();
        let (cos, sin) = (i64::from(cos.to_bits()), i64::from(sin.to_bits()));
        [(x * cos + y * sin) >> 30, (y * cos - x * sin) >> 30].map(|part| part as i32)
    }
}

/// Bin and range in march steps of a ray's end point, from a displaced position.
///
/// The result is wrong, but valid, for end points nearer than the displacement.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "bins are below 360; ranges are at most 1500 steps and 1.5 m more"
)]
fn seen([forward, left]: [i32; 2], bin: usize, steps: u16) -> (usize, u16) {
    let sine = |degrees: usize| i32::from(SINES.get(degrees).copied().unwrap_or(0));
    let (sin, cos) = (sine(bin), sine(bin + BINS / 4));
    // Components of the end point across and along the ray, relative to the displaced position.
    let across = (forward * sin - left * cos) >> SINE_BITS;
    let along =
        (i32::from(steps) * PARTS - ((forward * cos + left * sin) >> SINE_BITS)).max(across.abs()).max(1);
    // atan t = t (pi / 4 + 0.273 (1 - |t|)) within 0.25 degrees, t up to 1 in 1/256; in 1/256 degree.
    let slope = (across << 8) / along;
    let turned = (slope * (45 * 256 + ((4004 * (256 - slope.abs())) >> 8))) >> 8;
    let bin = (bin as i32 + ((turned + 128) >> 8)).rem_euclid(BINS as i32) as usize;
    let range = along + ((across * slope) >> 9);
    (bin, ((range + PARTS / 2) / PARTS) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::num::Nats;
    use crate::pose::plane_of;
    use crate::pose::tests::{Building, point};
    use proptest::prelude::*;
    use std::boxed::Box;

    proptest! {
        #[test]
        fn predicted_end_points_match_exact_geometry(
            forward in -400_i32..=400, left in -400_i32..=400, bin in 0_usize..BINS, steps in 60_u16..=MAX_STEPS,
        ) {
            let angle = (bin as f64).to_radians();
            let parts = f64::from(PARTS);
            let end = [angle.cos(), angle.sin()].map(|unit| unit * f64::from(steps) * parts);
            let (x, y) = (end[0] - f64::from(forward), end[1] - f64::from(left));
            let (found, range) = seen([forward, left], bin, steps);
            let off = (y.atan2(x).to_degrees() - found as f64 + 540.0).rem_euclid(360.0) - 180.0;
            prop_assert!(off.abs() <= 0.5 + 0.3, "{} degrees off", off);
            let exact = x.hypot(y) / parts;
            prop_assert!((f64::from(range) - exact).abs() <= 0.7 + 0.01 * exact, "{} for {}", range, exact);
        }

        #[test]
        fn end_points_nearer_than_the_displacement_stay_in_range(forward in -1200_i32..=1200, left in -1200_i32..=1200, bin in 0_usize..BINS, steps in 0_u16..60) {
            let (found, range) = seen([forward, left], bin, steps);
            prop_assert!(found < BINS && range <= MAX_STEPS);
        }
    }

    #[test]
    fn a_turned_view_equals_a_shift_of_the_scores() {
        let building = Building::new();
        let layer = building.layer();
        let (at, heading) = (point(7.1, 2.3), Turn::from_ratio(33, 360));
        let mut table = Box::new(EvidenceTable::EMPTY);
        for (bin, (steps, hit)) in
            layer.plan.rays(at, heading + Turn::from_ratio(3, 360), 1).unwrap().enumerate()
        {
            table.set(plane_of(steps, hit), bin, Nats::from_bits(40));
        }
        let mut view = View::cast(&layer.plan, at, heading, 4).unwrap();
        let nowhere = [Metres::ZERO; 2];
        let around: [i32; 9] = view.scores(&table, nowhere);
        let best = around.iter().max();
        assert_eq!(around.iter().position(|score| Some(score) == best), Some(7), "3 degrees to the left");
        view.turn(heading + Turn::from_ratio(3, 360));
        let there: [i32; 1] = view.scores(&table, nowhere);
        assert_eq!(there[0], around[7]);
        view.turn(heading);
        assert_eq!(view.scores::<9>(&table, nowhere), around);
    }

    #[test]
    fn displacements_are_rotated_into_the_heading() {
        let building = Building::new();
        let view = View::cast(&building.layer().plan, point(7.1, 2.3), Turn::from_ratio(1, 4), 4).unwrap();
        let half = Metres::from_num(0.5);
        // North is ahead, west to the left.
        assert_eq!(view.along_heading([Metres::ZERO, half]), [400, 0]);
        assert_eq!(view.along_heading([-half, Metres::ZERO]), [0, 400]);
        assert_eq!(view.along_heading([Metres::MAX, Metres::ZERO]), [0, -800]);
    }
}
