//! Whether covariances are honest: how many errors of right answers lie within 1, 2 and 3 standard deviations.

use super::judged::JudgedFrame;
use crate::dataset::tum::Pose;
use crate::evaluate::Record;
use crate::output::Decimal;
use crate::site::wrapped;
use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

/// Probability from which an answer counts as said.
const SAID: f32 = 0.5;

/// Shares of the errors of right answers within 1, 2 and 3 standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// Number of right answers: said with a probability of one half or more, within 1 m and 30 degrees.
    pub answers: usize,
    /// Of positions, by the Mahalanobis distance; 0.39, 0.86 and 0.99 of a Gaussian.
    pub position: [Decimal; 3],
    /// Of headings; 0.68, 0.95 and 0.997 of a Gaussian.
    pub heading: [Decimal; 3],
}

impl Coverage {
    /// Of the single answers to frames with ground truth.
    #[must_use]
    pub fn of(frames: &[JudgedFrame<'_>]) -> Self {
        let said =
            |frame: &&JudgedFrame<'_>| frame.misses[0].is_right() && frame.record.probability() >= SAID;
        let deviations: Vec<[f64; 2]> = frames
            .iter()
            .filter(said)
            .filter_map(|frame| deviations(frame.record, frame.truth.as_ref()?))
            .collect();
        let share = |part: usize, sigmas: f64| {
            let within = deviations.iter().filter(|deviation| deviation[part] <= sigmas).count();
            Decimal(within as f64 / deviations.len() as f64)
        };
        let shares = |part: usize| [1.0, 2.0, 3.0].map(|sigmas| share(part, sigmas));
        Self { answers: deviations.len(), position: shares(0), heading: shares(1) }
    }
}

/// The errors of a frame's position and heading in standard deviations.
fn deviations(record: &Record, truth: &Pose) -> Option<[f64; 2]> {
    let (found, rows) = (record.single.first()?, record.covariance?);
    let [[xx, xy, _], [_, yy, _], [_, _, heading]] = rows.map(|row| row.map(f64::from));
    let [x, y] = found.position();
    let error = Vector2::new(x - truth.position.x, y - truth.position.y);
    let weighed = Matrix2::new(xx, xy, xy, yy).try_inverse()? * error;
    let turn = wrapped(found.heading_deg() - truth.heading_deg()).to_radians();
    Some([error.dot(&weighed).sqrt(), turn.abs() / heading.sqrt()])
}
