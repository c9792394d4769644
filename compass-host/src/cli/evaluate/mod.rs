//! `compass evaluate`: a recording frame by frame and as a sequence, against the truth.

use super::exit::Outcome;
use super::heights::HeightArgs;
use super::notes::note;
use super::progress::Bars;
use super::up::MountOption;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use compass_core::Settings;
use compass_host::calibration::{Calibration, CameraNames};
use compass_host::dataset::recording::{Recording, Shot, Source, Topics};
use compass_host::dataset::trajectory::Trajectory;
use compass_host::dataset::tum::{self, Pose};
use compass_host::evaluate::judged::{JudgedFrame, ROWS, count_up_sources, mean_milliseconds};
use compass_host::evaluate::report::{self, ReportData};
use compass_host::evaluate::sequence::Followed;
use compass_host::evaluate::{
    Coverage, EvaluateError, Evidence, Fingerprint, FrameErrors, Job, Journal, Judge, Misses, Record, Row,
    largest_errors, localize, sequence,
};
use compass_host::input;
use compass_host::locator::Locator;
use compass_host::output::{Decimal, create_dir, write_file};
use compass_host::progress::Progress as _;
use compass_host::site_file::{SiteFile, SiteFloor};
use compass_host::wall_check::WallSummary;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

mod output;
mod recording;
mod started;

use output::{Frame, Output};
use started::Started;

/// The result of a part.
#[derive(Debug, Serialize)]
struct Part {
    part: usize,
    parts: usize,
    frames: usize,
    resumed: usize,
}

#[derive(Debug, clap::Args)]
pub(super) struct Evaluate {
    /// The site file
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// Camera calibration: a camera chain of Kalibr, .yaml, or what Basalt and ROS write
    #[arg(long, value_name = "FILE")]
    calib: PathBuf,
    /// Cameras of the calibration that are cam0 and cam1 [default: cam0,cam1]
    #[arg(long, value_name = "CAM0[,CAM1]")]
    cameras: Option<CameraNames>,
    /// The recording: cam0/data.csv lists the frames in cam0/data, likewise cam1, imu0/data.csv has accelerations; or a
    /// ROS 2 bag, a folder or a file
    #[arg(long, value_name = "DIR")]
    dataset: PathBuf,
    /// Topics of the bag; what is left off or empty is not used [default: as the calibration names them, else those that
    /// their names number]
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
    /// Localize only the I-th of N parts of the frames, 1 to N; --merge joins the parts
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with = "merge")]
    shard: Option<[usize; 2]>,
    /// Output folders to take finished frames from, of --shard with the same input; what none has is localized
    #[arg(long, value_name = "DIR,...", value_delimiter = ',')]
    merge: Vec<PathBuf>,
    /// Which side of cam0's image is up, within 45 degrees, where the accelerometer does not tell
    #[arg(long, value_enum, default_value_t = MountOption::Auto)]
    mount: MountOption,
    #[command(flatten)]
    heights: HeightArgs,
    /// Largest share of the frames, of the readings or of the true poses that may be left out; above it the exit status is
    /// 1
    #[arg(long, value_name = "SHARE", default_value = "0.5", value_parser = share)]
    max_left_out: f64,
    #[command(flatten)]
    json: JsonOption,
}

/// Parses a share, 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected 0 to 1".to_owned())
}

/// Parses the number of a part and how many there are.
fn shard(text: &str) -> Result<[usize; 2], String> {
    let numbers = text.split_once('/').and_then(|(part, of)| part.parse().ok().zip(of.parse().ok()));
    let good = numbers.filter(|(part, of)| (1..=*of).contains(part));
    good.map(|(part, of)| [part, of]).ok_or_else(|| format!("'{text}' is not I/N with I from 1 to N"))
}

impl Evaluate {
    pub(super) fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        // All input is read before any output is written.
        let file = SiteFile::read(&self.map)?;
        let floors = file.floors();
        let mut locator =
            Locator::without_rig(&floors, Settings::FULL).with_context(|| self.map.display().to_string())?;
        let floor = self.true_floor(&floors)?;
        let calibration = Calibration::load_cameras(&self.calib, &self.cameras.clone().unwrap_or_default())?;
        let mut recording =
            Recording::read_with_progress(&self.dataset, self.topics.as_ref(), &calibration, &Bars)?;
        recording.shots = recording.shots.into_iter().step_by(self.every.get()).collect();
        let truth = Trajectory::read(&self.groundtruth)?;
        recording.faults.merge(truth.faults().clone());
        self.check_times(&truth, &recording.shots)?;
        let [part, parts] = self.shard.unwrap_or([1, 1]);
        recording.shots = recording.shots.into_iter().skip(part - 1).step_by(parts).collect();
        let odometry = self.odometry.as_deref().map(Trajectory::read).transpose()?;
        let evidence = self.out.join("evidence");
        let imu = recording.imu.take();
        let job = Job {
            floors: &floors,
            calibration: &calibration,
            mount: self.mount.into(),
            imu: imu.as_ref(),
            heights: self.heights.prior(),
            truth: &truth,
            floor,
            evidence: &evidence,
        };
        let fingerprints = self.fingerprints(&file, &job, &recording.shots)?;
        let started = Started::new(&self.out);
        create_dir(&evidence)?;
        let journal = self.journal(&job, fingerprints)?;
        let resumed = journal.len();
        let jobs =
            self.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get);
        let records = localize(&job, &recording.shots, &journal, jobs, &Bars).inspect_err(|error| {
            if matches!(error, EvaluateError::NoneReadable(_)) {
                started.undo();
            }
        })?;
        if self.shard.is_some() {
            return self.tell_part(&records, resumed);
        }
        recording::complete(&mut recording, &calibration, &records, imu.is_some());
        let followed = sequence::follow(&job, &records, &mut locator, odometry.as_ref(), &Bars)?;
        let judge = Judge { layers: locator.layers(), floor };
        let frames: Vec<_> = records
            .iter()
            .zip(&followed.estimates)
            .map(|(record, estimate)| JudgedFrame::new(record, estimate.as_ref(), &judge, &truth))
            .collect();
        self.write(&job, &recording, &frames, resumed, &followed)?;
        recording::check_share(&recording, &records, self.max_left_out)?;
        Ok(Outcome::Done)
    }

    /// The frames that are finished, here and in other folders.
    fn journal(&self, job: &Job<'_>, fingerprints: HashMap<u64, String>) -> Result<Journal> {
        let is_whole = |record: &Record| {
            let evidence = || Evidence::fingerprint(&job.evidence_file(record.timestamp_ns));
            record.problem.is_some() || (record.evidence.is_some() && record.evidence == evidence())
        };
        let journal = Journal::open(&self.out.join("frames.jsonl"), fingerprints, is_whole)?;
        for folder in &self.merge {
            let evidence_of = |record: &Record| -> Result<bool, EvaluateError> {
                let Some(fingerprint) = &record.evidence else { return Ok(record.problem.is_some()) };
                let ours = job.evidence_file(record.timestamp_ns);
                let theirs = folder.join("evidence").join(ours.file_name().unwrap_or_default());
                Evidence::copy(&theirs, fingerprint, &ours)
            };
            let [lines, taken] = journal.merge(&folder.join("frames.jsonl"), evidence_of)?;
            if taken < lines {
                let folder = folder.display();
                note(&format!(
                    "{folder}: {taken} of {lines} frames are of this input and this build, and not known yet"
                ));
            }
        }
        Ok(journal)
    }

    /// Says how far a part is.
    fn tell_part(&self, records: &[Record], resumed: usize) -> Result<Outcome> {
        let [part, parts] = self.shard.unwrap_or([1, 1]);
        let frames = records.len();
        let summary = format!("part {part} of {parts}: {frames} frames, {resumed} from an earlier run\n");
        self.json.emit(&Part { part, parts, frames, resumed }, &summary)?;
        Ok(Outcome::Done)
    }

    /// Checks that poses and frames are of one time.
    fn check_times(&self, truth: &Trajectory, shots: &[Shot]) -> Result<()> {
        if shots.iter().any(|shot| truth.at(shot.timestamp_ns).is_some()) {
            return Ok(());
        }
        let (poses, frames) = (self.groundtruth.display(), self.dataset.display());
        let seconds = |ns: u64| ns as f64 / 1e9;
        let spans = match (truth.span(), shots.first(), shots.last()) {
            (Some([from, to]), Some(first), Some(last)) => format!(
                " (poses from {} to {} s, frames from {} to {} s)",
                seconds(from),
                seconds(to),
                seconds(first.timestamp_ns),
                seconds(last.timestamp_ns)
            ),
            _ => String::new(),
        };
        bail!("{poses}: no pose at the time of any frame of {frames}{spans}; are they of one recording?")
    }

    /// Index of the floor of the ground truth.
    fn true_floor(&self, floors: &[SiteFloor<'_>]) -> Result<usize> {
        let map = self.map.display();
        let names: Vec<&str> = floors.iter().filter_map(SiteFloor::name).collect();
        match &self.floor {
            Some(wanted) => names
                .iter()
                .position(|name| name == wanted)
                .with_context(|| format!("{map}: has no floor '{wanted}'; there are: {}", names.join(", "))),
            None if floors.len() == 1 => Ok(0),
            None => bail!(
                "{map}: has {} floors; tell with --floor which one the truth lies on: {}",
                floors.len(),
                names.join(", ")
            ),
        }
    }

    /// Fingerprint of everything that the results of each frame depend on.
    fn fingerprints(&self, file: &SiteFile, job: &Job<'_>, shots: &[Shot]) -> Result<HashMap<u64, String>> {
        let read = |path: &Path| {
            input::read_whole(path).with_context(|| format!("{}: cannot be read", path.display()))
        };
        let options = format!("{:?} {:?} {:?}", self.mount, self.heights, self.floor);
        let common = Fingerprint::new()
            .of(file.as_bytes())
            .of(&read(&self.calib)?)
            .of(&read(&self.groundtruth)?)
            .of(options.as_bytes());
        let steps = Bars.begin(shots.len(), "reading frames");
        let print = |shot: &Shot| {
            let images =
                shot.images.iter().fold(common, |print, image| match image.as_ref().map(Source::contents) {
                    None => print.of(b"none"),
                    Some(Ok(bytes)) => print.of(&bytes),
                    Some(Err(error)) => print.of(error.to_string().as_bytes()),
                });
            steps.step();
            let gravity = job.gravity(shot.timestamp_ns);
            (shot.timestamp_ns, images.of(format!("{gravity:?}").as_bytes()).text())
        };
        Ok(shots.par_iter().map(print).collect())
    }

    /// Writes trajectories, report and result.
    fn write(
        &self,
        job: &Job<'_>,
        recording: &Recording,
        frames: &[JudgedFrame<'_>],
        resumed: usize,
        followed: &Followed,
    ) -> Result<()> {
        let single = frames
            .iter()
            .filter_map(|frame| Some(sequence::pose(frame.record, frame.record.single.first()?)));
        write_trajectory(&self.out.join("single.tum"), single)?;
        let track = frames
            .iter()
            .filter(|frame| frame.record.problem.is_none())
            .filter_map(|frame| Some(sequence::pose(frame.record, &frame.track?)));
        write_trajectory(&self.out.join("track.tum"), track)?;
        let scored: Vec<_> = frames.iter().filter(|frame| frame.truth.is_some()).collect();
        let misses = |row: usize| -> Vec<Misses> { scored.iter().map(|frame| frame.misses[row]).collect() };
        let rows: Vec<Row> = ROWS.iter().enumerate().map(|(n, name)| Row::of(name, &misses(n))).collect();
        let sure =
            scored.iter().filter(|frame| frame.estimate.is_some_and(|e| e.probability >= sequence::SURE));
        let sure = Row::of("track, sure", &sure.map(|frame| frame.misses[1]).collect::<Vec<_>>());
        let milliseconds = mean_milliseconds(frames, followed.milliseconds);
        let walls = &followed.walls;
        walls.write(&self.out.join("walls.csv"))?;
        let path = self.out.join("report.html");
        let shown_floor = job.floors.get(job.floor).context("no such floor")?;
        let plan = shown_floor.floor.and_then(|floor| floor.plan(0)).context("the floor has no plan")?;
        let shown: Vec<FrameErrors> = frames.iter().map(JudgedFrame::errors).collect();
        let right: Vec<_> =
            frames.iter().map(|frame| frame.truth.map(|_| frame.misses[0].is_right())).collect();
        let data = ReportData {
            title: "COMPASS on a recording",
            plan,
            rows: &rows,
            frames: &shown,
            right: &right,
            milliseconds: &milliseconds,
            walls,
            largest_errors: &largest_errors::draw(&self.out, &shown, &recording.shots)?,
            faults: &recording.faults,
            notes: &recording.notes,
        };
        report::write(&self.out, &data)?;
        let output = Output {
            frames: frames.len(),
            resumed,
            scored: scored.len(),
            unseen: frames.iter().filter(|frame| frame.record.problem.is_some()).count(),
            left_out: (&recording.faults).into(),
            notes: &recording.notes,
            topics: recording.topics.as_ref().map(Topics::to_string),
            up_from: count_up_sources(frames),
            coverage: Coverage::of(frames),
            rows: rows.into_iter().chain([sure]).collect(),
            milliseconds: milliseconds.iter().map(|(stage, ms)| (stage.clone(), Decimal(*ms))).collect(),
            walls: WallSummary::of(walls),
            report: path,
            results: frames.iter().map(|frame| Frame::of(frame, job.floors)).collect(),
        };
        self.json.emit(&output, &output.summary())
    }
}

fn write_trajectory(path: &Path, poses: impl Iterator<Item = Pose>) -> Result<()> {
    Ok(write_file(path, tum::text(&poses.collect::<Vec<_>>()).as_bytes())?)
}
