//! Localizing a recording, frame by frame and as a sequence, and holding the answers against the truth.
//!
//! frames -> one [`Record`] each, on all cores, kept in a [`Journal`] so that an interrupted run continues ->
//! the [track](sequence::follow) -> [`Row`]s of errors, one for each way of localizing.
//!
//! Beside the answer from the frame there are two more for each frame. The *oracle* is the same search with evidence
//! that the plan itself gives at the true pose: what it loses the matcher loses. The *paper's* is the five-channel
//! cosine of the descriptor of what was seen.

mod evidence_file;
mod journal;
mod oracle;
mod paper;
mod record;
pub mod report;
mod row;
pub mod sequence;
mod worker;
pub mod worst;

pub use evidence_file::Evidence;
pub use journal::{Fingerprint, Journal};
pub use oracle::sharp;
pub use paper::Paper;
pub use record::{Found, PAPER, Record};
pub use row::{Judge, Misses, Row};
pub use worker::Worker;

use crate::calibration::Calibration;
use crate::dataset::imu::{Gravity, Readings};
use crate::dataset::recording::Shot;
use crate::dataset::trajectory::Trajectory;
use crate::eyes::Mount;
use crate::site::progress;
use crate::site_file::SiteFloor;
use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Readings of the accelerometer this far from a frame tell gravity, nanoseconds: half a second in all, about a step of
/// somebody who walks, so that the ups and downs of the step cancel.
const GRAVITY_REACH_NS: u64 = 250_000_000;

/// What to localize, and with what.
#[derive(Debug)]
pub struct Job<'a> {
    /// The floors.
    pub storeys: &'a [SiteFloor<'a>],
    /// The cameras.
    pub calibration: &'a Calibration,
    /// Which side of cam0's image is up; the accelerometer overrules it.
    pub mount: Mount,
    /// The accelerometer, where there is one.
    pub imu: Option<&'a Readings>,
    /// Height of cam0 above the floor in metres, where it is known.
    pub height_m: Option<f32>,
    /// Where cam0 was.
    pub truth: &'a Trajectory,
    /// The number of the floor that the truth lies on.
    pub floor: usize,
    /// Where evidence is kept.
    pub evidence: &'a Path,
}

impl Job<'_> {
    /// What the accelerometer says of gravity at the time of a frame, in the axes of cam0; `None` without one, where the
    /// calibration does not tell how it lies, and where it moves too much.
    #[must_use]
    pub fn gravity(&self, timestamp_ns: u64) -> Option<Gravity> {
        let shift_s = self.calibration.cameras[0].as_ref()?.timeshift_s;
        let time_ns = timestamp_ns.checked_add_signed((shift_s * 1e9).round() as i64)?;
        self.calibration.in_cam0(&self.imu?.gravity_near(time_ns, GRAVITY_REACH_NS).ok()?)
    }

    /// The file that keeps the evidence of a frame.
    #[must_use]
    pub fn evidence_file(&self, timestamp_ns: u64) -> PathBuf {
        self.evidence.join(format!("{timestamp_ns}.png"))
    }
}

/// Localizes the shots that the journal lacks, `jobs` at a time, and returns the records of all in their order.
///
/// # Errors
/// Names the file of the first frame that cannot be read, or the output that cannot be written.
pub fn localize(job: &Job<'_>, shots: &[Shot], journal: &Journal, jobs: usize) -> Result<Vec<Record>> {
    let open: Vec<&Shot> = shots.iter().filter(|shot| journal.get(shot.timestamp_ns).is_none()).collect();
    let bar = progress(open.len(), "localizing frames");
    let (next, stop, failed) = (AtomicUsize::new(0), AtomicBool::new(false), Mutex::new(None));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.min(open.len()).max(1)).build()?;
    pool.broadcast(|_| {
        let mut worker = None;
        while !stop.load(Ordering::Relaxed)
            && let Some(shot) = open.get(next.fetch_add(1, Ordering::Relaxed))
        {
            let worked = worker
                .get_or_insert_with(|| Worker::new(job))
                .as_mut()
                .map_err(|no_plan| (*no_plan).into())
                .and_then(|worker| worker.record(shot))
                .and_then(|record| journal.add(record));
            if let Err(error) = worked {
                stop.store(true, Ordering::Relaxed);
                // A panic elsewhere does not spoil an error.
                failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
            }
            bar.inc(1);
        }
    });
    bar.finish_and_clear();
    match failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        Some(error) => Err(error),
        None => {
            shots.iter().map(|shot| journal.get(shot.timestamp_ns).context("a frame has no result")).collect()
        }
    }
}
