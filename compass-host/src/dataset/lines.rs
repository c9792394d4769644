//! Text files with one record per line: blank lines and lines that begin with `#` are skipped.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file of lines could not be read: one line that names the file and the line at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LinesError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A line is not a valid record.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
}

/// Passes the records of a file to `take`, trimmed and in order, until it rejects one with an error.
pub(super) fn visit(path: &Path, mut take: impl FnMut(&str) -> Result<(), String>) -> Result<(), LinesError> {
    let bytes =
        std::fs::read(path).map_err(|source| LinesError::Read { path: path.to_path_buf(), source })?;
    for (number, line) in String::from_utf8_lossy(&bytes).lines().enumerate() {
        let line = line.trim_start_matches('\u{feff}').trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        take(line).map_err(|problem| LinesError::Line {
            path: path.to_path_buf(),
            line: number + 1,
            problem,
        })?;
    }
    Ok(())
}
