//! The floor plan as a backdrop with metric axes.

use std::fmt;

use super::axes::{ABOVE, Axes, Axis, BELOW, BESIDE};
use super::canvas::{Canvas, Rect};
use super::error::{DrawError, Drawn};
use super::style::{PLAN_WALL, WINDOW};
use compass_core::base::scan::Hit;
use compass_core::map::plan::Plan;
use plotters::style::RGBColor;

/// Tallest plot of a plan in pixels.
const TALLEST: f64 = 1500.0;

/// A floor plan to draw: a raster whose row 0 is the southernmost.
pub struct PlanPicture<'a> {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Metres per pixel.
    pub resolution_m: f64,
    /// Map coordinates of the outer corner of the pixel (0, 0), in metres.
    pub origin: [f64; 2],
    /// Whether the pixel in this column and row is wall.
    pub is_wall: &'a dyn Fn(u32, u32) -> bool,
    /// Whether the pixel in this column and row is glazing.
    pub is_window: &'a dyn Fn(u32, u32) -> bool,
}

impl fmt::Debug for PlanPicture<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PlanPicture")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("resolution_m", &self.resolution_m)
            .field("origin", &self.origin)
            .finish_non_exhaustive()
    }
}

/// Calls `draw` with a packed plan in the form that the figures take.
pub fn with_packed_plan<T>(plan: &Plan<'_>, draw: impl FnOnce(&PlanPicture<'_>) -> T) -> T {
    let is = |x: u32, y: u32, hit: Hit| plan.hit_at(plan.cell_centre(x as u16, y as u16)) == Some(hit);
    let grid = plan.grid();
    draw(&PlanPicture {
        width: plan.width(),
        height: plan.height(),
        resolution_m: f64::from(grid.resolution_nm) / 1e9,
        origin: [grid.origin.x.to_num(), grid.origin.y.to_num()],
        is_wall: &|x, y| is(x, y, Hit::Wall),
        is_window: &|x, y| is(x, y, Hit::Window),
    })
}

/// A rectangle of the map in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
}

impl Extent {
    fn cover(&mut self, [x, y]: [f64; 2]) {
        self.x = [self.x[0].min(x), self.x[1].max(x)];
        self.y = [self.y[0].min(y), self.y[1].max(y)];
    }

    fn grow(&mut self, margin: f64) {
        self.x = [self.x[0] - margin, self.x[1] + margin];
        self.y = [self.y[0] - margin, self.y[1] + margin];
    }

    fn sides(&self) -> [f64; 2] {
        [self.x[1] - self.x[0], self.y[1] - self.y[0]]
    }

    pub(super) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.x[0]..=self.x[1]).contains(&x) && (self.y[0]..=self.y[1]).contains(&y)
    }

    /// The share, 0..=1, of the way from a point inside to `to` that lies inside.
    pub(super) fn inside_share(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let along = |[low, high]: [f64; 2], from: f64, to: f64| {
            let bound = if to > from { high } else { low };
            if to == from { 1.0 } else { (bound - from) / (to - from) }
        };
        along(self.x, from[0], to[0]).min(along(self.y, from[1], to[1])).clamp(0.0, 1.0)
    }
}

impl PlanPicture<'_> {
    /// The part of the map to show: the bounding box of all ink and of `points`, with a margin.
    ///
    /// # Errors
    /// When the plan has no pixels, no positive resolution, or a point is not finite.
    pub(super) fn extent(&self, points: &[[f64; 2]]) -> Result<Extent, DrawError> {
        if self.width == 0 || self.height == 0 {
            return Err("the plan has no pixels".into());
        }
        if !(self.resolution_m.is_finite() && self.resolution_m > 0.0) {
            return Err("the plan's resolution is not positive".into());
        }
        if points.iter().chain([&self.origin]).flatten().any(|v| !v.is_finite()) {
            return Err("a position is not finite".into());
        }
        let mut extent = self.ink_box();
        for &point in points {
            extent.cover(point);
        }
        let [width, height] = extent.sides();
        extent.grow((0.03 * width.max(height)).max(0.3));
        Ok(extent)
    }

    /// The bounding box of all walls and windows; of the whole raster when there are none.
    fn ink_box(&self) -> Extent {
        let inked = |x: u32, y: u32| (self.is_wall)(x, y) || (self.is_window)(x, y);
        let corner = |x: u32, y: u32| {
            [
                self.origin[0] + f64::from(x) * self.resolution_m,
                self.origin[1] + f64::from(y) * self.resolution_m,
            ]
        };
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let mut ink = Extent { x: nothing, y: nothing };
        for y in 0..self.height {
            let Some(first) = (0..self.width).find(|&x| inked(x, y)) else { continue };
            let last = (first..self.width).rev().find(|&x| inked(x, y)).unwrap_or(first);
            ink.cover(corner(first, y));
            ink.cover(corner(last + 1, y + 1));
        }
        if ink.x[0] > ink.x[1] {
            ink.cover(corner(0, 0));
            ink.cover(corner(self.width, self.height));
        }
        ink
    }

    /// Draws walls and windows; ink narrower than a pixel stays visible, glazing takes precedence.
    pub(super) fn draw(&self, canvas: &Canvas<'_>, axes: &Axes) -> Drawn {
        self.paint(canvas, axes, |x, y| {
            let window = (self.is_window)(x, y).then_some((1, WINDOW));
            window.or_else(|| (self.is_wall)(x, y).then_some((0, PLAN_WALL)))
        })
    }

    /// Paints each square of the picture in the colour of its pixels; where they differ, that of the highest rank.
    pub(super) fn paint(
        &self,
        canvas: &Canvas<'_>,
        axes: &Axes,
        colour: impl Fn(u32, u32) -> Option<(u8, RGBColor)>,
    ) -> Drawn {
        let metres = (axes.x.to - axes.x.from) / axes.frame.width();
        let column =
            |px: f64| (axes.x.from + (px - axes.frame.left) * metres - self.origin[0]) / self.resolution_m;
        let row =
            |px: f64| (axes.y.from + (axes.frame.bottom - px) * metres - self.origin[1]) / self.resolution_m;
        canvas.paint(axes.frame, |square| {
            let rows = cells(row(square.bottom), row(square.top), self.height);
            let columns = cells(column(square.left), column(square.right), self.width);
            let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
            pixels.filter_map(|(x, y)| colour(x, y)).max_by_key(|(rank, _)| *rank).map(|(_, colour)| colour)
        })
    }
}

/// The raster cells that the span overlaps, within 0..`count`.
fn cells(from: f64, to: f64, count: u32) -> std::ops::Range<u32> {
    let limit = f64::from(count);
    let first = from.floor().clamp(0.0, limit);
    let last = to.ceil().clamp(0.0, limit);
    first as u32..last as u32
}

/// The size on the page of a plan's plot: equal scale on both axes.
#[derive(Debug)]
pub(super) struct MapLayout {
    x: Axis,
    y: Axis,
    width: f64,
    height: f64,
    room: f64,
    /// Space kept free to the right of the plot.
    beside: f64,
}

impl MapLayout {
    /// Fits `extent` into a page whose body is `available` pixels wide, with `beside` pixels kept free
    /// to the right of the plot for a colour bar.
    pub(super) fn new(extent: Extent, available: f64, beside: f64) -> Result<Self, DrawError> {
        let [metres_x, metres_y] = extent.sides();
        let beside = beside.max(BESIDE);
        let y = Axis::new("y (m)", extent.y[0], extent.y[1], 6);
        let room = y.room()?;
        let scale = ((available - room - beside) / metres_x).min(TALLEST / metres_y);
        let (width, height) = (metres_x * scale, metres_y * scale);
        let ticks = |size: f64| ((size / 150.0) as usize).clamp(2, 10);
        Ok(Self {
            x: Axis::new("x (m)", extent.x[0], extent.x[1], ticks(width)),
            y: Axis::new("y (m)", extent.y[0], extent.y[1], ticks(height)),
            width,
            height,
            room,
            beside,
        })
    }

    /// Height of the body that holds the plot.
    pub(super) fn body(&self) -> f64 {
        ABOVE + self.height + BELOW
    }

    /// The plot within the body.
    pub(super) fn axes(self, body: Rect) -> Axes {
        let spare = (body.width() - self.room - self.width - self.beside).max(0.0);
        let left = body.left + self.room + spare / 2.0;
        let top = body.top + ABOVE;
        let frame = Rect { left, top, right: left + self.width, bottom: top + self.height };
        Axes { frame, x: self.x, y: self.y }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(is_wall: &dyn Fn(u32, u32) -> bool) -> PlanPicture<'_> {
        PlanPicture {
            width: 100,
            height: 50,
            resolution_m: 0.1,
            origin: [-1.0, 2.0],
            is_wall,
            is_window: &|_, _| false,
        }
    }

    #[test]
    fn extent_is_the_ink_with_a_margin() {
        let extent = plan(&|x, y| (20..30).contains(&x) && y == 10).extent(&[]).unwrap();
        let expected = [0.7, 2.3, 2.7, 3.4];
        let got = [extent.x[0], extent.x[1], extent.y[0], extent.y[1]];
        assert!(got.iter().zip(expected).all(|(g, e)| (g - e).abs() < 1e-9), "{got:?}");
    }

    #[test]
    fn extent_of_a_blank_plan_is_all_of_it() {
        let extent = plan(&|_, _| false).extent(&[]).unwrap();
        assert!(extent.contains([-1.0, 2.0]) && extent.contains([9.0, 7.0]));
        assert!(plan(&|_, _| false).extent(&[[f64::NAN, 0.0]]).is_err());
    }

    #[test]
    fn inside_share_stops_at_the_border() {
        let extent = Extent { x: [0.0, 10.0], y: [0.0, 4.0] };
        assert_eq!(extent.inside_share([5.0, 2.0], [25.0, 2.0]), 0.25);
        assert_eq!(extent.inside_share([5.0, 2.0], [5.0, -2.0]), 0.5);
        assert_eq!(extent.inside_share([5.0, 2.0], [6.0, 3.0]), 1.0);
    }

    #[test]
    fn cells_stay_in_the_raster() {
        assert_eq!(cells(-3.0, 2.5, 10), 0..3);
        assert_eq!(cells(9.2, 12.0, 10), 9..10);
        assert!(cells(11.0, 12.0, 10).is_empty());
    }
}
