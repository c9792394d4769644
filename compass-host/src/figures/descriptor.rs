//! The 5 x 360 descriptor as rows of colour.

use std::path::Path;

use plotters::style::text_anchor::{HPos, VPos};

use super::axes::{Axes, Axis, BELOW, draw_colour_bar};
use super::canvas::{Canvas, Drawn, Rect};
use super::output::FigureError;
use super::page::Page;
use super::style::{TEXT_PX, nice_step, viridis};

/// The channels, in the descriptor's order.
const NAMES: [&str; 5] = ["r / r_max", "hit type", "|dr/dθ| / 5 m", "1 / (1 + r)", "std(r) / 10 m"];

const NAME_HEIGHT: f64 = 46.0;
const ROW_HEIGHT: f64 = 96.0;
const PITCH: f64 = NAME_HEIGHT + ROW_HEIGHT + 10.0;
/// Space to the right for the colour bars and their numbers.
const BARS: f64 = 130.0;
const LEFT_ROOM: f64 = 40.0;

/// Draws the five channels of a descriptor as heat-map rows over the bearing.
///
/// Each row has a colour bar of its own from 0 to a round number not below the row's largest value.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_descriptor(path: &Path, channels: &[[f64; 360]; 5]) -> Result<(), FigureError> {
    let body = 5.0 * PITCH + BELOW - 20.0;
    let caption = "Descriptor: five channels by bearing, colour scale per row";
    Page { path, caption, legend: Vec::new(), body }.draw(|canvas, body| {
        for (n, channel) in channels.iter().enumerate() {
            let top = body.top + n as f64 * PITCH + NAME_HEIGHT;
            let frame =
                Rect { left: body.left + LEFT_ROOM, top, right: body.right - BARS, bottom: top + ROW_HEIGHT };
            let above = (HPos::Left, VPos::Bottom);
            canvas.text([frame.left, top - 6.0], TEXT_PX, above, NAMES[n])?;
            let x = Axis::degrees("bearing relative to the heading (degrees)");
            let x = if n == 4 { x } else { x.bare() };
            draw_row(canvas, frame, x, channel)?;
        }
        Ok(())
    })
}

fn draw_row(canvas: &Canvas<'_>, frame: Rect, x: Axis, channel: &[f64; 360]) -> Drawn {
    let largest = channel.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = if largest > 0.0 { nice_step(largest) } else { 1.0 };
    let y = Axis { label: String::new(), from: 0.0, to: 1.0, ticks: Vec::new() };
    let axes = Axes { frame, x, y };
    for (bin, value) in channel.iter().enumerate() {
        // The row ends at 360 degrees, half a bin into the bin at 0 again.
        let right = if bin == 359 { frame.right } else { axes.x_px(bin as f64 + 0.5) };
        let cell = Rect { left: axes.x_px(bin as f64 - 0.5), right, ..frame };
        canvas.fill(cell, viridis(value / top))?;
    }
    axes.draw_frame(canvas)?;
    let bar = Rect { left: frame.right + 24.0, right: frame.right + 50.0, ..frame };
    draw_colour_bar(canvas, bar, [0.0, top], 1, "")
}
