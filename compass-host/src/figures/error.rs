//! Why drawing failed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::output::OutputError;

/// Why a figure or a report did not come about.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The data cannot be drawn.
    #[error("cannot draw {}: {reason}", path.display())]
    Draw {
        /// The file that was to hold the picture.
        path: PathBuf,
        /// What is wrong with the data.
        reason: String,
    },
}

impl FigureError {
    /// Data that cannot be drawn, and why.
    pub(crate) fn draw(path: &Path, reason: &dyn std::fmt::Display) -> Self {
        Self::Draw { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// Why a drawing step failed: bad data in words, or an error of the drawing library.
pub(super) type DrawError = Box<dyn std::error::Error + Send + Sync>;

/// What every drawing step returns.
pub(super) type Drawn = Result<(), DrawError>;
