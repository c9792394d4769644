//! Frames to records, on all cores.

use super::error::{EvaluateError, Result};
use super::job::Job;
use super::journal::Journal;
use super::record::Record;
use super::worker::Worker;
use crate::dataset::recording::Shot;
use crate::progress::Progress;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Localizes the shots that the journal lacks, `jobs` at a time, and returns the records of all shots in order.
///
/// # Errors
/// Names the output that cannot be written; [`EvaluateError::NoneReadable`] if no image of any shot can be used.
pub fn localize(
    job: &Job<'_>,
    shots: &[Shot],
    journal: &Journal,
    jobs: usize,
    progress: &dyn Progress,
) -> Result<Vec<Record>> {
    let open: Vec<&Shot> = shots.iter().filter(|shot| journal.get(shot.timestamp_ns).is_none()).collect();
    let steps = progress.begin(open.len(), "localizing frames");
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
                // A panic of another thread leaves the stored error valid.
                failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
            }
            steps.step();
        }
    });
    drop(steps);
    match failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        Some(error) => Err(error),
        None => {
            let get = |shot: &Shot| journal.get(shot.timestamp_ns).ok_or(EvaluateError::NoResult);
            let records: Vec<Record> = shots.iter().map(get).collect::<Result<_>>()?;
            match records.first() {
                Some(Record { problem: Some(problem), .. }) if records.iter().all(|r| r.is_unreadable) => {
                    Err(EvaluateError::NoneReadable(problem.clone()))
                }
                _ => Ok(records),
            }
        }
    }
}
