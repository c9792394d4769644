//! Search of the vertical vanishing point.

use super::arc::{Arc, degrees, sharpness};
use super::vertical::Vertical;
use crate::vision::camera::{Bearing, PerCamera};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Smallest number of inlier arcs of an answer.
pub const LEAST_INLIERS: u16 = 20;
/// Number of candidate directions that are refined.
const PEAKS: usize = 6;
/// Smallest separation of candidate directions: cosine of 6 degrees.
pub(super) const APART: f32 = 0.994_521_9;
/// Iterations of the reweighted refinement.
const ROUNDS: usize = 8;
/// Standard deviation of the prior of the vertical around the hint, degrees.
const SPREAD_DEG: f32 = 35.0;

/// Prior of the up direction, in the axes of camera 0; vectors of any length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UpHint {
    /// Near this direction, as for a known mounting or from an accelerometer.
    Up(Bearing),
    /// Near this axis or its opposite, equally likely; the answer has the sign of the vector.
    Axis(Bearing),
}

impl UpHint {
    /// Prior of a unit vector, relative to the direction of the hint itself, 0 to 1: a Gaussian of 35 degrees. What
    /// [`vertical`] selects by is this times the [support](Vertical::support).
    ///
    /// ```
    /// use compass_core::{Bearing, UpHint};
    ///
    /// let hint = UpHint::Axis(Bearing::y());
    /// assert_eq!((hint.prior(&Bearing::y()), hint.prior(&-Bearing::y())), (1.0, 1.0));
    /// assert!(hint.prior(&Bearing::x()) < 0.04, "90 degrees off");
    /// ```
    #[must_use]
    pub fn prior(&self, direction: &Bearing) -> f32 {
        let (Self::Up(hint) | Self::Axis(hint)) = *self;
        let cos = direction.dot(&unit(hint, 1e-6).unwrap_or_else(Vector3::y));
        prior(if matches!(self, Self::Axis(_)) { libm::fabsf(cos) } else { cos })
    }
}

/// The prior at this cosine of the angle to the hint.
fn prior(cos: f32) -> f32 {
    let off = degrees(libm::acosf(cos.clamp(-1.0, 1.0))) / SPREAD_DEG;
    libm::expf(-0.5 * off * off)
}

/// Parameters of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Inlier tolerance: largest angle between an inlier's great circle and the vertical, degrees. 2, or 3 for small images.
    pub tolerance_deg: f32,
    /// Number of arc pairs sampled.
    pub trials: u16,
    /// Seed of the pair sampling.
    pub seed: u32,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { tolerance_deg: 2.0, trials: 300, seed: 1 }
    }
}

/// A candidate direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    pub(super) direction: Bearing,
    pub(super) support: f32,
    /// Support times the prior of the hint.
    pub(super) rank: f32,
}

/// The best candidates, each apart from the others.
pub(super) type Peaks = Vec<Peak, PEAKS>;

/// Finds the vertical vanishing point of arcs, the up vector.
///
/// `None` if it has fewer than [`LEAST_INLIERS`] inliers.
///
/// # Formats
/// Arcs and hint in the axes of camera 0; the answer is a unit vector. The same seed gives the same bits.
///
/// # Accuracy
/// Within 0.3 degrees of the truth for synthetic scenes with 0.6 px of noise, at any tilt to 45 degrees (test
/// `finds_up_at_any_tilt_to_45_degrees`); [`UP_ERROR_DEG`](super::UP_ERROR_DEG) bounds the rounding, which `compass compare`
/// checks.
///
/// # Cost
/// One pass over the arcs per trial, 300 by default, and 9 passes for each of at most 6 peaks. Measured as `attitude` in
/// `targets/budget.txt`.
///
/// # References
/// M. A. Fischler and R. C. Bolles, "Random Sample Consensus", CACM 24, 1981.
///
/// ```
/// use compass_core::vision::attitude::{Arc, Parameters, UpHint, vertical};
/// use compass_core::Bearing;
///
/// // 24 vertical lines at the horizon, all around.
/// let arcs: [Arc; 24] = core::array::from_fn(|k| {
///     let (sin, cos) = (k as f32 * 0.26).sin_cos();
///     let (normal, middle) = (Bearing::new(cos, 0.0, -sin), Bearing::new(sin, 0.0, cos));
///     Arc { normal, middle, weight: 10.0, camera: 0 }
/// });
/// let hint = UpHint::Up(Bearing::new(0.1, -1.0, 0.2));
/// let found = vertical(&arcs, hint, &Parameters::default()).unwrap();
/// assert!((found.up + Bearing::y()).norm() < 1e-3);
/// assert_eq!(found.inliers, [24, 0]);
/// assert!(vertical(&arcs[..9], hint, &Parameters::default()).is_none());
/// ```
#[must_use]
pub fn vertical(arcs: &[Arc], hint: UpHint, parameters: &Parameters) -> Option<Vertical> {
    let scorer = Scorer::new(arcs, hint, parameters.tolerance_deg);
    let mut peaks = Peaks::new();
    scorer.sample(parameters, |peak| keep(&mut peaks, peak, APART));
    scorer.best(&mut peaks)
}

/// Support of the best of the other peaks, at least 6 degrees away.
pub(super) fn runner_up<'p>(best: &Peak, peaks: impl Iterator<Item = &'p Peak>) -> f32 {
    peaks.filter(|m| m.direction.dot(&best.direction).abs() < APART).map(|m| m.support).fold(0.0, f32::max)
}

/// Inserts a peak with non-maximum suppression: it replaces lower-ranked peaks within an angle of this cosine, or the
/// lowest of a full list.
pub(super) fn keep(peaks: &mut Peaks, peak: Peak, apart: f32) {
    let close = |m: &Peak| m.direction.dot(&peak.direction).abs() >= apart;
    if peaks.iter().any(|m| close(m) && m.rank >= peak.rank) {
        return;
    }
    peaks.retain(|m| !close(m));
    if peaks.is_full() {
        let weakest = peaks.iter().enumerate().min_by(|a, b| a.1.rank.total_cmp(&b.1.rank));
        let Some((index, weakest)) = weakest else { return };
        if weakest.rank >= peak.rank {
            return;
        }
        peaks.swap_remove(index);
    }
    let _ = peaks.push(peak);
}

/// Scores directions by the arcs that agree with them.
pub(super) struct Scorer<'a> {
    arcs: &'a [Arc],
    pub(super) hint: Bearing,
    pub(super) signed: bool,
    /// 1 / sin^2 of the tolerance.
    sharpness: f32,
}

impl<'a> Scorer<'a> {
    pub(super) fn new(arcs: &'a [Arc], hint: UpHint, tolerance_deg: f32) -> Self {
        let (hint, signed) = match hint {
            UpHint::Up(up) => (up, true),
            UpHint::Axis(axis) => (axis, false),
        };
        let hint = unit(hint, 1e-6).unwrap_or_else(Vector3::y);
        Self { arcs, hint, signed, sharpness: sharpness(tolerance_deg) }
    }

    /// Scores the intersections of pairs of arcs.
    #[inline(always)]
    pub(super) fn sample(&self, parameters: &Parameters, mut take: impl FnMut(Peak)) {
        let mut random = Random(parameters.seed.wrapping_mul(0x9e37_79b9) | 1);
        for _ in 0..parameters.trials {
            let (Some(a), Some(b)) = (random.pick(self.arcs), random.pick(self.arcs)) else { break };
            if let Some(direction) = unit(a.normal.cross(&b.normal), 0.05) {
                take(self.peak(direction));
            }
        }
    }

    /// The best of the peaks, each refined, if enough arcs agree with it.
    pub(super) fn best(&self, peaks: &mut Peaks) -> Option<Vertical> {
        for peak in peaks.iter_mut() {
            *peak = self.refined(peak.direction);
        }
        let best = *peaks.iter().max_by(|a, b| a.rank.total_cmp(&b.rank))?;
        self.answer(best, runner_up(&best, peaks.iter()))
    }

    #[inline(always)]
    fn agreement(&self, arc: &Arc, direction: &Bearing) -> f32 {
        arc.agrees(direction, self.sharpness)
    }

    fn peak(&self, direction: Bearing) -> Peak {
        let direction = if direction.dot(&self.hint) < 0.0 { -direction } else { direction };
        let support: f32 = self.arcs.iter().map(|arc| arc.weight * self.agreement(arc, &direction)).sum();
        Peak { direction, support, rank: support * prior(direction.dot(&self.hint)) }
    }

    /// Iteratively reweighted least squares: the eigenvector of the smallest eigenvalue of the weighted scatter of normals.
    pub(super) fn refined(&self, mut direction: Bearing) -> Peak {
        for _ in 0..ROUNDS {
            let mut scatter = Matrix3::zeros();
            for arc in self.arcs {
                let weight = arc.weight * self.agreement(arc, &direction);
                if weight > 0.0 {
                    scatter += arc.normal * arc.normal.transpose() * weight;
                }
            }
            direction = smallest(&scatter, direction);
        }
        self.peak(direction)
    }

    /// The answer that a peak gives; `None` if too few arcs agree with it.
    pub(super) fn answer(&self, best: Peak, runner_up: f32) -> Option<Vertical> {
        let (mut inliers, mut squares, mut weights) = (PerCamera::<u16>::default(), 0.0, 0.0);
        for arc in self.arcs {
            let agreement = self.agreement(arc, &best.direction);
            if agreement > 0.0 {
                if let Some(count) = inliers.get_mut(arc.camera as usize) {
                    *count = count.saturating_add(1);
                }
                let weight = arc.weight * agreement;
                squares += weight * (1.0 - agreement) / self.sharpness;
                weights += weight;
            }
        }
        let up = if self.signed || best.direction.dot(&self.hint) >= 0.0 {
            best.direction
        } else {
            -best.direction
        };
        let residual_deg = if weights > 0.0 { degrees(libm::sqrtf(squares / weights)) } else { 0.0 };
        let answer = Vertical { up, inliers, support: best.support, runner_up, residual_deg };
        (inliers.iter().sum::<u16>() >= LEAST_INLIERS).then_some(answer)
    }
}

/// The eigenvector of the smallest eigenvalue of a symmetric matrix, with the sign of `start`: power iteration of the
/// adjugate, which has the same eigenvectors and the largest eigenvalue for that one.
fn smallest(scatter: &Matrix3<f32>, start: Bearing) -> Bearing {
    let [x, y, z] = [0, 1, 2].map(|column| scatter.column(column).into_owned());
    let adjugate = Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]);
    let mut v = start;
    for _ in 0..8 {
        let Some(next) = unit(adjugate * v, 0.0) else { return v };
        v = if next.dot(&start) < 0.0 { -next } else { next };
    }
    v
}

/// The vector scaled to length 1; `None` if it is shorter than `least`, zero or not finite.
fn unit(v: Bearing, least: f32) -> Option<Bearing> {
    // Scaling first keeps squares from underflow and overflow.
    let largest = v.x.abs().max(v.y.abs()).max(v.z.abs());
    if !(largest > least * 0.5 && largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let scaled = v / largest;
    let length = libm::sqrtf(scaled.dot(&scaled));
    (length * largest >= least).then(|| scaled / length)
}

/// xorshift32 (G. Marsaglia, "Xorshift RNGs", 2003).
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// Draws an arc, with a probability that grows with its weight: rejection sampling, at most 6 draws.
    fn pick<'a>(&mut self, arcs: &'a [Arc]) -> Option<&'a Arc> {
        let mut arc = None;
        for _ in 0..6 {
            let index = ((u64::from(self.next()) * arcs.len() as u64) >> 32) as usize;
            arc = arcs.get(index);
            let chance = (self.next() >> 8) as f32 * (25.0 / 16_777_216.0);
            if arc.is_some_and(|arc| chance < arc.weight) {
                break;
            }
        }
        arc
    }
}
