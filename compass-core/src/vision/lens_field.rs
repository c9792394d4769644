//! The image of a lens's field, as a mask.

use crate::base::num::truncate_to_u16;
use crate::vision::camera::{Bearing, View};

/// Angle from the optical axis within which segments are detected, radians: 95 degrees.
const FIELD: f32 = 95.0 * core::f32::consts::PI / 180.0;
/// Width, pixels, of the rim that the gradient at the border of the field reaches.
const RIM_PX: f32 = 3.0;

/// Sets the bits of the pixels within 95 degrees of the optical axis, less a rim of 3 pixels, and clears the others.
///
/// `bits` has the layout of [`BitMask`](crate::base::raster::BitMask); rows beyond its length are omitted.
///
/// # Formats
/// One bit a pixel, rows padded to whole bytes.
///
/// # Accuracy
/// Exact: every pixel is decided by the inequality of the ellipse (test `bits_match_the_ellipse`).
///
/// # Cost
/// One square root and at most 10 tests of pixels per row.
///
/// ```
/// use compass_core::vision::camera::Equidistant;
/// use compass_core::vision::lens_field::fill_mask;
/// use compass_core::{BitMask, Camera, Intrinsics, View};
///
/// // 95 degrees are 16.6 px from the centre.
/// let intrinsics = Intrinsics { fx: 10.0, fy: 10.0, cx: 19.5, cy: 19.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 40, 40);
/// let mut bits = [0xff; 5 * 40];
/// fill_mask(&view, &mut bits);
/// let mask = BitMask::new(&bits, 40, 40).unwrap();
/// assert!(mask.get(32, 19) && !mask.get(34, 19) && !mask.get(0, 0));
/// # Ok::<(), compass_core::CameraError>(())
/// ```
pub fn fill_mask(view: &View, bits: &mut [u8]) {
    let row_bytes = usize::from(view.width).div_ceil(8);
    let border = Ellipse::of(view);
    for (y, row) in (0..view.height).zip(bits.chunks_exact_mut(row_bytes.max(1))) {
        let inside = border.columns(f32::from(y), view.width);
        for (byte, from) in row.iter_mut().zip((0_u16..).step_by(8)) {
            let bits = |end: u16| (1_u16 << end.saturating_sub(from).min(8)) - 1;
            let [low, _] = (bits(inside[1]) & !bits(inside[0])).to_le_bytes();
            *byte = low;
        }
    }
}

/// The border of the field: an ellipse around the principal point.
struct Ellipse {
    centre: [f32; 2],
    focal: [f32; 2],
    /// Radius in focal lengths.
    radius: f32,
}

impl Ellipse {
    fn of(view: &View) -> Self {
        let i = view.camera.intrinsics();
        let (sin, cos) = libm::sincosf(FIELD);
        let rim = view.camera.project(&Bearing::new(sin, 0.0, cos));
        let radius = rim.map_or(f32::INFINITY, |p| (p.x - i.cx - RIM_PX) / i.fx);
        Self { centre: [i.cx, i.cy], focal: [i.fx, i.fy], radius }
    }

    /// The columns of a row inside the ellipse: the first, and the one after the last.
    fn columns(&self, y: f32, width: u16) -> [u16; 2] {
        let ([cx, cy], [fx, fy]) = (self.centre, self.focal);
        let v = (y - cy) / fy;
        let half_chord_squared = self.radius * self.radius - v * v;
        let contains = |x: u16| {
            let u = (f32::from(x) - cx) / fx;
            u * u + v * v < self.radius * self.radius
        };
        if self.radius.is_infinite() {
            return [0, width];
        }
        if half_chord_squared <= 0.0 {
            return [0; 2];
        }
        // The root locates the border within a pixel; the inequality decides for the pixels around it.
        let reach = libm::sqrtf(half_chord_squared) * fx;
        let near = |x: f32| truncate_to_u16(x.max(0.0)).min(width);
        let first = near(cx - reach - 1.0);
        let end = near(cx + reach + 3.0);
        let start = (first..end).take(4).find(|x| contains(*x)).unwrap_or(end);
        let last = (start..end).rev().take(6).find(|x| contains(*x));
        last.map_or([0; 2], |last| [start, last + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::raster::BitMask;
    use crate::vision::camera::{Camera, Equidistant, Intrinsics};
    use std::vec;

    #[test]
    fn bits_match_the_ellipse() {
        for (focal, width, height, cx) in
            [(20.0, 100_u16, 90_u16, 47.3), (31.7, 64, 70, 30.0), (11.0, 77, 64, 2.0)]
        {
            let lens = Equidistant::new(Intrinsics { fx: focal, fy: focal * 1.01, cx, cy: 41.6 }).unwrap();
            let view = View::new(Camera::Equidistant(lens), width, height);
            let mut bits = vec![0xa5; BitMask::row_bytes(width.into()) * usize::from(height)];
            fill_mask(&view, &mut bits);
            let mask = BitMask::new(&bits, width.into(), height.into()).unwrap();
            let border = Ellipse::of(&view);
            let mut inside = 0;
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                let u = (f32::from(x) - border.centre[0]) / border.focal[0];
                let v = (f32::from(y) - border.centre[1]) / border.focal[1];
                let expected = u * u + v * v < border.radius * border.radius;
                assert_eq!(mask.get(x.into(), y.into()), expected, "{x}, {y} of {width} x {height}");
                inside += usize::from(expected);
            }
            assert!(inside > 400, "{inside}");
        }
    }
}
