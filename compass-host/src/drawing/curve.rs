//! Curves as lists of points.

use std::f64::consts::TAU;

/// Greatest distance of a chord from its arc, in metres.
const SAGITTA_M: f64 = 0.002;
/// Most chords of a full turn.
const MAX_CHORDS: f64 = 720.0;

/// Chords for an arc of `sweep` radians and a radius in metres.
pub(super) fn chords(radius_m: f64, sweep: f64) -> usize {
    let step = 2.0 * (1.0 - SAGITTA_M / radius_m.abs().max(SAGITTA_M)).acos();
    let wanted = (sweep.abs() / step.max(TAU / MAX_CHORDS)).ceil();
    wanted.clamp(4.0, MAX_CHORDS) as usize
}

/// Points along an elliptic arc: centre + cos(t) `u` + sin(t) `v`, for t from `start` over `sweep` radians.
pub(super) fn arc(
    centre: [f64; 2],
    [u, v]: [[f64; 2]; 2],
    start: f64,
    sweep: f64,
    unit_m: f64,
) -> Vec<[f64; 2]> {
    let radius = u[0].hypot(u[1]).max(v[0].hypot(v[1]));
    let count = chords(radius * unit_m, sweep);
    let at = |n: usize| {
        let (sin, cos) = (start + sweep * n as f64 / count as f64).sin_cos();
        [0, 1].map(|axis| centre[axis] + cos * u[axis] + sin * v[axis])
    };
    (0..=count).map(at).collect()
}

/// The counter-clockwise sweep in (0, 2 pi] from one angle to another.
pub(super) fn sweep(start: f64, end: f64) -> f64 {
    let sweep = (end - start).rem_euclid(TAU);
    if sweep < 1e-9 { TAU } else { sweep }
}

/// Points along a circular arc from `from` to `to` whose bulge is the tangent of a quarter of its angle, positive
/// counter-clockwise; without `from` itself.
pub(super) fn bulge(from: [f64; 2], to: [f64; 2], bulge: f64, unit_m: f64) -> Vec<[f64; 2]> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let chord = dx.hypot(dy);
    if bulge.abs() < 1e-9 || chord == 0.0 || !bulge.is_finite() {
        return vec![to];
    }
    // The centre lies on the perpendicular bisector, (1 - b^2) / 4b of the chord to its left.
    let left = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = [f64::midpoint(from[0], to[0]) - dy * left, f64::midpoint(from[1], to[1]) + dx * left];
    let spoke = [from[0] - centre[0], from[1] - centre[1]];
    let mut points = arc(centre, [spoke, [-spoke[1], spoke[0]]], 0.0, 4.0 * bulge.atan(), unit_m);
    points.remove(0);
    if let Some(last) = points.last_mut() {
        *last = to;
    }
    points
}

/// A corner of a polyline and the bulge of the segment that starts there.
pub(super) type Corner = ([f64; 2], f64);

/// A polyline with bulges as points; closed by its first point if `closed`.
pub(super) fn polyline(corners: &[Corner], closed: bool, unit_m: f64) -> Vec<[f64; 2]> {
    let Some(&(first, _)) = corners.first() else { return Vec::new() };
    let mut points = vec![first];
    for pair in corners.windows(2) {
        points.extend(bulge(pair[0].0, pair[1].0, pair[0].1, unit_m));
    }
    if let (true, Some(&(last, by))) = (closed, corners.last()) {
        points.extend(bulge(last, first, by, unit_m));
    }
    points
}

/// Points along a rational B-spline, by de Boor's algorithm; empty for knots that do not fit the control points.
pub(super) fn spline(degree: usize, knots: &[f64], control: &[[f64; 2]], weights: &[f64]) -> Vec<[f64; 2]> {
    let count = control.len();
    if degree == 0 || count <= degree || knots.len() != count + degree + 1 {
        return Vec::new();
    }
    if knots.windows(2).any(|pair| pair[0].is_nan() || pair[1].is_nan() || pair[0] > pair[1]) {
        return Vec::new();
    }
    // Homogeneous control points.
    let weight = |at: usize| weights.get(at).copied().filter(|weight| *weight > 0.0).unwrap_or(1.0);
    let control: Vec<[f64; 3]> =
        (0..count).map(|at| [control[at][0] * weight(at), control[at][1] * weight(at), weight(at)]).collect();
    let per_span = 8.max(32 / degree);
    let mut points = Vec::new();
    for span in degree..count {
        let (from, to) = (knots[span], knots[span + 1]);
        if to > from {
            let last = if span + 1 == count { per_span } else { per_span - 1 };
            points.extend((0..=last).map(|n| {
                let t = from + (to - from) * n as f64 / per_span as f64;
                de_boor(degree, knots, &control, span, t)
            }));
        }
    }
    points
}

fn de_boor(degree: usize, knots: &[f64], control: &[[f64; 3]], span: usize, t: f64) -> [f64; 2] {
    let mut d: Vec<[f64; 3]> = control[span - degree..=span].to_vec();
    for round in 1..=degree {
        for at in (round..=degree).rev() {
            let low = knots[at + span - degree];
            let high = knots[at + 1 + span - round];
            let share = if high > low { (t - low) / (high - low) } else { 0.0 };
            d[at] = [0, 1, 2].map(|axis| (1.0 - share) * d[at - 1][axis] + share * d[at][axis]);
        }
    }
    let [x, y, w] = d[degree];
    [x / w, y / w]
}

/// Contours from the moves of a pen, with Bezier curves as chords.
#[derive(Default)]
pub(super) struct Outline {
    pub(super) contours: Vec<Vec<[f64; 2]>>,
}

/// Chords of a Bezier curve. Drawings are made of short ones: a turn has four.
const BEZIER_CHORDS: u32 = 16;

impl Outline {
    pub(super) fn move_to(&mut self, to: [f64; 2]) {
        self.contours.push(vec![to]);
    }

    pub(super) fn line_to(&mut self, to: [f64; 2]) {
        if let Some(contour) = self.contours.last_mut() {
            contour.push(to);
        }
    }

    pub(super) fn quadratic_to(&mut self, control: [f64; 2], to: [f64; 2]) {
        let Some(from) = self.position() else { return };
        // The cubic of the same shape.
        let towards = |end: [f64; 2]| [0, 1].map(|axis| end[axis] + (control[axis] - end[axis]) * 2.0 / 3.0);
        self.cubic_to(towards(from), towards(to), to);
    }

    pub(super) fn cubic_to(&mut self, a: [f64; 2], b: [f64; 2], to: [f64; 2]) {
        let Some(from) = self.position() else { return };
        for n in 1..=BEZIER_CHORDS {
            let t = f64::from(n) / f64::from(BEZIER_CHORDS);
            let s = 1.0 - t;
            let along = |axis: usize| {
                s * s * s * from[axis]
                    + 3.0 * s * s * t * a[axis]
                    + 3.0 * s * t * t * b[axis]
                    + t * t * t * to[axis]
            };
            self.line_to([along(0), along(1)]);
        }
    }

    /// Closes the contour; what follows without a move starts where it began.
    pub(super) fn close(&mut self) {
        let Some(first) = self.contours.last().and_then(|contour| contour.first().copied()) else { return };
        self.line_to(first);
        self.move_to(first);
    }

    fn position(&self) -> Option<[f64; 2]> {
        self.contours.last()?.last().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_of_a_bulge_lie_on_its_circle(
            from in prop::array::uniform2(-50.0..50.0), to in prop::array::uniform2(-50.0..50.0), by in -3.0..3.0_f64,
        ) {
            let chord = f64::hypot(to[0] - from[0], to[1] - from[1]);
            prop_assume!(chord > 0.01 && by.abs() > 0.01);
            let points = bulge(from, to, by, 1.0);
            prop_assert_eq!(*points.last().unwrap(), to);
            // The arc's height over its chord is |b| half chords, on the right of a counter-clockwise arc.
            let side = |p: &[f64; 2]| {
                ((p[0] - from[0]) * (to[1] - from[1]) - (p[1] - from[1]) * (to[0] - from[0])) / chord
            };
            let height = points.iter().map(side).fold(0.0, |most: f64, s| if s.abs() > most.abs() { s } else { most });
            let radius = chord * (1.0 + by * by) / (4.0 * by.abs());
            prop_assert!((height - by * chord / 2.0).abs() < radius * 0.001 + 0.003, "{height} of {}", by * chord / 2.0);
        }
    }

    #[test]
    fn a_rational_spline_of_degree_two_is_a_circle() {
        let w = std::f64::consts::FRAC_1_SQRT_2;
        let points =
            spline(2, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &[[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[1.0, w, 1.0]);
        assert!(points.len() > 8);
        assert!(points.iter().all(|[x, y]| (x.hypot(*y) - 1.0).abs() < 1e-12));
        assert_eq!(points[0], [1.0, 0.0]);
        assert!(points.last().unwrap()[0].abs() < 1e-12);
    }

    #[test]
    fn a_line_of_degree_one_goes_through_its_corners() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0]];
        let points = spline(1, &[0.0, 0.0, 1.0, 2.0, 2.0], &corners, &[]);
        assert!(corners.iter().all(|corner| points.contains(corner)), "{points:?}");
        assert!(spline(3, &[0.0; 3], &corners, &[]).is_empty(), "knots that do not fit");
        assert!(spline(1, &[0.0, 0.0, f64::NAN, 2.0, 2.0], &corners, &[]).is_empty());
    }

    #[test]
    fn chords_stay_within_two_millimetres() {
        for radius in [0.05, 0.9, 5.0, 60.0] {
            let count = chords(radius, TAU) as f64;
            let sagitta = radius * (1.0 - (TAU / count / 2.0).cos());
            assert!(sagitta <= SAGITTA_M * 1.001, "{radius}: {sagitta}");
        }
    }
}
