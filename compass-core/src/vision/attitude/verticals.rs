//! The directions that may be vertical, where the best one alone may be wrong.

use super::arc::Arc;
use super::search::{APART, Parameters, Peak, Peaks, Scorer, UpHint, keep, runner_up};
use super::vertical::Vertical;
use crate::base::order;
use core::cmp::Reverse;
use heapless::Vec;

/// Most directions that [`verticals`] gives.
pub const MOST_VERTICALS: usize = 3;
/// Smallest separation of them: cosine of 30 degrees.
const SEPARATE: f32 = 0.866_025_4;
/// Largest angle between a known up direction and those beyond the first: cosine of 45 degrees.
const CONE: f32 = 0.707_106_77;

/// The directions that may be the vertical vanishing point: that of [`vertical`](super::vertical()) first, then those that are at least 30
/// degrees away from it and from each other, by what it is selected by: support times the [prior](UpHint::prior).
///
/// Empty if [`vertical`](super::vertical()) is `None`; each has at least [`LEAST_INLIERS`](super::LEAST_INLIERS) inliers. Near a known up direction
/// ([`UpHint::Up`]), all but the first are within 45 degrees of it; near an axis they are anywhere, with the sign of the
/// axis. How much of the first one's support and prior another must have to count is for the caller to say.
///
/// # Formats
/// As of [`vertical`](super::vertical()).
///
/// # Cost
/// That of [`vertical`](super::vertical()), and 9 more passes over the arcs for each of at most 6 peaks.
///
/// ```
/// use compass_core::vision::attitude::{Arc, Parameters, UpHint, verticals};
/// use compass_core::Bearing;
///
/// // Lines along y, and half as many along x.
/// let arcs: [Arc; 72] = core::array::from_fn(|k| {
///     let (sin, cos) = (k as f32 * 0.13).sin_cos();
///     let (normal, middle) = match k % 3 {
///         0 => (Bearing::new(0.0, cos, -sin), Bearing::new(0.0, sin, cos)),
///         _ => (Bearing::new(cos, 0.0, -sin), Bearing::new(sin, 0.0, cos)),
///     };
///     Arc { normal, middle, weight: 10.0, camera: 0 }
/// });
/// let found = verticals(&arcs, UpHint::Axis(-Bearing::y()), &Parameters::default());
/// assert_eq!(found.len(), 2);
/// assert!((found[0].up + Bearing::y()).norm() < 1e-2);
/// assert!(found[1].up.x.abs() > 0.999 && found[1].support < 0.6 * found[0].support);
/// ```
#[must_use]
pub fn verticals(arcs: &[Arc], hint: UpHint, parameters: &Parameters) -> Vec<Vertical, MOST_VERTICALS> {
    let scorer = Scorer::new(arcs, hint, parameters.tolerance_deg);
    // Anywhere for an axis.
    let is_allowed = |peak: &Peak| !scorer.signed || peak.direction.dot(&scorer.hint) >= CONE;
    let (mut peaks, mut others) = (Peaks::new(), Peaks::new());
    scorer.sample(parameters, |peak| {
        keep(&mut peaks, peak, APART);
        if is_allowed(&peak) {
            keep(&mut others, peak, SEPARATE);
        }
    });
    let mut found = Vec::new();
    let Some(first) = scorer.best(&mut peaks) else { return found };
    let _ = found.push(first);
    for peak in &mut others {
        *peak = scorer.refined(peak.direction);
    }
    // The bits of numbers that are not negative have their order.
    order::sort_by_key(&mut others, |peak| Reverse(peak.rank.to_bits()));
    for peak in &others {
        let is_separate = |other: &Vertical| peak.direction.dot(&other.up).abs() <= SEPARATE;
        if !is_allowed(peak) || !found.iter().all(is_separate) {
            continue;
        }
        if let Some(other) = scorer.answer(*peak, runner_up(peak, peaks.iter().chain(&others))) {
            // A full list has its three directions.
            let _ = found.push(other);
        }
    }
    found
}
