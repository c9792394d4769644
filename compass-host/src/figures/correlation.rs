//! Correlation score by shift, with the peaks marked.

use std::path::Path;

use plotters::style::text_anchor::{HPos, VPos};

use super::axes::{Axes, Axis, BELOW, BESIDE};
use super::canvas::Canvas;
use super::error::{DrawError, Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{self, MUTED, Pen, TEXT_PX, nice_step};
use super::text::text_width;

const PLOT: f64 = 620.0;
/// Space above the plot for the shifts of the peaks.
const HEAD: f64 = 52.0;

/// One labelled correlation curve.
#[derive(Debug, Clone, Copy)]
pub struct Curve<'a> {
    /// Name of the curve, such as "centred".
    pub label: &'a str,
    /// The score of each shift in degrees.
    pub score: &'a [f64; 360],
}

impl Curve<'_> {
    /// The shift of the largest score, the first of equal ones; `None` when no score is finite.
    #[must_use]
    pub fn peak(&self) -> Option<(usize, f64)> {
        let finite = self.score.iter().copied().enumerate().filter(|(_, s)| s.is_finite());
        finite.reduce(|best, next| if next.1 > best.1 { next } else { best })
    }
}

/// The range in which shifts are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shifts {
    /// 0 to 360 degrees: a query against a map, where every heading is possible.
    Turn,
    /// -180 to 180 degrees: an observation against the plan at a known pose, where 0 is expected.
    Signed,
}

impl Shifts {
    const fn first(self) -> i32 {
        match self {
            Self::Turn => 0,
            Self::Signed => -180,
        }
    }

    const fn caption(self) -> &'static str {
        match self {
            Self::Turn => "Correlation score by shift of the query against the map",
            Self::Signed => "Correlation score by shift of what is seen against the plan",
        }
    }

    fn axis(self) -> Axis {
        let axis = Axis::degrees("shift (degrees)");
        let first = f64::from(self.first());
        let ticks = axis.ticks.iter().map(|(at, _)| (at + first, style::number(at + first))).collect();
        Axis { from: axis.from + first, to: axis.to + first, ticks, ..axis }
    }

    /// The shift of a bin in degrees.
    fn of(self, bin: usize) -> f64 {
        let shift = bin as i32;
        f64::from(if shift > 360 + self.first() { shift - 360 } else { shift })
    }

    /// The bins in order of their shifts, with the first repeated at the end.
    fn bins(self) -> impl Iterator<Item = (f64, usize)> {
        let first = self.first();
        (first..=first + 360).map(|shift| (f64::from(shift), shift.rem_euclid(360) as usize))
    }
}

/// Draws correlation scores by shift, each curve's peak marked and labelled.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_correlation(path: &Path, curves: &[Curve<'_>], shifts: Shifts) -> Result<(), FigureError> {
    let entry = |(n, curve): (usize, &Curve<'_>)| {
        let peak = curve.peak().map_or("no peak".to_owned(), |(shift, score)| {
            format!("peak {} at {}°", style::score(score), style::number(shifts.of(shift)))
        });
        Entry::new(Symbol::Line(Pen::series(n)), format!("{}: {peak}", curve.label))
    };
    let page = Page {
        path,
        caption: shifts.caption(),
        legend: curves.iter().enumerate().map(entry).collect(),
        body: HEAD + PLOT + BELOW,
    };
    page.draw(|canvas, body| {
        let y = score_axis(curves);
        let frame = body.inset(y.room()?, HEAD, BESIDE, BELOW);
        let axes = Axes { frame, x: shifts.axis(), y };
        axes.draw_grid(canvas)?;
        for (shift, _) in curves.iter().filter_map(Curve::peak) {
            let x = axes.x_px(shifts.of(shift));
            let dropped = [[x, frame.top - 10.0], [x, frame.bottom]];
            canvas.line(&dropped, Pen { dash: Some([8.0, 8.0]), ..Pen::solid(MUTED, 2.5) })?;
        }
        for (n, curve) in curves.iter().enumerate() {
            draw_curve(canvas, &axes, curve, shifts, Pen::series(n))?;
        }
        for (x, text) in peak_labels(curves, shifts, &axes)? {
            canvas.text([x, frame.top - 8.0], TEXT_PX, (HPos::Center, VPos::Bottom), &text)?;
        }
        axes.draw_frame(canvas)
    })
}

fn score_axis(curves: &[Curve<'_>]) -> Axis {
    let scores = || curves.iter().flat_map(|c| c.score).copied().filter(|s| s.is_finite());
    let high = scores().fold(f64::NEG_INFINITY, f64::max);
    let low = scores().fold(f64::INFINITY, f64::min);
    if low > high {
        return Axis::new("score", 0.0, 1.0, 5);
    }
    let margin = ((high - low) * 0.06).max(1e-3);
    let step = nice_step((high - low) / 6.0);
    let from = ((low - margin) / step).floor() * step;
    let to = ((high + margin) / step).ceil() * step;
    Axis::new("score", from, to, ((to - from) / step).round() as usize)
}

fn draw_curve(canvas: &Canvas<'_>, axes: &Axes, curve: &Curve<'_>, shifts: Shifts, pen: Pen) -> Drawn {
    let around = shifts.bins().map(|(shift, bin)| (shift, curve.score[bin]));
    let points: Vec<_> = around.filter(|(_, s)| s.is_finite()).map(|(x, s)| axes.at(x, s)).collect();
    canvas.line(&points, pen)?;
    match curve.peak() {
        Some((shift, score)) => canvas.ring(axes.at(shifts.of(shift), score), 11.0, 4.0, pen.colour),
        None => Ok(()),
    }
}

/// The shifts of the peaks above the plot; overlapping labels are merged.
fn peak_labels(curves: &[Curve<'_>], shifts: Shifts, axes: &Axes) -> Result<Vec<(f64, String)>, DrawError> {
    let mut peaks: Vec<f64> = curves.iter().filter_map(|c| Some(shifts.of(c.peak()?.0))).collect();
    peaks.sort_by(f64::total_cmp);
    peaks.dedup();
    let mut labels: Vec<(f64, String)> = Vec::new();
    for shift in peaks {
        let (x, text) = (axes.x_px(shift), format!("{}°", style::number(shift)));
        match labels.last_mut() {
            Some((at, before))
                if x - *at < text_width(before, TEXT_PX)? / 2.0 + text_width(&text, TEXT_PX)? =>
            {
                *at = (*at + x) / 2.0;
                *before = format!("{before}, {text}");
            }
            _ => labels.push((x, text)),
        }
    }
    for (x, text) in &mut labels {
        let half = text_width(text, TEXT_PX)? / 2.0;
        *x = x.clamp(axes.frame.left + half - BESIDE, axes.frame.right + BESIDE - half);
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_go_around_once() {
        for shifts in [Shifts::Turn, Shifts::Signed] {
            let mut bins = shifts.bins();
            assert!(bins.all(|(shift, bin)| (shifts.of(bin) - shift).rem_euclid(360.0) == 0.0));
            assert_eq!(shifts.bins().count(), 361);
        }
        assert_eq!([1, 180, 359].map(|bin| Shifts::Signed.of(bin)), [1.0, 180.0, -1.0]);
        assert_eq!([1, 180, 359].map(|bin| Shifts::Turn.of(bin)), [1.0, 180.0, 359.0]);
    }

    #[test]
    fn peak_is_the_first_largest_finite_score() {
        let mut score = [0.0; 360];
        score[3] = f64::NAN;
        score[137] = 0.8;
        score[200] = 0.8;
        assert_eq!(Curve { label: "", score: &score }.peak(), Some((137, 0.8)));
        assert_eq!(Curve { label: "", score: &[f64::NAN; 360] }.peak(), None);
    }
}
