//! Window or wall in every direction, seen from above.

use std::path::Path;

use compass_core::base::scan::Hit;
use plotters::style::RGBColor;

use super::canvas::{CENTRE, Canvas};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol, hit_entries};
use super::polar::Dial;
use super::style::{INK, Pen, TEXT_PX, UNKNOWN, hit_colour};

/// Outer radius and width of the band of observed hits, and width of the plan's around it, in pixels.
const RADIUS: f64 = 420.0;
const RING: f64 = 130.0;
const GAP: f64 = 16.0;
const PLAN: f64 = 80.0;
/// Space around the outer band for the bearings.
const AROUND: f64 = 66.0;

/// Draws the observed hits as a band around the robot (forward is up), and those of the plan around it if given.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_seen(
    path: &Path,
    hit: &[Hit; 360],
    known: &[bool; 360],
    plan: Option<&[Hit; 360]>,
) -> Result<(), FigureError> {
    let outer = RADIUS + plan.map_or(0.0, |_| GAP + PLAN);
    let seen = known.iter().filter(|known| **known).count();
    let mut legend = hit_entries(None);
    legend.push(Entry::new(Symbol::Patch(UNKNOWN), format!("not seen ({})", 360 - seen)));
    let caption = match plan {
        Some(_) => "Hit type by bearing relative to the heading: seen (inner ring), plan (outer ring)",
        None => "Hit type by bearing relative to the heading, as seen",
    };
    Page { path, caption, legend, body: 2.0 * (outer + AROUND) }.draw(|canvas, body| {
        let dial = Dial { centre: body.centre(), radius: outer };
        let colour = |bin: usize| if known[bin] { hit_colour(hit[bin]) } else { UNKNOWN };
        draw_band(canvas, &dial, [RADIUS - RING, RADIUS], colour)?;
        if let Some(plan) = plan {
            draw_band(canvas, &dial, [RADIUS + GAP, outer], |bin| hit_colour(plan[bin]))?;
        }
        let bins = (0..360).filter(|&bin| known[bin] && hit[bin] == Hit::Window).count();
        let [x, y] = dial.centre;
        canvas.text([x, y - 20.0], TEXT_PX, CENTRE, &format!("{bins} of {seen} bins"))?;
        canvas.text([x, y + 20.0], TEXT_PX, CENTRE, "see a window")?;
        dial.draw_bearings(canvas)
    })
}

fn draw_band(
    canvas: &Canvas<'_>,
    dial: &Dial,
    [inner, outer]: [f64; 2],
    colour: impl Fn(usize) -> RGBColor,
) -> Drawn {
    (0..360).try_for_each(|bin| dial.sector(canvas, bin, [inner, outer], colour(bin)))?;
    dial.circle(canvas, inner, Pen::solid(INK, 1.5))?;
    dial.circle(canvas, outer, Pen::solid(INK, 1.5))
}
