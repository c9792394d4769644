//! Frames compared with the ground truth.

use super::frame_errors::FrameErrors;
use super::record::{Found, PAPER, Record};
use super::row::{Judge, Misses};
use crate::dataset::trajectory::Trajectory;
use crate::dataset::tum::Pose;
use compass_core::pose::track::Estimate;
use std::collections::BTreeMap;

/// The localization methods, in the order of the report.
pub const ROWS: [&str; 7] = ["single", "track", "oracle", PAPER[0].0, PAPER[1].0, PAPER[2].0, PAPER[3].0];

/// A frame with its ground truth and its errors.
#[derive(Debug)]
pub struct JudgedFrame<'a> {
    /// The record of the frame.
    pub record: &'a Record,
    /// The track estimate after the frame.
    pub estimate: Option<&'a Estimate>,
    /// The pose of the track.
    pub track: Option<Found>,
    /// The true pose, where there is one.
    pub truth: Option<Pose>,
    /// The errors by row of [`ROWS`].
    pub misses: [Misses; ROWS.len()],
    /// Compares layers with the true floor.
    pub judge: &'a Judge<'a>,
}

impl<'a> JudgedFrame<'a> {
    /// Compares a record and the track with the ground truth.
    #[must_use]
    pub fn new(
        record: &'a Record,
        estimate: Option<&'a Estimate>,
        judge: &'a Judge<'a>,
        truth: &Trajectory,
    ) -> Self {
        let truth = truth.at(record.timestamp_ns);
        let track = estimate.map(|estimate| Found::from(&estimate.pose));
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

    /// The errors as the report shows them.
    #[must_use]
    pub fn errors(&self) -> FrameErrors {
        let here = |found: Option<&Found>| found.filter(|f| self.judge.is_on_floor(f)).map(Found::position);
        let known = |error: f64| if self.truth.is_some() { error } else { f64::NAN };
        FrameErrors {
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
}

/// Number of frames by source of the up vector, keyed by [`UpFrom::name`](crate::up::UpFrom::name).
#[must_use]
pub fn count_up_sources(frames: &[JudgedFrame<'_>]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for frame in frames.iter().filter(|frame| frame.record.up.is_some()) {
        *counts.entry(frame.record.up_from.name()).or_default() += 1;
    }
    counts
}

/// Mean milliseconds by stage, each over the frames that reached it, and by step of the track.
#[must_use]
pub fn mean_milliseconds(frames: &[JudgedFrame<'_>], track_ms: f64) -> Vec<(String, f64)> {
    let mut sums: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for (stage, ms) in frames.iter().flat_map(|frame| &frame.record.milliseconds) {
        let sum = sums.entry(stage).or_default();
        *sum = (sum.0 + ms, sum.1 + 1);
    }
    let mean = |(stage, (ms, count)): (&str, (f64, usize))| (stage.to_owned(), ms / count as f64);
    sums.into_iter().map(mean).chain([("track".to_owned(), track_ms)]).collect()
}
