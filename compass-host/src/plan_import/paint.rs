//! Shapes of a drawing as pixels of a plan.

use super::raster::PlanRaster;
use crate::drawing::{Paint, Shape};
use tiny_skia::{FillRule, LineCap, LineJoin, Mask, Path, PathBuilder, Stroke, Transform};

/// Least width of a line in pixels: rays that march in steps of two must not slip through.
const LEAST_LINE_PX: f64 = 2.0;
/// Most pixels of a band, which takes a byte each.
const BAND_PIXELS: usize = 1 << 24;

/// Where shapes become pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Pixels along x.
    pub(super) width: u32,
    /// Pixels along y.
    pub(super) height: u32,
    /// Metres per pixel.
    pub(super) resolution_m: f64,
    /// Drawing's coordinates of the outer corner of pixel (0, 0), in metres.
    pub(super) corner: [f64; 2],
    /// Map coordinates of the same corner, in metres.
    pub(super) origin: [f64; 2],
}

impl Frame {
    /// A plan of this frame without walls and glazing.
    pub(super) fn empty(&self) -> PlanRaster {
        PlanRaster::empty(self.width, self.height, self.resolution_m, self.origin)
    }
}

/// Draws shapes as walls.
pub(super) fn walls<'a>(
    raster: &mut PlanRaster,
    frame: &Frame,
    shapes: impl Iterator<Item = &'a Shape> + Clone,
) {
    paint(frame, shapes, |x, y| raster.set_wall(x, y));
}

/// Draws shapes as glazing, over walls.
pub(super) fn glazing<'a>(
    raster: &mut PlanRaster,
    frame: &Frame,
    shapes: impl Iterator<Item = &'a Shape> + Clone,
) {
    paint(frame, shapes, |x, y| raster.set_window(x, y));
}

/// Calls `set` with every pixel of the shapes, band by band: a byte per pixel of a whole plan may be too much.
fn paint<'a>(frame: &Frame, shapes: impl Iterator<Item = &'a Shape> + Clone, mut set: impl FnMut(u32, u32)) {
    let rows = (BAND_PIXELS / frame.width.max(1) as usize).clamp(1, frame.height.max(1) as usize) as u32;
    let Some(mut mask) = Mask::new(frame.width, rows) else { return };
    for first in (0..frame.height).step_by(rows as usize) {
        mask.clear();
        let low = frame.corner[1] + f64::from(first) * frame.resolution_m;
        let high = low + f64::from(rows) * frame.resolution_m;
        for shape in shapes.clone() {
            let slack = line_width(frame, shape.paint) * frame.resolution_m;
            let [least, most] = shape.extent();
            if most[1] + slack >= low && least[1] - slack <= high {
                draw(&mut mask, frame, low, shape);
            }
        }
        let bytes = mask.data().chunks_exact(frame.width as usize);
        for (y, row) in (first..frame.height).zip(bytes) {
            for (x, _) in (0..).zip(row).filter(|(_, byte)| **byte != 0) {
                set(x, y);
            }
        }
    }
}

fn draw(mask: &mut Mask, frame: &Frame, low: f64, shape: &Shape) {
    let Some(path) = path(frame, low, shape) else { return };
    let outline = match shape.paint {
        Paint::Fill => Some(path),
        Paint::Stroke(_) => {
            let stroke = Stroke {
                width: line_width(frame, shape.paint) as f32,
                line_cap: LineCap::Square,
                line_join: LineJoin::Miter,
                ..Stroke::default()
            };
            path.stroke(&stroke, 1.0)
        }
    };
    let rule = if shape.paint == Paint::Fill { FillRule::EvenOdd } else { FillRule::Winding };
    if let Some(outline) = outline {
        mask.fill_path(&outline, rule, false, Transform::identity());
    }
}

/// The contours in pixels of a band whose lower edge is at `low` metres.
fn path(frame: &Frame, low: f64, shape: &Shape) -> Option<Path> {
    let pixel = |[x, y]: [f64; 2]| {
        // Differences first: far-off coordinates do not fit into f32.
        [(x - frame.corner[0]) / frame.resolution_m, (y - low) / frame.resolution_m].map(|value| value as f32)
    };
    let mut builder = PathBuilder::new();
    for contour in &shape.contours {
        let Some((first, others)) = contour.split_first() else { continue };
        let [x, y] = pixel(*first);
        builder.move_to(x, y);
        for &point in others {
            let [x, y] = pixel(point);
            builder.line_to(x, y);
        }
        if shape.paint == Paint::Fill || contour.first() == contour.last() {
            builder.close();
        }
    }
    builder.finish()
}

/// The width of a line in pixels.
fn line_width(frame: &Frame, paint: Paint) -> f64 {
    match paint {
        Paint::Fill => 0.0,
        Paint::Stroke(width) => (width / frame.resolution_m).max(LEAST_LINE_PX),
    }
}
