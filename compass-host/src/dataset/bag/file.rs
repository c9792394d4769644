//! The files of a bag, recognised by their content.

use super::sqlite_file;
use crate::input::{self, limits};
use crate::temporary::Temporary;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::{TempDir, TempPath};

/// The storage format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    Sqlite,
    Mcap,
}

/// What a file is, by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// A storage of a bag.
    Bag(Storage),
    /// Compressed with zstd as a whole.
    Zstd,
    /// A bag of ROS 1.
    Ros1,
    /// Anything else.
    Other,
}

/// First bytes by content.
const MAGIC: [(&[u8], Content); 4] = [
    (b"SQLite format 3\0", Content::Bag(Storage::Sqlite)),
    (b"\x89MCAP0\r\n", Content::Bag(Storage::Mcap)),
    (&ZSTD, Content::Zstd),
    (b"#ROSBAG V", Content::Ros1),
];

/// First bytes of what zstd compressed.
pub(super) const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A file of a bag may unpack to this many times its bytes beyond the limit; recordings reach about 10.
const UNPACKED_RATIO: u64 = 100;

/// What a file is.
pub(super) fn content(path: &Path) -> io::Result<Content> {
    let mut head = Vec::new();
    input::open(path)?.take(16).read_to_end(&mut head)?;
    let known = MAGIC.iter().find(|(magic, _)| head.starts_with(magic));
    Ok(known.map_or(Content::Other, |(_, content)| *content))
}

/// The error for a bag of ROS 1.
pub(super) const ROS1: &str = "this is a ROS 1 bag; convert it to ROS 2, as with 'rosbags-convert --src IN.bag --dst OUT' of the \
                    Python package rosbags";

/// A file of a bag.
#[derive(Debug)]
pub(super) struct BagFile {
    /// The path as stored in the bag.
    pub(super) name: PathBuf,
    pub(super) storage: Storage,
    /// A copy that is read in its place, deleted with the bag.
    copy: Option<Copy>,
}

#[derive(Debug)]
enum Copy {
    /// Of a file that is compressed as a whole: storages need random access.
    Unpacked(Temporary<TempPath>),
    /// Of a database with its write-ahead log.
    Merged { path: PathBuf, _folder: Temporary<TempDir> },
}

impl BagFile {
    /// Recognises a file, and copies it where it cannot be read in place.
    pub(super) fn open(name: PathBuf) -> Result<Self, String> {
        let unread = |error: io::Error| format!("cannot be read: {error}");
        let mut found = content(&name).map_err(unread)?;
        let mut copy = None;
        if found == Content::Zstd {
            let unpacked = unpack(&name).map_err(|error| format!("zstd: {error}"))?;
            found = content(unpacked.path()).map_err(unread)?;
            copy = Some(Copy::Unpacked(unpacked));
        }
        let storage = match found {
            Content::Bag(storage) => storage,
            Content::Ros1 => return Err(ROS1.to_owned()),
            Content::Zstd | Content::Other => {
                return Err("neither an MCAP nor an SQLite file of a bag".to_owned());
            }
        };
        if storage == Storage::Sqlite && copy.is_none() {
            copy = sqlite_file::copy(&name)
                .map_err(unread)?
                .map(|(folder, path)| Copy::Merged { path, _folder: folder });
        }
        Ok(Self { name, storage, copy })
    }

    /// Where to read it.
    pub(super) fn path(&self) -> &Path {
        match &self.copy {
            None => &self.name,
            Some(Copy::Unpacked(file)) => file.path(),
            Some(Copy::Merged { path, .. }) => path,
        }
    }
}

/// Decompresses a file into a temporary one.
fn unpack(packed: &Path) -> io::Result<Temporary<TempPath>> {
    let packed = input::open(packed)?;
    let limit =
        packed.metadata()?.len().saturating_mul(UNPACKED_RATIO).saturating_add(limits().unpacked_bytes);
    let mut unpacked = Temporary::file()?;
    let mut source = zstd::Decoder::new(packed)?.take(limit.saturating_add(1));
    if io::copy(&mut source, unpacked.writer())? > limit {
        return Err(input::unpacks_to_more(limit));
    }
    Ok(unpacked.close())
}

/// The files of a bag in a folder without metadata, in order.
pub(super) fn storages(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_storage = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
        let name = name.strip_suffix(".zstd").unwrap_or(&name);
        [".db3", ".mcap", ".bag"].iter().any(|ending| name.ends_with(ending))
    };
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(is_storage).collect();
    // The recorder numbers them: of two names of different lengths the longer is later.
    files.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    files
}
