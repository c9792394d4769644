//! Gap jumping: tests whether a line continues beyond a gap of a few pixels.

use super::cell::strength;
use super::gradient::sobel;
use super::growth::{End, Growth};
use super::walk::{Cells, Position, Walker};
use crate::base::num::{count_as_i32, index_of, truncate_to_i32};
use heapless::Vec;

/// Gap lengths tried, in pixels; the line must continue for as many pixels beyond the gap.
const LENGTHS: [i32; 3] = [5, 7, 9];
/// Longest gap.
const MAX_LENGTH: usize = 9;
/// Pixels across the gap, both of its ends, and the pixels walked beyond.
const MAX_PIXELS: usize = 2 * MAX_LENGTH + 4;
/// Squared cosine of twice 10 degrees, the largest angle between the line's normal and the gradient.
const DOUBLE_ANGLE_COS_SQUARED: f32 = 0.883_022_2;

/// Pixels that bridge a gap.
#[derive(Debug)]
pub(super) struct Jump {
    pub(super) pixels: Vec<Position, MAX_PIXELS>,
}

/// Searches the continuation of a line beyond one of its ends.
pub(super) fn find(cells: &Cells<'_>, smoothed: &[u8], growth: &Growth, end: End) -> Option<Jump> {
    let from = if end == End::Head { growth.head[0] } else { growth.tail[0] };
    LENGTHS.into_iter().filter(|j| growth.line.len() > index_of(*j)).find_map(|length| {
        let landing = landing(cells, growth, from, end, length)?;
        let mut pixels = between(from, landing);
        let gap = pixels.len();
        walk_on(cells, growth, length, &mut pixels)?;
        continues(smoothed, cells, growth, pixels.get(gap..)?).then_some(Jump { pixels })
    })
}

/// The strongest pixel of the four around the point `length` pixels beyond the end.
fn landing(cells: &Cells<'_>, growth: &Growth, from: Position, end: End, length: i32) -> Option<Position> {
    let slope = growth.line.slope as f32 / 65_536.0;
    let (dx, dy) = growth.outwards(end);
    let reach = length as f32 / libm::sqrtf(1.0 + slope * slope) * (dx + dy) as f32;
    let [x, y] = growth.line.foot(from);
    let (x, y) =
        if growth.line.steep { (x + slope * reach, y + reach) } else { (x + reach, y + slope * reach) };
    let corner = Position { x: truncate_to_i32(x), y: truncate_to_i32(y) };
    if x < 0.0 || y < 0.0 || !cells.contains(corner) {
        return None;
    }
    let mut best = (0, corner);
    for (dx, dy) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let p = Position { x: corner.x + dx, y: corner.y + dy };
        if cells.contains(p) && strength(cells.get(p)) > best.0 {
            best = (strength(cells.get(p)), p);
        }
    }
    (best.0 > 0).then_some(best.1)
}

/// Bresenham's line, both ends included; ties step sideways.
fn between(from: Position, to: Position) -> Vec<Position, MAX_PIXELS> {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let (length, aside) = (dx.abs().max(dy.abs()), dx.abs().min(dy.abs()));
    let steep = dx.abs() < dy.abs();
    let (sx, sy) = (dx.signum(), dy.signum());
    let mut pixels = Vec::new();
    let (mut p, mut error) = (from, 0);
    let _ = pixels.push(p);
    for _ in 0..length.min(count_as_i32(MAX_PIXELS)) {
        error += aside;
        let moved = 2 * error >= length;
        error -= if moved { length } else { 0 };
        p.x += if steep && !moved { 0 } else { sx };
        p.y += if !steep && !moved { 0 } else { sy };
        let _ = pixels.push(p);
    }
    pixels
}

/// Walks `length` pixels beyond the gap; `None` unless all are edge pixels within reach of the line.
fn walk_on(
    cells: &Cells<'_>,
    growth: &Growth,
    length: i32,
    pixels: &mut Vec<Position, MAX_PIXELS>,
) -> Option<()> {
    let last = *pixels.last()?;
    let before = pixels.get(pixels.len().checked_sub(2)?)?;
    let mut walker = Walker { at: last, dx: last.x - before.x, dy: last.y - before.y };
    for _ in 0..length {
        let cell = walker.advance(cells, growth.line.steep);
        if strength(cell) == 0 || !growth.line.takes(walker.at) {
            return None;
        }
        pixels.push(walker.at).ok()?;
    }
    Some(())
}

/// Whether the gradients at the walked pixels and their neighbours across the line have one dominant direction, that of
/// the line's normal: from the structure tensor, without roots or angles.
fn continues(smoothed: &[u8], cells: &Cells<'_>, growth: &Growth, pixels: &[Position]) -> bool {
    let (mut xx, mut xy, mut yy) = (0_i32, 0_i32, 0_i32);
    for p in pixels {
        for across in -1..=1 {
            let (x, y) = if growth.line.steep { (p.x + across, p.y) } else { (p.x, p.y + across) };
            let (dx, dy) = sobel(smoothed, cells, Position { x, y });
            xx += dx * dx;
            xy += dx * dy;
            yy += dy * dy;
        }
    }
    let (sum, difference, twice) = ((xx + yy) as f32, (xx - yy) as f32, (2 * xy) as f32);
    let spread = difference * difference + twice * twice;
    // Eigenvalues (sum +- sqrt(spread)) / 2 in a ratio above 10: 11 sqrt(spread) > 9 sum.
    if 121.0 * spread <= 81.0 * sum * sum {
        return false;
    }
    let slope = growth.line.slope as f32 / 65_536.0;
    let slope = if growth.line.steep { [slope, 1.0] } else { [1.0, slope] };
    // Twice the angle of the normal (-d_y, d_x).
    let (cos, sin) = (slope[1] * slope[1] - slope[0] * slope[0], -2.0 * slope[0] * slope[1]);
    let along = difference * cos + twice * sin;
    along > 0.0 && along * along > DOUBLE_ANGLE_COS_SQUARED * spread * (cos * cos + sin * sin)
}
