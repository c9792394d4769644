//! What exists for pictures: the feature `introspect`.

use super::edges::{self, Edge, VerticalSegment};
use super::window::Window;
use crate::vision::camera::{Pixel, Rig};
use crate::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use crate::vision::panorama::Resolution;
use heapless::Vec;

/// Visits the edges that [`WindowFinder::finish`](super::WindowFinder::finish) groups near-vertical segments into, in order
/// of columns; without the ends of the view.
///
/// ```
/// use compass_core::vision::panorama::Resolution;
/// use compass_core::vision::windows::{VerticalSegment, visit_edges};
///
/// // A segment without length is no edge.
/// visit_edges(&mut [VerticalSegment::EMPTY], Resolution::COARSE, |_| unreachable!());
/// ```
pub fn visit_edges(segments: &mut [VerticalSegment], resolution: Resolution, visit: impl FnMut(&Edge)) {
    let mut edges = Vec::new();
    edges::gather(segments, resolution, &mut edges);
    edges.iter().for_each(visit);
}

/// Bounding box `[x0, y0, x1, y1]`, pixels, of a window in the image of its camera, clamped to the image; `None` if no
/// sampled point of it is in the camera's field. The window is sampled at 9 x 9 points.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Bearing, Camera, CameraError, Intrinsics, Rig, View};
/// # use compass_core::vision::level_frame::LevelFrame;
/// # use compass_core::vision::panorama::Resolution;
/// use compass_core::vision::windows::{Window, image_box};
///
/// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 200, 200);
/// let (rig, level) = (Rig::new([Some(view), None])?, LevelFrame::new(&-Bearing::y()).unwrap());
/// // Ahead, 20 degrees wide, from the horizon to 10 degrees above.
/// let window = Window { columns: [340, 380], rows: [50, 70], ..Window::EMPTY };
/// let [x0, y0, x1, y1] = image_box(&window, &rig, &level, Resolution::COARSE).unwrap();
/// assert!((x0 - 82.0).abs() < 0.1 && (x1 - 117.0).abs() < 0.1);
/// assert!((y0 - 82.0).abs() < 0.1 && (y1 - 99.5).abs() < 0.1);
/// # Ok::<(), CameraError>(())
/// ```
#[must_use]
pub fn image_box(window: &Window, rig: &Rig, level: &LevelFrame, resolution: Resolution) -> Option<[f32; 4]> {
    /// Sampled points along each side.
    const POINTS: usize = 9;
    let view = rig.view(usize::from(window.camera))?;
    let radians = core::f32::consts::PI / 180.0;
    let ([right, left], [sill, lintel]) = (window.azimuth_deg(resolution), window.elevation_deg(resolution));
    let along =
        |from: f32, to: f32, k: usize| (from + (to - from) * (k as f32 / (POINTS - 1) as f32)) * radians;
    let (most_x, most_y) = (f32::from(view.width) - 1.0, f32::from(view.height) - 1.0);
    let mut extent: Option<[f32; 4]> = None;
    for (u, v) in (0..POINTS * POINTS).map(|k| (k % POINTS, k / POINTS)) {
        let bearing = level.bearing(along(right, left, u), along(sill, lintel, v));
        let seen = view.rotation.tr_mul(&(bearing * NOMINAL_RANGE_M - view.position));
        let Some(Pixel { x, y }) = view.camera.project(&seen) else { continue };
        let (x, y) = (x.max(0.0).min(most_x), y.max(0.0).min(most_y));
        let [x0, y0, x1, y1] = extent.unwrap_or([x, y, x, y]);
        extent = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
    }
    extent
}
