//! Localizes the newest pair of frames, one at a time.

use super::answer::{Level, candidates_message, diagnosis, map_to_odom, pose_message};
use super::messages::{CompressedImage, Header, Image, Odometry, Time};
use super::options::Options;
use super::outputs::Outputs;
use crate::calibration::Calibration;
use crate::dataset::bag::{compressed_frame, raw_frame};
use crate::doubt;
use crate::dual_image;
use crate::frame::Frame;
use crate::locator::Locator;
use crate::site_file::SiteFloor;
use crate::up_by_plan::{Placed, locate_by_plan};
use compass_core::{Motion, Settings, Track};
use std::sync::{Condvar, Mutex};
use std::time::Instant;

/// The message of a camera.
#[derive(Debug)]
pub(super) enum Picture {
    /// With the pixels as they are.
    Raw(Image),
    /// With an image file.
    Compressed(CompressedImage),
}

impl Picture {
    /// When it was taken.
    #[must_use]
    pub(super) const fn stamp(&self) -> Time {
        match self {
            Self::Raw(image) => image.header.stamp,
            Self::Compressed(image) => image.header.stamp,
        }
    }

    fn frame(&self) -> Result<Frame, String> {
        match self {
            Self::Raw(image) => raw_frame(
                (image.width, image.height),
                &image.encoding,
                image.is_bigendian != 0,
                image.step,
                &image.data,
            ),
            Self::Compressed(image) => compressed_frame(&image.format, &image.data),
        }
    }
}

/// Sizes of the frames of cam0 and cam1.
type Sizes = [Option<(u32, u32)>; 2];

/// What is to be localized.
#[derive(Debug)]
pub(super) struct Job {
    /// When the frames were taken, nanoseconds.
    pub(super) stamp_ns: u64,
    /// The same as it came.
    pub(super) stamp: Time,
    /// The frames of cam0 and cam1.
    pub(super) pictures: [Option<Picture>; 2],
    /// The odometry nearest before.
    pub(super) odometry: Option<Odometry>,
    /// When the last of the messages came.
    pub(super) arrived: Instant,
}

/// The newest job, which waits until the former is done; those that are overtaken are dropped and counted.
#[derive(Debug, Default)]
pub(super) struct Slot {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    job: Option<Job>,
    dropped: u64,
    relocalize: bool,
    is_over: bool,
}

impl Slot {
    fn with<R>(&self, change: impl FnOnce(&mut State) -> R) -> R {
        let mut state = self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let result = change(&mut state);
        self.changed.notify_one();
        result
    }

    /// Puts a job in place of one that waits.
    pub(super) fn put(&self, job: Job) {
        self.with(|state| state.dropped += u64::from(state.job.replace(job).is_some()));
    }

    /// Forgets the track, and says the initial pose anew.
    pub(super) fn relocalize(&self) {
        self.with(|state| state.relocalize = true);
    }

    /// Ends the worker.
    pub(super) fn end(&self) {
        self.with(|state| state.is_over = true);
    }

    /// Jobs that were overtaken.
    #[must_use]
    pub(super) fn dropped(&self) -> u64 {
        self.with(|state| state.dropped)
    }

    /// Waits for a job, and whether to forget what was; `None` at the end.
    fn take(&self) -> Option<(Job, bool)> {
        let mut state = self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        loop {
            if state.is_over {
                return None;
            }
            if let Some(job) = state.job.take() {
                return Some((job, std::mem::take(&mut state.relocalize)));
            }
            state = self.changed.wait(state).unwrap_or_else(|poisoned| poisoned.into_inner());
        }
    }
}

/// What the last frames led to, for the diagnosis.
#[derive(Debug, Clone)]
pub(super) struct Report {
    /// How good it is.
    pub(super) level: Level,
    /// In words.
    pub(super) message: String,
    /// Pairs localized so far.
    pub(super) answered: u64,
    /// Of those, poses said.
    pub(super) said: u64,
    /// Milliseconds from the arrival of the frames to the answer.
    pub(super) milliseconds: f64,
    /// Probability of the last answer.
    pub(super) probability: f32,
}

/// Localizes jobs until the slot ends.
pub(super) struct Worker<'a, 'o> {
    options: &'o Options,
    floors: &'o [SiteFloor<'a>],
    calibration: &'o Calibration,
    outputs: &'o Outputs,
    locators: Vec<(Sizes, Locator<'a>)>,
    track: Box<Track>,
    /// Stamp and odometry of the frames before.
    before: Option<(u64, Option<Odometry>)>,
    initial_said: bool,
    report: Report,
}

impl std::fmt::Debug for Worker<'_, '_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Worker").field("report", &self.report).finish_non_exhaustive()
    }
}

impl<'a, 'o> Worker<'a, 'o> {
    /// With nothing seen yet.
    #[must_use]
    pub(super) fn new(
        options: &'o Options,
        floors: &'o [SiteFloor<'a>],
        calibration: &'o Calibration,
        outputs: &'o Outputs,
    ) -> Self {
        let report = Report {
            level: Level::Stale,
            message: "no frames yet".to_owned(),
            answered: 0,
            said: 0,
            milliseconds: 0.0,
            probability: 0.0,
        };
        let (locators, track) = (Vec::new(), Box::new(Track::new()));
        Self {
            options,
            floors,
            calibration,
            outputs,
            locators,
            track,
            before: None,
            initial_said: false,
            report,
        }
    }

    /// Works until the slot ends.
    pub(super) fn run(mut self, slot: &Slot) {
        while let Some((job, relocalize)) = slot.take() {
            if relocalize {
                (*self.track, self.before, self.initial_said) = (Track::new(), None, false);
            }
            if let Err(problem) = self.answer(&job) {
                (self.report.level, self.report.message) = (Level::Error, problem);
            }
            self.report.answered += 1;
            self.report.milliseconds = job.arrived.elapsed().as_secs_f64() * 1e3;
            self.diagnose(job.stamp, slot);
        }
    }

    fn answer(&mut self, job: &Job) -> Result<(), String> {
        let Self { options, floors, calibration, outputs, locators, track, before, initial_said, report } =
            self;
        let read = |camera: usize| {
            let picture = job.pictures[camera].as_ref();
            picture
                .map(Picture::frame)
                .transpose()
                .map_err(|problem| format!("the frame of cam{camera}: {problem}"))
        };
        let (frames, _) = dual_image::split(calibration, [read(0)?, read(1)?]);
        let frames = frames.each_ref().map(Option::as_ref);
        let locator = locator_for(locators, floors, calibration, frames)?;
        let mut segmented = locator.segment(frames).map_err(|error| error.to_string())?;
        let ups = options.mount.candidates(&mut segmented);
        let placed =
            match ups.and_then(|ups| locate_by_plan(segmented, &ups, options.heights, &options.place)) {
                Ok(placed) => placed,
                Err(error) => {
                    let level = if error.is_answer() { Level::Warning } else { Level::Error };
                    (report.level, report.probability) = (level, 0.0);
                    report.message = doubt::with_fault(error.to_string(), doubt::of_frames(frames));
                    return Ok(());
                }
            };
        let Placed { mut seen, fix, .. } = placed;
        let (seconds, motion) = since(before.as_ref(), job);
        let estimate = seen.track(track, &fix, seconds, motion);
        *before = Some((job.stamp_ns, job.odometry.clone()));
        report.probability = fix.probability();
        let header = Header { stamp: job.stamp, frame_id: options.map_frame.clone() };
        outputs.candidates(candidates_message(header.clone(), fix.poses()));
        let said = fix
            .best()
            .zip(fix.covariance())
            .filter(|_| f64::from(fix.probability()) >= options.min_probability);
        let Some((best, covariance)) = said else {
            report.level = Level::Warning;
            report.message =
                doubt::with_fault(doubt::of_fix(&fix, options.min_probability), doubt::of_frames(frames));
            return Ok(());
        };
        (report.level, report.said) = (Level::Good, report.said + 1);
        report.message = format!("on floor {}", fix.floor_name().unwrap_or_default());
        let message = pose_message(header.clone(), best, &covariance);
        if options.initial_pose && !*initial_said && fix.is_sure() {
            outputs.initial_pose(message.clone());
            *initial_said = true;
        }
        outputs.pose(message);
        if let Some(odometry) = &job.odometry {
            // The track knows where the robot is if a single frame is mistaken.
            let pose = estimate.map_or(*best, |estimate| estimate.pose);
            outputs.transform(map_to_odom(header, &odometry.header.frame_id, &pose, &odometry.pose.pose));
        }
        Ok(())
    }

    fn diagnose(&self, stamp: Time, slot: &Slot) {
        let Report { level, message, answered, said, milliseconds, probability } = &self.report;
        let values = [
            ("answered", answered.to_string()),
            ("said", said.to_string()),
            ("dropped", slot.dropped().to_string()),
            ("milliseconds", format!("{milliseconds:.1}")),
            ("probability", format!("{probability:.3}")),
        ];
        self.outputs.diagnosis(diagnosis(stamp, &self.options.name, *level, message, values));
    }
}

/// The locator for frames of these sizes, made when they come first.
fn locator_for<'l, 'a>(
    locators: &'l mut Vec<(Sizes, Locator<'a>)>,
    floors: &[SiteFloor<'a>],
    calibration: &Calibration,
    frames: [Option<&Frame>; 2],
) -> Result<&'l mut Locator<'a>, String> {
    let sizes = frames.map(|frame| frame.map(|frame| (frame.width(), frame.height())));
    let known = locators.iter().position(|(known, _)| *known == sizes);
    let number = match known {
        Some(number) => number,
        None => {
            let rig = calibration.rig(sizes).map_err(|error| error.to_string())?;
            let locator = Locator::new(floors, rig, Settings::FULL).map_err(|error| error.to_string())?;
            // One or two sizes at a time: a stranger who sends many does not fill the memory.
            locators.truncate(1);
            locators.push((sizes, locator));
            locators.len() - 1
        }
    };
    Ok(&mut locators[number].1)
}

/// Seconds since the frames before, and the motion that odometry tells; of frames from the past none.
fn since(before: Option<&(u64, Option<Odometry>)>, job: &Job) -> (f32, Option<Motion>) {
    let Some((stamp_ns, odometry)) = before else { return (0.0, None) };
    let seconds = job.stamp_ns.saturating_sub(*stamp_ns) as f64 / 1e9;
    let motion = odometry.as_ref().zip(job.odometry.as_ref()).map(|(before, now)| {
        let (from, to) = (&before.pose.pose, &now.pose.pose);
        let (sin, cos) = from.orientation.yaw().sin_cos();
        let [x, y] = [to.position.x - from.position.x, to.position.y - from.position.y];
        let turn = to.orientation.yaw() - from.orientation.yaw();
        let turn = turn.sin().atan2(turn.cos());
        Motion {
            forward_m: (cos * x + sin * y) as f32,
            left_m: (cos * y - sin * x) as f32,
            turn: turn as f32,
        }
    });
    let finite =
        |motion: &Motion| [motion.forward_m, motion.left_m, motion.turn].iter().all(|v| v.is_finite());
    (seconds as f32, motion.filter(finite))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(stamp_ns: u64) -> Job {
        let stamp = Time { sec: 0, nanosec: u32::try_from(stamp_ns).unwrap() };
        Job { stamp_ns, stamp, pictures: [None, None], odometry: None, arrived: Instant::now() }
    }

    #[test]
    fn the_newest_job_is_taken_and_others_are_counted() {
        let slot = Slot::default();
        (0..4).for_each(|stamp| slot.put(job(stamp)));
        slot.relocalize();
        let (taken, relocalize) = slot.take().unwrap();
        assert_eq!((taken.stamp_ns, relocalize, slot.dropped()), (3, true, 3));
        slot.put(job(9));
        assert!(!slot.take().unwrap().1);
        slot.end();
        assert!(slot.take().is_none());
    }
}
