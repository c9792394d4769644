//! What is read from outside, and how much of it: one policy for every reader.
//!
//! Files come from strangers. A reader takes regular files alone, besides pipes that the shell opened, and no more of them than
//! its [`Limits`]: bytes of a file, pixels of an image as its header says them, bytes of a message once it is unpacked. What is
//! larger is refused by an error that names the limit, before memory is claimed for it.
//!
//! Where there is no file system, as in a browser, the program [lends](lend) files under their names.

use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

const MIB: u64 = 1 << 20;

/// The largest that is read of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of a file with settings: calibrations, descriptions of maps and bags. 16 MiB.
    pub settings_bytes: u64,
    /// Bytes of a table: trajectories, lists of frames, readings, journals. 1 GiB.
    pub table_bytes: u64,
    /// Bytes of an image file. 512 MiB.
    pub image_bytes: u64,
    /// Bytes of a drawing. 1 GiB.
    pub drawing_bytes: u64,
    /// Bytes of a site file. 4 GiB.
    pub site_bytes: u64,
    /// Pixels of a plan, 400 million.
    pub plan_pixels: u64,
    /// Pixels of a frame, 134 million: two of the largest that are searched for segments, side by side.
    pub frame_pixels: u64,
    /// Bytes of a message or record of a bag, unpacked. 128 MiB.
    pub message_bytes: u64,
    /// Bytes that a file of a bag may unpack to: this many, and 100 times its own. 256 MiB.
    pub unpacked_bytes: u64,
}

impl Limits {
    /// The limits unless others are set.
    pub const DEFAULT: Self = Self {
        settings_bytes: 16 * MIB,
        table_bytes: 1024 * MIB,
        image_bytes: 512 * MIB,
        drawing_bytes: 1024 * MIB,
        site_bytes: 4096 * MIB,
        plan_pixels: 400_000_000,
        frame_pixels: 2 * 8192 * 8192,
        message_bytes: 128 * MIB,
        unpacked_bytes: 256 * MIB,
    };

    /// All limits, `factor` times as high.
    #[must_use]
    pub const fn raised(self, factor: u32) -> Self {
        const fn times(limit: u64, factor: u32) -> u64 {
            limit.saturating_mul(factor as u64)
        }
        Self {
            settings_bytes: times(self.settings_bytes, factor),
            table_bytes: times(self.table_bytes, factor),
            image_bytes: times(self.image_bytes, factor),
            drawing_bytes: times(self.drawing_bytes, factor),
            site_bytes: times(self.site_bytes, factor),
            plan_pixels: times(self.plan_pixels, factor),
            frame_pixels: times(self.frame_pixels, factor),
            message_bytes: times(self.message_bytes, factor),
            unpacked_bytes: times(self.unpacked_bytes, factor),
        }
    }
}

static LIMITS: RwLock<Limits> = RwLock::new(Limits::DEFAULT);

/// The limits of the process.
#[must_use]
pub fn limits() -> Limits {
    *LIMITS.read().unwrap_or_else(PoisonError::into_inner)
}

/// Sets the limits of the process, for all readers from then on.
pub fn set_limits(limits: Limits) {
    *LIMITS.write().unwrap_or_else(PoisonError::into_inner) = limits;
}

static LENT: RwLock<BTreeMap<PathBuf, Arc<[u8]>>> = RwLock::new(BTreeMap::new());

/// Lends a file: from then on the readers of plans in images and drawings, calibrations, frames and sites find these bytes
/// under this name, whatever the file system has there. Recordings are not read so.
pub fn lend(path: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) {
    LENT.write().unwrap_or_else(PoisonError::into_inner).insert(path.into(), bytes.into());
}

/// Takes back a file that was lent.
pub fn take_back(path: &Path) {
    LENT.write().unwrap_or_else(PoisonError::into_inner).remove(path);
}

fn lent(path: &Path) -> Option<Arc<[u8]>> {
    LENT.read().unwrap_or_else(PoisonError::into_inner).get(path).map(Arc::clone)
}

/// Whether something has this name.
pub(crate) fn exists(path: &Path) -> bool {
    find(path).is_ok()
}

/// Finds something of this name.
pub(crate) fn find(path: &Path) -> io::Result<()> {
    if lent(path).is_some() { Ok(()) } else { std::fs::metadata(path).map(drop) }
}

/// The first bytes of a file, at most `most`.
pub(crate) fn read_head(path: &Path, most: usize) -> io::Result<Vec<u8>> {
    if let Some(bytes) = lent(path) {
        return Ok(bytes[..most.min(bytes.len())].to_vec());
    }
    let mut head = Vec::new();
    open(path)?.take(most as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// Opens a file: a regular one, or a pipe that the shell opened.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    // Before it is opened: a named pipe without a writer would block.
    check_kind(path, &std::fs::metadata(path)?)?;
    File::open(path)
}

/// Reads a whole file of at most `limit` bytes.
pub(crate) fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    if let Some(bytes) = lent(path) {
        let length = bytes.len() as u64;
        return if length > limit { Err(too_large(length, limit)) } else { Ok(bytes.to_vec()) };
    }
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > limit {
        return Err(too_large(length, limit));
    }
    let mut bytes = Vec::new();
    // A file may grow, and a pipe has no length.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > limit {
        true => Err(too_large(bytes.len() as u64, limit)),
        false => Ok(bytes),
    }
}

/// Reads a whole file that has no limit of its own: at most [`Limits::table_bytes`].
///
/// # Errors
/// The system's, or that it is no file, or too large.
pub fn read_whole(path: &Path) -> io::Result<Vec<u8>> {
    read(path, limits().table_bytes)
}

/// [`read`], of text in UTF-8.
#[cfg(any(feature = "bag", feature = "drawings", test))]
pub(crate) fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(read(path, limit)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not text in UTF-8"))
}

/// Checks that a file is one that [`read`] would read, for readers of other libraries.
#[cfg(feature = "cad")]
pub(crate) fn check(path: &Path, limit: u64) -> io::Result<()> {
    let length = open(path)?.metadata()?.len();
    if length > limit { Err(too_large(length, limit)) } else { Ok(()) }
}

/// Reads all of `source`, at most `limit` bytes: what is packed may be a thousand times as large.
#[cfg(feature = "bag")]
pub(crate) fn unpack(source: impl Read, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(unpacks_to_more(limit)) } else { Ok(bytes) }
}

/// The error for packed data that unpack to more than a limit.
#[cfg(feature = "bag")]
pub(crate) fn unpacks_to_more(limit: u64) -> io::Error {
    refused(format!("it unpacks to more than the limit of {}; --raise-limits raises it", size(limit)))
}

/// Whether a relative path stays in the folder that it is relative to, by its name alone.
pub(crate) fn is_within(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

fn check_kind(path: &Path, data: &Metadata) -> io::Result<()> {
    if data.is_file() || is_pipe_of_shell(path, data) {
        return Ok(());
    }
    Err(refused(
        if data.is_dir() { "it is a folder" } else { "it is a device or a named pipe, not a file" }.into(),
    ))
}

/// Whether a path is standard input, or `<(command)` of a shell.
#[cfg(unix)]
fn is_pipe_of_shell(path: &Path, data: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let is_descriptor =
        path == Path::new("/dev/stdin") || path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd");
    data.file_type().is_fifo() && is_descriptor
}

#[cfg(not(unix))]
fn is_pipe_of_shell(_: &Path, _: &Metadata) -> bool {
    false
}

fn too_large(length: u64, limit: u64) -> io::Error {
    let factor = length.div_ceil(limit.max(1));
    refused(format!(
        "{} are more than the limit of {}; --raise-limits {factor} raises it",
        size(length),
        size(limit)
    ))
}

fn refused(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// A number of bytes for people.
fn size(bytes: u64) -> String {
    match bytes {
        0..MIB => format!("{bytes} bytes"),
        _ => format!("{} MiB", bytes / MIB),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lent_file_is_found_under_its_name_until_it_is_taken_back() {
        let path = Path::new("nowhere/lent.bin");
        assert!(!exists(path) && read(path, 9).is_err());
        lend(path, b"12345".as_slice());
        assert!(exists(path) && find(path).is_ok());
        assert_eq!(read(path, 5).unwrap(), b"12345");
        assert_eq!(read_head(path, 2).unwrap(), b"12");
        assert_eq!(read_head(path, 9).unwrap(), b"12345");
        assert!(read(path, 4).unwrap_err().to_string().contains("more than the limit of 4 bytes"));
        take_back(path);
        assert!(!exists(path) && read(path, 9).is_err());
    }

    #[test]
    fn files_are_read_up_to_their_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, b"1234567890").unwrap();
        assert_eq!(read(&path, 10).unwrap(), b"1234567890");
        assert_eq!(read_text(&path, 11).unwrap(), "1234567890");
        let refused = read(&path, 4).unwrap_err().to_string();
        assert_eq!(refused, "10 bytes are more than the limit of 4 bytes; --raise-limits 3 raises it");
        assert_eq!(read(folder.path(), 4).unwrap_err().to_string(), "it is a folder");
        assert_eq!(read(&folder.path().join("b"), 4).unwrap_err().kind(), io::ErrorKind::NotFound);
        std::fs::write(&path, b"\xff\xfe").unwrap();
        assert_eq!(read_text(&path, 10).unwrap_err().to_string(), "not text in UTF-8");
    }

    /// A file with holes claims any length without a byte on the disk.
    #[test]
    fn a_long_file_is_refused_by_its_length() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("holes");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = read(&path, Limits::DEFAULT.table_bytes).unwrap_err().to_string();
        assert!(
            refused.starts_with("1048576 MiB are more than the limit of 1024 MiB; --raise-limits 1024"),
            "{refused}"
        );
    }

    #[test]
    #[cfg(unix)]
    fn devices_and_named_pipes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [Path::new("/dev/zero"), Path::new("/dev/null"), &pipe] {
            let refused = read(path, 100).unwrap_err().to_string();
            assert_eq!(refused, "it is a device or a named pipe, not a file", "{}", path.display());
        }
    }

    #[test]
    fn paths_that_leave_their_folder_are_told() {
        assert!(["a.png", "data/a.png", "./a", "a..b/c"].iter().all(|path| is_within(Path::new(path))));
        assert!(["/etc/passwd", "../a.png", "data/../../a"].iter().all(|path| !is_within(Path::new(path))));
    }

    #[test]
    fn limits_are_raised_together() {
        let raised = Limits::DEFAULT.raised(3);
        assert_eq!((raised.plan_pixels, raised.message_bytes), (1_200_000_000, 384 * MIB));
        assert_eq!(Limits::DEFAULT.raised(u32::MAX).raised(u32::MAX).site_bytes, u64::MAX);
        assert_eq!(Limits::DEFAULT.raised(1), Limits::DEFAULT);
    }

    #[test]
    #[cfg(feature = "bag")]
    fn packed_data_is_unpacked_up_to_a_limit() {
        assert_eq!(unpack(io::repeat(7).take(5), 5).unwrap(), [7; 5]);
        let refused = unpack(io::repeat(7), 5).unwrap_err().to_string();
        assert_eq!(refused, "it unpacks to more than the limit of 5 bytes; --raise-limits raises it");
    }
}
