//! Frames rendered from a plan.

use crate::arrays::from_rgb;
use crate::error::{finite, wrong, wrong_in};
use crate::plan::Plan;
use crate::rig::Rig;
use compass_host::dataset::tum::Pose;
use compass_host::simulate::{Scene, SceneOptions, render};
use pyo3::prelude::*;

/// Renders what both cameras see from a pose in a plan: (cam0, cam1), uint8 of shape (height, width, 3); None for a camera that
/// the rig lacks.
///
/// `z` is the height above the floor in metres, `pitch` and `roll` are degrees (roll 180: upside down), `size` is (width,
/// height) in pixels, `seed` decides clutter, people, materials and noise.
#[pyfunction]
#[pyo3(signature = (plan, rig, x, y, heading, *, z=1.6, pitch=0.0, roll=180.0, size=(736, 720), seed=1, ceiling=2.75, clutter=2, people=1, missing=0.0))]
#[expect(clippy::too_many_arguments, clippy::type_complexity, reason = "keyword arguments; a pair of images")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    plan: &Plan,
    rig: &Rig,
    x: f64,
    y: f64,
    heading: f64,
    z: f64,
    pitch: f64,
    roll: f64,
    size: (u32, u32),
    seed: u64,
    ceiling: f64,
    clutter: u32,
    people: u32,
    missing: f64,
) -> PyResult<(Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>)> {
    let numbers = [
        ("x", x),
        ("y", y),
        ("heading", heading),
        ("z", z),
        ("pitch", pitch),
        ("roll", roll),
        ("ceiling", ceiling),
    ];
    for (name, value) in numbers {
        finite(name, value)?;
    }
    if !(0.0..=1.0).contains(&missing) {
        return Err(wrong_in("missing", format!("{missing} is not a share of 0 to 1")));
    }
    if ![size.0, size.1].iter().all(|side| (16..=8192).contains(side)) {
        return Err(wrong_in("size", format!("{size:?}: sides must be 16 to 8192 pixels")));
    }
    let sizes = [0, 1].map(|number| rig.calibration.cameras[number].is_some().then_some(size));
    let cameras = rig.calibration.rig(sizes).map_err(wrong)?;
    let options = SceneOptions {
        seed,
        style: seed,
        ceiling_m: ceiling,
        clutter,
        people,
        missing,
        ..SceneOptions::default()
    };
    let pose = Pose::looking(0, [x, y, z], heading, pitch, roll);
    let frames = py.detach(|| render(&Scene::new(&options, &plan.raster), &cameras, &pose));
    let [cam0, cam1] = frames.map(|frame| frame.map(|frame| from_rgb(py, frame)).transpose());
    Ok((cam0?, cam1?))
}
