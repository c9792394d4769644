//! Covariance of a pose, from the curvature of its score.
//!
//! A quadratic is fitted to the scores around the pose, at 3 x 3 positions and five headings, that [parallax](View) predicts
//! from one cast. Its curvature is the information of the images as if all directions erred independently. They do not,
//! because neighbouring ones see the same wall: the information is divided by `CORRELATION`. Two errors are common to all
//! directions and are added: ranges are all too long or all too short, because heights are quantized and plans are out of
//! scale, which moves the pose as far as the quadratic says (`SCALE`); and walls are not quite where they are drawn (`LEAST`).
//!
//! # Thresholds
//! | constant | value | effect |
//! |---|---|---|
//! | `STEP`, `STRIDE` | 0.1 m, 4 degrees | distance of the positions; azimuth stride of the rays |
//! | `CORRELATION` | 8 | nats that count as one independent one |
//! | `SCALE` | 5 % | standard deviation of the scale of ranges |
//! | `LEAST` | 0.05 m, 0.5 degrees | standard deviations that remain however much is seen |
//! | `WIDEST` | 0.5 m, 10 degrees | standard deviations where the images say nothing: half of what separates alternatives |
//!
//! The first three are fitted to errors of right answers: `docs/measured.md`, "Covariance".

use super::evidence::EvidenceTable;
use super::parallax::View;
use super::search::FloorLayer;
use crate::base::num::{CastNats, Metres};
use crate::base::pose::ScoredPose;
use core::f32::consts::PI;

/// Distance of the positions whose scores are predicted.
const STEP: Metres = Metres::lit("0.1");
/// The same in metres.
const STEP_M: f32 = 0.1;
/// Azimuth stride of the rays, degrees.
const STRIDE: usize = 4;
/// Headings whose scores are predicted, 1 degree apart, as many as refinement predicts so that both share the code: the five in
/// the middle count.
const HEADINGS: usize = 9;
/// Radians in a degree.
const DEGREE: f32 = PI / 180.0;
/// Nats that count as one independent one.
const CORRELATION: f32 = 8.0;
/// Standard deviation of the logarithm of the scale of ranges.
const SCALE: f32 = 0.05;
/// Scales of ranges between which the slope of the score is compared, percent, and their difference.
const SCALES: [u16; 2] = [94, 106];
const SCALE_SPAN: f32 = 0.12;
/// Standard deviations of x, y (metres) and heading (radians) that remain however much is seen.
const LEAST: Vector = [0.05, 0.05, 0.5 * DEGREE];
/// Standard deviations where the images say nothing.
const WIDEST: Vector = [0.5, 0.5, 10.0 * DEGREE];
/// Passes over all planes of rotation; three make the rest negligible.
const SWEEPS: usize = 5;

/// x, y and heading.
type Vector = [f32; 3];
type Matrix = [Vector; 3];

/// Covariance of the error of a pose that is right: of x, y and heading.
///
/// It is that of one mode alone, the pose being within 1 m of the true one: how likely that is, is the
/// [probability](super::Fix::probability).
///
/// # Formats
/// m², m rad and rad² in map axes. Symmetric and positive definite; standard deviations are at least 0.05 m and
/// 0.5 degrees.
///
/// # Accuracy
/// Of 18 right answers to real views of a home, 39, 83 and 100 % of the positions lie within 1, 2 and 3 standard deviations
/// (39, 86 and 99 % of a Gaussian), of 487 simulated ones that were not used to fit it 75, 96 and 99 %: `docs/measured.md`,
/// "Covariance".
///
/// ```
/// use compass_core::Covariance;
///
/// // A pose that is right, of which nothing else is known: 0.5 m and 10 degrees.
/// assert_eq!(Covariance::UNKNOWN.position_m(), 0.5);
/// assert!((Covariance::UNKNOWN.heading_rad().to_degrees() - 10.0).abs() < 1e-4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariance {
    rows: Matrix,
}

impl Covariance {
    /// Where nothing is known but that the pose is right.
    pub const UNKNOWN: Self = {
        let [x, y, heading] = WIDEST;
        Self { rows: [[x * x, 0.0, 0.0], [0.0, y * y, 0.0], [0.0, 0.0, heading * heading]] }
    };

    /// Of a pose on a layer, by the evidence for its heights.
    #[inline(never)]
    pub(super) fn new(table: &EvidenceTable, layer: &FloorLayer<'_>, pose: &ScoredPose) -> Self {
        let Ok(view) = View::cast(&layer.plan, pose.at, pose.heading, STRIDE) else { return Self::UNKNOWN };
        let curvature = Quadratic::fit(table, &view).curvature;
        let [shorter, longer] = SCALES.map(|percent| Quadratic::fit(table, &view.scaled(percent)).slope);
        let slopes = zip(longer, shorter, |longer, shorter| (longer - shorter) / (SCALE_SPAN * CORRELATION));
        let information = curvature.map(|row| row.map(|value| -value / CORRELATION));
        let spread = spread(information);
        let drift =
            zip(spread.map(|row| dot(row, slopes) * SCALE), WIDEST, |drift, most| drift.clamp(-most, most));
        let [x, y, heading] = LEAST.map(|least| least * least);
        let least = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, heading]];
        let common = drift.map(|a| drift.map(|b| a * b));
        Self { rows: sum(sum(spread, common), least) }
    }

    /// The matrix over x, y and heading: m², m rad, rad².
    #[must_use]
    pub const fn rows(&self) -> [[f32; 3]; 3] {
        self.rows
    }

    /// Standard deviation of the position along the direction where it is largest, metres.
    #[must_use]
    pub fn position_m(&self) -> f32 {
        let [[x, xy, _], [_, y, _], _] = self.rows;
        let half = (x - y) / 2.0;
        libm::sqrtf((x + y) / 2.0 + libm::sqrtf(half * half + xy * xy))
    }

    /// Standard deviation of the heading, radians.
    #[must_use]
    pub fn heading_rad(&self) -> f32 {
        let [_, _, [_, _, heading]] = self.rows;
        libm::sqrtf(heading)
    }
}

/// A quadratic through the scores around a pose, in nats, metres and radians.
struct Quadratic {
    slope: Vector,
    curvature: Matrix,
}

impl Quadratic {
    /// By least squares: sums with the polynomials of first and second order that are orthogonal on these positions and
    /// headings.
    #[inline(never)]
    fn fit(table: &EvidenceTable, view: &View) -> Self {
        let [mut x, mut y, mut h, mut xx, mut yy, mut hh, mut xy, mut xh, mut yh] = [0_i32; 9];
        // At most 72 scores of 2900 nats are summed: 32 bits are enough.
        for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
            let aside = [i, j].map(|steps| STEP.saturating_mul_int(steps.into()));
            let [_, _, a, b, c, d, e, _, _] = view.scores::<HEADINGS>(table, aside);
            let all = a + b + c + d + e;
            let turned = 2 * (e - a) + d - b;
            (x, y, h) = (x + all * i, y + all * j, h + turned);
            (xx, yy) = (xx + all * (3 * i * i - 2), yy + all * (3 * j * j - 2));
            hh += 2 * (a + e - c) - b - d;
            (xy, xh, yh) = (xy + all * i * j, xh + turned * i, yh + turned * j);
        }
        // Divided by the sum of squares of each polynomial, and by 2 where the second derivative is twice the coefficient.
        let [metre2, mixed, radian2] = [STEP_M * STEP_M, STEP_M * DEGREE, DEGREE * DEGREE];
        let [xy, xh, yh] = [nats(xy, 20.0 * metre2), nats(xh, 60.0 * mixed), nats(yh, 60.0 * mixed)];
        Self {
            slope: [nats(x, 30.0 * STEP_M), nats(y, 30.0 * STEP_M), nats(h, 90.0 * DEGREE)],
            curvature: [
                [nats(xx, 15.0 * metre2), xy, xh],
                [xy, nats(yy, 15.0 * metre2), yh],
                [xh, yh, nats(hh, 63.0 * radian2)],
            ],
        }
    }
}

/// A sum of scores, which are bits of [`CastNats`], over the norm of its polynomial.
#[expect(clippy::cast_precision_loss, reason = "7 digits are enough")]
fn nats(sum: i32, norm: f32) -> f32 {
    const NAT: f32 = CastNats::ONE.to_bits() as f32;
    sum as f32 / (NAT * norm)
}

/// The inverse of an information, in which directions without information, and those where the score has no maximum, have the
/// standard deviation [`WIDEST`].
fn spread(information: Matrix) -> Matrix {
    // Relative to WIDEST the axes compare.
    let relative = zip(information, WIDEST, |row, a| zip(row, WIDEST, |value, b| value * a * b));
    let (values, axes) = principal(relative);
    let shares = values.map(|value| 1.0 / (1.0 + value.max(0.0)));
    let axes = zip(axes, WIDEST, |row, widest| row.map(|part| part * widest));
    axes.map(|a| axes.map(|b| dot(zip(a, b, |a, b| a * b), shares)))
}

/// Eigenvalues of a symmetric matrix, and its eigenvectors in the columns, by Jacobi's rotations.
fn principal(matrix: Matrix) -> (Vector, Matrix) {
    let [[mut a, mut b, mut c], [_, mut d, mut e], [_, _, mut f]] = matrix;
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..3 * SWEEPS {
        let (cos, sin) = rotation(a, b, d);
        let tan = sin / cos;
        (a, d) = (a - tan * b, d + tan * b);
        (c, e) = (cos * c - sin * e, sin * c + cos * e);
        // The axes change places in a circle, so that each pair comes first in turn.
        (a, b, c, d, e, f) = (d, e, 0.0, f, c, a);
        axes = axes.map(|[x, y, z]| [sin * x + cos * y, z, cos * x - sin * y]);
    }
    ([a, d, f], axes)
}

/// Cosine and sine of the smaller rotation that diagonalizes [[a, b], [b, d]].
fn rotation(a: f32, b: f32, d: f32) -> (f32, f32) {
    if b == 0.0 {
        return (1.0, 0.0);
    }
    let cotangent = (d - a) / (2.0 * b);
    let tan = 1.0 / (cotangent.abs() + libm::sqrtf(cotangent * cotangent + 1.0));
    let tan = if cotangent < 0.0 { -tan } else { tan };
    let cos = 1.0 / libm::sqrtf(tan * tan + 1.0);
    (cos, tan * cos)
}

fn zip<A, B, C>([a0, a1, a2]: [A; 3], [b0, b1, b2]: [B; 3], f: impl Fn(A, B) -> C) -> [C; 3] {
    [f(a0, b0), f(a1, b1), f(a2, b2)]
}

fn dot(a: Vector, b: Vector) -> f32 {
    let [x, y, heading] = zip(a, b, |a, b| a * b);
    x + y + heading
}

fn sum(a: Matrix, b: Matrix) -> Matrix {
    zip(a, b, |a, b| zip(a, b, |a, b| a + b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::num::{Nats, Turn};
    use crate::pose::plane_of;
    use crate::pose::tests::{Building, point};
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec;

    /// Covariance at a pose in the building, with evidence of its ranges in the bins selected.
    fn covariance(selected: impl Fn(usize) -> bool) -> Covariance {
        let building = Building::new();
        let layer = building.layer();
        let (at, heading) = (point(7.1, 2.3), Turn::ZERO);
        let mut table = Box::new(EvidenceTable::EMPTY);
        for (bin, (steps, hit)) in
            layer.plan.rays(at, heading, 1).unwrap().enumerate().filter(|(bin, _)| selected(*bin))
        {
            let plane = plane_of(steps, hit);
            for (beside, nats) in [(-2_i16, 1), (-1, 3), (0, 4), (1, 3), (2, 1)] {
                let plane = i16::from(plane) + beside;
                table.set(u8::try_from(plane).unwrap_or(0), bin, Nats::from_num(nats));
            }
        }
        Covariance::new(&table, &layer, &ScoredPose { at, heading, ..ScoredPose::NONE })
    }

    #[test]
    fn without_evidence_it_is_that_of_any_right_pose() {
        let [[x, xy, _], [_, y, _], [_, _, heading]] = covariance(|_| false).rows();
        let wide = |value: f32, axis: usize| {
            let expected = WIDEST[axis] * WIDEST[axis] + LEAST[axis] * LEAST[axis];
            assert!((value - expected).abs() < 1e-6, "{value}, not {expected}");
        };
        wide(x, 0);
        wide(y, 1);
        wide(heading, 2);
        assert_eq!(xy, 0.0);
    }

    #[test]
    fn a_direction_that_no_wall_bounds_is_uncertain() {
        let all = covariance(|_| true);
        assert!(all.position_m() < 0.1 && all.heading_rad() < 1.5 * DEGREE, "{all:?}");
        // Walls to the left and right alone: y is known, x is not.
        let [[x, ..], [_, y, _], _] =
            covariance(|bin| (80..100).contains(&bin) || (260..280).contains(&bin)).rows();
        assert!(x > 9.0 * y, "{x} along, {y} across");
    }

    proptest! {
        #[test]
        fn the_decomposition_gives_the_matrix_back(values in proptest::array::uniform6(-1e4_f32..1e4)) {
            let [a, b, c, d, e, f] = values;
            let matrix = [[a, b, c], [b, d, e], [c, e, f]];
            let (roots, axes) = principal(matrix);
            let size = values.iter().fold(1.0_f32, |size, value| size.max(value.abs()));
            let unit = axes.map(|a| axes.map(|b| dot(a, b)));
            let back = axes.map(|a| axes.map(|b| dot(zip(a, b, |a, b| a * b), roots)));
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                prop_assert!((back[row][column] - matrix[row][column]).abs() < 1e-5 * size);
                prop_assert!((unit[row][column] - f32::from(u8::from(row == column))).abs() < 1e-5);
            }
        }

        #[test]
        fn a_spread_is_positive_definite_and_at_most_the_widest(values in proptest::array::uniform6(-1e7_f32..1e7)) {
            let [a, b, c, d, e, f] = values;
            let spread = spread([[a, b, c], [b, d, e], [c, e, f]]);
            let relative = zip(spread, WIDEST, |row, a| zip(row, WIDEST, |value, b| value / a / b));
            let roots: Vec<f32> = principal(relative).0.to_vec();
            prop_assert!(roots.iter().all(|root| (-1e-6..=1.001).contains(root)), "{roots:?}");
        }
    }
}
