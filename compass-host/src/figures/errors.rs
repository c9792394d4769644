//! Distribution of localization errors over many queries.

use std::path::Path;

use super::axes::{ABOVE, Axes, Axis, BELOW, BESIDE};
use super::canvas::{Canvas, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{MUTED, Pen, number};

const PLOT: f64 = 600.0;
/// Steps of a curve narrower than this are drawn as a slope, in pixels.
const SHORTEST_TREAD: f64 = 6.0;
/// Smaller errors are shown as these: metres and degrees.
const SMALLEST: [f64; 2] = [1e-3, 1e-2];
/// Thresholds of the recall figures: metres and degrees.
const THRESHOLDS_M: [f64; 3] = [0.1, 0.5, 1.0];
const THRESHOLDS_DEG: [f64; 1] = [30.0];

/// The errors of one method over its queries.
#[derive(Debug, Clone, Copy)]
pub struct ErrorSeries<'a> {
    /// The method.
    pub label: &'a str,
    /// Position error of each query in metres; not finite where no pose was found.
    pub position_m: &'a [f64],
    /// Heading error of each query in degrees; not finite where no pose was found.
    pub heading_deg: &'a [f64],
}

/// Draws the share of queries whose position and heading errors stay below a bound, over the bound.
///
/// Queries without a pose (an error that is not finite) count as never below it.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_error_cdf(path: &Path, series: &[ErrorSeries<'_>]) -> Result<(), FigureError> {
    let entry = |(n, one): (usize, &ErrorSeries<'_>)| Entry::new(Symbol::Line(Pen::series(n)), summary(one));
    let page = Page {
        path,
        caption: "Share of queries with at most this error (vertical lines: recall thresholds)",
        legend: series.iter().enumerate().map(entry).collect(),
        body: ABOVE + PLOT + BELOW,
    };
    page.draw(|canvas, body| {
        let y = Axis::new("share of queries (%)", 0.0, 100.0, 5);
        let room = y.room()?;
        let middle = body.centre()[0];
        let left = Rect { right: middle - 30.0, ..body.inset(room, ABOVE, 0.0, BELOW) };
        let right = Rect { left: left.right + 84.0, right: body.right - BESIDE, ..left };
        let position: Vec<&[f64]> = series.iter().map(|s| s.position_m).collect();
        let x = log_axis("position error (m)", &position, SMALLEST[0], None);
        draw_panel(canvas, &Axes { frame: left, x, y: y.clone() }, &position, &THRESHOLDS_M)?;
        let heading: Vec<&[f64]> = series.iter().map(|s| s.heading_deg).collect();
        let x = log_axis("heading error (degrees)", &heading, SMALLEST[1], Some(180.0));
        draw_panel(canvas, &Axes { frame: right, x, y: y.bare() }, &heading, &THRESHOLDS_DEG)
    })
}

fn summary(series: &ErrorSeries<'_>) -> String {
    let median = |errors: &[f64], digits: f64, unit: &str| match quantile(errors, 0.5) {
        Some(value) => format!("{}{unit}", number((value * digits).round() / digits)),
        None => "none".to_owned(),
    };
    format!(
        "{} (n = {}): median {}, {}",
        series.label,
        series.position_m.len(),
        median(series.position_m, 1000.0, " m"),
        median(series.heading_deg, 100.0, "°")
    )
}

/// The finite errors in ascending order.
fn ascending(errors: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = errors.iter().map(|e| e.abs()).filter(|e| e.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The smallest error that a share of all queries does not exceed; `None` if fewer have a pose.
fn quantile(errors: &[f64], share: f64) -> Option<f64> {
    let rank = (share * errors.len() as f64).ceil().max(1.0) as usize;
    ascending(errors).get(rank - 1).copied()
}

/// A logarithmic axis (its values are decimal logarithms) over whole decades, or up to the largest possible value.
fn log_axis(label: &str, series: &[&[f64]], smallest: f64, largest: Option<f64>) -> Axis {
    let all = || series.iter().flat_map(|errors| ascending(errors)).map(|e| e.max(smallest));
    let low = all().fold(f64::INFINITY, f64::min);
    let high = all().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = if low <= high { (low, high) } else { (smallest, 1.0) };
    let from = low.log10().floor() as i32;
    let to = (high.log10().ceil() as i32).max(from + 1);
    let limit = largest.map_or(f64::INFINITY, f64::log10).max(f64::from(from) + 0.5);
    let to = f64::from(to).min(limit);
    let decades = (from..).map(|n| (f64::from(n), number(10f64.powi(n))));
    let ticks = decades.take_while(|&(n, _)| n <= to).collect();
    Axis { label: label.to_owned(), from: from.into(), to, ticks }
}

fn draw_panel(canvas: &Canvas<'_>, axes: &Axes, series: &[&[f64]], thresholds: &[f64]) -> Drawn {
    axes.draw_grid(canvas)?;
    let shown = axes.x.from..=axes.x.to;
    for x in thresholds.iter().map(|t| t.log10()).filter(|x| shown.contains(x)) {
        let pen = Pen { dash: Some([8.0, 8.0]), ..Pen::solid(MUTED, 2.5) };
        canvas.line(&[axes.at(x, 0.0), axes.at(x, 100.0)], pen)?;
    }
    for (n, errors) in series.iter().enumerate() {
        draw_steps(canvas, axes, errors, Pen::series(n))?;
    }
    axes.draw_frame(canvas)
}

fn draw_steps(canvas: &Canvas<'_>, axes: &Axes, errors: &[f64], pen: Pen) -> Drawn {
    let mut points = vec![axes.at(axes.x.from, 0.0)];
    let mut share = 0.0;
    for (n, error) in ascending(errors).into_iter().enumerate() {
        let x = error.log10().clamp(axes.x.from, axes.x.to);
        // Very short treads are invisible and would only roughen the dashes.
        if points.last().is_none_or(|last| axes.x_px(x) - last[0] > SHORTEST_TREAD) {
            points.push(axes.at(x, share));
        }
        share = (n + 1) as f64 / errors.len() as f64 * 100.0;
        points.push(axes.at(x, share));
    }
    points.push(axes.at(axes.x.to, share));
    canvas.line(&points, pen)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantile_counts_queries_without_a_pose() {
        assert_eq!(quantile(&[3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile(&[f64::NAN, 1.0, f64::INFINITY, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile(&[f64::NAN, 1.0, f64::NAN], 0.5), None);
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn log_axis_covers_whole_decades() {
        let axis = log_axis("", &[&[0.0, 0.03, 7.0]], 1e-3, None);
        assert_eq!((axis.from, axis.to), (-3.0, 1.0));
        assert_eq!(axis.ticks[0].1, "0.001");
        let angles = log_axis("", &[&[0.2, 170.0]], 1e-2, Some(180.0));
        assert_eq!((angles.from, angles.to, angles.ticks.len()), (-1.0, 180f64.log10(), 4));
    }
}
