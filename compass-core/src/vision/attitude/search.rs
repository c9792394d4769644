//! The vertical vanishing point.

use super::arc::{Arc, degrees, sharpness};
use super::vertical::Vertical;
use crate::vision::camera::{Bearing, PerCamera};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Arcs needed to tell.
pub const LEAST_INLIERS: u16 = 20;
/// Directions kept until the end, and how far they are apart: cosine of 6 degrees.
const PEAKS: usize = 6;
const APART: f32 = 0.994_521_9;
/// Rounds of refinement.
const ROUNDS: usize = 8;
/// Spread of the vertical around the hint, degrees.
const SPREAD_DEG: f32 = 35.0;

/// Where up is likely, in the axes of camera 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UpHint {
    /// Near this direction, as for a known mounting or from an accelerometer.
    Up(Bearing),
    /// Near this axis, one way or the other; the answer takes the sign of the vector.
    Axis(Bearing),
}

/// What the search looks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Largest angle between an inlier's great circle and the vertical, degrees: 2, or 3 for small images.
    pub tolerance_deg: f32,
    /// Pairs of arcs tried.
    pub trials: u16,
    /// Seed of the choice of pairs.
    pub seed: u32,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { tolerance_deg: 2.0, trials: 300, seed: 1 }
    }
}

/// A direction that arcs point to.
#[derive(Debug, Clone, Copy)]
struct Peak {
    direction: Bearing,
    support: f32,
    /// Support times the prior.
    rank: f32,
}

/// Finds the vertical vanishing point of arcs, and with it the up vector.
///
/// `None` if fewer than [`LEAST_INLIERS`] arcs agree. The work is bounded by trials times arcs.
#[must_use]
pub fn vertical(arcs: &[Arc], hint: UpHint, parameters: &Parameters) -> Option<Vertical> {
    let judge = Judge::new(arcs, hint, parameters.tolerance_deg);
    let mut random = Random(parameters.seed.wrapping_mul(0x9e37_79b9) | 1);
    let mut modes: Vec<Peak, PEAKS> = Vec::new();
    for _ in 0..parameters.trials {
        let (Some(a), Some(b)) = (random.pick(arcs), random.pick(arcs)) else { break };
        if let Some(direction) = unit(a.normal.cross(&b.normal), 0.05) {
            keep(&mut modes, judge.mode(direction));
        }
    }
    for mode in &mut modes {
        *mode = judge.refined(mode.direction);
    }
    let best = *modes.iter().max_by(|a, b| a.rank.total_cmp(&b.rank))?;
    let apart = |m: &&Peak| m.direction.dot(&best.direction).abs() < APART;
    let runner_up = modes.iter().filter(apart).map(|m| m.support).fold(0.0, f32::max);
    let answer = judge.answer(best, runner_up);
    (answer.inliers.iter().sum::<u16>() >= LEAST_INLIERS).then_some(answer)
}

/// Puts a mode on the list, in place of weaker ones close to it, or of the weakest.
fn keep(modes: &mut Vec<Peak, PEAKS>, mode: Peak) {
    let close = |m: &Peak| m.direction.dot(&mode.direction).abs() >= APART;
    if modes.iter().any(|m| close(m) && m.rank >= mode.rank) {
        return;
    }
    modes.retain(|m| !close(m));
    if modes.is_full() {
        let weakest = modes.iter().enumerate().min_by(|a, b| a.1.rank.total_cmp(&b.1.rank));
        let Some((index, weakest)) = weakest else { return };
        if weakest.rank >= mode.rank {
            return;
        }
        modes.swap_remove(index);
    }
    let _ = modes.push(mode);
}

/// Scores directions.
struct Judge<'a> {
    arcs: &'a [Arc],
    hint: Bearing,
    signed: bool,
    /// 1 / sin^2 of the tolerance.
    sharpness: f32,
}

impl<'a> Judge<'a> {
    fn new(arcs: &'a [Arc], hint: UpHint, tolerance_deg: f32) -> Self {
        let (hint, signed) = match hint {
            UpHint::Up(up) => (up, true),
            UpHint::Axis(axis) => (axis, false),
        };
        let hint = unit(hint, 1e-6).unwrap_or_else(Vector3::y);
        Self { arcs, hint, signed, sharpness: sharpness(tolerance_deg) }
    }

    #[inline(always)]
    fn agreement(&self, arc: &Arc, direction: &Bearing) -> f32 {
        arc.agrees(direction, self.sharpness)
    }

    fn mode(&self, direction: Bearing) -> Peak {
        let direction = if direction.dot(&self.hint) < 0.0 { -direction } else { direction };
        let support: f32 = self.arcs.iter().map(|arc| arc.weight * self.agreement(arc, &direction)).sum();
        let off = degrees(libm::acosf(direction.dot(&self.hint).clamp(-1.0, 1.0))) / SPREAD_DEG;
        Peak { direction, support, rank: support * libm::expf(-0.5 * off * off) }
    }

    /// The direction that the arcs around it agree on: smallest eigenvector of their normals, reweighted.
    fn refined(&self, mut direction: Bearing) -> Peak {
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
        self.mode(direction)
    }

    fn answer(&self, best: Peak, runner_up: f32) -> Vertical {
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
        Vertical { up, inliers, support: best.support, runner_up, residual_deg }
    }
}

/// The eigenvector of the smallest eigenvalue of a symmetric matrix, near `start`: by powers of the adjugate, which has
/// the same eigenvectors and that eigenvalue largest.
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

fn unit(v: Bearing, least: f32) -> Option<Bearing> {
    // Scaled first, so that squares neither vanish nor overflow.
    let largest = v.x.abs().max(v.y.abs()).max(v.z.abs());
    if !(largest > least * 0.5 && largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let scaled = v / largest;
    let length = libm::sqrtf(scaled.dot(&scaled));
    (length * largest >= least).then(|| scaled / length)
}

/// xorshift32 (Marsaglia 2003): small, and good enough to pick pairs.
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// An arc, long ones more often.
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
