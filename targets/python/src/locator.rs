//! From frames to a pose.

use crate::arrays::frame;
use crate::error::{finite, wrong, wrong_in};
use crate::fix::Fix;
use crate::rig::Rig;
use crate::seen::Observation;
use crate::site::Site;
use crate::track::{Estimate, Track};
use compass_host::compass_core::base::ladder::HEIGHTS_M;
use compass_host::compass_core::pose::FloorLayer;
use compass_host::compass_core::vision::camera::Bearing;
use compass_host::compass_core::{self, Motion};
use compass_host::locator::see;
use compass_host::up_by_plan::{Placed, locate_by_plan};
use compass_host::{
    Calibration, Frame, HeightPrior, KnownPose, KnownPoseError, Mount, PosePrior, SeeError, Settings,
    SiteFile, VisualDescriptor, doubt, dual_image,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Finds the poses of a rig on a site.
#[pyclass(frozen, module = "compass_localization")]
#[derive(Debug)]
pub(crate) struct Locator {
    site: Arc<SiteFile>,
    name: String,
    calibration: Arc<Calibration>,
    mount: Mount,
    settings: Settings,
}

/// What is known beforehand, and how sure an answer must be.
struct Question {
    up: Option<Bearing>,
    heights: HeightPrior,
    known: KnownPose,
    least: f64,
}

/// A place in the time of a track.
struct Step<'t> {
    track: &'t Track,
    seconds: f32,
    motion: Option<Motion>,
}

#[pymethods]
impl Locator {
    /// For the cameras of a rig on a site.
    ///
    /// `settings` is 'full', what pays on a computer, or 'board', what a microcontroller has the memory for.
    #[new]
    #[pyo3(signature = (site, rig, settings="full"))]
    fn new(site: &Site, rig: &Rig, settings: &str) -> PyResult<Self> {
        let settings = match settings {
            "full" => Settings::FULL,
            "board" => Settings::BOARD,
            _ => return Err(wrong_in("settings", format!("{settings:?} is not 'full' or 'board'"))),
        };
        if site.file.floors().iter().any(|floor| floor.floor.is_none()) {
            return Err(wrong_in(&site.name, compass_host::NoPlan));
        }
        let (site, name) = (Arc::clone(&site.file), site.name.clone());
        Ok(Self { site, name, calibration: Arc::clone(&rig.calibration), mount: rig.mount, settings })
    }

    /// Finds where frames were taken.
    ///
    /// `cam0`, `cam1`: uint8 of shape (height, width) or (height, width, 3) in RGB; one may be None. `up`: up vector in the axes
    /// of cam0 (x right, y down, z forward), in place of the vertical lines of the image. `camera_height`: metres of cam0 above
    /// the floor, 0.55 to 2.4; searched if None. `ceiling_between`: bounds (a, b) of the ceiling above the floor, metres. `near`:
    /// (x, y, radius) in metres, `heading_near`: (degrees, width to either side), `floor`: name; they restrict the search.
    /// `min_probability`: below it the answer is not sure. `track`: takes the frames into a belief, `seconds` after the ones
    /// before, with the motion (forward m, left m, turn rad) since then, if odometry tells it.
    ///
    /// Other threads run while it works. Raises CompassError for input that cannot be used; that the frames do not tell where they
    /// were taken is no error but a Fix that is not sure, with its reason.
    #[pyo3(signature = (cam0=None, cam1=None, *, up=None, camera_height=None, ceiling_between=None, near=None, heading_near=None, floor=None, min_probability=0.5, track=None, seconds=0.0, motion=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments")]
    fn locate(
        &self,
        py: Python<'_>,
        cam0: Option<&Bound<'_, PyAny>>,
        cam1: Option<&Bound<'_, PyAny>>,
        up: Option<[f64; 3]>,
        camera_height: Option<f64>,
        ceiling_between: Option<[f64; 2]>,
        near: Option<[f64; 3]>,
        heading_near: Option<[f64; 2]>,
        floor: Option<String>,
        min_probability: f64,
        track: Option<Py<Track>>,
        seconds: f64,
        motion: Option<[f64; 3]>,
    ) -> PyResult<Fix> {
        if !(0.0..=1.0).contains(&min_probability) {
            return Err(wrong_in("min_probability", format!("{min_probability} is not 0 to 1")));
        }
        let question = Question {
            up: direction(up)?,
            heights: heights(camera_height, ceiling_between)?,
            known: KnownPose { near, heading_near, floor },
            least: min_probability,
        };
        let frames = frames(cam0, cam1)?;
        let (seconds, motion) = (seconds_since(seconds)?, motion_of(motion)?);
        let step = track.as_ref().map(|track| Step { track: track.get(), seconds, motion });
        py.detach(|| self.answer(frames, &question, step.as_ref()))
    }

    /// What frames show, as a dict of arrays, without a site.
    ///
    /// `channels` (5, 360) as of Plan.describe; `range_m` (360,), NaN where neither floor nor ceiling was seen; `hit` (360,) of uint8,
    /// 0 open, 1 window, 2 wall, 255 out of view; `confidence` (360,) 0 to 1; `evidence` (360,) log odds of a window, nats;
    /// `up_in_cam0` (3,); `camera_height_m`, `ceiling_height_m`.
    #[pyo3(signature = (cam0=None, cam1=None, *, up=None, camera_height=None))]
    fn see<'py>(
        &self,
        py: Python<'py>,
        cam0: Option<&Bound<'_, PyAny>>,
        cam1: Option<&Bound<'_, PyAny>>,
        up: Option<[f64; 3]>,
        camera_height: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (up, heights) = (direction(up)?, heights(camera_height, None)?);
        let frames = frames(cam0, cam1)?;
        py.detach(|| self.observe(frames, up, heights))?.to_dict(py)
    }

    fn __repr__(&self) -> String {
        format!("Locator(site={:?}, mount={:?})", self.name, self.mount)
    }
}

impl Locator {
    fn observe(
        &self,
        frames: [Option<Frame>; 2],
        up: Option<Bearing>,
        heights: HeightPrior,
    ) -> PyResult<Observation> {
        let (frames, rig) = self.rigged(frames)?;
        let mut locator = compass_host::Locator::without_site(rig, self.settings);
        let mut segmented = locator.segment(frames.each_ref().map(Option::as_ref)).map_err(wrong)?;
        let up = match up {
            Some(up) => up,
            None => self.mount.vertical(&mut segmented).map_err(wrong)?.up,
        };
        let levelled = segmented.level(&up).map_err(|error| wrong(SeeError::from(error)))?;
        let up = levelled.frame().up();
        let mut seen = see(levelled);
        let evidence = seen.window_evidence().clone();
        Ok(Observation { up, evidence, descriptor: VisualDescriptor::of(&mut seen, heights) })
    }

    /// The frames with those of images that show both lenses split, and the rig for their sizes.
    fn rigged(&self, frames: [Option<Frame>; 2]) -> PyResult<([Option<Frame>; 2], compass_core::Rig)> {
        let (frames, _) = dual_image::split(&self.calibration, frames);
        let sizes =
            frames.each_ref().map(|frame| frame.as_ref().map(|frame| (frame.width(), frame.height())));
        let rig = self.calibration.rig(sizes).map_err(wrong)?;
        Ok((frames, rig))
    }

    fn answer(
        &self,
        frames: [Option<Frame>; 2],
        question: &Question,
        step: Option<&Step<'_>>,
    ) -> PyResult<Fix> {
        let (frames, rig) = self.rigged(frames)?;
        let frames = frames.each_ref().map(Option::as_ref);
        let floors = self.site.floors();
        let mut locator = compass_host::Locator::new(&floors, rig, self.settings).map_err(wrong)?;
        let within = question.prior(&self.name, locator.layers())?;
        let mut segmented = locator.segment(frames).map_err(wrong)?;
        let ups = question.up.map_or_else(|| self.mount.candidates(&mut segmented), |up| Ok(vec![up]));
        let placed = ups.and_then(|ups| locate_by_plan(segmented, &ups, question.heights, &within));
        let Placed { up, mut seen, fix } = match placed {
            Ok(placed) => placed,
            Err(error) if error.is_answer() => {
                let mut nothing = Fix::nothing(Arc::clone(&self.site), error.to_string());
                nothing.add_reason(doubt::of_frames(frames));
                return Ok(nothing);
            }
            Err(error) => return Err(wrong(error)),
        };
        let estimate = step.and_then(|step| {
            let mut track = step.track.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            seen.track(&mut track, &fix, step.seconds, step.motion)
        });
        let layers = locator.layers();
        let estimate = estimate.map(|estimate| Estimate::new(&estimate, layers));
        let mut answer = Fix::new(Arc::clone(&self.site), &fix, up, layers, question.least, estimate);
        if !answer.is_sure() {
            answer.add_reason(doubt::of_maps(&floors));
            answer.add_reason(doubt::of_frames(frames));
        }
        Ok(answer)
    }
}

impl Question {
    /// What is known of the pose.
    fn prior(&self, name: &str, layers: &[FloorLayer<'_>]) -> PyResult<PosePrior> {
        self.known.prior(layers).map_err(|error| match &error {
            KnownPoseError::Near => wrong_in("near", error),
            KnownPoseError::Floor { there } => {
                let asked = self.known.floor.as_deref().unwrap_or_default();
                wrong_in("floor", format!("{name} has no floor {asked:?}, but {there}"))
            }
            _ => wrong_in("heading_near", error),
        })
    }
}

fn frames(cam0: Option<&Bound<'_, PyAny>>, cam1: Option<&Bound<'_, PyAny>>) -> PyResult<[Option<Frame>; 2]> {
    if cam0.is_none() && cam1.is_none() {
        return Err(wrong("no frame: give cam0, cam1 or both"));
    }
    let of = |name: &str, array: Option<&Bound<'_, PyAny>>| array.map(|array| frame(name, array)).transpose();
    Ok([of("cam0", cam0)?, of("cam1", cam1)?])
}

fn direction(up: Option<[f64; 3]>) -> PyResult<Option<Bearing>> {
    let Some([x, y, z]) = up else { return Ok(None) };
    let length = x.hypot(y).hypot(z);
    if !(length.is_finite() && length > 1e-6) {
        return Err(wrong_in("up", format!("({x}, {y}, {z}) is not a direction")));
    }
    Ok(Some(Bearing::new(x as f32, y as f32, z as f32)))
}

pub(crate) fn heights(camera: Option<f64>, ceiling: Option<[f64; 2]>) -> PyResult<HeightPrior> {
    let [least, most] = HEIGHTS_M;
    let prior = match camera.map(|metres| metres as f32) {
        None => HeightPrior::UNKNOWN,
        Some(metres) if (least..=most).contains(&metres) => HeightPrior::camera(metres),
        Some(metres) => {
            return Err(wrong_in("camera_height", format!("{metres} is not {least} to {most} m")));
        }
    };
    match ceiling {
        None => Ok(prior),
        Some([a, b]) if a <= b && [a, b].iter().all(|bound| (1.0..=12.0).contains(bound)) => {
            Ok(prior.with_ceiling_between([a as f32, b as f32]))
        }
        Some([a, b]) => {
            Err(wrong_in("ceiling_between", format!("({a}, {b}) is not within 1 to 12 m, in order")))
        }
    }
}

fn seconds_since(seconds: f64) -> PyResult<f32> {
    if seconds.is_finite() && seconds >= 0.0 {
        Ok(seconds as f32)
    } else {
        Err(wrong_in("seconds", format!("{seconds} is not 0 or more")))
    }
}

fn motion_of(motion: Option<[f64; 3]>) -> PyResult<Option<Motion>> {
    let Some(values) = motion else { return Ok(None) };
    let mut numbers = [0.0; 3];
    for (number, value) in numbers.iter_mut().zip(values) {
        *number = finite("motion", value)? as f32;
    }
    let [forward_m, left_m, turn] = numbers;
    Ok(Some(Motion { forward_m, left_m, turn }))
}
