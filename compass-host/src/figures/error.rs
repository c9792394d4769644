//! Why drawing failed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::output::OutputError;

/// Why a figure or a report was not drawn.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The data cannot be drawn.
    #[error("cannot draw {}: {reason}", path.display())]
    Draw {
        /// The output file of the picture.
        path: PathBuf,
        /// What is wrong with the data.
        reason: String,
    },
}

impl FigureError {
    /// An error about the data, in words.
    pub(crate) fn draw(path: &Path, reason: &dyn std::fmt::Display) -> Self {
        Self::Draw { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// Why a drawing step failed: an error about the data, or one of the drawing library.
pub(super) type DrawError = Box<dyn std::error::Error + Send + Sync>;

/// The result of a drawing step.
pub(super) type Drawn = Result<(), DrawError>;
