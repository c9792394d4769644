//! The files and topics of a bag, and what was read from it.

use super::file::{self, BagFile, Storage};
use super::metadata::Metadata;
use super::place::Place;
use super::topic::Topic;
use super::{mcap_file, message, sqlite_file};
use crate::dataset::error::DatasetError;
use crate::dataset::faults::Faults;
use crate::dataset::imu::Readings;
use crate::dataset::pairs::List;
use crate::dataset::topics::Topics;
use crate::frame::Frame;
use crate::image_file::Pixels;
use crate::input;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The file that describes a bag.
pub(super) const METADATA: &str = "metadata.yaml";

/// The contents read from a bag.
pub(in crate::dataset) struct Contents {
    /// The frames of cam0 and cam1.
    pub(in crate::dataset) frames: [List<Message>; 2],
    /// The accelerometer, if there is one.
    pub(in crate::dataset) imu: Option<Readings>,
    /// The topics that were read.
    pub(in crate::dataset) topics: Topics,
    /// What was left out.
    pub(in crate::dataset) faults: Faults,
    /// What else a user should know.
    pub(in crate::dataset) notes: Vec<String>,
}

/// A message with a frame.
#[derive(Debug, Clone)]
pub struct Message {
    pub(super) bag: Arc<Bag>,
    pub(super) topic: Arc<Topic>,
    /// Index of the file.
    pub(super) file: usize,
    pub(super) place: Place,
    pub(super) time_ns: u64,
}

impl Message {
    /// Fetches and decodes the frame.
    pub(in crate::dataset) fn read(&self) -> Result<Frame, DatasetError> {
        self.pixels().map(Frame::from).map_err(|problem| self.problem(&problem))
    }

    /// The message as it is stored.
    pub(in crate::dataset) fn contents(&self) -> Result<Vec<u8>, DatasetError> {
        self.fetch().map_err(|problem| self.problem(&problem))
    }

    fn problem(&self, problem: &str) -> DatasetError {
        let name = &self.bag.files[self.file].name;
        let (seconds, ns) = (self.time_ns / 1_000_000_000, self.time_ns % 1_000_000_000);
        DatasetError::bad(name, format!("{} at {seconds}.{ns:09} s: {problem}", self.topic.name))
    }

    fn fetch(&self) -> Result<Vec<u8>, String> {
        let path = self.bag.files[self.file].path();
        match self.place {
            Place::Row(id) => sqlite_file::fetch(path, id),
            Place::Record { offset, before } => mcap_file::fetch(path, offset, before),
        }
    }

    fn pixels(&self) -> Result<Pixels, String> {
        let bytes = self.fetch()?;
        let bytes = match bytes.starts_with(&file::ZSTD) {
            true => zstd::Decoder::new(&bytes[..])
                .and_then(|packed| input::unpack(packed, input::limits().message_bytes))
                .map_err(|error| error.to_string())?,
            false => bytes,
        };
        message::pixels(self.topic.kind(), &bytes)
    }

    /// File, topic and time, for messages.
    pub(in crate::dataset) fn name(&self) -> String {
        let (seconds, ns) = (self.time_ns / 1_000_000_000, self.time_ns % 1_000_000_000);
        format!("{}: {} at {seconds}.{ns:09} s", self.bag.files[self.file].name.display(), self.topic.name)
    }
}

/// The files and topics of a bag.
#[derive(Debug)]
pub(super) struct Bag {
    pub(super) files: Vec<BagFile>,
    pub(super) topics: Vec<Topic>,
}

impl Bag {
    /// Opens the files of a bag; one that cannot be read is left out with a note, as long as another one can.
    pub(super) fn open(path: &Path, notes: &mut Vec<String>) -> Result<Self, DatasetError> {
        let (names, described) = Self::names(path, notes)?;
        let (mut files, mut first) = (Vec::new(), None);
        for name in names {
            match BagFile::open(name.clone()) {
                Ok(file) => files.push(file),
                Err(problem) => {
                    let error = DatasetError::bad(&name, problem);
                    notes.push(format!("{error}: left out"));
                    first.get_or_insert(error);
                }
            }
        }
        match first {
            Some(error) if files.is_empty() => return Err(error),
            _ => {}
        }
        let topics = match described {
            Some(topics) => topics,
            None => Self::topics(&files)?,
        };
        Ok(Self { files, topics })
    }

    /// The files of a bag, and its topics if metadata say them.
    fn names(
        path: &Path,
        notes: &mut Vec<String>,
    ) -> Result<(Vec<PathBuf>, Option<Vec<Topic>>), DatasetError> {
        let described = path.join(METADATA);
        if path.is_file() {
            return Ok((vec![path.to_path_buf()], None));
        }
        if !described.exists() {
            return Ok((file::storages(path), None));
        }
        match Metadata::read(&described) {
            Ok(metadata) => {
                let listed: Vec<_> = metadata.files.iter().map(|file| path.join(file)).collect();
                let there = file::storages(path);
                if there.is_empty() || listed.iter().any(|file| file.exists()) {
                    return Ok((listed, Some(metadata.topics)));
                }
                let described = described.display();
                notes.push(format!("{described}: none of its files is there; those beside it are read"));
                Ok((there, None))
            }
            // A recorder that lost power leaves none, or an empty one.
            Err(problem) => {
                let (error, files) = (DatasetError::bad(&described, problem), file::storages(path));
                if files.is_empty() {
                    return Err(error);
                }
                notes.push(format!("{error}; the files beside it are read"));
                Ok((files, None))
            }
        }
    }

    /// The topics that the files themselves list.
    fn topics(files: &[BagFile]) -> Result<Vec<Topic>, DatasetError> {
        let mut all: Vec<Topic> = Vec::new();
        let mut first = None;
        for file in files {
            let topics = match file.storage {
                Storage::Sqlite => sqlite_file::topics(file.path()),
                Storage::Mcap => mcap_file::topics(file.path()),
            };
            match topics {
                Ok(topics) => {
                    for topic in topics {
                        match all.iter_mut().find(|known| known.name == topic.name) {
                            Some(known) => known.count += topic.count,
                            None => all.push(topic),
                        }
                    }
                }
                Err(problem) => {
                    first.get_or_insert(DatasetError::bad(&file.name, problem));
                }
            }
        }
        match first {
            Some(error) if all.is_empty() => Err(error),
            _ => Ok(all),
        }
    }
}
