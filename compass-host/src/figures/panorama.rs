//! The cameras' levelled panorama with the boundaries of floor and ceiling found in it.

use std::path::Path;

use compass_core::base::ladder::{NEAREST_M, NOMINAL_HEIGHT_M, RUNG};
use compass_core::vision::boundary::{NOMINAL_RUNG, RUNGS};
use plotters::style::RGBColor;
use rayon::prelude::*;

use super::canvas::{CENTRE, Canvas, LEFT, Px, RIGHT, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::style::{INK, Pen, TICK_PX, UNKNOWN, number};

/// The overlays of the panorama.
#[derive(Debug, Clone, Copy)]
pub struct PanoramaPicture<'a> {
    /// Range in metres and its confidence, by bin.
    pub ranges: &'a [Option<[f64; 2]>; 360],
    /// The plan's ranges, if there is one, metres.
    pub plan: Option<&'a [f64; 360]>,
    /// Heights of the camera above the floor and of the ceiling above the camera, metres.
    pub heights_m: [f64; 2],
    /// Azimuths and elevations of the windows, degrees: right and left, sill and lintel.
    pub windows: &'a [[[f64; 2]; 2]],
    /// Probability of the boundary by surface (floor, ceiling), rung and bin, [`CELLS`](compass_core::vision::boundary::CELLS) values: drawn over the image.
    pub probability: Option<&'a [f32]>,
}

/// Elevations shown, degrees to either side of the horizon.
const REACH_DEG: f64 = 50.0;
/// Space to the left of the view for the elevations, above it, between its halves, and for the azimuths below each.
const BESIDE: f64 = 76.0;
const ABOVE: f64 = 16.0;
const BETWEEN: f64 = 24.0;
const AZIMUTHS: f64 = 44.0;
/// The plan's boundary line breaks where the range changes by more than this ratio.
const JUMP: f64 = 1.25;

/// Colours of the boundaries found, and the confidence below which each is used.
const FOUND: [(f64, RGBColor, &str); 3] = [
    (1.0 / 3.0, RGBColor(0xd8, 0x20, 0x10), "below 1/3"),
    (2.0 / 3.0, RGBColor(0xff, 0x9a, 0x00), "to 2/3"),
    (f64::INFINITY, RGBColor(0xff, 0xf0, 0x30), "above 2/3"),
];
const PLAN: RGBColor = RGBColor(0xff, 0x40, 0xc8);
const WINDOWS: RGBColor = RGBColor(0x30, 0xb0, 0xff);
/// Colours of a probable boundary of floor and ceiling.
const PROBABLE: [RGBColor; 2] = [RGBColor(0xff, 0x9a, 0x00), RGBColor(0x30, 0xe0, 0xff)];
/// Probability of a rung that is drawn in the full colour.
const FULL: f32 = 0.25;
const HORIZON: RGBColor = RGBColor(0xf0, 0xf0, 0xf0);

/// Draws the half of the view ahead, and below it the half behind; `colour` gives the image colour at an azimuth
/// (counter-clockwise) and elevation in radians.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_panorama(
    path: &Path,
    data: &PanoramaPicture<'_>,
    colour: impl Fn(f32, f32) -> Option<[u8; 3]> + Sync,
) -> Result<(), FigureError> {
    let height = half_height() + AZIMUTHS;
    let page = Page {
        path,
        caption: "Where walls meet floor and ceiling, ahead (above) and behind (below), by azimuth and elevation",
        legend: data.legend(),
        body: ABOVE + 2.0 * (height + BETWEEN),
    };
    page.draw(|canvas, body| {
        for (n, from_deg) in [90.0, -90.0].into_iter().enumerate() {
            let top = body.top + ABOVE + n as f64 * (height + BETWEEN);
            let frame =
                Rect { left: body.left + BESIDE, top, right: body.right - 4.0, bottom: top + half_height() };
            let half = Half { data, frame, from_deg };
            half.draw_view(canvas, &colour)?;
            half.draw_found(canvas)?;
        }
        Ok(())
    })
}

/// Pixels per degree.
fn scale() -> f64 {
    (Page::INNER_WIDTH - BESIDE - 4.0) / 180.0
}

fn half_height() -> f64 {
    2.0 * REACH_DEG * scale()
}

/// The class of a confidence in [`FOUND`].
fn class(confidence: f64) -> usize {
    FOUND.iter().position(|(below, ..)| confidence < *below).unwrap_or(0)
}

impl PanoramaPicture<'_> {
    fn legend(&self) -> Vec<Entry> {
        let line = |colour| Symbol::Line(Pen::solid(colour, 6.0));
        let found = FOUND.iter().enumerate().map(|(n, (_, colour, name))| {
            let bins = self.ranges.iter().flatten().filter(|[_, sure]| class(*sure) == n).count();
            Entry::new(line(*colour), format!("found, confidence {name} ({bins})"))
        });
        let mut entries: Vec<_> = found.collect();
        if self.probability.is_some() {
            let names = ["probable boundary of the floor", "of the ceiling"];
            entries = PROBABLE.into_iter().zip(names).map(|(c, name)| Entry::new(line(c), name)).collect();
        }
        if self.plan.is_some() {
            entries.push(Entry::new(line(PLAN), "plan"));
        }
        entries.push(Entry::new(line(WINDOWS), format!("windows ({})", self.windows.len())));
        entries
    }

    /// The image's colour in a direction in gray, with the probability of a boundary over it; azimuth and elevation in
    /// degrees.
    fn with_probability(&self, [r, g, b]: [u8; 3], azimuth: f64, elevation: f64) -> [u8; 3] {
        let Some(cells) = self.probability else { return [r, g, b] };
        let surface = usize::from(elevation > 0.0);
        let log_range = -elevation.to_radians().tan().abs().ln();
        let rung = (log_range - f64::from(NEAREST_M / NOMINAL_HEIGHT_M).ln()) / f64::from(RUNG)
            + NOMINAL_RUNG as f64;
        let bin = azimuth.rem_euclid(360.0).round() as usize % 360;
        let cell = (0.0..RUNGS as f64).contains(&rung.round()).then(|| rung.round() as usize * 360 + bin);
        let chance = cell.and_then(|cell| cells.get(surface * RUNGS * 360 + cell)).copied().unwrap_or(0.0);
        let (share, gray) = ((chance / FULL).min(1.0), (f32::from(r) + f32::from(g) + f32::from(b)) / 4.5);
        let RGBColor(r, g, b) = PROBABLE[surface];
        [r, g, b].map(|full| (gray + (f32::from(full) - gray) * share) as u8)
    }

    /// Elevations in degrees at which a wall at this range meets the floor and the ceiling.
    fn boundaries(&self, range_m: f64) -> [f64; 2] {
        let [below, above] = self.heights_m;
        [-below, above].map(|height| height.atan2(range_m).to_degrees())
    }
}

/// 180 degrees of the view, clockwise from an azimuth.
struct Half<'a> {
    data: &'a PanoramaPicture<'a>,
    frame: Rect,
    from_deg: f64,
}

impl Half<'_> {
    fn y_px(&self, elevation_deg: f64) -> f64 {
        self.frame.top + (REACH_DEG - elevation_deg) * scale()
    }

    /// Pixel columns between two azimuths, the right one first, clipped to this half.
    fn span(&self, [right, left]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        let (frame, from) = (self.frame, self.from_deg);
        [-360.0, 0.0, 360.0].into_iter().filter_map(move |turn| {
            let [a, b] = [left, right].map(|azimuth| frame.left + (from - azimuth - turn) * scale());
            let (a, b) = (a.max(frame.left), b.min(frame.right));
            (a < b).then_some([a, b])
        })
    }

    fn draw_view(
        &self,
        canvas: &Canvas<'_>,
        colour: &(impl Fn(f32, f32) -> Option<[u8; 3]> + Sync),
    ) -> Drawn {
        let frame = self.frame;
        let (columns, rows) = (frame.width().ceil() as usize, frame.height().ceil() as usize);
        let place = |at: usize| (at as f64 + 0.5) / scale();
        let look = |index: usize| {
            let azimuth = self.from_deg - place(index % columns);
            let elevation = REACH_DEG - place(index / columns);
            let seen = colour(azimuth.to_radians() as f32, elevation.to_radians() as f32);
            seen.map(|seen| self.data.with_probability(seen, azimuth, elevation))
        };
        let view: Vec<_> = (0..columns * rows).into_par_iter().map(look).collect();
        canvas.paint(frame, |square| {
            let [x, y] = square.centre();
            let at = (y - frame.top) as usize * columns + (x - frame.left) as usize;
            Some(view.get(at).copied().flatten().map_or(UNKNOWN, |[r, g, b]| RGBColor(r, g, b)))
        })?;
        let horizon = self.y_px(0.0);
        canvas.line(&[[frame.left, horizon], [frame.right, horizon]], Pen::solid(HORIZON, 1.0))
    }

    fn draw_found(&self, canvas: &Canvas<'_>) -> Drawn {
        for [azimuths, [sill, lintel]] in self.data.windows {
            for [left, right] in self.span(*azimuths) {
                let [top, bottom] = [*lintel, *sill].map(|e| self.y_px(e.clamp(-REACH_DEG, REACH_DEG)));
                canvas.outline(Rect { left, top, right, bottom }, Pen::solid(INK, 6.0))?;
                canvas.outline(Rect { left, top, right, bottom }, Pen::solid(WINDOWS, 3.0))?;
            }
        }
        for pen in [Pen::solid(INK, 8.0), Pen::solid(PLAN, 4.0)] {
            self.draw_plan(canvas, pen)?;
        }
        for (halo, surface) in [(true, 0), (true, 1), (false, 0), (false, 1)] {
            for (bin, [range_m, sure]) in
                self.data.ranges.iter().enumerate().filter_map(|(b, r)| Some((b, (*r)?)))
            {
                let pen = if halo { Pen::solid(INK, 9.0) } else { Pen::solid(FOUND[class(sure)].1, 5.0) };
                let elevation = self.data.boundaries(range_m)[surface];
                if elevation.abs() > REACH_DEG {
                    continue;
                }
                let y = self.y_px(elevation);
                let azimuth = bin as f64;
                for [left, right] in self.span([azimuth - 0.5, azimuth + 0.5]) {
                    canvas.line(&[[left, y], [right, y]], pen)?;
                }
            }
        }
        self.draw_scale(canvas)
    }

    /// The plan's boundaries, in pieces between range discontinuities.
    fn draw_plan(&self, canvas: &Canvas<'_>, pen: Pen) -> Drawn {
        let Some(plan) = self.data.plan else { return Ok(()) };
        for surface in 0..2 {
            let mut piece: Vec<Px> = Vec::new();
            let mut before = f64::NAN;
            for turn in 0..=180 {
                let azimuth = self.from_deg - f64::from(turn);
                let range = plan[(azimuth.rem_euclid(360.0)) as usize];
                let elevation = self.data.boundaries(range)[surface];
                let shown = elevation.abs() <= REACH_DEG;
                if range / before > JUMP || before / range > JUMP || !shown {
                    canvas.line(&piece, pen)?;
                    piece.clear();
                }
                before = range;
                if shown {
                    let x = self.frame.left + f64::from(turn) * scale();
                    piece.push([x, self.y_px(elevation)]);
                }
            }
            canvas.line(&piece, pen)?;
        }
        Ok(())
    }

    fn draw_scale(&self, canvas: &Canvas<'_>) -> Drawn {
        let frame = self.frame;
        for elevation in (-50..=50).step_by(10) {
            let y = self.y_px(f64::from(elevation));
            canvas.line(&[[frame.left - 8.0, y], [frame.left, y]], Pen::solid(INK, 2.0))?;
            let text = format!("{}°", number(f64::from(elevation)));
            canvas.text([frame.left - 12.0, y], TICK_PX, RIGHT, &text)?;
        }
        for turn in (0..=180).step_by(10) {
            let azimuth = (self.from_deg - f64::from(turn) + 540.0).rem_euclid(360.0) - 180.0;
            let x = frame.left + f64::from(turn) * scale();
            canvas.line(&[[x, frame.bottom], [x, frame.bottom + 8.0]], Pen::solid(INK, 2.0))?;
            let x = x.min(frame.right - 22.0);
            canvas.text([x, frame.bottom + 8.0 + 18.0], TICK_PX, CENTRE, &number(azimuth))?;
        }
        canvas.text([frame.left - BESIDE, frame.bottom + 26.0], TICK_PX, LEFT, "az.")?;
        canvas.outline(frame, Pen::solid(INK, 2.0))
    }
}
