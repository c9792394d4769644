//! Files that are written atomically, and the numbers of machine-readable results.

use crate::temporary::Temporary;
use compass_core::ScoredPose;
use compass_core::base::num::Metres;
use compass_core::map::site_map::Sink;
use serde::{Serialize, Serializer};
use std::borrow::Cow;
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
        plain(self.0, 6, serializer)
    }
}

/// The bits of x, y and heading, and of the score, in hexadecimal: what is compared between targets.
#[must_use]
pub fn pose_bits(pose: &ScoredPose) -> String {
    let [x, y] = [pose.at.x, pose.at.y].map(Metres::to_bits);
    format!("{x:016x} {y:016x} {:08x} {}", pose.heading.to_bits(), pose.score.to_bits())
}

/// An entry of a covariance in the JSON output: as [`Decimal`], with at most ten places, because half a degree squared is 0.00008.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variance(pub f64);

impl Serialize for Variance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        plain(self.0, 10, serializer)
    }
}

/// A number with at most `places` behind the point.
fn plain<S: Serializer>(value: f64, places: usize, serializer: S) -> Result<S::Ok, S::Error> {
    if !value.is_finite() {
        return serializer.serialize_none();
    }
    let text = format!("{value:.places$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    let text = if text == "-0" { "0" } else { text };
    let raw = serde_json::value::RawValue::from_string(text.to_owned());
    raw.map_err(serde::ser::Error::custom)?.serialize(serializer)
}

/// A whole array of [`Decimal`]s.
pub fn decimals(values: impl IntoIterator<Item = f64>) -> Vec<Decimal> {
    values.into_iter().map(Decimal).collect()
}

/// Text for terminals and pages: control characters other than line breaks and tabs, and those that turn the direction of writing, are
/// written as their code points. Names and messages from files may hold any.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_harmful = |c: char| {
        let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns || (c.is_control() && !['\n', '\t'].contains(&c))
    };
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| if is_harmful(c) { c.escape_unicode().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
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

/// Checks, before long work, that a file can be written at `path`.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn check_file(path: &Path) -> Result<(), OutputError> {
    let check = || {
        let target = target(path)?;
        match target.metadata() {
            _ if is_stream(&target) => Ok(()),
            Ok(data) if data.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            _ => Temporary::file_in(folder(&target), &builder()).map(drop),
        }
    };
    check().map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

/// The file that a path stands for, which need not exist: the end of a chain of symbolic links.
fn target(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let is_link = path.symlink_metadata().is_ok_and(|data| data.is_symlink());
        if !is_link || is_stream(&path) {
            return Ok(path);
        }
        path = folder(&path).join(std::fs::read_link(&path)?);
    }
    Err(io::Error::other("too many symbolic links"))
}

fn is_standard_output(path: &Path) -> bool {
    ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

/// Whether a path is written through: a device, a pipe, or what a descriptor of the process stands for, as `/dev/stdout`. A
/// file that is renamed would take its place.
fn is_stream(path: &Path) -> bool {
    let is_other = path.metadata().is_ok_and(|data| !data.is_file() && !data.is_dir());
    let descriptors = ["/dev/stdin", "/dev/stdout", "/dev/stderr", "/dev/fd", "/proc/self/fd"];
    is_other || descriptors.iter().any(|name| path.starts_with(name) && path.exists())
}

/// Most symbolic links that are followed, as on Linux.
const MAX_LINKS: usize = 40;

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let path = &target(path)?;
    if is_standard_output(path) {
        // What is printed follows it.
        return io::stdout().write_all(bytes).and_then(|()| io::stdout().flush());
    }
    if is_stream(path) {
        return std::fs::OpenOptions::new().append(true).open(path)?.write_all(bytes);
    }
    let before = path.metadata().ok();
    let directory = folder(path);
    let mut file = Temporary::file_in(directory, &builder())?;
    file.writer().write_all(bytes)?;
    if let Some(before) = before {
        file.writer().set_permissions(before.permissions())?;
    }
    // Before the name: a loss of power leaves the file of before or this one, whole.
    file.writer().sync_all()?;
    file.persist(path)?;
    sync_folder(directory);
    Ok(())
}

/// Writes the names in a folder to the disk, where the system can; without that only a loss of power takes a new name.
fn sync_folder(folder: &Path) {
    let _ = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
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
    #[cfg(unix)]
    fn links_are_followed_and_modes_kept() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let [file, link, chain, dangling] =
            ["file", "link", "chain", "dangling"].map(|name| home.path().join(name));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
        for (to, name) in [("file", &link), ("link", &chain), ("later", &dangling)] {
            std::os::unix::fs::symlink(to, name).unwrap();
        }
        write_file(&chain, b"new").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o640);
        assert!(
            chain.symlink_metadata().unwrap().is_symlink() && link.symlink_metadata().unwrap().is_symlink()
        );
        write_file(&dangling, b"there").unwrap();
        assert_eq!(std::fs::read(home.path().join("later")).unwrap(), b"there");
        std::os::unix::fs::symlink("loop", home.path().join("loop")).unwrap();
        let refused = write_file(&home.path().join("loop"), b"x").unwrap_err().to_string();
        assert!(refused.ends_with("loop: too many symbolic links"), "{refused}");
    }

    #[test]
    #[cfg(unix)]
    fn devices_and_pipes_are_written_to_and_stay() {
        use std::os::unix::fs::FileTypeExt;
        let home = tempfile::tempdir().unwrap();
        let pipe = home.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        write_file(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(pipe.symlink_metadata().unwrap().file_type().is_fifo());
        write_file(Path::new("/dev/null"), b"gone").unwrap();
        assert!(Path::new("/dev/null").metadata().unwrap().file_type().is_char_device());
        let full = write_file(Path::new("/dev/full"), b"x").unwrap_err().to_string();
        assert!(full.starts_with("cannot write /dev/full: "), "{full}");
    }

    #[test]
    fn a_file_that_cannot_be_written_is_told_before_the_work() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("new");
        check_file(&path).unwrap();
        assert_eq!(std::fs::read_dir(home.path()).unwrap().count(), 0);
        for bad in [home.path().to_path_buf(), path.join("x")] {
            let refused = check_file(&bad).unwrap_err().to_string();
            assert!(refused.starts_with(&format!("cannot write {}: ", bad.display())), "{refused}");
        }
    }

    #[test]
    fn harmful_characters_are_shown_as_code_points() {
        assert_eq!(printable("Büro 3\nzwei"), "Büro 3\nzwei");
        assert_eq!(printable("a\u{1b}[31mred\r\u{7}"), "a\\u{1b}[31mred\\u{d}\\u{7}");
        assert_eq!(printable("gnp.\u{202e}exe"), "gnp.\\u{202e}exe");
    }

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
