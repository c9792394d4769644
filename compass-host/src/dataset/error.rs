//! Why a recording could not be read.

use super::table::TableError;
use crate::image_file::ImageFileError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a recording could not be read: one line that names the file and the place at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A list cannot be read, or one of its lines is not a frame or reading.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A frame cannot be read.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// The folder, or a file of a bag, is malformed.
    #[error("{}: {problem}", path.display())]
    Bad {
        /// The folder or file.
        path: PathBuf,
        /// What is wrong with it, and where.
        problem: String,
    },
}

impl DatasetError {
    pub(super) fn bad(path: &Path, problem: impl Into<String>) -> Self {
        Self::Bad { path: path.to_path_buf(), problem: problem.into() }
    }
}
