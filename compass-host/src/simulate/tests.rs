use super::fan::Fan;
use super::grid::{Surface, WALL};
use super::*;
use crate::calibration::Calibration;
use crate::plan_import::PlanRaster;
use crate::sample;
use crate::site::PackedPlan;
use compass_core::base::raster::is_red;
use compass_core::base::scan::Hit;

const SIZE: (u32, u32) = (368, 360);

fn rig() -> Rig {
    Calibration::nominal().rig([Some(SIZE), Some(SIZE)]).unwrap()
}

/// An empty room of 6 m x 5 m, with a window in its eastern wall.
fn room() -> PlanRaster {
    let mut raster = PlanRaster::empty(700, 600, 0.01, [0.0, 0.0]);
    for y in 0..600 {
        for x in 0..700 {
            let inside = (50..650).contains(&x) && (50..550).contains(&y);
            let near = (30..670).contains(&x) && (30..570).contains(&y);
            if near && !inside {
                let window = x >= 650 && (200..400).contains(&y);
                if window { raster.set_window(x, y) } else { raster.set_wall(x, y) }
            }
        }
    }
    raster
}

fn empty() -> SceneOptions {
    SceneOptions { clutter: 0, people: 0, operator: false, ..SceneOptions::default() }
}

/// Mean brightness of 5 x 5 pixels around the image of a point of the map.
fn brightness(frames: &[Option<RgbImage>; 2], pose: &Pose, point: [f64; 3]) -> f64 {
    let rig = rig();
    let (number, view) =
        if pose.rotation.inverse().transform_vector(&(Vector3::from(point) - pose.position)).z > 0.0 {
            (0, rig.view(0).unwrap())
        } else {
            (1, rig.view(1).unwrap())
        };
    let in_rig = pose.rotation.inverse() * (Vector3::from(point) - pose.position);
    let bearing = view.rotation.transpose() * (in_rig.cast() - view.position);
    let at = view.camera.project(&bearing).unwrap();
    let (x, y) = (at.x.round() as u32, at.y.round() as u32);
    let frame = frames[number].as_ref().unwrap();
    let patch = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| frame.get_pixel(x, y).0));
    patch.map(|[r, g, b]| f64::from(r) + f64::from(g) + f64::from(b)).sum::<f64>() / 75.0
}

#[test]
fn columns_have_the_ranges_of_the_core() {
    let raster = PlanRaster::from(sample::building());
    let plan = PackedPlan::new(&raster).unwrap();
    let scene = Scene::new(&empty(), &raster);
    for at in [sample::DEMO_POSE.0, [24.13, 8.71], [9.58, 6.83], [28.31, 16.87]] {
        let scan = plan.scan(at, 0.0).unwrap();
        let fan = Fan::new(&scene, at);
        let agrees = |&bin: &usize| {
            let face = fan.towards(bin as f32).faces().next().unwrap();
            let hit = match face.surface {
                Surface::Wall => Hit::Wall,
                Surface::Glass(..) => Hit::Window,
                Surface::Outdoors => Hit::Open,
            };
            // The core samples every 2 cm: its range is late by up to that, and it may step over a corner.
            let late = f32::from(scan.steps[bin]) * 0.02 - face.range;
            hit == scan.hit[bin] && (-0.011..0.031).contains(&late)
        };
        let agreeing = (0..360).filter(agrees).count();
        assert!(agreeing >= 355, "{agreeing} of 360 at {at:?}");
    }
}

#[test]
fn a_window_is_bright_in_either_camera_and_lights_the_floor() {
    let scene = Scene::new(&empty(), &room());
    for heading in [0.0, 180.0] {
        for roll in [0.0, 175.0] {
            let pose = Pose::looking(7, [3.0, 3.0, 1.5], heading, 5.0, roll);
            let frames = render(&scene, &rig(), &pose);
            let seen = |point| brightness(&frames, &pose, point);
            let window = seen([6.7, 2.6, 1.9]);
            let walls = [[6.5, 1.0, 1.5], [6.5, 5.0, 1.5], [0.5, 3.0, 1.5], [4.0, 5.5, 1.0]].map(seen);
            assert!(walls.iter().all(|wall| window > wall + 40.0), "{heading} {roll}: {window} {walls:?}");
            let floor = [[6.2, 3.5, 0.0], [4.2, 3.5, 0.0]].map(seen);
            assert!(floor[0] > floor[1] + 5.0, "light falls in: {heading} {roll}: {floor:?}");
        }
    }
}

#[test]
fn the_operator_is_below_whichever_way_the_camera_hangs() {
    let scene = Scene::new(&SceneOptions { operator: true, ..empty() }, &room());
    for roll in [0.0, 180.0] {
        let pose = Pose::looking(7, [3.0, 3.0, 1.5], 40.0, 0.0, roll);
        let up = pose.up_in_camera();
        for frame in render(&scene, &rig(), &pose).iter().flatten() {
            let red: Vec<f64> = frame
                .enumerate_pixels()
                .filter(|(_, _, pixel)| is_red(pixel.0))
                .map(|(_, y, _)| f64::from(y) - f64::from(SIZE.1) / 2.0)
                .collect();
            let mean = red.iter().sum::<f64>() / red.len() as f64;
            assert!(red.len() > 500 && mean * up.y < -30.0, "roll {roll}: {} red, mean y {mean}", red.len());
        }
    }
}

#[test]
fn the_frame_is_black_beyond_the_field() {
    let scene = Scene::new(&empty(), &room());
    let frames = render(&scene, &rig(), &Pose::looking(7, [3.0, 3.0, 1.5], 0.0, 0.0, 180.0));
    for frame in frames.iter().flatten() {
        let corners = [(3, 3), (364, 3), (3, 356), (364, 356)];
        assert!(corners.iter().all(|&(x, y)| frame.get_pixel(x, y).0.iter().all(|&v| v < 25)));
        assert!(frame.get_pixel(184, 180).0.iter().all(|&v| v > 40));
    }
}

#[test]
fn a_missing_camera_has_no_frame() {
    let scene = Scene::new(&empty(), &room());
    let rig = Calibration::nominal().rig([None, Some(SIZE)]).unwrap();
    let pose = Pose::looking(7, [3.0, 3.0, 1.5], 0.0, 0.0, 180.0);
    let both = render(&scene, &self::rig(), &pose);
    let [front, back] = render(&scene, &rig, &pose);
    assert!(front.is_none() && back.unwrap().dimensions() == both[1].as_ref().unwrap().dimensions());
}

#[test]
fn seeds_and_styles_decide_everything() {
    let raster = room();
    let pose = Pose::looking(7, [3.0, 3.0, 1.5], 20.0, 0.0, 180.0);
    let frames = |seed, style| {
        let options = SceneOptions { seed, style, clutter: 30, people: 2, ..SceneOptions::default() };
        render(&Scene::new(&options, &raster), &rig(), &pose)
    };
    let first = frames(1, 1);
    assert!(first == frames(1, 1));
    assert!(first != frames(2, 1) && first != frames(1, 2));
}

#[test]
fn only_thin_interior_walls_go_missing() {
    let raster = PlanRaster::from(sample::building());
    let whole = Scene::new(&empty(), &raster).grid;
    let walls = |grid: &grid::Grid, columns: std::ops::Range<i64>, rows: std::ops::Range<i64>| {
        rows.flat_map(|y| columns.clone().map(move |x| (x, y)))
            .filter(|&(x, y)| grid.cell(x, y) == WALL)
            .count()
    };
    // Columns and pillars are a tenth of these rooms' walls, and stay.
    let (facade, rooms) = ((100..3100, 100..140), (400..2900, 170..600));
    for (missing, least, most) in [(0.0, 0.0, 0.0), (0.3, 0.05, 0.6), (1.0, 0.85, 0.95)] {
        let torn = Scene::new(&SceneOptions { missing, ..empty() }, &raster).grid;
        let count = |grid, (columns, rows): &(std::ops::Range<i64>, _)| {
            walls(grid, columns.clone(), std::ops::Range::clone(rows)) as f64
        };
        assert!(count(&whole, &facade) == count(&torn, &facade), "{missing}");
        let gone = 1.0 - count(&torn, &rooms) / count(&whole, &rooms);
        assert!((least..=most).contains(&gone), "{missing}: {gone} of the walls of the southern rooms");
    }
}
