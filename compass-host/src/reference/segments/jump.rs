//! Gap bridging: whether the edge continues beyond the end of a segment.

use super::gradient::{Axis, Field, Pixel};
use super::line::Line;
use super::options::Options;
use super::traced::{End, Traced, step};

/// Unit vector that points out of a segment at one end.
pub(super) fn heading(line: &Line, end: End) -> [f64; 2] {
    match end {
        End::Head => line.direction(),
        End::Tail => line.direction().map(|d| -d),
    }
}

/// Pixels from the end over a gap and as far again along the edge behind it; `None` when there is no edge.
pub(super) fn bridge(field: &Field, options: &Options, segment: &Traced, end: End) -> Option<Vec<Pixel>> {
    let from = segment.ends[end as usize];
    // Pixels of failed attempts are kept: a longer jump is judged together with those before it.
    let mut walked = Vec::new();
    for &length in &options.jump_lengths {
        if segment.fit.count <= i64::from(length) {
            return None;
        }
        let Some(target) = landing(field, &segment.line, from, end, length) else { continue };
        let mut bridge = straight_pixels(from, target);
        let Some(&previous) = bridge.iter().rev().nth(1) else { continue };
        let first = walked.len();
        let complete = walk_on(field, options, segment, [target, previous], length, &mut walked);
        if complete && is_edge(field, options, segment, &walked) {
            bridge.extend(&walked[first..]);
            return Some(bridge);
        }
    }
    None
}

/// The strongest of the four pixels about the point `length` pixels beyond the end.
fn landing(field: &Field, line: &Line, from: Pixel, end: End, length: i32) -> Option<Pixel> {
    let (foot, heading) = (line.project(from), heading(line, end));
    let point = [0, 1].map(|k| foot[k] + f64::from(length) * heading[k]);
    let [width, height] = field.size().map(f64::from);
    if point[0] < 0.0 || point[1] < 0.0 || point[0] >= width || point[1] >= height {
        return None;
    }
    let [x, y] = point.map(|v| v as i32);
    let mut best = [x, y];
    for pixel in [[x + 1, y], [x, y + 1], [x + 1, y + 1]] {
        if field.magnitude(pixel) > field.magnitude(best) {
            best = pixel;
        }
    }
    (field.magnitude(best) > 0).then_some(best)
}

/// Walks as many pixels as were jumped, only along the segment's axis.
fn walk_on(
    field: &Field,
    options: &Options,
    segment: &Traced,
    [mut at, mut previous]: [Pixel; 2],
    length: i32,
    walked: &mut Vec<Pixel>,
) -> bool {
    for _ in 0..length {
        let Some(next) = step(field, at, previous, segment.fit.axis) else { return false };
        (previous, at) = (at, next);
        if field.magnitude(at) == 0 || segment.line.distance(at) >= options.inlier_distance {
            return false;
        }
        walked.push(at);
    }
    true
}

/// Whether the structure tensor around the pixels has one dominant direction, across the line.
fn is_edge(field: &Field, options: &Options, segment: &Traced, pixels: &[Pixel]) -> bool {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for pixel in pixels {
        for offset in -1..=1 {
            let mut near = *pixel;
            near[segment.fit.axis.cross()] += offset;
            let [dx, dy] = field.gradient(near);
            (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        }
    }
    let (half_sum, half_gap) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let gradient_angle = (2.0 * xy).atan2(xx - yy) / 2.0;
    let normal_angle = segment.line.normal[1].atan2(segment.line.normal[0]);
    half_sum + half_gap > options.eigenvalue_ratio * (half_sum - half_gap)
        && undirected(gradient_angle - normal_angle) < options.jump_angle_deg.to_radians()
}

/// Angle between two undirected lines, 0 to a quarter turn, in radians.
pub(super) fn undirected(angle: f64) -> f64 {
    let angle = angle.rem_euclid(std::f64::consts::PI);
    angle.min(std::f64::consts::PI - angle)
}

/// Bresenham's line from `a` to `b`, both included.
fn straight_pixels(a: Pixel, b: Pixel) -> Vec<Pixel> {
    let axis = Axis::of_extent(f64::from(b[0] - a[0]), f64::from(b[1] - a[1]));
    let (m, c) = (axis.main(), axis.cross());
    let (length, rise) = ((b[m] - a[m]).abs(), (b[c] - a[c]).abs());
    let (mut pixel, mut error) = (a, 0);
    let mut pixels = vec![a];
    for _ in 0..length {
        pixel[m] += (b[m] - a[m]).signum();
        error += rise;
        // A deviation of exactly half a pixel steps across: this decides ties.
        if 2 * error >= length {
            pixel[c] += (b[c] - a[c]).signum();
            error -= length;
        }
        pixels.push(pixel);
    }
    pixels
}
