//! Recordings against the truth, as columns.

use crate::error::{wrong, wrong_in};
use crate::locator::heights;
use crate::rig::Rig;
use crate::site::Site;
use compass_host::dataset::recording::Recording;
use compass_host::dataset::trajectory::Trajectory;
use compass_host::evaluate::judged::JudgedFrame;
use compass_host::evaluate::{Found, Job, Journal, Judge, Misses, localize, sequence};
use compass_host::{Settings, Silent, SiteFloor};
use numpy::IntoPyArray as _;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// What is evaluated.
struct Question<'a> {
    site: &'a Site,
    rig: &'a Rig,
    dataset: &'a Path,
    groundtruth: &'a Path,
    odometry: Option<&'a Path>,
    floor: Option<&'a str>,
    camera_height: Option<f64>,
    every: NonZeroUsize,
}

/// The columns, an entry a frame.
#[derive(Default)]
struct Columns {
    timestamp_ns: Vec<u64>,
    numbers: Vec<(&'static str, Vec<f64>)>,
    problem: Vec<Option<String>>,
}

/// Localizes a recording frame by frame and as a sequence, and holds it against the truth, as `compass evaluate` does.
///
/// `dataset` is a folder with cam0/data.csv and cam1/data.csv, `groundtruth` and `odometry` are TUM files (timestamp tx ty tz qx qy
/// qz qw) of cam0 in the map and in any frame whose z points up. `floor` names the floor of the truth, `camera_height` is metres
/// above it, `every` takes only every n-th frame.
///
/// Returns a dict of columns that pandas.DataFrame takes, an entry a frame: `timestamp_ns`; `true_x`, `true_y`, `true_heading_deg`; `x`,
/// `y`, `heading_deg`, `probability`, `error_m`, `error_deg` of the frame alone; `track_x`, `track_y`, `track_heading_deg`,
/// `track_probability`, `track_error_m`, `track_error_deg` of the sequence; `problem`. Metres and degrees; NaN where there is no pose
/// or no truth; an error is infinite without a pose or on another floor. Other threads run while it works.
#[pyfunction]
#[pyo3(signature = (site, rig, dataset, groundtruth, *, odometry=None, floor=None, camera_height=None, every=1))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    site: &Site,
    rig: &Rig,
    dataset: PathBuf,
    groundtruth: PathBuf,
    odometry: Option<PathBuf>,
    floor: Option<String>,
    camera_height: Option<f64>,
    every: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let every = NonZeroUsize::new(every).ok_or_else(|| wrong_in("every", "0 takes no frame"))?;
    let question = Question {
        site,
        rig,
        dataset: &dataset,
        groundtruth: &groundtruth,
        odometry: odometry.as_deref(),
        floor: floor.as_deref(),
        camera_height,
        every,
    };
    let Columns { timestamp_ns, numbers, problem } = py.detach(|| question.answer())?;
    let dict = PyDict::new(py);
    dict.set_item("timestamp_ns", timestamp_ns.into_pyarray(py))?;
    for (name, values) in numbers {
        dict.set_item(name, values.into_pyarray(py))?;
    }
    dict.set_item("problem", problem)?;
    Ok(dict)
}

impl Question<'_> {
    fn answer(&self) -> PyResult<Columns> {
        let floors = self.site.file.floors();
        let mut locator = compass_host::Locator::without_rig(&floors, Settings::FULL).map_err(wrong)?;
        let calibration = &self.rig.calibration;
        let mut recording = Recording::read(self.dataset, None, calibration).map_err(wrong)?;
        recording.shots = recording.shots.into_iter().step_by(self.every.get()).collect();
        let truth = Trajectory::read(self.groundtruth).map_err(wrong)?;
        if !recording.shots.iter().any(|shot| truth.at(shot.timestamp_ns).is_some()) {
            let dataset = self.dataset.display();
            return Err(wrong_in(
                self.groundtruth.display(),
                format!("no pose at the time of any frame of {dataset}"),
            ));
        }
        let odometry = self.odometry.map(Trajectory::read).transpose().map_err(wrong)?;
        let folder = tempfile::tempdir().map_err(wrong)?;
        let imu = recording.imu.take();
        let job = Job {
            floors: &floors,
            calibration,
            mount: self.rig.mount,
            imu: imu.as_ref(),
            heights: heights(self.camera_height, None)?,
            truth: &truth,
            floor: self.true_floor(&floors)?,
            evidence: folder.path(),
        };
        let journal =
            Journal::open(&folder.path().join("frames.jsonl"), HashMap::new(), |_| false).map_err(wrong)?;
        let jobs = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let records = localize(&job, &recording.shots, &journal, jobs, &Silent).map_err(wrong)?;
        let followed =
            sequence::follow(&job, &records, &mut locator, odometry.as_ref(), &Silent).map_err(wrong)?;
        let judge = Judge { layers: locator.layers(), floor: job.floor };
        let frames = records.iter().zip(&followed.estimates);
        let frames: Vec<_> = frames
            .map(|(record, estimate)| JudgedFrame::new(record, estimate.as_ref(), &judge, &truth))
            .collect();
        Ok(Columns::of(&frames))
    }

    fn true_floor(&self, floors: &[SiteFloor<'_>]) -> PyResult<usize> {
        let names: Vec<&str> = floors.iter().filter_map(SiteFloor::name).collect();
        let there = names.join(", ");
        match self.floor {
            Some(wanted) => names.iter().position(|name| *name == wanted).ok_or_else(|| {
                wrong_in("floor", format!("{} has no floor {wanted:?}, but {there}", self.site.name))
            }),
            None if floors.len() == 1 => Ok(0),
            None => Err(wrong_in("floor", format!("which one does the truth lie on: {there}?"))),
        }
    }
}

impl Columns {
    fn of(frames: &[JudgedFrame<'_>]) -> Self {
        let truth = |frame: &JudgedFrame<'_>| {
            frame.truth.map_or([f64::NAN; 3], |pose| [pose.position.x, pose.position.y, pose.heading_deg()])
        };
        let single = |frame: &JudgedFrame<'_>| place(frame.record.single.first());
        let track = |frame: &JudgedFrame<'_>| place(frame.track.as_ref());
        let error = |frame: &JudgedFrame<'_>, row: usize| {
            let Misses { metres, degrees } = frame.misses[row];
            if frame.truth.is_some() { [metres, degrees] } else { [f64::NAN; 2] }
        };
        let column = |of: &dyn Fn(&JudgedFrame<'_>) -> f64| frames.iter().map(of).collect::<Vec<f64>>();
        let numbers = vec![
            ("true_x", column(&|frame| truth(frame)[0])),
            ("true_y", column(&|frame| truth(frame)[1])),
            ("true_heading_deg", column(&|frame| truth(frame)[2].rem_euclid(360.0))),
            ("x", column(&|frame| single(frame)[0])),
            ("y", column(&|frame| single(frame)[1])),
            ("heading_deg", column(&|frame| single(frame)[2])),
            ("probability", column(&|frame| f64::from(frame.record.probability()))),
            ("error_m", column(&|frame| error(frame, SINGLE)[0])),
            ("error_deg", column(&|frame| error(frame, SINGLE)[1])),
            ("track_x", column(&|frame| track(frame)[0])),
            ("track_y", column(&|frame| track(frame)[1])),
            ("track_heading_deg", column(&|frame| track(frame)[2])),
            (
                "track_probability",
                column(&|frame| frame.estimate.map_or(0.0, |estimate| f64::from(estimate.probability))),
            ),
            ("track_error_m", column(&|frame| error(frame, TRACK)[0])),
            ("track_error_deg", column(&|frame| error(frame, TRACK)[1])),
        ];
        Self {
            timestamp_ns: frames.iter().map(|frame| frame.record.timestamp_ns).collect(),
            numbers,
            problem: frames.iter().map(|frame| frame.record.problem.clone()).collect(),
        }
    }
}

/// Rows of [`compass_host::evaluate::judged::ROWS`].
const SINGLE: usize = 0;
const TRACK: usize = 1;

/// x, y and heading; NaN without a pose.
fn place(found: Option<&Found>) -> [f64; 3] {
    found.map_or([f64::NAN; 3], |found| {
        let [x, y] = found.position();
        [x, y, found.heading_deg().rem_euclid(360.0)]
    })
}
