//! Range by bearing in the robot's frame: forward is up, left is left.

use std::path::Path;

use compass_core::base::scan::Hit;
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Anchor, CENTRE, Canvas, Px, Rect};
use super::error::{Drawn, FigureError};
use super::page::{Page, hit_entries};
use super::style::{INK, PAPER, Pen, TICK_PX, hit_colour, nice_ticks, number, tint};
use super::text::text_width;

/// Radius of the outermost ring in pixels.
const RADIUS: f64 = 620.0;
/// Space around it for the bearings.
const AROUND: f64 = 60.0;
/// The range of a ray without a hit, in metres.
const OPEN_RANGE_M: f64 = 30.0;

/// Draws range by bearing relative to the heading, coloured by hit type.
///
/// Bin 0 points up, bearings grow counter-clockwise. Open bins are filled to the rim.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_polar(path: &Path, range_m: &[f64; 360], hit: &[Hit; 360]) -> Result<(), FigureError> {
    let met = || range_m.iter().zip(hit).filter(|&(r, &h)| h != Hit::Open && r.is_finite());
    let farthest = met().map(|(&r, _)| r).fold(0.0, f64::max);
    let nearest = met().map(|(&r, _)| r).fold(f64::INFINITY, f64::min);
    let caption = if farthest > 0.0 {
        format!("Range by bearing relative to the heading: {nearest:.2} m to {farthest:.2} m, where not open")
    } else {
        "Range by bearing relative to the heading: nothing is met within reach".to_owned()
    };
    let farthest = if farthest > 0.0 { farthest } else { OPEN_RANGE_M };
    let legend = hit_entries(Some(hit));
    let body = 2.0 * (RADIUS + AROUND);
    Page { path, caption: &caption, legend, body }.draw(|canvas, body| {
        let dial = Dial { centre: body.centre(), radius: RADIUS };
        let metre = RADIUS / (farthest * 1.04);
        let reach: [f64; 360] = std::array::from_fn(|bin| match hit[bin] {
            Hit::Open => RADIUS,
            _ => (range_m[bin] * metre).clamp(0.0, RADIUS),
        });
        let rings = nice_ticks(0.0, farthest, 5).into_iter().filter(|&ring| ring > 0.0);
        let rings: Vec<_> = rings.map(|ring| (ring * metre, format!("{} m", number(ring)))).collect();
        for bin in 0..360 {
            dial.sector(canvas, bin, [0.0, reach[bin]], tint(hit_colour(hit[bin]), 0.25))?;
        }
        draw_rings(canvas, &dial, &rings)?;
        draw_marks(canvas, &dial, &reach, hit)?;
        draw_ring_labels(canvas, &dial, &rings, free_bearing(&reach, &rings))?;
        dial.draw_bearings(canvas)
    })
}

/// Marks the range of each bin that has a hit, in pixels.
fn draw_marks(canvas: &Canvas<'_>, dial: &Dial, reach: &[f64; 360], hit: &[Hit; 360]) -> Drawn {
    for bin in (0..360).filter(|&bin| hit[bin] != Hit::Open) {
        dial.sector(canvas, bin, [(reach[bin] - 8.0).max(0.0), reach[bin]], hit_colour(hit[bin]))?;
    }
    Ok(())
}

/// Draws rings of the given radii (pixels), and spokes.
fn draw_rings(canvas: &Canvas<'_>, dial: &Dial, rings: &[(f64, String)]) -> Drawn {
    let pen = Pen::solid(tint(INK, 0.35), 1.5);
    for bearing in (0..360).step_by(45).map(f64::from) {
        canvas.line(&[dial.at(bearing, 0.0), dial.at(bearing, RADIUS)], pen)?;
    }
    for (ring, _) in rings {
        dial.circle(canvas, *ring, pen)?;
    }
    Ok(())
}

/// Labels the rings along a bearing.
fn draw_ring_labels(canvas: &Canvas<'_>, dial: &Dial, rings: &[(f64, String)], bearing_deg: f64) -> Drawn {
    for (ring, text) in rings {
        let [x, y] = dial.at(bearing_deg, *ring);
        let half = text_width(text, TICK_PX)? / 2.0 + 4.0;
        let plate = Rect { left: x - half, top: y - 15.0, right: x + half, bottom: y + 15.0 };
        canvas.fill(plate, PAPER)?;
        canvas.text([x, y], TICK_PX, CENTRE, text)?;
    }
    Ok(())
}

/// The bearing between two spokes at which the labels of the rings stay farthest from the range marks.
fn free_bearing(reach: &[f64; 360], rings: &[(f64, String)]) -> f64 {
    let clearance = |bearing: usize| {
        let nearby = (bearing + 345..=bearing + 375).map(|bin| reach[bin % 360]);
        let gaps = nearby.flat_map(|reach| rings.iter().map(move |(ring, _)| (reach - ring).abs()));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let bearings = (0..8).map(|n| 22 + 45 * n);
    bearings.max_by(|&a, &b| clearance(a).total_cmp(&clearance(b))).map_or(0.0, |b| b as f64 + 0.5)
}

/// A circle of bearings: 0 is up, counter-clockwise positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dial {
    pub(super) centre: Px,
    pub(super) radius: f64,
}

impl Dial {
    /// The pixel at this bearing in degrees and distance in pixels.
    pub(super) fn at(&self, bearing_deg: f64, distance: f64) -> Px {
        let (sin, cos) = bearing_deg.to_radians().sin_cos();
        [self.centre[0] - distance * sin, self.centre[1] - distance * cos]
    }

    /// Fills one bin between two distances.
    pub(super) fn sector(
        &self,
        canvas: &Canvas<'_>,
        bin: usize,
        [inner, outer]: [f64; 2],
        colour: RGBColor,
    ) -> Drawn {
        let bearing = bin as f64;
        // Slightly wider than the bin, so that no seam shows between neighbours.
        let (from, to) = (bearing - 0.55, bearing + 0.55);
        let corners = [
            self.at(from, inner),
            self.at(from, outer),
            self.at(bearing, outer),
            self.at(to, outer),
            self.at(to, inner),
        ];
        canvas.polygon(&corners, colour)
    }

    /// A circle around the centre.
    pub(super) fn circle(&self, canvas: &Canvas<'_>, distance: f64, pen: Pen) -> Drawn {
        let points: Vec<Px> = (0..=360).map(|b| self.at(f64::from(b), distance)).collect();
        canvas.line(&points, pen)
    }

    /// Rim and bearings every 45 degrees.
    pub(super) fn draw_bearings(&self, canvas: &Canvas<'_>) -> Drawn {
        self.circle(canvas, self.radius, Pen::solid(INK, 2.0))?;
        for bearing in (0..360).step_by(45).map(f64::from) {
            let side = match bearing {
                90.0 => " left",
                270.0 => " right",
                _ => "",
            };
            let text = format!("{bearing}°{side}");
            let tick = [self.at(bearing, self.radius), self.at(bearing, self.radius + 10.0)];
            canvas.line(&tick, Pen::solid(INK, 2.0))?;
            canvas.text(self.at(bearing, self.radius + 16.0), TICK_PX, outward(bearing), &text)?;
        }
        Ok(())
    }
}

/// The anchor of a text outside the rim: it grows away from the centre.
fn outward(bearing_deg: f64) -> Anchor {
    let (sin, cos) = bearing_deg.to_radians().sin_cos();
    let horizontal = match sin {
        s if s > 0.1 => HPos::Right,
        s if s < -0.1 => HPos::Left,
        _ => HPos::Center,
    };
    let vertical = match cos {
        c if c > 0.1 => VPos::Bottom,
        c if c < -0.1 => VPos::Top,
        _ => VPos::Center,
    };
    (horizontal, vertical)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_grow_to_the_left_from_up() {
        let dial = Dial { centre: [100.0, 100.0], radius: 50.0 };
        let close = |a: Px, b: Px| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9;
        assert!(close(dial.at(0.0, 10.0), [100.0, 90.0]));
        assert!(close(dial.at(90.0, 10.0), [90.0, 100.0]));
        assert!(close(dial.at(180.0, 10.0), [100.0, 110.0]));
    }
}
