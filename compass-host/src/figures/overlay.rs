//! A camera frame with lines drawn over it.

use std::path::Path;

use plotters::style::RGBColor;

use super::canvas::{CENTRE, Canvas, Px, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{INK, PAPER, Pen, TICK_PX};
use super::text::text_width;
use crate::frame::Frame;
use compass_core::vision::camera::Pixel;

/// Lines of one kind, in pixels of the frame: pixel centres are at integers.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Name of the kind; the legend adds the number of lines.
    pub label: String,
    /// Their colour.
    pub colour: RGBColor,
    /// Their width in pixels of the page.
    pub width: f64,
    /// The lines, each through all of its points.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Notes, each placed above a position.
    pub notes: Vec<([f64; 2], String)>,
}

impl Layer {
    /// A layer without lines.
    #[must_use]
    pub fn new(label: impl Into<String>, colour: RGBColor, width: f64) -> Self {
        Self { label: label.into(), colour, width, lines: Vec::new(), notes: Vec::new() }
    }

    /// A layer without lines that the legend leaves out.
    #[must_use]
    pub fn unnamed(colour: RGBColor, width: f64) -> Self {
        Self::new(String::new(), colour, width)
    }

    fn entry(&self) -> Option<Entry> {
        let symbol = Symbol::Line(Pen::solid(self.colour, self.width.max(4.0)));
        let label = format!("{} ({})", self.label, self.lines.len());
        (!self.label.is_empty()).then(|| Entry::new(symbol, label))
    }
}

/// Draws a frame, and over it the layers, the last on top.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_overlay(path: &Path, caption: &str, frame: &Frame, layers: &[Layer]) -> Result<(), FigureError> {
    let scale = Page::INNER_WIDTH / f64::from(frame.width());
    let body = scale * f64::from(frame.height());
    let legend = layers.iter().filter_map(Layer::entry).collect();
    Page { path, caption, legend, body: body + 16.0 }.draw(|canvas, body| {
        let shown = Rect { bottom: body.bottom - 16.0, ..body };
        draw_frame(canvas, shown, frame)?;
        let place = |[x, y]: [f64; 2]| [body.left + (x + 0.5) * scale, body.top + (y + 0.5) * scale];
        for layer in layers {
            let pen = Pen::solid(layer.colour, layer.width);
            for line in &layer.lines {
                // The drawing library's own clipping needs points near the page.
                let points: Vec<Px> = line.iter().map(|&p| within(place(p), shown)).collect();
                canvas.line(&points, pen)?;
            }
        }
        let mut notes = Notes::new(shown);
        let mut written = layers.iter().flat_map(|layer| &layer.notes);
        written.try_for_each(|(at, note)| notes.write(canvas, within(place(*at), shown), note))
    })
}

fn within([x, y]: Px, rect: Rect) -> Px {
    [x.clamp(rect.left, rect.right), y.clamp(rect.top, rect.bottom)]
}

fn draw_frame(canvas: &Canvas<'_>, rect: Rect, frame: &Frame) -> Drawn {
    let (width, height) = (frame.width(), frame.height());
    let scale = f64::from(width) / rect.width();
    canvas.paint(rect, |square| {
        let [x, y] = square.centre();
        let x = (((x - rect.left) * scale) as u32).min(width - 1);
        let y = (((y - rect.top) * scale) as u32).min(height - 1);
        frame.colour(Pixel { x: x as f32, y: y as f32 }).map(|[r, g, b]| RGBColor(r, g, b))
    })
}

/// Short texts on plates that do not overlap each other.
#[derive(Debug)]
pub(super) struct Notes {
    bounds: Rect,
    placed: Vec<Rect>,
}

impl Notes {
    /// Notes within `bounds`.
    pub(super) const fn new(bounds: Rect) -> Self {
        Self { bounds, placed: Vec::new() }
    }

    /// Writes a note above a position, or higher if that place is taken.
    pub(super) fn write(&mut self, canvas: &Canvas<'_>, [x, y]: Px, text: &str) -> Drawn {
        let half = text_width(text, TICK_PX)? / 2.0 + 5.0;
        let Rect { left, top, right, bottom } = self.bounds;
        let x = x.clamp(left + half, (right - half).max(left + half));
        let plate = |step: i32| {
            let y = y - NOTE * (f64::from(step) / 4.0 + 0.6);
            let y = y.clamp(top + NOTE / 2.0, (bottom - NOTE / 2.0).max(top + NOTE / 2.0));
            Rect { left: x - half, top: y - NOTE / 2.0, right: x + half, bottom: y + NOTE / 2.0 }
        };
        let is_free = |plate: &Rect| !self.placed.iter().any(|other| touch(plate, other));
        let plate = (0..STEPS).map(plate).find(is_free).unwrap_or_else(|| plate(0));
        self.placed.push(plate);
        let inside = plate.inset(0.0, 1.0, 0.0, 1.0);
        canvas.fill(inside, PAPER)?;
        canvas.outline(inside, Pen::solid(INK, 1.0))?;
        canvas.text(plate.centre(), TICK_PX, CENTRE, text)
    }
}

/// Height of a note, and the number of quarter-height steps that are tried.
const NOTE: f64 = 32.0;
const STEPS: i32 = 48;

fn touch(a: &Rect, b: &Rect) -> bool {
    a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom
}
