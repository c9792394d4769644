//! Why an evaluation stopped.

use crate::figures::FigureError;
use crate::image_file::ImageFileError;
use crate::locator::NoPlan;
use crate::output::OutputError;
use std::path::PathBuf;
use thiserror::Error;

/// Why an evaluation stopped: one line that names the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// A floor has no plan.
    #[error(transparent)]
    NoPlan(#[from] NoPlan),
    /// A result cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture or the report cannot be drawn or written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A stored evidence file is not an image.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// A stored evidence file holds an image of another layout.
    #[error("{}: no evidence", .0.display())]
    NoEvidence(PathBuf),
    /// The journal cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    ReadJournal {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The journal cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    WriteJournal {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A record cannot be serialized as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// The threads could not be started.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// No frame of the recording can be used; the problem of the first.
    #[error("{0}")]
    NoneReadable(String),
    /// A frame has no record after all workers ended.
    #[error("a frame has no result")]
    NoResult,
}

/// The result of an evaluation step.
pub(super) type Result<T, E = EvaluateError> = std::result::Result<T, E>;
