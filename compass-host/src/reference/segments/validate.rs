//! Keeps the segments whose pixels have gradients across the line.

use super::gradient::Field;
use super::jump::undirected;
use super::options::{Options, Segment};
use super::traced::Traced;
use super::walk::{Drawing, Label};

/// Share of a segment near each end that is not checked, and the maximum of that in pixels.
const END_SHARE: f64 = 0.1;
const END_MOST: f64 = 5.0;

/// The segment between its projected ends; `None` when most of its pixels disagree with it.
pub(super) fn validate(
    field: &Field,
    options: &Options,
    drawing: &Drawing<'_>,
    traced: &Traced,
) -> Option<Segment> {
    let [start, end] = traced.ends.map(|pixel| traced.line.project(pixel));
    let along = [end[0] - start[0], end[1] - start[1]];
    let length = along[0].hypot(along[1]);
    let pixels = drawing.pixels.get(traced.pixels.clone())?;
    if pixels.len() < 2 || length <= 0.0 || !length.is_finite() {
        return None;
    }
    if !options.validate {
        return Some(Segment { start, end, score: length });
    }
    let normal_angle = along[0].atan2(-along[1]);
    let skipped = (END_SHARE * pixels.len() as f64).min(END_MOST) as i32;
    let main = traced.fit.axis.main();
    let (mut inliers, mut outliers) = (0, 0);
    for &pixel in pixels {
        let near_end = traced.ends.iter().any(|end| (pixel[main] - end[main]).abs() < skipped);
        if near_end || drawing.label(pixel) != Label::Inlier {
            continue;
        }
        let [dx, dy] = field.gradient_at(traced.line.project(pixel));
        let agrees = undirected(dy.atan2(dx) - normal_angle) <= options.validation_angle_rad;
        *if agrees { &mut inliers } else { &mut outliers } += 1;
    }
    (inliers > outliers).then_some(Segment { start, end, score: f64::from(inliers) })
}
