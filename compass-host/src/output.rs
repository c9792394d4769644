//! Files that are written atomically, and the numbers of machine-readable results.

use crate::temporary::Temporary;
use compass_core::map::site_map::Sink;
use serde::{Serialize, Serializer};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file or directory could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file could not be written; a previous file is unchanged.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The image cannot be encoded.
    #[error("{}: cannot be encoded: {source}", path.display())]
    Encode {
        /// The output file of the image.
        path: PathBuf,
        /// The encoder's error.
        source: image::ImageError,
    },
    /// The directory could not be created.
    #[error("{}: cannot create the directory: {source}", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

/// A number of the JSON output: a plain decimal of at most six places, never an exponent.
///
/// Values that are not finite become `null`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal(pub f64);

impl Serialize for Decimal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return serializer.serialize_none();
        }
        let text = format!("{:.6}", self.0);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        let text = if text == "-0" { "0" } else { text };
        let raw = serde_json::value::RawValue::from_string(text.to_owned());
        raw.map_err(serde::ser::Error::custom)?.serialize(serializer)
    }
}

/// A whole array of [`Decimal`]s.
pub fn decimals(values: impl IntoIterator<Item = f64>) -> Vec<Decimal> {
    values.into_iter().map(Decimal).collect()
}

/// Writes `bytes` to a new file beside `path` and renames it: the file is whole or absent.
///
/// # Errors
/// [`OutputError::Write`] names `path`; a previous file is unchanged.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    replace(path, bytes).map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

/// Writes an image as PNG, atomically.
///
/// # Errors
/// [`OutputError`] names the file.
pub fn write_png(path: &Path, image: &image::RgbImage) -> Result<(), OutputError> {
    let mut png = io::Cursor::new(Vec::new());
    image
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|source| OutputError::Encode { path: path.to_owned(), source })?;
    write_file(path, png.get_ref())
}

/// Creates a directory for output with all its parents.
///
/// # Errors
/// [`OutputError::Directory`] names the directory.
pub fn create_dir(path: &Path) -> Result<(), OutputError> {
    std::fs::create_dir_all(path).map_err(|source| OutputError::Directory { path: path.to_owned(), source })
}

/// Bytes in memory, as a target of the core's writers.
#[derive(Debug, Default)]
pub struct Bytes(pub Vec<u8>);

impl Sink for Bytes {
    type Error = std::convert::Infallible;
    fn append(&mut self, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut file = Temporary::file_in(directory, &builder()).map_err(|e| plain(&e))?;
    file.writer().write_all(bytes)?;
    file.persist(path).map_err(|e| plain(&e))
}

/// The system's message alone: the error of `tempfile` names a temporary path that the user does not know.
fn plain(error: &io::Error) -> io::Error {
    error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error)
}

/// Temporary files with the permissions of an ordinary new file instead of owner-only ones.
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
        write_file(&path, b"one").unwrap();
        write_file(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn error_is_one_line_that_names_the_path() {
        let path = Path::new("no/such/folder/a.png");
        let message = write_file(path, b"").unwrap_err().to_string();
        assert!(message.starts_with("cannot write no/such/folder/a.png: "), "{message}");
        assert!(!message.contains('\n') && !message.contains(".compass-"), "{message}");
    }

    #[test]
    fn numbers_are_plain_decimals() {
        let text = |v: f64| serde_json::to_string(&Decimal(v)).unwrap();
        assert_eq!(text(0.000_001), "0.000001");
        assert_eq!(text(1e-9), "0");
        assert_eq!(text(-1e-9), "0");
        assert_eq!(text(123_456_789.25), "123456789.25");
        assert_eq!(text(30.0), "30");
        assert_eq!(text(f64::NAN), "null");
    }
}
