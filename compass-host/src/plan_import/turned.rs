//! A plan turned about the outer corner of its bottom-left pixel, as the yaw of a map's origin says.

use super::raster::PlanRaster;
use std::f64::consts::FRAC_PI_2;

/// Deviation from a quarter turn that counts as none, radians: across 100 m it shifts a plan by less than 1 mm.
const SLACK: f64 = 1e-5;

/// The plan turned counter-clockwise by `yaw` radians about its origin, on the smallest raster that holds it.
///
/// Quarter turns are exact; at other angles each pixel is what the plan has at its centre. `None` where a side would be
/// longer than 65535 pixels.
pub(super) fn turned(plan: PlanRaster, yaw: f64) -> Option<PlanRaster> {
    let (sin, cos) = sin_cos(yaw);
    if cos == 1.0 {
        return Some(plan);
    }
    let (width, height) = (f64::from(plan.width), f64::from(plan.height));
    let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
    let along_x = corners.map(|[u, v]| u * cos - v * sin);
    let along_y = corners.map(|[u, v]| u * sin + v * cos);
    let (left, columns) = extent(along_x)?;
    let (bottom, rows) = extent(along_y)?;
    let origin = [plan.origin[0] + left * plan.resolution_m, plan.origin[1] + bottom * plan.resolution_m];
    let mut found = PlanRaster::empty(columns, rows, plan.resolution_m, origin);
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
        let (right, up) = (f64::from(x) + 0.5 + left, f64::from(y) + 0.5 + bottom);
        let (u, v) = (right * cos + up * sin, up * cos - right * sin);
        if u < 0.0 || v < 0.0 {
            continue;
        }
        let (u, v) = (u as u32, v as u32);
        if plan.is_wall(u, v) {
            found.set_wall(x, y);
        } else if plan.is_window(u, v) {
            found.set_window(x, y);
        }
    }
    Some(found)
}

/// Sine and cosine, exact at quarter turns.
fn sin_cos(yaw: f64) -> (f64, f64) {
    let quarters = (yaw / FRAC_PI_2).round();
    if (yaw - quarters * FRAC_PI_2).abs() > SLACK {
        return yaw.sin_cos();
    }
    match quarters.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

/// The least of four values, and the whole pixels from it to the largest.
fn extent(values: [f64; 4]) -> Option<(f64, u32)> {
    let least = values.into_iter().fold(f64::INFINITY, f64::min);
    let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // Rounding in the last place must not add a pixel.
    let pixels = (most - least - 1e-6).ceil();
    (pixels <= f64::from(crate::image_file::MAX_SIDE)).then_some((least, pixels as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Three pixels wide, two high: a wall at (2, 0), glazing at (0, 1).
    fn plan() -> PlanRaster {
        let mut plan = PlanRaster::empty(3, 2, 0.5, [10.0, 20.0]);
        plan.set_wall(2, 0);
        plan.set_window(0, 1);
        plan
    }

    #[test]
    fn quarter_turns_are_exact() {
        let quarter = turned(plan(), FRAC_PI_2).unwrap();
        assert_eq!((quarter.width, quarter.height, quarter.origin), (2, 3, [9.0, 20.0]));
        assert!(quarter.is_wall(1, 2) && quarter.is_window(0, 0));
        let half = turned(plan(), -PI).unwrap();
        assert_eq!((half.width, half.height, half.origin), (3, 2, [8.5, 19.0]));
        assert!(half.is_wall(0, 1) && half.is_window(2, 0));
        assert_eq!(turned(plan(), 1e-7).unwrap(), plan());
        let mut around = plan();
        (0..4).for_each(|_| around = turned(around.clone(), FRAC_PI_2).unwrap());
        assert_eq!((&around.walls, &around.windows), (&plan().walls, &plan().windows));
    }

    #[test]
    fn small_angles_are_no_quarter_turns() {
        // 0.4 m across 100 m, where the cosine is 1 to within the slack.
        let mut plan = PlanRaster::empty(1000, 3, 0.1, [0.0; 2]);
        (0..1000).for_each(|x| plan.set_wall(x, 0));
        let found = turned(plan, 0.004).unwrap();
        assert!(found.is_wall(10, 0) && found.is_wall(990, 4) && !found.is_wall(990, 0));
        for (turns, wanted) in
            [(-1.0, (-1.0, 0.0)), (-2.0, (0.0, -1.0)), (3.0, (-1.0, 0.0)), (5.0, (1.0, 0.0))]
        {
            assert_eq!(sin_cos(turns * FRAC_PI_2), wanted, "{turns}");
        }
    }

    #[test]
    fn other_angles_keep_every_place_within_a_pixel() {
        let mut plan = PlanRaster::empty(40, 30, 0.1, [-1.0, 2.0]);
        (5..12).for_each(|x| (4..9).for_each(|y| plan.set_wall(x, y)));
        let yaw = 0.4_f64;
        let found = turned(plan, yaw).unwrap();
        let count = (0..found.height).flat_map(|y| (0..found.width).map(move |x| (x, y)));
        let count = count.filter(|&(x, y)| found.is_wall(x, y)).count();
        assert!((32..=38).contains(&count), "35 pixels before, {count} after");
        let (u, v) = (0.85, 0.65);
        let (x, y) = (-1.0 + u * yaw.cos() - v * yaw.sin(), 2.0 + u * yaw.sin() + v * yaw.cos());
        let pixel = |at: f64, origin: f64| ((at - origin) / 0.1) as u32;
        assert!(found.is_wall(pixel(x, found.origin[0]), pixel(y, found.origin[1])));
    }
}
