//! `compass evaluate`: a recording frame by frame and as a sequence, against the truth.

use super::Outcome;
use super::cameras::height;
use anyhow::{Context as _, Result, bail};
use compass_core::pose::track::Estimate;
use compass_host::as_built::WallsSeen;
use compass_host::calibration::Calibration;
use compass_host::dataset::recording::{Recording, Shot, Source, Topics};
use compass_host::dataset::trajectory::Trajectory;
use compass_host::dataset::tum::{self, Pose};
use compass_host::evaluate::report::{self, Shown, Story};
use compass_host::evaluate::sequence::Followed;
use compass_host::evaluate::{
    Found, Job, Journal, Judge, Misses, PAPER, Record, Row, localize, sequence, worst,
};
use compass_host::eyes::Mount;
use compass_host::locator::Locator;
use compass_host::output::{Decimal, JsonOption, create_dir, write_file};
use compass_host::site_file::{SiteFile, SiteFloor};
use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

mod output;

use output::{Frame, Output, Placed, Tracked};

/// The ways of localizing, in the order of the report.
const ROWS: [&str; 7] = ["single", "track", "oracle", PAPER[0].0, PAPER[1].0, PAPER[2].0, PAPER[3].0];
#[derive(Debug, clap::Args)]
pub(super) struct Evaluate {
    /// The site file
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// Camera calibration: a Kalibr camera-imu chain .yaml
    #[arg(long, value_name = "FILE")]
    calib: PathBuf,
    /// The recording: cam0/data.csv lists the frames in cam0/data, likewise cam1, imu0/data.csv has accelerations; or a
    /// ROS 2 bag
    #[arg(long, value_name = "DIR")]
    dataset: PathBuf,
    /// Topics of the bag; what is left off or empty is not used [default: as the calibration names them, else the only
    /// ones, in the order of their names]
    #[arg(long, value_name = "CAM0,CAM1[,IMU]")]
    topics: Option<Topics>,
    /// True poses of cam0 in the map: timestamp tx ty tz qx qy qz qw
    #[arg(long, value_name = "TUM")]
    groundtruth: PathBuf,
    /// Where to write report.html, single.tum and track.tum; a run that was interrupted continues there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Floor of the site that the truth lies on [default: the only one]
    #[arg(long, value_name = "NAME")]
    floor: Option<String>,
    /// Poses of cam0 in any frame whose z points up, for the track: motion between frames is taken from them
    #[arg(long, value_name = "TUM")]
    odometry: Option<PathBuf>,
    /// Take only every N-th frame
    #[arg(long, value_name = "N", default_value = "1")]
    every: NonZeroUsize,
    /// Frames at a time [default: one per core]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Which side of cam0's image is up, within 45 degrees, where the accelerometer does not tell
    #[arg(long, value_enum, default_value_t = Mount::Auto)]
    mount: Mount,
    /// Height of cam0 above the floor in metres [default: estimated]
    #[arg(long, value_name = "M", value_parser = height, allow_hyphen_values = true)]
    camera_height: Option<f32>,
    #[command(flatten)]
    json: JsonOption,
}

impl Evaluate {
    pub(super) fn run(&self) -> Result<Outcome> {
        // Everything is read before anything is written.
        let file = SiteFile::read(&self.map)?;
        let storeys = file.storeys();
        let mut locator = Locator::new(&storeys).with_context(|| self.map.display().to_string())?;
        let floor = self.floor(&storeys)?;
        let calibration = Calibration::load(&self.calib)?;
        let mut recording = Recording::read(&self.dataset, self.topics.as_ref(), &calibration)?;
        recording.shots = recording.shots.into_iter().step_by(self.every.get()).collect();
        let shots = &recording.shots;
        let truth = Trajectory::read(&self.groundtruth)?;
        if shots.iter().all(|shot| truth.at(shot.timestamp_ns).is_none()) {
            let (truth, frames) = (self.groundtruth.display(), self.dataset.display());
            bail!("{truth}: no pose at the time of any frame of {frames}; are they of one recording?");
        }
        let odometry = self.odometry.as_deref().map(Trajectory::read).transpose()?;
        let evidence = self.out.join("evidence");
        let job = Job {
            storeys: &storeys,
            calibration: &calibration,
            mount: self.mount,
            imu: recording.imu.as_ref(),
            height_m: self.camera_height,
            truth: &truth,
            floor,
            evidence: &evidence,
        };
        let fingerprints = self.fingerprints(&file, &job, shots)?;
        create_dir(&evidence)?;
        let is_whole =
            |record: &Record| record.problem.is_some() || job.evidence_file(record.timestamp_ns).is_file();
        let journal = Journal::open(&self.out.join("frames.jsonl"), fingerprints, is_whole)?;
        let resumed = journal.len();
        let jobs =
            self.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get);
        let records = localize(&job, shots, &journal, jobs)?;
        let followed = sequence::follow(&job, &records, &mut locator, odometry.as_ref())?;
        let judge = Judge { layers: locator.layers(), floor };
        let finished: Vec<_> = records
            .iter()
            .zip(&followed.estimates)
            .map(|(record, estimate)| Finished::new(record, estimate.as_ref(), &judge, &truth))
            .collect();
        self.write(&job, &recording, &finished, resumed, &followed)?;
        Ok(Outcome::Done)
    }

    /// The number of the floor that the truth lies on.
    fn floor(&self, storeys: &[SiteFloor<'_>]) -> Result<usize> {
        let map = self.map.display();
        let names: Vec<&str> = storeys.iter().filter_map(SiteFloor::name).collect();
        match &self.floor {
            Some(wanted) => names
                .iter()
                .position(|name| name == wanted)
                .with_context(|| format!("{map}: has no floor '{wanted}'; there are: {}", names.join(", "))),
            None if storeys.len() == 1 => Ok(0),
            None => bail!(
                "{map}: has {} floors; tell with --floor which one the truth lies on: {}",
                storeys.len(),
                names.join(", ")
            ),
        }
    }

    /// What the results of each frame depend on.
    fn fingerprints(&self, file: &SiteFile, job: &Job<'_>, shots: &[Shot]) -> Result<HashMap<u64, String>> {
        let read =
            |path: &Path| std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()));
        let options = format!("{:?} {:?} {:?}", self.mount, self.camera_height, self.floor);
        let common = compass_host::evaluate::Fingerprint::new()
            .of(file.as_bytes())
            .of(&read(&self.calib)?)
            .of(&read(&self.groundtruth)?)
            .of(options.as_bytes());
        let print = |shot: &Shot| {
            let images = shot.images.each_ref().map(|image| image.as_ref().map(Source::identity));
            let gravity = job.gravity(shot.timestamp_ns);
            (shot.timestamp_ns, common.of(format!("{images:?} {gravity:?}").as_bytes()).text())
        };
        Ok(shots.iter().map(print).collect())
    }

    /// Writes trajectories, report and result.
    fn write(
        &self,
        job: &Job<'_>,
        recording: &Recording,
        finished: &[Finished<'_>],
        resumed: usize,
        followed: &Followed,
    ) -> Result<()> {
        let single = finished
            .iter()
            .filter_map(|frame| Some(sequence::pose(frame.record, frame.record.single.first()?)));
        write_trajectory(&self.out.join("single.tum"), single)?;
        let track = finished
            .iter()
            .filter(|frame| frame.record.problem.is_none())
            .filter_map(|frame| Some(sequence::pose(frame.record, &frame.track?)));
        write_trajectory(&self.out.join("track.tum"), track)?;
        let scored: Vec<_> = finished.iter().filter(|frame| frame.truth.is_some()).collect();
        let misses = |row: usize| -> Vec<Misses> { scored.iter().map(|frame| frame.misses[row]).collect() };
        let rows: Vec<Row> = ROWS.iter().enumerate().map(|(n, name)| Row::of(name, &misses(n))).collect();
        let sure =
            scored.iter().filter(|frame| frame.estimate.is_some_and(|e| e.probability >= sequence::SURE));
        let sure = Row::of("track, sure", &sure.map(|frame| frame.misses[1]).collect::<Vec<_>>());
        let milliseconds = means(finished, followed.milliseconds);
        let walls = &followed.walls;
        walls.write(&self.out.join("walls.csv"))?;
        let path = self.out.join("report.html");
        let storey = job.storeys.get(job.floor).context("no such floor")?;
        let plan = storey.floor.and_then(|floor| floor.plan(0)).context("the floor has no plan")?;
        let shown: Vec<Shown> = finished.iter().map(Finished::shown).collect();
        let right: Vec<_> =
            finished.iter().map(|frame| frame.truth.map(|_| frame.misses[0].is_right())).collect();
        let story = Story {
            title: "COMPASS on a recording",
            plan,
            rows: &rows,
            frames: &shown,
            right: &right,
            milliseconds: &milliseconds,
            walls,
            worst: &worst::draw(&self.out, &shown, &recording.shots)?,
        };
        report::write(&self.out, &story)?;
        let output = Output {
            frames: finished.len(),
            resumed,
            scored: scored.len(),
            unseen: finished.iter().filter(|frame| frame.record.problem.is_some()).count(),
            topics: recording.topics.as_ref().map(Topics::to_string),
            up_from: count(finished),
            rows: rows.into_iter().chain([sure]).collect(),
            milliseconds: milliseconds.iter().map(|(stage, ms)| (stage.clone(), Decimal(*ms))).collect(),
            walls: WallsSeen::of(walls),
            report: path,
            results: finished.iter().map(|frame| frame.output(job.storeys)).collect(),
        };
        self.json.emit(&output, &output.summary())
    }
}

fn write_trajectory(path: &Path, poses: impl Iterator<Item = Pose>) -> Result<()> {
    write_file(path, tum::text(&poses.collect::<Vec<_>>()).as_bytes())
}

/// How many frames have their up vector from what.
fn count(finished: &[Finished<'_>]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for frame in finished.iter().filter(|frame| frame.record.up.is_some()) {
        *counts.entry(frame.record.up_from.name()).or_default() += 1;
    }
    counts
}

/// Mean milliseconds by stage, over the frames that came so far.
fn means(finished: &[Finished<'_>], track_ms: f64) -> Vec<(String, f64)> {
    let mut sums: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for (stage, ms) in finished.iter().flat_map(|frame| &frame.record.milliseconds) {
        let sum = sums.entry(stage).or_default();
        *sum = (sum.0 + ms, sum.1 + 1);
    }
    let mean = |(stage, (ms, count)): (&str, (f64, usize))| (stage.to_owned(), ms / count as f64);
    sums.into_iter().map(mean).chain([("track".to_owned(), track_ms)]).collect()
}

/// A frame with its truth and all that is off.
struct Finished<'a> {
    record: &'a Record,
    estimate: Option<&'a Estimate>,
    track: Option<Found>,
    truth: Option<Pose>,
    /// By row.
    misses: [Misses; ROWS.len()],
    judge: &'a Judge<'a>,
}

impl<'a> Finished<'a> {
    fn new(
        record: &'a Record,
        estimate: Option<&'a Estimate>,
        judge: &'a Judge<'a>,
        truth: &Trajectory,
    ) -> Self {
        let truth = truth.at(record.timestamp_ns);
        let track = estimate.map(|estimate| Found::from(&estimate.mode));
        let best = |found: &'a [Found]| found.first();
        let all = [
            best(&record.single),
            track.as_ref(),
            best(&record.oracle),
            record.paper[0].as_ref(),
            record.paper[1].as_ref(),
            record.paper[2].as_ref(),
            record.paper[3].as_ref(),
        ];
        let misses = all.map(|found| truth.map_or(Misses::ALL, |truth| judge.misses(found, &truth)));
        Self { record, estimate, track, truth, misses, judge }
    }

    fn shown(&self) -> Shown {
        let here = |found: Option<&Found>| found.filter(|f| self.judge.is_on_floor(f)).map(Found::position);
        let known = |error: f64| if self.truth.is_some() { error } else { f64::NAN };
        Shown {
            timestamp_ns: self.record.timestamp_ns,
            truth: self.truth.map(|truth| [truth.position.x, truth.position.y]),
            single: here(self.record.single.first()),
            track: here(self.track.as_ref()),
            metres: self.misses.iter().map(|misses| known(misses.metres)).collect(),
            degrees: self.misses.iter().map(|misses| known(misses.degrees)).collect(),
            margin: self.record.margin(),
            problem: self.record.problem.clone(),
        }
    }

    fn output<'b>(&'b self, storeys: &[SiteFloor<'b>]) -> Frame<'b> {
        let placed = |found: Option<&Found>, row: usize| {
            found.map(|found| {
                let layer = self.judge.layers.get(usize::from(found.layer));
                let storey = layer.and_then(|layer| storeys.get(usize::from(layer.floor)));
                let name = storey.and_then(SiteFloor::name).filter(|_| storeys.len() > 1);
                Placed::new(found, name, self.truth.map(|_| self.misses[row]))
            })
        };
        let single = &self.record.single;
        Frame {
            timestamp_ns: self.record.timestamp_ns,
            problem: self.record.problem.as_deref(),
            up_from: self.record.up.map(|_| self.record.up_from.name()),
            margin: Decimal(self.record.margin()),
            single: placed(single.first(), 0),
            track: placed(self.track.as_ref(), 1).zip(self.estimate).map(|(placed, estimate)| Tracked {
                placed,
                probability: Decimal(f64::from(estimate.probability)),
                spread_m: Decimal(f64::from(estimate.spread_m)),
            }),
            oracle: placed(self.record.oracle.first(), 2),
            paper_plain: placed(self.record.paper[0].as_ref(), 3),
            paper_centred: placed(self.record.paper[1].as_ref(), 4),
            paper_hit_type: placed(self.record.paper[2].as_ref(), 5),
            paper_range: placed(self.record.paper[3].as_ref(), 6),
        }
    }
}
