//! One pass over a bag, for the times of its frames and the readings of its IMU.

use super::choice::Role;
use super::contents::{Bag, Contents, Message};
use super::file::{Storage, ZSTD};
use super::place::{Found, Place};
use super::topic::Topic;
use super::{mcap_file, message, sqlite_file};
use crate::dataset::error::DatasetError;
use crate::dataset::faults::{Faults, Item};
use crate::dataset::imu::{Reading, Readings};
use crate::dataset::pairs::List;
use crate::dataset::topics::Topics;
use crate::progress::Steps;
use nalgebra::Vector3;
use std::collections::btree_map::Entry;
use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::Arc;

/// An item with its two times, nanoseconds.
struct Timed<T> {
    /// By its header; 0 if that is not set.
    stamp_ns: u64,
    recorded_ns: u64,
    at: At,
    item: T,
}

/// Where a message is.
#[derive(Clone, Copy)]
struct At {
    /// Index of the file.
    file: usize,
    place: Place,
}

/// The results of scanning a bag.
pub(super) struct Scan {
    bag: Arc<Bag>,
    roles: Vec<(Role, Arc<Topic>)>,
    /// The topics, each once.
    names: Vec<String>,
    frames: [Vec<Timed<Message>>; 2],
    readings: Vec<Timed<Vector3<f64>>>,
    faults: Faults,
    /// Files that are damaged.
    damage: Vec<DatasetError>,
    notes: Vec<String>,
    steps: Box<dyn Steps>,
}

impl Scan {
    pub(super) fn new(
        bag: Arc<Bag>,
        topics: Vec<(Role, Topic)>,
        notes: Vec<String>,
        steps: Box<dyn Steps>,
    ) -> Self {
        let roles: Vec<_> = topics.into_iter().map(|(role, topic)| (role, Arc::new(topic))).collect();
        let mut names: Vec<String> = Vec::new();
        for (_, topic) in &roles {
            if !names.contains(&topic.name) {
                names.push(topic.name.clone());
            }
        }
        Self {
            bag,
            roles,
            names,
            frames: [Vec::new(), Vec::new()],
            readings: Vec::new(),
            faults: Faults::default(),
            damage: Vec::new(),
            notes,
            steps,
        }
    }

    /// Visits all files; what cannot be read of one is left out.
    pub(super) fn run(&mut self) {
        let bag = Arc::clone(&self.bag);
        let names = self.names.clone();
        for (number, file) in bag.files.iter().enumerate() {
            let mut take = |found: Found<'_>| self.take(number, found);
            let visited = match file.storage {
                Storage::Sqlite => {
                    sqlite_file::visit(file.path(), &names, &mut take).map(|()| mcap_file::Damage::default())
                }
                Storage::Mcap => mcap_file::visit(file.path(), &names, &mut take),
            };
            let damage = visited
                .unwrap_or_else(|problem| mcap_file::Damage { chunks: Vec::new(), end: Some(problem) });
            let problems = damage.chunks.into_iter().chain(damage.end);
            self.damage.extend(problems.map(|problem| DatasetError::bad(&file.name, problem)));
        }
    }

    fn take(&mut self, file: usize, Found { topic, place, recorded_ns, bytes }: Found<'_>) {
        self.steps.step();
        let name = &self.names[topic];
        let serving: Vec<_> = self.roles.iter().filter(|(_, topic)| topic.name == *name).cloned().collect();
        let at = At { file, place };
        let is_imu = serving.iter().any(|(role, _)| *role == Role::Imu);
        if is_imu {
            match plain(bytes).and_then(message::imu) {
                Ok((stamp_ns, item)) => {
                    self.readings.push(Timed { stamp_ns, recorded_ns, at, item });
                }
                Err(problem) => self.leave_out(Item::Reading, topic, at, problem),
            }
            return;
        }
        match plain(bytes).and_then(message::stamp) {
            Ok(stamp_ns) => {
                for (role, topic) in serving {
                    let Role::Camera(camera) = role else { continue };
                    let item = Message { bag: Arc::clone(&self.bag), topic, file, place, time_ns: stamp_ns };
                    self.frames[camera].push(Timed { stamp_ns, recorded_ns, at, item });
                }
            }
            Err(problem) => self.leave_out(Item::Frame, topic, at, problem),
        }
    }

    /// Leaves out a message of a topic.
    fn leave_out(&mut self, item: Item, topic: usize, at: At, problem: impl Into<String>) {
        let name = self.names[topic].clone();
        self.leave_out_named(item, &name, at, problem);
    }

    fn leave_out_named(
        &mut self,
        item: Item,
        topic: &str,
        At { file, place }: At,
        problem: impl Into<String>,
    ) {
        let place = match place {
            Place::Row(id) => format!("row {id}"),
            Place::Record { offset, before } => format!("byte {offset}, message {before}"),
        };
        let file = self.bag.files[file].name.display();
        self.faults.add(item, format!("{file}: {topic}, {place}"), problem);
    }

    pub(super) fn finish(mut self, path: &Path) -> Result<Contents, DatasetError> {
        let mut topics = Topics::default();
        let mut frames = [List::new(), List::new()];
        for (role, topic) in std::mem::take(&mut self.roles) {
            let Role::Camera(camera) = role else {
                topics.imu = Some(topic.name.clone());
                continue;
            };
            topics.cameras[camera] = Some(topic.name.clone());
            let found = std::mem::take(&mut self.frames[camera]);
            frames[camera] = self.frames_by_time(&topic.name, found);
        }
        if frames.iter().all(List::is_empty) {
            return Err(self.nothing(path, &topics));
        }
        let imu = topics.imu.clone().map(|name| {
            let readings = self.readings_by_time(&name);
            Readings::new(path.join(name.trim_start_matches('/')), readings)
        });
        let rest = |error: &DatasetError| format!("{error}; what is whole is used");
        self.notes.extend(self.damage.iter().map(rest));
        Ok(Contents { frames, imu, topics, faults: self.faults, notes: self.notes })
    }

    /// Why there is no frame.
    fn nothing(self, path: &Path, topics: &Topics) -> DatasetError {
        if let Some(damage) = self.damage.into_iter().next() {
            return damage;
        }
        match self.faults.first().first() {
            Some(fault) => DatasetError::bad(Path::new(&fault.place), fault.problem.clone()),
            None => {
                let names: Vec<_> = topics.cameras.iter().flatten().map(String::as_str).collect();
                DatasetError::bad(path, format!("{}: no messages", names.join(" and ")))
            }
        }
    }

    /// The frames of a camera by time; of two at one time the first stays.
    fn frames_by_time(&mut self, name: &str, found: Vec<Timed<Message>>) -> List<Message> {
        if found.is_empty() {
            self.notes.push(format!("{name}: no frames"));
        }
        let by_recording = self.lacks_stamps(name, &found);
        let mut frames = List::new();
        for Timed { stamp_ns, recorded_ns, at, item } in found {
            let time_ns = if by_recording { recorded_ns } else { stamp_ns };
            if time_ns == 0 {
                self.leave_out_named(Item::Frame, name, at, "its stamp is 0");
                continue;
            }
            match frames.entry(time_ns) {
                Entry::Occupied(_) => {
                    let problem = format!("another frame has the stamp {time_ns} ns");
                    self.leave_out_named(Item::Frame, name, at, problem);
                }
                Entry::Vacant(free) => {
                    free.insert(Message { time_ns, ..item });
                }
            }
        }
        self.faults.count_used(Item::Frame, frames.len());
        frames
    }

    fn readings_by_time(&mut self, name: &str) -> Vec<Reading> {
        let found = std::mem::take(&mut self.readings);
        if found.is_empty() {
            self.notes.push(format!("{name}: no readings"));
        }
        let by_recording = self.lacks_stamps(name, &found);
        let mut readings = Vec::new();
        for Timed { stamp_ns, recorded_ns, at, item: acceleration } in found {
            match if by_recording { recorded_ns } else { stamp_ns } {
                0 => self.leave_out_named(Item::Reading, name, at, "its stamp is 0"),
                timestamp_ns => readings.push(Reading { timestamp_ns, acceleration }),
            }
        }
        self.faults.count_used(Item::Reading, readings.len());
        readings
    }

    /// Whether no message of a topic has a stamp, so that the times of recording are all there is.
    fn lacks_stamps<T>(&mut self, name: &str, found: &[Timed<T>]) -> bool {
        let lacks = !found.is_empty() && found.iter().all(|timed| timed.stamp_ns == 0);
        if lacks {
            self.notes.push(format!("{name}: all stamps are 0; the times of recording are used"));
        }
        lacks
    }
}

/// A message, decompressed if rosbag2 compressed it by itself.
fn plain(bytes: &mut dyn Read) -> Result<Box<dyn Read + '_>, String> {
    let mut head = Vec::new();
    bytes.take(ZSTD.len() as u64).read_to_end(&mut head).map_err(|error| error.to_string())?;
    let is_packed = head == ZSTD;
    let whole = Cursor::new(head).chain(bytes);
    if is_packed {
        return Ok(Box::new(zstd::Decoder::new(whole).map_err(|error| error.to_string())?));
    }
    Ok(Box::new(whole))
}
