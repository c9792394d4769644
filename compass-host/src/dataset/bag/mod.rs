//! ROS 2 bags: a folder of `metadata.yaml` and one file or several, `SQLite` (`.db3`) or MCAP, each as a whole, its
//! messages or its chunks compressed or not.
//!
//! A bag is scanned once for the stamps of the frames and the readings of the IMU; a frame is fetched again on demand.
//! Times are those of the messages' headers, not of their recording.

mod choice;
mod mcap_file;
mod message;
mod metadata;
mod place;
mod sqlite_file;

use super::error::DatasetError;
use super::imu::{Reading, Readings};
use super::pairs::List;
use super::topics::Topics;
use crate::calibration::Calibration;
use crate::frame::Frame;
use crate::image_file::Pixels;
use crate::progress::{Progress, Steps};
use choice::Role;
use metadata::{Compression, Metadata, Storage, Topic};
use place::Place;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempPath;

/// The contents read from a bag.
pub(super) struct Contents {
    /// The frames of cam0 and cam1.
    pub(super) frames: [List<Message>; 2],
    /// The accelerometer, if there is one.
    pub(super) imu: Option<Readings>,
    /// The topics that were read.
    pub(super) topics: Topics,
}

/// Reads the stamps and readings of the bag in `dir` that the file `metadata` describes.
pub(super) fn read(
    dir: &Path,
    metadata: &Path,
    topics: Option<&Topics>,
    calibration: &Calibration,
    progress: &dyn Progress,
) -> Result<Contents, DatasetError> {
    let metadata = Metadata::read(metadata).map_err(|problem| DatasetError::bad(metadata, problem))?;
    let chosen =
        choice::choose(&metadata.topics, topics, calibration).map_err(|p| DatasetError::bad(dir, p))?;
    let messages = chosen.iter().map(|(_, topic)| topic.count).sum();
    let bag = Arc::new(Bag::open(dir, metadata)?);
    let mut scan = Scan::new(bag, chosen, progress.begin(messages, "reading the bag"));
    for file in 0..scan.bag.files.len() {
        scan.visit(file)?;
    }
    scan.finish(dir)
}

/// A message with a frame.
#[derive(Debug, Clone)]
pub struct Message {
    bag: Arc<Bag>,
    topic: Arc<Topic>,
    /// Index of the file.
    file: usize,
    place: Place,
    stamp_ns: u64,
}

impl Message {
    /// Fetches and decodes the frame.
    pub(super) fn read(&self) -> Result<Frame, DatasetError> {
        let name = &self.bag.files[self.file].name;
        self.pixels().map(Frame::from).map_err(|problem| {
            let (seconds, ns) = (self.stamp_ns / 1_000_000_000, self.stamp_ns % 1_000_000_000);
            DatasetError::bad(name, format!("{} at {seconds}.{ns:09} s: {problem}", self.topic.name))
        })
    }

    fn pixels(&self) -> Result<Pixels, String> {
        let path = self.bag.files[self.file].path();
        let bytes = match self.place {
            Place::Row(id) => sqlite_file::fetch(path, id)?,
            Place::Record { offset, before } => mcap_file::fetch(path, offset, before)?,
        };
        let bytes = match self.bag.compression {
            Compression::Messages => zstd::decode_all(&bytes[..]).map_err(|error| error.to_string())?,
            Compression::None | Compression::Files => bytes,
        };
        if self.topic.is_compressed_image() {
            message::compressed_image(&bytes)
        } else {
            message::image(&bytes)
        }
    }

    /// See [`Source::identity`](super::recording::Source::identity).
    pub(super) fn identity(&self) -> String {
        let file = &self.bag.files[self.file];
        format!("{} {} {} {:?}", file.name.display(), file.bytes, self.topic.name, self.place)
    }
}

/// The files of a bag.
#[derive(Debug)]
struct Bag {
    storage: Storage,
    compression: Compression,
    files: Vec<BagFile>,
}

#[derive(Debug)]
struct BagFile {
    /// The path as stored in the bag.
    name: PathBuf,
    /// Its length there, bytes.
    bytes: u64,
    /// The decompressed copy of a file that is compressed as a whole; deleted with the bag.
    unpacked: Option<TempPath>,
}

impl BagFile {
    fn path(&self) -> &Path {
        self.unpacked.as_deref().unwrap_or(&self.name)
    }
}

impl Bag {
    fn open(dir: &Path, metadata: Metadata) -> Result<Self, DatasetError> {
        let Metadata { storage, compression, files, .. } = metadata;
        let open = |name: PathBuf| {
            let data = std::fs::metadata(&name).map_err(|error| error.to_string());
            let bytes =
                data.map_err(|problem| DatasetError::bad(&name, format!("cannot be read: {problem}")))?.len();
            let unpacked = match compression {
                Compression::Files => {
                    Some(unpack(&name).map_err(|error| DatasetError::bad(&name, format!("zstd: {error}")))?)
                }
                Compression::None | Compression::Messages => None,
            };
            Ok(BagFile { name, bytes, unpacked })
        };
        let files: Result<_, DatasetError> = files.iter().map(|file| open(dir.join(file))).collect();
        Ok(Self { storage, compression, files: files? })
    }
}

/// Decompresses a file into a temporary one: storages need random access.
fn unpack(packed: &Path) -> std::io::Result<TempPath> {
    let mut unpacked = tempfile::NamedTempFile::new()?;
    zstd::stream::copy_decode(File::open(packed)?, &mut unpacked)?;
    Ok(unpacked.into_temp_path())
}

/// The results of scanning a bag.
struct Scan {
    bag: Arc<Bag>,
    topics: Vec<(Role, Arc<Topic>)>,
    frames: [List<Message>; 2],
    readings: Vec<Reading>,
    steps: Box<dyn Steps>,
}

impl Scan {
    fn new(bag: Arc<Bag>, topics: Vec<(Role, Topic)>, steps: Box<dyn Steps>) -> Self {
        let topics = topics.into_iter().map(|(role, topic)| (role, Arc::new(topic))).collect();
        Self { bag, topics, frames: [List::new(), List::new()], readings: Vec::new(), steps }
    }

    fn visit(&mut self, file: usize) -> Result<(), DatasetError> {
        let bag = Arc::clone(&self.bag);
        let names: Vec<String> = self.topics.iter().map(|(_, topic)| topic.name.clone()).collect();
        let mut take = |topic: usize, place: Place, input: &mut dyn Read| {
            self.steps.step();
            self.take(topic, file, place, input).map_err(|problem| format!("{}: {problem}", names[topic]))
        };
        let file = &bag.files[file];
        let visited = match bag.storage {
            Storage::Sqlite => sqlite_file::visit(file.path(), &names, &mut take),
            Storage::Mcap => mcap_file::visit(file.path(), &names, &mut take),
        };
        visited.map_err(|problem| DatasetError::bad(&file.name, problem))
    }

    fn take(&mut self, topic: usize, file: usize, place: Place, input: &mut dyn Read) -> Result<(), String> {
        let mut unpacked;
        let input: &mut dyn Read = match self.bag.compression {
            Compression::Messages => {
                unpacked = zstd::Decoder::new(input).map_err(|error| error.to_string())?;
                &mut unpacked
            }
            Compression::None | Compression::Files => input,
        };
        let (role, topic) = &self.topics[topic];
        match role {
            Role::Camera(camera) => {
                let (bag, topic) = (Arc::clone(&self.bag), Arc::clone(topic));
                let stamp_ns = message::stamp(input)?;
                let message = Message { bag, topic, file, place, stamp_ns };
                match self.frames[*camera].insert(stamp_ns, message) {
                    Some(_) => Err(format!("two messages have the stamp {stamp_ns} ns")),
                    None => Ok(()),
                }
            }
            Role::Imu => {
                self.readings.push(message::imu(input)?);
                Ok(())
            }
        }
    }

    fn finish(self, dir: &Path) -> Result<Contents, DatasetError> {
        let mut topics = Topics::default();
        let mut imu = None;
        for (role, Topic { name, .. }) in self.topics.iter().map(|(role, topic)| (role, &**topic)) {
            let is_empty = match *role {
                Role::Camera(camera) => {
                    topics.cameras[camera] = Some(name.clone());
                    self.frames[camera].is_empty()
                }
                Role::Imu => {
                    topics.imu = Some(name.clone());
                    imu = Some(dir.join(name.trim_start_matches('/')));
                    self.readings.is_empty()
                }
            };
            if is_empty {
                return Err(DatasetError::bad(dir, format!("{name}: no messages")));
            }
        }
        let imu = imu.map(|name| Readings::new(name, self.readings));
        Ok(Contents { frames: self.frames, imu, topics })
    }
}
