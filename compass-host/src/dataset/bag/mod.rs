//! ROS 2 bags: a folder of `metadata.yaml` and one file or several, `SQLite` (`.db3`) or MCAP, each as a whole, its
//! messages or its chunks compressed or not; or such files without metadata.
//!
//! A bag is scanned once for the stamps of the frames and the readings of the IMU; a frame is fetched again on demand.
//! Times are those of the messages' headers, or of their recording where a topic has none.

mod choice;
mod encoding;
mod file;
mod kind;
mod mcap_file;
mod message;
mod metadata;
mod place;
mod scan;
mod sqlite_file;
mod topic;

use super::error::DatasetError;
use super::faults::Faults;
use super::imu::Readings;
use super::pairs::List;
use super::topics::Topics;
use crate::calibration::Calibration;
use crate::frame::Frame;
use crate::image_file::Pixels;
use crate::progress::Progress;
use file::{BagFile, Content, Storage};
use metadata::Metadata;
use place::Place;
use scan::Scan;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use topic::Topic;

/// The file that describes a bag.
pub(super) const METADATA: &str = "metadata.yaml";

/// The contents read from a bag.
pub(super) struct Contents {
    /// The frames of cam0 and cam1.
    pub(super) frames: [List<Message>; 2],
    /// The accelerometer, if there is one.
    pub(super) imu: Option<Readings>,
    /// The topics that were read.
    pub(super) topics: Topics,
    /// What was left out.
    pub(super) faults: Faults,
    /// What else a user should know.
    pub(super) notes: Vec<String>,
}

/// Whether a path is a bag: a file of one, or a folder with some or with metadata.
pub(super) fn is_one(path: &Path) -> bool {
    if path.is_file() {
        return file::content(path).is_ok_and(|content| content != Content::Other);
    }
    path.join(METADATA).exists() || !file::storages(path).is_empty()
}

/// Reads the stamps and readings of a bag.
pub(super) fn read(
    path: &Path,
    topics: Option<&Topics>,
    calibration: &Calibration,
    progress: &dyn Progress,
) -> Result<Contents, DatasetError> {
    let mut notes = Vec::new();
    let bag = Bag::open(path, &mut notes)?;
    let chosen = choice::choose(&bag.topics, topics, calibration).map_err(|p| DatasetError::bad(path, p))?;
    let messages = chosen.iter().map(|(_, topic)| topic.count).sum();
    let mut scan = Scan::new(Arc::new(bag), chosen, notes, progress.begin(messages, "reading the bag"));
    scan.run();
    scan.finish(path)
}

/// A message with a frame.
#[derive(Debug, Clone)]
pub struct Message {
    bag: Arc<Bag>,
    topic: Arc<Topic>,
    /// Index of the file.
    file: usize,
    place: Place,
    time_ns: u64,
}

impl Message {
    /// Fetches and decodes the frame.
    pub(super) fn read(&self) -> Result<Frame, DatasetError> {
        let name = &self.bag.files[self.file].name;
        self.pixels().map(Frame::from).map_err(|problem| {
            let (seconds, ns) = (self.time_ns / 1_000_000_000, self.time_ns % 1_000_000_000);
            DatasetError::bad(name, format!("{} at {seconds}.{ns:09} s: {problem}", self.topic.name))
        })
    }

    fn pixels(&self) -> Result<Pixels, String> {
        let path = self.bag.files[self.file].path();
        let bytes = match self.place {
            Place::Row(id) => sqlite_file::fetch(path, id)?,
            Place::Record { offset, before } => mcap_file::fetch(path, offset, before)?,
        };
        let bytes = match bytes.starts_with(&file::ZSTD) {
            true => zstd::decode_all(&bytes[..]).map_err(|error| error.to_string())?,
            false => bytes,
        };
        message::pixels(self.topic.kind(), &bytes)
    }

    /// See [`Source::identity`](super::recording::Source::identity).
    pub(super) fn identity(&self) -> String {
        let file = &self.bag.files[self.file];
        format!("{} {} {} {:?}", file.name.display(), file.bytes, self.topic.name, self.place)
    }

    /// File, topic and time, for messages.
    pub(super) fn name(&self) -> String {
        let (seconds, ns) = (self.time_ns / 1_000_000_000, self.time_ns % 1_000_000_000);
        format!("{}: {} at {seconds}.{ns:09} s", self.bag.files[self.file].name.display(), self.topic.name)
    }
}

/// The files and topics of a bag.
#[derive(Debug)]
struct Bag {
    files: Vec<BagFile>,
    topics: Vec<Topic>,
}

impl Bag {
    /// Opens the files of a bag; one that cannot be read is left out with a note, as long as another one can.
    fn open(path: &Path, notes: &mut Vec<String>) -> Result<Self, DatasetError> {
        let (names, described) = Self::names(path)?;
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
    fn names(path: &Path) -> Result<(Vec<PathBuf>, Option<Vec<Topic>>), DatasetError> {
        let described = path.join(METADATA);
        if path.is_file() {
            return Ok((vec![path.to_path_buf()], None));
        }
        if !described.exists() {
            return Ok((file::storages(path), None));
        }
        let metadata =
            Metadata::read(&described).map_err(|problem| DatasetError::bad(&described, problem))?;
        Ok((metadata.files.iter().map(|file| path.join(file)).collect(), Some(metadata.topics)))
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
