//! Axes with ticks and labels, and the colour bar.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, LEFT, Px, RIGHT, Rect};
use super::error::{DrawError, Drawn};
use super::style::{GRID, INK, Pen, TEXT_PX, TICK_PX, nice_ticks, number, viridis};
use super::text::text_width;

/// Space below a plot for the numbers and label of its x axis.
pub(super) const BELOW: f64 = 100.0;
/// Space above a plot for the upper half of the number at its top.
pub(super) const ABOVE: f64 = 22.0;
/// Space to the right of a plot for the right half of the number at its end.
pub(super) const BESIDE: f64 = 40.0;

const TICK_LENGTH: f64 = 8.0;
const FRAME: Pen = Pen::solid(INK, 2.0);

/// One axis.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis with about `count` round ticks.
    pub(super) fn new(label: impl Into<String>, from: f64, to: f64, count: usize) -> Self {
        let ticks = nice_ticks(from, to, count).into_iter().map(|t| (t, number(t))).collect();
        Self { label: label.into(), from, to, ticks }
    }

    /// Bearing or shift in degrees over the full turn, bins centred on their degree.
    pub(super) fn degrees(label: &str) -> Self {
        let ticks = (0..=8).map(|n| (f64::from(n) * 45.0, format!("{}", n * 45))).collect();
        Self { label: label.to_owned(), from: -0.5, to: 360.5, ticks }
    }

    /// The same axis without numbers and label, for the upper one of two panels.
    pub(super) fn bare(mut self) -> Self {
        self.label.clear();
        for (_, text) in &mut self.ticks {
            text.clear();
        }
        self
    }

    /// Space to the left of a plot with this y axis.
    pub(super) fn room(&self) -> Result<f64, DrawError> {
        let label = if self.label.is_empty() { 0.0 } else { TEXT_PX + 14.0 };
        Ok(self.widest()? + TICK_LENGTH + 8.0 + label)
    }

    fn widest(&self) -> Result<f64, DrawError> {
        self.ticks.iter().try_fold(0.0, |widest, (_, text)| {
            Ok(if text.is_empty() { widest } else { text_width(text, TICK_PX)?.max(widest) })
        })
    }
}

/// A plot: a rectangle of the picture and the ranges it shows.
#[derive(Debug, Clone)]
pub(super) struct Axes {
    pub(super) frame: Rect,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Axes {
    /// The pixel of a data point.
    pub(super) fn at(&self, x: f64, y: f64) -> Px {
        [self.x_px(x), self.y_px(y)]
    }

    /// The pixel column of an x value.
    pub(super) fn x_px(&self, x: f64) -> f64 {
        self.frame.left + (x - self.x.from) / (self.x.to - self.x.from) * self.frame.width()
    }

    /// The pixel row of a y value.
    pub(super) fn y_px(&self, y: f64) -> f64 {
        self.frame.bottom - (y - self.y.from) / (self.y.to - self.y.from) * self.frame.height()
    }

    /// Grid lines, to be drawn below the data.
    pub(super) fn draw_grid(&self, canvas: &Canvas<'_>) -> Drawn {
        let pen = Pen::solid(GRID, 1.5);
        for &(x, _) in &self.x.ticks {
            canvas.line(&[self.at(x, self.y.from), self.at(x, self.y.to)], pen)?;
        }
        for &(y, _) in &self.y.ticks {
            canvas.line(&[self.at(self.x.from, y), self.at(self.x.to, y)], pen)?;
        }
        Ok(())
    }

    /// Frame, ticks, numbers and labels, to be drawn above the data.
    pub(super) fn draw_frame(&self, canvas: &Canvas<'_>) -> Drawn {
        let Rect { left, bottom, .. } = self.frame;
        canvas.outline(self.frame, FRAME)?;
        for (x, text) in &self.x.ticks {
            let x = self.x_px(*x);
            canvas.line(&[[x, bottom], [x, bottom + TICK_LENGTH]], FRAME)?;
            let below = (HPos::Center, VPos::Top);
            canvas.text([x, bottom + TICK_LENGTH + 2.0], TICK_PX, below, text)?;
        }
        for (y, text) in &self.y.ticks {
            let y = self.y_px(*y);
            canvas.line(&[[left - TICK_LENGTH, y], [left, y]], FRAME)?;
            canvas.text([left - TICK_LENGTH - 6.0, y], TICK_PX, RIGHT, text)?;
        }
        self.draw_labels(canvas)
    }

    fn draw_labels(&self, canvas: &Canvas<'_>) -> Drawn {
        let [x, y] = self.frame.centre();
        let below = (HPos::Center, VPos::Top);
        canvas.text([x, self.frame.bottom + 44.0], TEXT_PX, below, &self.x.label)?;
        let left = self.frame.left - self.y.widest()? - TICK_LENGTH - 12.0 - TEXT_PX / 2.0;
        canvas.upright_text([left, y], &self.y.label)
    }
}

/// A vertical viridis bar with its range: numbers and label stand to its right.
pub(super) fn draw_colour_bar(
    canvas: &Canvas<'_>,
    bar: Rect,
    [from, to]: [f64; 2],
    ticks: usize,
    label: &str,
) -> Drawn {
    canvas.paint(bar, |square| Some(viridis((bar.bottom - square.centre()[1]) / bar.height())))?;
    canvas.outline(bar, FRAME)?;
    let axis = Axis::new(label, from, to, ticks);
    for (value, text) in &axis.ticks {
        let y = bar.bottom - (value - from) / (to - from) * bar.height();
        canvas.line(&[[bar.right, y], [bar.right + TICK_LENGTH, y]], FRAME)?;
        canvas.text([bar.right + TICK_LENGTH + 6.0, y], TICK_PX, LEFT, text)?;
    }
    if label.is_empty() {
        return Ok(());
    }
    let x = bar.right + TICK_LENGTH + axis.widest()? + 18.0 + TEXT_PX / 2.0;
    canvas.upright_text([x, bar.centre()[1]], label)
}
