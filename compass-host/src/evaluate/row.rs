//! Errors and their statistics over all frames.

use super::record::Found;
use crate::dataset::tum::Pose;
use crate::output::Decimal;
use crate::site::wrapped;
use compass_core::pose::FloorLayer;
use serde::Serialize;

/// The score falls to 10^(-1/5) per metre of error.
const DECAY_PER_M: f64 = -0.460_517_018_598_809_17;

/// The error of a pose; infinite without a pose or on the wrong floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misses {
    /// Metres.
    pub metres: f64,
    /// Degrees.
    pub degrees: f64,
}

impl Misses {
    /// No pose.
    pub const ALL: Self = Self { metres: f64::INFINITY, degrees: f64::INFINITY };

    /// Within 1 m and 30 degrees.
    #[must_use]
    pub fn is_right(self) -> bool {
        self.metres <= 1.0 && self.degrees <= 30.0
    }

    /// 100 exp(-0.46 error), 0 without a pose.
    #[must_use]
    pub fn score(self) -> f64 {
        100.0 * (DECAY_PER_M * self.metres).exp()
    }
}

/// Compares layers with the true floor.
#[derive(Debug, Clone, Copy)]
pub struct Judge<'a> {
    /// The layers to which the indices of poses refer.
    pub layers: &'a [FloorLayer<'a>],
    /// The true floor.
    pub floor: usize,
}

impl Judge<'_> {
    /// Whether a pose is on the true floor.
    #[must_use]
    pub fn is_on_floor(&self, found: &Found) -> bool {
        let floor = self.layers.get(usize::from(found.layer)).map(|layer| usize::from(layer.floor));
        floor == Some(self.floor)
    }

    /// The error of a pose.
    #[must_use]
    pub fn misses(&self, found: Option<&Found>, truth: &Pose) -> Misses {
        let Some(found) = found.filter(|found| self.is_on_floor(found)) else { return Misses::ALL };
        let [x, y] = found.position();
        let turn = wrapped(found.heading_deg() - truth.heading_deg());
        Misses { metres: (x - truth.position.x).hypot(y - truth.position.y), degrees: turn.abs() }
    }
}

/// The errors of one localization method over all frames with ground truth.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the method.
    pub name: &'static str,
    /// Number of frames.
    pub scored: usize,
    /// Number of frames with a pose on the right floor.
    pub found: usize,
    /// Median position error, metres; null where fewer than half of the frames have a pose, as in the fields below.
    pub median_position_error_m: Decimal,
    /// Degrees.
    pub median_heading_error_deg: Decimal,
    /// Share of frames within 0.1 m.
    pub recall_at_0_1_m: Decimal,
    /// Share of frames within 0.5 m.
    pub recall_at_0_5_m: Decimal,
    /// Share of frames within 1 m.
    pub recall_at_1_m: Decimal,
    /// Share of frames within 1 m and 30 degrees.
    pub recall_at_1_m_30_deg: Decimal,
    /// Mean of the frames' scores.
    pub challenge_score: Decimal,
}

impl Row {
    /// Computes the statistics.
    #[must_use]
    pub fn of(name: &'static str, misses: &[Misses]) -> Self {
        let scored = misses.len();
        let share = |is: &dyn Fn(&Misses) -> bool| {
            Decimal(misses.iter().filter(|misses| is(misses)).count() as f64 / scored as f64)
        };
        let within = |metres: f64| share(&|misses| misses.metres <= metres);
        Self {
            name,
            scored,
            found: misses.iter().filter(|misses| misses.metres.is_finite()).count(),
            median_position_error_m: Decimal(median(misses.iter().map(|misses| misses.metres))),
            median_heading_error_deg: Decimal(median(misses.iter().map(|misses| misses.degrees))),
            recall_at_0_1_m: within(0.1),
            recall_at_0_5_m: within(0.5),
            recall_at_1_m: within(1.0),
            recall_at_1_m_30_deg: share(&|misses| misses.is_right()),
            challenge_score: Decimal(misses.iter().map(|misses| misses.score()).sum::<f64>() / scored as f64),
        }
    }
}

/// The lower median; NaN for an empty list.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_count_what_was_not_found() {
        let misses = [(0.05, 1.0), (0.4, 40.0), (0.9, 2.0), (5.0, 90.0)]
            .map(|(metres, degrees)| Misses { metres, degrees });
        let row = Row::of("x", &[misses.as_slice(), &[Misses::ALL]].concat());
        assert_eq!((row.scored, row.found), (5, 4));
        assert_eq!(row.median_position_error_m, Decimal(0.9));
        let recalls = [row.recall_at_0_1_m, row.recall_at_0_5_m, row.recall_at_1_m, row.recall_at_1_m_30_deg];
        assert_eq!(recalls, [0.2, 0.4, 0.6, 0.4].map(Decimal));
        assert!((Misses { metres: 5.0, degrees: 0.0 }.score() - 10.0).abs() < 1e-9);
        assert_eq!(Misses::ALL.score(), 0.0);
        assert!(!Row::of("none", &[]).challenge_score.0.is_finite());
    }
}
