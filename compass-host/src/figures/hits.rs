//! Comparison of two hit-type arrays: the bins on which they agree and differ.

use std::path::Path;

use compass_core::base::scan::Hit;
use plotters::style::RGBColor;

use super::axes::{Axes, Axis, BELOW, BESIDE};
use super::canvas::{CENTRE, Canvas, LEFT, RIGHT, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol, hit_entries};
use super::polar::Dial;
use super::style::{AGREE, DISAGREE, INK, PAPER, Pen, TEXT_PX, TICK_PX, UNKNOWN, hit_colour, score};
use super::text::wrap;

/// Two hit-type arrays in the same frame, and their similarity.
#[derive(Debug, Clone, Copy)]
pub struct HitComparison<'a> {
    /// Name of the first array, such as "query".
    pub first_label: &'a str,
    /// The first array.
    pub first: &'a [Hit; 360],
    /// Name of the second array, such as "map".
    pub second_label: &'a str,
    /// The second array.
    pub second: &'a [Hit; 360],
    /// Which bins of the first array are known; all if absent.
    pub known: Option<&'a [bool; 360]>,
    /// Cosine similarity of the two hit-type channels.
    pub cosine: f64,
    /// Cosine similarity of the centred channels.
    pub centred: f64,
}

impl HitComparison<'_> {
    /// The number of known bins with the same hit type in both.
    #[must_use]
    pub fn agreeing_bins(&self) -> usize {
        (0..360).filter(|&bin| self.is_known(bin) && self.first[bin] == self.second[bin]).count()
    }

    /// The number of known bins.
    #[must_use]
    pub fn known_bins(&self) -> usize {
        self.known.map_or(360, |known| known.iter().filter(|&&known| known).count())
    }

    fn is_known(&self, bin: usize) -> bool {
        self.known.is_none_or(|known| known[bin])
    }

    fn caption(&self) -> String {
        format!(
            "Hit type, {} against {}: {} of {} bins agree, cosine {}, centred {}",
            self.first_label,
            self.second_label,
            self.agreeing_bins(),
            self.known_bins(),
            score(self.cosine),
            score(self.centred)
        )
    }

    /// The three bands from the outside in (or top to bottom): name, and the colour of each bin.
    fn bands(&self) -> [(&str, [RGBColor; 360]); 3] {
        let of_known = |bin: usize, colour: RGBColor| if self.is_known(bin) { colour } else { UNKNOWN };
        let agreement = std::array::from_fn(|bin| {
            of_known(bin, if self.first[bin] == self.second[bin] { AGREE } else { DISAGREE })
        });
        let first = std::array::from_fn(|bin| of_known(bin, hit_colour(self.first[bin])));
        [
            (self.first_label, first),
            (self.second_label, self.second.map(hit_colour)),
            ("agreement", agreement),
        ]
    }

    fn legend(&self) -> Vec<Entry> {
        let (agreeing, known) = (self.agreeing_bins(), self.known_bins());
        let mut entries = hit_entries(None);
        let mut add = |colour, label| entries.push(Entry::new(Symbol::Patch(colour), label));
        if known < 360 {
            add(UNKNOWN, format!("not seen ({})", 360 - known));
        }
        add(AGREE, format!("agree ({agreeing})"));
        add(DISAGREE, format!("differ ({})", known - agreeing));
        entries
    }
}

/// Outer radius of the outermost ring, width of a ring, and space between two, in pixels.
const RADIUS: f64 = 470.0;
const RING: f64 = 92.0;
const GAP: f64 = 14.0;
/// Space around the rings for the bearings.
const AROUND: f64 = 66.0;
/// Offset of each ring's name below the centre, clear of the bearings.
const LEVELS: [f64; 3] = [-200.0, -90.0, 90.0];

/// Draws both arrays as rings around the robot (forward is up) with a ring of their agreement inside.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_hits_polar(path: &Path, data: &HitComparison<'_>) -> Result<(), FigureError> {
    let body = 2.0 * (RADIUS + AROUND);
    Page { path, caption: &data.caption(), legend: data.legend(), body }.draw(|canvas, body| {
        let centre = [body.left + RADIUS + AROUND + 70.0, body.centre()[1]];
        let dial = Dial { centre, radius: RADIUS };
        for (n, (name, colours)) in data.bands().iter().enumerate() {
            let outer = RADIUS - n as f64 * (RING + GAP);
            for (bin, &colour) in colours.iter().enumerate() {
                dial.sector(canvas, bin, [outer - RING, outer], colour)?;
            }
            let label = [RADIUS + AROUND + 90.0, LEVELS[n]];
            draw_leader(canvas, &dial, outer - RING / 2.0, label, body.right, name)?;
        }
        dial.draw_bearings(canvas)?;
        let [x, y] = centre;
        let count = format!("{} of {}", data.agreeing_bins(), data.known_bins());
        canvas.text([x, y - 20.0], TEXT_PX, CENTRE, &count)?;
        canvas.text([x, y + 20.0], TEXT_PX, CENTRE, "bins agree")
    })
}

/// A name beside the dial and a line from it to its ring, level with it.
fn draw_leader(
    canvas: &Canvas<'_>,
    dial: &Dial,
    radius: f64,
    [right, down]: [f64; 2],
    limit: f64,
    name: &str,
) -> Drawn {
    let [x, y] = [dial.centre[0], dial.centre[1] + down];
    let on_ring = [x + (radius * radius - down * down).max(0.0).sqrt(), y];
    let start = [x + right, y];
    canvas.line(&[start, on_ring], Pen::solid(PAPER, 8.0))?;
    canvas.disc(on_ring, 13.0, PAPER)?;
    canvas.line(&[start, on_ring], Pen::solid(INK, 2.5))?;
    canvas.disc(on_ring, 9.0, INK)?;
    let lines = wrap(name, TEXT_PX, limit - start[0] - 12.0)?;
    let first = y - 20.0 * (lines.len() as f64 - 1.0);
    for (n, line) in lines.iter().enumerate() {
        canvas.text([start[0] + 12.0, first + 40.0 * n as f64], TEXT_PX, LEFT, line)?;
    }
    Ok(())
}

const STRIP: f64 = 110.0;
const STRIP_PITCH: f64 = 130.0;
/// Space to the left of the strips for their names.
const NAMES: f64 = 270.0;

/// Draws both arrays as strips over the bearing, with a strip of their agreement below.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_hits_linear(path: &Path, data: &HitComparison<'_>) -> Result<(), FigureError> {
    let body = 20.0 + 3.0 * STRIP_PITCH + BELOW;
    Page { path, caption: &data.caption(), legend: data.legend(), body }.draw(|canvas, body| {
        for (n, (name, colours)) in data.bands().iter().enumerate() {
            let top = body.top + 20.0 + n as f64 * STRIP_PITCH;
            let frame =
                Rect { left: body.left + NAMES, top, right: body.right - BESIDE, bottom: top + STRIP };
            let x = Axis::degrees("bearing relative to the heading (degrees)");
            let x = if n == 2 { x } else { x.bare() };
            let y = Axis { label: String::new(), from: 0.0, to: 1.0, ticks: Vec::new() };
            draw_strip(canvas, &Axes { frame, x, y }, colours)?;
            draw_name(canvas, frame, name)?;
        }
        Ok(())
    })
}

fn draw_strip(canvas: &Canvas<'_>, axes: &Axes, colours: &[RGBColor; 360]) -> Drawn {
    for (bin, &colour) in colours.iter().chain(colours.first()).enumerate() {
        let left = axes.x_px(bin as f64 - 0.5);
        let right = axes.x_px(bin as f64 + 0.5).min(axes.frame.right);
        canvas.fill(Rect { left, right, ..axes.frame }, colour)?;
    }
    axes.draw_frame(canvas)
}

fn draw_name(canvas: &Canvas<'_>, strip: Rect, name: &str) -> Drawn {
    let lines = wrap(name, TICK_PX, NAMES - 24.0)?;
    let first = strip.centre()[1] - 18.0 * (lines.len() as f64 - 1.0);
    for (n, line) in lines.iter().enumerate() {
        canvas.text([strip.left - 16.0, first + 36.0 * n as f64], TICK_PX, RIGHT, line)?;
    }
    Ok(())
}
