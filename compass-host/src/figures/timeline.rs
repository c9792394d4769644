//! Errors over time, and the reliability of the margin.

use std::path::Path;

use plotters::style::text_anchor::{HPos, VPos};

use super::axes::{ABOVE, Axes, Axis, BELOW, BESIDE};
use super::canvas::{Px, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{AGREE, MUTED, Pen, TICK_PX, number};

const PLOT: f64 = 560.0;
/// Errors are clamped to these, metres; a frame without a pose is drawn at the upper one.
const SHOWN_M: [f64; 2] = [0.01, 100.0];
/// Thresholds of the recall figures, metres.
const THRESHOLDS_M: [f64; 3] = [0.1, 0.5, 1.0];

/// Errors of one method at the frames' times.
#[derive(Debug, Clone, Copy)]
pub struct ErrorCurve<'a> {
    /// The method.
    pub label: &'a str,
    /// Metres; infinite without a pose, NaN without ground truth.
    pub metres: &'a [f64],
    /// Whether neighbours depend on each other: drawn as a line instead of dots.
    pub joined: bool,
}

/// Draws position errors over the time in seconds, on a logarithmic scale.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_errors_over_time(
    path: &Path,
    seconds: &[f64],
    curves: &[ErrorCurve<'_>],
) -> Result<(), FigureError> {
    let entry = |(n, curve): (usize, &ErrorCurve<'_>)| {
        let pen = Pen::series(n);
        Entry::new(if curve.joined { Symbol::Line(pen) } else { Symbol::Dot(pen.colour) }, curve.label)
    };
    let page = Page {
        path,
        caption: "Position error over time (grey: recall thresholds; no pose, or another floor: at the top)",
        legend: curves.iter().enumerate().map(entry).collect(),
        body: ABOVE + PLOT + BELOW,
    };
    page.draw(|canvas, body| {
        let last = seconds.iter().copied().fold(1.0, f64::max);
        let x = Axis::new("time (s)", 0.0, last * 1.01, 8);
        let y = decades("position error (m)", SHOWN_M);
        let axes = Axes { frame: body.inset(y.room()?, ABOVE, BESIDE, BELOW), x, y };
        axes.draw_grid(canvas)?;
        for threshold in THRESHOLDS_M.map(f64::log10) {
            let pen = Pen { dash: Some([8.0, 8.0]), ..Pen::solid(MUTED, 2.5) };
            canvas.line(&[axes.at(0.0, threshold), axes.at(axes.x.to, threshold)], pen)?;
        }
        for (n, curve) in curves.iter().enumerate() {
            let shown = |metres: f64| metres.clamp(SHOWN_M[0], SHOWN_M[1]).log10();
            let known = seconds.iter().zip(curve.metres).filter(|(_, metres)| !metres.is_nan());
            let points: Vec<Px> = known.map(|(&time, &metres)| axes.at(time, shown(metres))).collect();
            if curve.joined {
                canvas.line(&points, Pen::series(n))?;
            } else {
                points.iter().try_for_each(|&at| canvas.disc(at, 6.0, Pen::series(n).colour))?;
            }
        }
        axes.draw_frame(canvas)
    })
}

/// A logarithmic axis over whole decades; its values are decimal logarithms.
fn decades(label: &str, [from, to]: [f64; 2]) -> Axis {
    let (from, to) = (from.log10().round(), to.log10().round());
    let ticks = (from as i32..=to as i32).map(|n| (f64::from(n), number(10f64.powi(n)))).collect();
    Axis { label: label.to_owned(), from, to, ticks }
}

/// Bounds of the bins of margins, nats.
const MARGINS: [f64; 7] = [0.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

/// Draws the share of correct answers by the margin in nats; each answer is its margin and whether it is correct.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_reliability(path: &Path, answers: &[(f64, bool)]) -> Result<(), FigureError> {
    let bins: Vec<(String, usize, usize)> = (0..MARGINS.len()).map(|bin| count(answers, bin)).collect();
    let page = Page {
        path,
        caption: "Answers within 1 m and 30° by the margin over the next pose (above the bars: right of all)",
        legend: vec![Entry::new(Symbol::Patch(AGREE), "share of right answers")],
        body: ABOVE + PLOT + BELOW,
    };
    page.draw(|canvas, body| {
        let y = Axis::new("right (%)", 0.0, 110.0, 5);
        let ticks = bins.iter().enumerate().map(|(n, bin)| (n as f64, bin.0.clone())).collect();
        let x = Axis { label: "margin (nats)".into(), from: -0.6, to: bins.len() as f64 - 0.4, ticks };
        let axes = Axes { frame: body.inset(y.room()?, ABOVE, BESIDE, BELOW), x, y };
        axes.draw_grid(canvas)?;
        let draw = |(n, (_, right, all)): (usize, &(String, usize, usize))| -> Drawn {
            let n = n as f64;
            let share = if *all == 0 { 0.0 } else { 100.0 * *right as f64 / *all as f64 };
            let [left, top] = axes.at(n - 0.4, share);
            let [right_px, bottom] = axes.at(n + 0.4, 0.0);
            canvas.fill(Rect { left, top, right: right_px, bottom }, AGREE)?;
            let above = [(left + right_px) / 2.0, top - 4.0];
            canvas.text(above, TICK_PX, (HPos::Center, VPos::Bottom), &format!("{right} of {all}"))
        };
        bins.iter().enumerate().try_for_each(draw)?;
        axes.draw_frame(canvas)
    })
}

/// A bin's label, its number of correct answers and of all answers.
fn count(answers: &[(f64, bool)], bin: usize) -> (String, usize, usize) {
    let from = MARGINS[bin];
    let to = MARGINS.get(bin + 1).copied().unwrap_or(f64::INFINITY);
    let name = if to.is_finite() {
        format!("{}\u{2013}{}", number(from), number(to))
    } else {
        format!("{}+", number(from))
    };
    let inside = || answers.iter().filter(move |(margin, _)| (from..to).contains(margin));
    (name, inside().filter(|(_, right)| *right).count(), inside().count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_margin_is_in_one_bin() {
        let answers = [0.0, 4.9, 5.0, 199.0, 200.0, 1e9].map(|margin| (margin, margin > 5.0));
        let bins: Vec<_> = (0..MARGINS.len()).map(|bin| count(&answers, bin)).collect();
        assert_eq!(bins.iter().map(|bin| bin.2).sum::<usize>(), answers.len());
        assert_eq!(bins[0], ("0\u{2013}5".to_owned(), 0, 2));
        assert_eq!(bins[6], ("200+".to_owned(), 2, 2));
    }

    #[test]
    fn pictures_are_drawn_of_little() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        draw_errors_over_time(&path, &[], &[]).unwrap();
        let metres = [0.0, f64::NAN, f64::INFINITY];
        let curve = |joined| ErrorCurve { label: "x", metres: &metres, joined };
        draw_errors_over_time(&path, &[0.0, 1.0, 2.0], &[curve(true), curve(false)]).unwrap();
        draw_reliability(&path, &[]).unwrap();
    }
}
