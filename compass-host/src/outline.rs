//! What was seen in the level frame, as lines in the image of a camera.

use compass_core::vision::camera::{Pixel, View};
use compass_core::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use compass_core::vision::panorama::Resolution;
use compass_core::vision::windows::Window;

/// Lines along each side of a window.
const SIDE: u8 = 16;

/// Where a point is in the image of a camera, pixels; `None` if its lens or its sensor ends before. `range_m` is the distance from cam0.
#[must_use]
pub fn pixel(
    level: &LevelFrame,
    view: &View,
    [azimuth, elevation]: [f32; 2],
    range_m: f32,
) -> Option<[f64; 2]> {
    let size = [f32::from(view.width), f32::from(view.height)];
    let bearing = level.bearing(azimuth.to_radians(), elevation.to_radians());
    let seen = view.rotation.tr_mul(&(bearing * range_m - view.position));
    let Pixel { x, y } = view.camera.project(&seen)?;
    let on_image = (0.0..size[0]).contains(&x) && (0.0..size[1]).contains(&y);
    on_image.then(|| [f64::from(x), f64::from(y)])
}

/// The outline of a window in a camera's image, as far as the lens reaches, pixels.
#[must_use]
pub fn window(window: &Window, view: &View, level: &LevelFrame, resolution: Resolution) -> Vec<[f64; 2]> {
    let ([right, left], [sill, lintel]) = (window.azimuth_deg(resolution), window.elevation_deg(resolution));
    let corners = [[left, lintel], [right, lintel], [right, sill], [left, sill], [left, lintel]];
    let sides = corners.windows(2).flat_map(|ends| {
        (0..=SIDE).map(move |step| {
            let share = f32::from(step) / f32::from(SIDE);
            [0, 1].map(|axis| ends[0][axis] + (ends[1][axis] - ends[0][axis]) * share)
        })
    });
    sides.filter_map(|direction| pixel(level, view, direction, NOMINAL_RANGE_M)).collect()
}

/// Where a wall meets the floor or the ceiling, `above_m` above cam0 (below it if negative), in a camera's image, pixels: one
/// point for each direction with a range; `None` where there is none or the camera does not see it.
#[must_use]
pub fn boundary(
    ranges_m: &[Option<f64>; 360],
    above_m: f64,
    view: &View,
    level: &LevelFrame,
) -> Vec<Option<[f64; 2]>> {
    let point = |(bin, range): (usize, &Option<f64>)| {
        let range = (*range)?;
        let direction = [bin as f32, above_m.atan2(range).to_degrees() as f32];
        pixel(level, view, direction, range.hypot(above_m) as f32)
    };
    ranges_m.iter().enumerate().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Calibration;
    use compass_core::Bearing;

    #[test]
    fn a_floor_lies_below_the_horizon_and_a_ceiling_above() {
        let rig = Calibration::nominal().rig([Some((736, 720)); 2]).unwrap();
        let view = rig.view(0).unwrap();
        // Upright: up is -y of the image.
        let level = LevelFrame::new(&Bearing::new(0.0, -1.0, 0.0)).unwrap();
        let mut ranges = [None; 360];
        ranges[0] = Some(3.0);
        ranges[180] = Some(3.0);
        let [floor, horizon, ceiling] = [-1.5, 0.0, 1.0].map(|above| boundary(&ranges, above, view, &level));
        let y = |line: &[Option<[f64; 2]>]| line[0].unwrap()[1];
        assert!(y(&floor) > y(&horizon) + 50.0 && y(&ceiling) < y(&horizon) - 50.0);
        // Behind the camera, and where no range is known.
        assert!(floor[180].is_none() && floor[1].is_none());
        let centre = pixel(&level, view, [0.0, 0.0], 3.0).unwrap();
        assert_eq!(horizon[0], Some(centre));
    }
}
