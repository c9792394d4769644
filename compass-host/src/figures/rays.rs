//! The rays of a scan over the plan, coloured by hit type.

use std::path::Path;

use compass_core::base::scan::Hit;

use super::axes::Axes;
use super::canvas::Canvas;
use super::error::{DrawError, Drawn, FigureError};
use super::page::{Entry, Page, Symbol, draw_pose, hit_entries};
use super::plan::{Extent, MapLayout, PlanPicture};
use super::style::{FOUND, Pen, hit_colour, number, tint};

/// Every second ray is drawn, so that rays stay distinguishable near the robot.
const RAY_STRIDE: usize = 2;

/// Draws the rays of a scan over the plan's walls and windows.
///
/// `position` is in metres of the map, `heading_deg` counter-clockwise from +x; bin j of `range_m` and
/// `hit` looks along heading + j degrees. The picture shows the bounding box of the plan's ink; rays
/// that leave it end at its border.
///
/// # Errors
/// [`FigureError`] when the file cannot be written, or the plan is empty or a value not finite.
pub fn draw_rays(
    path: &Path,
    plan: &PlanPicture<'_>,
    position: [f64; 2],
    heading_deg: f64,
    range_m: &[f64; 360],
    hit: &[Hit; 360],
) -> Result<(), FigureError> {
    let prepare = || -> Result<_, DrawError> {
        let extent = plan.extent(&[position])?;
        Ok((extent, MapLayout::new(extent, Page::INNER_WIDTH, 0.0)?))
    };
    let (extent, layout) = prepare().map_err(|e| FigureError::draw(path, &*e))?;
    let mut legend = hit_entries(Some(hit));
    legend.push(Entry::new(Symbol::Pose(FOUND), "robot and heading"));
    let [x, y] = position;
    let caption = format!(
        "Rays by hit type at ({} m, {} m), heading {}° (bins per type in the legend)",
        number(x),
        number(y),
        number(heading_deg)
    );
    Page { path, caption: &caption, legend, body: layout.body() }.draw(|canvas, body| {
        let axes = layout.axes(body);
        axes.draw_grid(canvas)?;
        let rays = Rays { extent, position, heading_deg, range_m, hit };
        rays.draw_lines(canvas, &axes)?;
        plan.draw(canvas, &axes)?;
        rays.draw_ends(canvas, &axes)?;
        draw_pose(canvas, axes.at(x, y), heading_deg, 13.0, FOUND)?;
        axes.draw_frame(canvas)
    })
}

struct Rays<'a> {
    extent: Extent,
    position: [f64; 2],
    heading_deg: f64,
    range_m: &'a [f64; 360],
    hit: &'a [Hit; 360],
}

impl Rays<'_> {
    /// The end point of the ray of a bin.
    fn end(&self, bin: usize) -> [f64; 2] {
        let (sin, cos) = (self.heading_deg + bin as f64).to_radians().sin_cos();
        let range = self.range_m[bin];
        [self.position[0] + range * cos, self.position[1] + range * sin]
    }

    fn bins(&self) -> impl Iterator<Item = usize> {
        (0..360).step_by(RAY_STRIDE).filter(|&bin| self.range_m[bin].is_finite())
    }

    fn draw_lines(&self, canvas: &Canvas<'_>, axes: &Axes) -> Drawn {
        let [x, y] = self.position;
        for bin in self.bins() {
            let end = self.end(bin);
            let share = self.extent.inside_share(self.position, end);
            let end = axes.at(x + share * (end[0] - x), y + share * (end[1] - y));
            let colour = tint(hit_colour(self.hit[bin]), 0.75);
            canvas.line(&[axes.at(x, y), end], Pen::solid(colour, 1.5))?;
        }
        Ok(())
    }

    fn draw_ends(&self, canvas: &Canvas<'_>, axes: &Axes) -> Drawn {
        for bin in self.bins() {
            let [x, y] = self.end(bin);
            if self.hit[bin] != Hit::Open && self.extent.contains([x, y]) {
                canvas.disc(axes.at(x, y), 4.5, hit_colour(self.hit[bin]))?;
            }
        }
        Ok(())
    }
}
