//! Files that appear whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a figure or a report did not come about.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
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

/// Writes `bytes` to a new file beside `path` and renames it.
///
/// # Errors
/// [`FigureError::Write`] naming `path`; what stood there before stays as it was.
pub(crate) fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FigureError> {
    replace(path, bytes).map_err(|source| FigureError::Write { path: path.to_owned(), source })
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut file = builder().tempfile_in(directory).map_err(|e| plain(&e))?;
    file.write_all(bytes)?;
    file.persist(path).map_err(|e| plain(&e.error))?;
    Ok(())
}

/// The system's message alone: the error of `tempfile` names a temporary path nobody asked for.
fn plain(error: &io::Error) -> io::Error {
    error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error)
}

/// Temporary files with the rights of an ordinary new file, not of a secret.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".compass-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_a_file_and_leaves_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn error_is_one_line_that_names_the_path() {
        let path = Path::new("no/such/folder/a.png");
        let message = write_atomically(path, b"").unwrap_err().to_string();
        assert!(message.starts_with("cannot write no/such/folder/a.png: "), "{message}");
        assert!(!message.contains('\n') && !message.contains(".compass-"), "{message}");
    }
}
