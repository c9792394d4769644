//! Shapes of a drawing as pixels of a plan.

use super::layers::LayerRole;
use super::raster::PlanRaster;
use crate::drawing::{Paint, Shape};
use std::ops::Range;
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
pub(super) fn walls(raster: &mut PlanRaster, frame: &Frame, shapes: &[&Shape]) {
    paint(frame, shapes, |x, y| raster.set_wall(x, y));
}

/// Draws shapes as glazing, over walls.
pub(super) fn glazing(raster: &mut PlanRaster, frame: &Frame, shapes: &[&Shape]) {
    paint(frame, shapes, |x, y| raster.set_window(x, y));
}

/// Makes what shapes cover neither wall nor glazing.
pub(super) fn clear(raster: &mut PlanRaster, frame: &Frame, shapes: &[&Shape]) {
    paint(frame, shapes, |x, y| raster.set_free(x, y));
}

/// Draws shapes in the order of the drawing, each over those before it, where `class_of` says what its layer is; `None`
/// clears what lies below.
pub(super) fn in_order<'a>(
    raster: &mut PlanRaster,
    frame: &Frame,
    shapes: impl Iterator<Item = &'a Shape>,
    class_of: impl Fn(usize) -> Option<LayerRole>,
) {
    // Runs of one class need one pass.
    let mut shapes = shapes.peekable();
    while let Some(first) = shapes.next() {
        let class = class_of(first.layer);
        let mut run = vec![first];
        while let Some(next) = shapes.next_if(|next| class_of(next.layer) == class) {
            run.push(next);
        }
        paint(frame, &run, |x, y| match class {
            Some(LayerRole::Glazing) => raster.set_window(x, y),
            Some(role) if role.is_wall() => raster.set_wall(x, y),
            _ => raster.set_free(x, y),
        });
    }
}

/// Calls `set` with every pixel of the shapes, band by band: a byte per pixel of a whole plan may be too much.
fn paint(frame: &Frame, shapes: &[&Shape], mut set: impl FnMut(u32, u32)) {
    let Some([columns, rows]) = touched(frame, shapes) else { return };
    let width = columns.end - columns.start;
    let height = (BAND_PIXELS / width as usize).clamp(1, (rows.end - rows.start) as usize) as u32;
    let Some(mut mask) = Mask::new(width, height) else { return };
    for first in rows.clone().step_by(height as usize) {
        mask.clear();
        let corner = [columns.start, first].map(f64::from);
        let corner = [0, 1].map(|axis| frame.corner[axis] + corner[axis] * frame.resolution_m);
        let high = corner[1] + f64::from(height) * frame.resolution_m;
        for shape in shapes {
            let slack = line_width(frame, shape.paint) * frame.resolution_m;
            let [least, most] = shape.extent();
            if most[1] + slack >= corner[1] && least[1] - slack <= high {
                draw(&mut mask, frame, corner, shape);
            }
        }
        let bytes = mask.data().chunks_exact(width as usize);
        for (y, row) in (first..rows.end).zip(bytes) {
            for (x, _) in (columns.start..).zip(row).filter(|(_, byte)| **byte != 0) {
                set(x, y);
            }
        }
    }
}

/// The columns and rows of the raster that shapes may touch.
fn touched(frame: &Frame, shapes: &[&Shape]) -> Option<[Range<u32>; 2]> {
    let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for shape in shapes {
        // Square caps and miters reach beyond half the width.
        let slack = 4.0 + 2.0 * line_width(frame, shape.paint);
        let [low, high] = shape.extent();
        for axis in 0..2 {
            let pixel = |value: f64| (value - frame.corner[axis]) / frame.resolution_m;
            least[axis] = least[axis].min(pixel(low[axis]) - slack);
            most[axis] = most[axis].max(pixel(high[axis]) + slack);
        }
    }
    let range = |axis: usize, side: u32| {
        let pixel = |value: f64| value.clamp(0.0, f64::from(side)) as u32;
        let range = pixel(least[axis])..pixel(most[axis].ceil());
        (!range.is_empty()).then_some(range)
    };
    Some([range(0, frame.width)?, range(1, frame.height)?])
}

fn draw(mask: &mut Mask, frame: &Frame, corner: [f64; 2], shape: &Shape) {
    let Some(path) = path(frame, corner, shape) else { return };
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

/// The contours in pixels of a part of the raster whose lower left corner is given in metres.
fn path(frame: &Frame, corner: [f64; 2], shape: &Shape) -> Option<Path> {
    // Differences first: far-off coordinates do not fit into f32.
    let pixel =
        |point: [f64; 2]| [0, 1].map(|axis| ((point[axis] - corner[axis]) / frame.resolution_m) as f32);
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
