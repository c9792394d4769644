//! Why an evaluation stopped.

use crate::calibration::CalibrationError;
use crate::dataset::recording::DatasetError;
use crate::figures::FigureError;
use crate::image_file::ImageFileError;
use crate::locator::NoPlan;
use crate::output::OutputError;
use std::path::PathBuf;
use thiserror::Error;

/// Why an evaluation stopped: one line, with the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// A frame of the recording cannot be read.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The calibration does not fit the frames.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A floor has no plan.
    #[error(transparent)]
    NoPlan(#[from] NoPlan),
    /// A result cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture or the report cannot be drawn or written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A file of evidence is no image.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// A file of evidence holds another image.
    #[error("{}: no evidence", .0.display())]
    NoEvidence(PathBuf),
    /// The journal cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    ReadJournal {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The journal cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    WriteJournal {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A record is no JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// The threads could not be started.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A frame was passed over.
    #[error("a frame has no result")]
    NoResult,
}

/// What the steps of an evaluation return.
pub(super) type Result<T, E = EvaluateError> = std::result::Result<T, E>;
