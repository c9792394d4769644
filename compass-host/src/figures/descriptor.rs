//! The 5 x 360 descriptor as rows of colour.

use std::path::Path;

use plotters::style::text_anchor::{HPos, VPos};

use super::axes::{Axes, Axis, BELOW, draw_colour_bar};
use super::canvas::{Canvas, RIGHT, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{MUTED, TEXT_PX, TICK_PX, nice_step, viridis};

/// The channels, in the descriptor's order.
const NAMES: [&str; 5] = ["r / r_max", "hit type", "|dr/dθ| / 5 m", "1 / (1 + r)", "std(r) / 10 m"];

const NAME_HEIGHT: f64 = 46.0;
const ROW_HEIGHT: f64 = 96.0;
const BETWEEN: f64 = 10.0;
/// Space to the right for the colour bars and their numbers.
const BARS: f64 = 130.0;
/// Space to the left: without row names, and with them.
const LEFT_ROOM: f64 = 40.0;
const NAMED_ROOM: f64 = 110.0;

/// Draws the five channels of a descriptor as heat-map rows over the bearing.
///
/// Each row has a colour bar of its own from 0 to a round number not below the row's largest value.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_descriptor(path: &Path, channels: &[[f64; 360]; 5]) -> Result<(), FigureError> {
    let caption = "Descriptor: five channels by bearing, colour scale per row";
    draw(path, caption, &[("", channels)])
}

/// Draws descriptors in one frame, channel by channel, each row named; the rows of a channel share a colour scale. NaN
/// is unknown.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_descriptors(path: &Path, named: &[(&str, &[[f64; 360]; 5])]) -> Result<(), FigureError> {
    draw(path, "Descriptors: five channels by bearing, colour scale per channel", named)
}

fn draw(path: &Path, caption: &str, named: &[(&str, &[[f64; 360]; 5])]) -> Result<(), FigureError> {
    let rows = named.len() as f64;
    let pitch = NAME_HEIGHT + rows * (ROW_HEIGHT + BETWEEN);
    let name_room = if named.iter().all(|(name, _)| name.is_empty()) { LEFT_ROOM } else { NAMED_ROOM };
    let unknown = named.iter().any(|(_, channels)| channels.as_flattened().iter().any(|v| v.is_nan()));
    let legend = unknown.then(|| Entry::new(Symbol::Patch(MUTED), "not known")).into_iter().collect();
    let body = 5.0 * pitch + BELOW - 20.0;
    Page { path, caption, legend, body }.draw(|canvas, body| {
        for (n, title) in NAMES.iter().enumerate() {
            let top = body.top + n as f64 * pitch + NAME_HEIGHT;
            let left = body.left + name_room;
            canvas.text([left, top - 6.0], TEXT_PX, (HPos::Left, VPos::Bottom), title)?;
            let scale = scale(named.iter().map(|(_, channels)| &channels[n]));
            let right = body.right - BARS;
            let bottom = top + rows * (ROW_HEIGHT + BETWEEN) - BETWEEN;
            let bar = Rect { left: right + 24.0, top, right: right + 50.0, bottom };
            draw_colour_bar(canvas, bar, [0.0, scale], 1, "")?;
            for (row, (name, channels)) in named.iter().enumerate() {
                let top = top + row as f64 * (ROW_HEIGHT + BETWEEN);
                let frame = Rect { left, top, right, bottom: top + ROW_HEIGHT };
                canvas.text([left - 14.0, frame.centre()[1]], TICK_PX, RIGHT, name)?;
                let x = Axis::degrees("bearing relative to the heading (degrees)");
                let x = if n == 4 && row + 1 == named.len() { x } else { x.bare() };
                draw_row(canvas, frame, x, &channels[n], scale)?;
            }
        }
        Ok(())
    })
}

/// A round number not below the largest value.
fn scale<'a>(rows: impl Iterator<Item = &'a [f64; 360]>) -> f64 {
    let largest = rows.flatten().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    if largest > 0.0 { nice_step(largest) } else { 1.0 }
}

fn draw_row(canvas: &Canvas<'_>, frame: Rect, x: Axis, channel: &[f64; 360], top: f64) -> Drawn {
    let y = Axis { label: String::new(), from: 0.0, to: 1.0, ticks: Vec::new() };
    let axes = Axes { frame, x, y };
    for (bin, value) in channel.iter().enumerate() {
        // The row ends at 360 degrees, which is half a bin into bin 0 again.
        let right = if bin == 359 { frame.right } else { axes.x_px(bin as f64 + 0.5) };
        let cell = Rect { left: axes.x_px(bin as f64 - 0.5), right, ..frame };
        canvas.fill(cell, viridis(value / top))?;
    }
    axes.draw_frame(canvas)
}
