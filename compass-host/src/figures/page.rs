//! The page layout of every figure: caption, body and legend, one below the other.

use std::path::Path;

use compass_core::base::scan::Hit;
use plotters::style::RGBColor;

use crate::output::write_file;

use super::canvas::{Canvas, LEFT, Px, Rect, to_png};
use super::error::{DrawError, Drawn, FigureError};
use super::style::{HITS, PAPER, Pen, TEXT_PX, WIDTH_PX, hit_colour, hit_name};
use super::text::{text_width, wrap};

const MARGIN: f64 = 20.0;
const LINE: f64 = 44.0;
/// Width of a legend's symbol and the space after it.
const SYMBOL: f64 = 64.0;
/// Space between two entries of a legend.
const BETWEEN: f64 = 48.0;
/// Width of the halo around a pose.
const HALO: f64 = 3.0;

/// The symbol of a legend entry.
#[derive(Debug, Clone, Copy)]
pub(super) enum Symbol {
    Patch(RGBColor),
    Line(Pen),
    Dot(RGBColor),
    Pose(RGBColor),
}

/// One entry of a legend.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) symbol: Symbol,
    pub(super) label: String,
}

impl Entry {
    pub(super) fn new(symbol: Symbol, label: impl Into<String>) -> Self {
        Self { symbol, label: label.into() }
    }
}

/// Legend entries of the three hit types, with the number of bins of each when there is one scan.
pub(super) fn hit_entries(hit: Option<&[Hit; 360]>) -> Vec<Entry> {
    let entry = |kind: Hit| {
        let count = hit.map(|all| all.iter().filter(|&&h| h == kind).count());
        let label = count.map_or(hit_name(kind).to_owned(), |n| format!("{} ({n})", hit_name(kind)));
        Entry::new(Symbol::Patch(hit_colour(kind)), label)
    };
    HITS.into_iter().map(entry).collect()
}

/// A figure without its body.
#[derive(Debug)]
pub(super) struct Page<'a> {
    pub(super) path: &'a Path,
    pub(super) caption: &'a str,
    pub(super) legend: Vec<Entry>,
    /// Height of the body in pixels.
    pub(super) body: f64,
}

impl Page<'_> {
    /// Width of the body in pixels.
    pub(super) const INNER_WIDTH: f64 = WIDTH_PX as f64 - 2.0 * MARGIN;

    /// Draws the page with `body` in the middle and writes it.
    pub(super) fn draw(&self, body: impl FnOnce(&Canvas<'_>, Rect) -> Drawn) -> Result<(), FigureError> {
        let png = self.render(body).map_err(|e| FigureError::draw(self.path, &*e))?;
        Ok(write_file(self.path, &png)?)
    }

    fn render(&self, body: impl FnOnce(&Canvas<'_>, Rect) -> Drawn) -> Result<Vec<u8>, DrawError> {
        let inner = Self::INNER_WIDTH;
        let caption = wrap(self.caption, TEXT_PX, inner)?;
        let legend = arrange(&self.legend, inner)?;
        let top = MARGIN + LINE * caption.len() as f64;
        let bottom = top + self.body;
        let height = bottom + LINE * legend.len() as f64 + MARGIN;
        to_png(WIDTH_PX, height.ceil() as u32, |canvas| {
            for (n, line) in caption.iter().enumerate() {
                canvas.text([MARGIN, MARGIN + LINE * (n as f64 + 0.5)], TEXT_PX, LEFT, line)?;
            }
            body(canvas, Rect { left: MARGIN, top, right: MARGIN + inner, bottom })?;
            for (n, row) in legend.iter().enumerate() {
                draw_row(canvas, row, bottom + LINE * (n as f64 + 0.5))?;
            }
            Ok(())
        })
    }
}

/// Rows of entries, each with its width.
type Rows<'a> = Vec<Vec<(&'a Entry, f64)>>;

fn row_width(row: &[(&Entry, f64)]) -> f64 {
    row.iter().map(|(_, width)| width + BETWEEN).sum::<f64>() - BETWEEN
}

/// Fills rows with entries from left to right.
fn arrange(entries: &[Entry], width: f64) -> Result<Rows<'_>, DrawError> {
    let mut rows: Rows<'_> = Vec::new();
    for entry in entries {
        let own = SYMBOL + text_width(&entry.label, TEXT_PX)?;
        match rows.last_mut() {
            Some(row) if row_width(row) + BETWEEN + own <= width => row.push((entry, own)),
            _ => rows.push(vec![(entry, own)]),
        }
    }
    Ok(rows)
}

fn draw_row(canvas: &Canvas<'_>, row: &[(&Entry, f64)], y: f64) -> Drawn {
    let mut x = (f64::from(WIDTH_PX) - row_width(row)) / 2.0;
    for (entry, width) in row {
        draw_symbol(canvas, entry.symbol, [x, y])?;
        canvas.text([x + SYMBOL, y], TEXT_PX, LEFT, &entry.label)?;
        x += width + BETWEEN;
    }
    Ok(())
}

fn draw_symbol(canvas: &Canvas<'_>, symbol: Symbol, [x, y]: Px) -> Drawn {
    let middle = [x + 26.0, y];
    match symbol {
        Symbol::Patch(colour) => {
            let rect = Rect { left: x + 4.0, top: y - 13.0, right: x + 48.0, bottom: y + 13.0 };
            canvas.fill(rect, colour)
        }
        Symbol::Line(pen) => canvas.line(&[[x, y], [x + 54.0, y]], pen),
        Symbol::Dot(colour) => canvas.disc(middle, 8.0, colour),
        Symbol::Pose(colour) => draw_pose(canvas, [x + 14.0, y], 0.0, 11.0, colour),
    }
}

/// A position and the direction it faces (degrees counter-clockwise from right), on a white halo.
pub(super) fn draw_pose(
    canvas: &Canvas<'_>,
    at: Px,
    heading_deg: f64,
    radius: f64,
    colour: RGBColor,
) -> Drawn {
    let (sin, cos) = heading_deg.to_radians().sin_cos();
    let along = |forward: f64, left: f64| {
        [at[0] + radius * (forward * cos - left * sin), at[1] - radius * (forward * sin + left * cos)]
    };
    let shaft = |grow: f64| {
        let (tip, wing, half) = (3.6 + 1.6 * grow, 1.0 + grow, 0.28 + 0.6 * grow);
        let neck = 2.1 - 0.5 * grow;
        [
            along(0.0, half),
            along(neck, half),
            along(neck, wing),
            along(tip, 0.0),
            along(neck, -wing),
            along(neck, -half),
            along(0.0, -half),
        ]
    };
    canvas.disc(at, radius + HALO, PAPER)?;
    canvas.polygon(&shaft(HALO / radius / 1.6), PAPER)?;
    canvas.polygon(&shaft(0.0), colour)?;
    canvas.disc(at, radius, colour)
}
