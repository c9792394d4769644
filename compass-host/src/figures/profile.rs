//! Range and range gradient by bearing, over the hit type.

use std::path::Path;

use compass_core::base::scan::Hit;

use super::axes::{ABOVE, Axes, Axis, BELOW, BESIDE};
use super::canvas::{Canvas, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Page, hit_entries};
use super::style::{Pen, hit_colour, nice_step, tint};

const PANEL: f64 = 400.0;
const BETWEEN: f64 = 36.0;
/// Strength of the hit colours behind the curves.
pub(super) const SHADE: f64 = 0.2;

/// Draws the range (m) and its gradient (m per degree) by bearing, the background shaded by hit type.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_profile(
    path: &Path,
    range_m: &[f64; 360],
    gradient_m: &[f64; 360],
    hit: &[Hit; 360],
) -> Result<(), FigureError> {
    let page = Page {
        path,
        caption: "Range and range gradient by bearing, shaded by hit type",
        legend: hit_entries(Some(hit)),
        body: ABOVE + 2.0 * PANEL + BETWEEN + BELOW,
    };
    page.draw(|canvas, body| {
        let upper = value_axis("range (m)", range_m);
        let lower = value_axis("|dr/dθ| (m per degree)", gradient_m);
        let room = upper.room()?.max(lower.room()?);
        let frame = Rect { bottom: body.top + ABOVE + PANEL, ..body.inset(room, ABOVE, BESIDE, 0.0) };
        let shift = PANEL + BETWEEN;
        let below = Rect { top: frame.top + shift, bottom: frame.bottom + shift, ..frame };
        let x = Axis::degrees("bearing relative to the heading (degrees)");
        draw_panel(canvas, &Axes { frame, x: x.clone().bare(), y: upper }, range_m, hit, 0)?;
        draw_panel(canvas, &Axes { frame: below, x, y: lower }, gradient_m, hit, 1)
    })
}

/// An axis from 0, or a round number below the smallest value, to one above the largest.
fn value_axis(label: &str, values: &[f64; 360]) -> Axis {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let low = finite().fold(0.0, f64::min);
    let high = finite().fold(0.0, f64::max);
    let step = nice_step((high - low) / 5.0);
    let to = ((high / step + 0.05).ceil() * step).max(step);
    Axis::new(label, (low / step).floor() * step, to, 5)
}

fn draw_panel(
    canvas: &Canvas<'_>,
    axes: &Axes,
    values: &[f64; 360],
    hit: &[Hit; 360],
    series: usize,
) -> Drawn {
    shade(canvas, axes, hit)?;
    axes.draw_grid(canvas)?;
    let mut run = Vec::new();
    for (bin, &value) in values.iter().chain(values.first()).enumerate() {
        if value.is_finite() {
            run.push(axes.at(bin as f64, value));
        } else {
            canvas.line(&run, curve(series))?;
            run.clear();
        }
    }
    canvas.line(&run, curve(series))?;
    axes.draw_frame(canvas)
}

/// Solid in both panels: each panel has only one curve.
const fn curve(series: usize) -> Pen {
    Pen { dash: None, ..Pen::series(series) }
}

fn shade(canvas: &Canvas<'_>, axes: &Axes, hit: &[Hit; 360]) -> Drawn {
    for (bin, &kind) in hit.iter().chain(hit.first()).enumerate() {
        let middle = bin as f64;
        let left = axes.x_px(middle - 0.5);
        let right = axes.x_px(middle + 0.5).min(axes.frame.right);
        canvas.fill(Rect { left, right, ..axes.frame }, tint(hit_colour(kind), SHADE))?;
    }
    Ok(())
}
