//! Validation: a segment is kept if most of its gradients point across it.

use super::cell::{INLIER, label};
use super::growth::{Growth, Trail};
use super::walk::{Cells, Position};
use crate::base::num::{count_as_i32, saturate_to_u16};

/// Squared sine of 0.15 rad, the largest angle between gradient and normal.
const SIN_SQUARED: f32 = 0.022_331_76;
/// Upper bound of the pixels next to each end that are not tested.
const MAX_MARGIN: usize = 5;

/// Number of a segment's pixels whose gradient points across it; `None` unless they are the majority.
pub(super) fn score(cells: &Cells<'_>, smoothed: &[u8], growth: &Growth, trail: &Trail<'_>) -> Option<u16> {
    let line = &growth.line;
    let margin = count_as_i32((line.len() / 10).min(MAX_MARGIN));
    let along = |p: Position| if line.steep { p.y } else { p.x };
    let ends = [along(growth.head[0]), along(growth.tail[0])];
    let slope = line.slope as f32 / 65_536.0;
    let allowed = SIN_SQUARED * (1.0 + slope * slope);
    let (mut agree, mut differ) = (0_u32, 0_u32);
    for p in trail.iter() {
        let u = along(p);
        if label(cells.get(p)) != INLIER || ends.iter().any(|end| (u - end).abs() < margin) {
            continue;
        }
        let (gu, gv) = gradient_on(smoothed, cells, line.steep, u, line.across_at(u));
        let off = gu + gv * slope;
        let ok = off * off <= allowed * (gu * gu + gv * gv);
        agree += u32::from(ok);
        differ += u32::from(!ok);
    }
    (agree > differ).then_some(saturate_to_u16(agree))
}

/// Gradient along and across the main axis at integer coordinate `u` and cross coordinate `v` (1/65536 px),
/// interpolated between the two pixels around it.
#[inline(always)]
fn gradient_on(smoothed: &[u8], cells: &Cells<'_>, steep: bool, u: i32, v: i32) -> (f32, f32) {
    let width = cells.width as isize;
    let (step_u, step_v) = if steep { (width, 1) } else { (1, width) };
    let corner = (u as isize - 1) * step_u + ((v >> 16) as isize - 1) * step_v;
    let part = v & 0xffff;
    let at = |du: isize, dv: isize| {
        let index = corner + du * step_u + dv * step_v;
        smoothed.get(index.cast_unsigned()).copied().map_or(0, i32::from)
    };
    // Three samples along u at four positions across.
    let row = |dv: isize| (at(0, dv), at(1, dv), at(2, dv));
    let rows = [row(0), row(1), row(2), row(3)];
    let difference = rows.map(|(a, _, c)| c - a);
    let sum = rows.map(|(a, b, c)| a + 2 * b + c);
    let du0 = difference[0] + 2 * difference[1] + difference[2];
    let du1 = difference[1] + 2 * difference[2] + difference[3];
    let (dv0, dv1) = (sum[2] - sum[0], sum[3] - sum[1]);
    // Products of at most 1020 * 65536 fit.
    let mix = |a: i32, b: i32| ((a << 8) + ((b - a) * (part >> 8))) as f32;
    (mix(du0, du1), mix(dv0, dv1))
}
