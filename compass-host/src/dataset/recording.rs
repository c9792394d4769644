//! A recording: pairs of frames in time, and accelerometer readings, from a folder in the `EuRoC` layout or from a ROS
//! 2 bag. Frames are decoded on demand.

#[cfg(feature = "bag")]
use super::bag;
pub use super::error::DatasetError;
use super::euroc;
use super::faults::Faults;
use super::imu::Readings;
use super::pairs::{List, pair};
pub use super::topics::Topics;
use crate::calibration::Calibration;
use crate::frame::Frame;
use crate::image_file::ImageFileError;
use crate::input::{self, limits};
use crate::progress::{Progress, Silent};
use std::path::{Path, PathBuf};

/// The frames of one instant.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Time of the frame of cam0, or of cam1 without one, in nanoseconds.
    pub timestamp_ns: u64,
    /// The frames of cam0 and cam1; at least one exists.
    pub images: [Option<Source>; 2],
}

/// The location of a frame.
#[derive(Debug, Clone)]
pub enum Source {
    /// A file of its own.
    File(PathBuf),
    /// A message of a bag.
    #[cfg(feature = "bag")]
    Message(bag::Message),
}

impl Source {
    /// Reads and decodes the frame.
    ///
    /// # Errors
    /// [`DatasetError`] with the file and, in a bag, topic and time of a missing or damaged frame.
    pub fn read(&self) -> Result<Frame, DatasetError> {
        match self {
            Self::File(path) => Ok(Frame::read(path)?),
            #[cfg(feature = "bag")]
            Self::Message(message) => message.read(),
        }
    }

    /// Where the frame is, for messages.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            #[cfg(feature = "bag")]
            Self::Message(message) => message.name(),
        }
    }

    /// The bytes of the image file or of the message, as they are stored.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn contents(&self) -> Result<Vec<u8>, DatasetError> {
        match self {
            Self::File(path) => input::read(path, limits().image_bytes)
                .map_err(|source| ImageFileError::Read { path: path.clone(), source }.into()),
            #[cfg(feature = "bag")]
            Self::Message(message) => message.contents(),
        }
    }
}

/// Frames and readings.
#[derive(Debug)]
pub struct Recording {
    /// In the order of time.
    pub shots: Vec<Shot>,
    /// The accelerometer, if there is one.
    pub imu: Option<Readings>,
    /// The topics that were read from a bag.
    pub topics: Option<Topics>,
    /// What was left out.
    pub faults: Faults,
    /// What else a user should know: damage, times that were taken from elsewhere.
    pub notes: Vec<String>,
}

impl Recording {
    /// Reads the index of a recording and pairs the frames of the cameras: each with the nearest in time if that is
    /// within half the spacing of the frames; frames without such a partner stay single. The topics of a bag are those
    /// that `topics` names, else those of the calibration, else those that their names number. Items that are invalid
    /// are left out.
    ///
    /// # Errors
    /// [`DatasetError`]: a list or bag of which nothing can be read, a bag without the topics, or no frames.
    pub fn read(
        path: &Path,
        topics: Option<&Topics>,
        calibration: &Calibration,
    ) -> Result<Self, DatasetError> {
        Self::read_with_progress(path, topics, calibration, &Silent)
    }

    /// [`Recording::read`] with progress reports.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_with_progress(
        path: &Path,
        topics: Option<&Topics>,
        calibration: &Calibration,
        progress: &dyn Progress,
    ) -> Result<Self, DatasetError> {
        let recording = if is_bag(path) {
            read_bag(path, topics, calibration, progress)?
        } else if topics.is_some() {
            return Err(DatasetError::bad(path, "no ROS 2 bag; topics are its"));
        } else {
            read_folder(path, calibration)?
        };
        if recording.shots.is_empty() {
            return Err(DatasetError::bad(path, no_frames(path)));
        }
        Ok(recording)
    }

    fn new<T>(lists: [List<T>; 2], source: fn(T) -> Source) -> Self {
        let sources = lists.map(|list| list.into_iter().map(|(time, place)| (time, source(place))).collect());
        let shot = |(timestamp_ns, images)| Shot { timestamp_ns, images };
        let shots = pair(&sources).into_iter().map(shot).collect();
        Self { shots, imu: None, topics: None, faults: Faults::default(), notes: Vec::new() }
    }
}

fn read_folder(path: &Path, calibration: &Calibration) -> Result<Recording, DatasetError> {
    let folder = euroc::folder(path);
    let cameras = [0, 1].map(|number| calibration.names[number].as_deref());
    let euroc::Contents { frames, imu, faults } = euroc::read(&folder, cameras)?;
    let notes = if folder == path { vec![] } else { vec![format!("{} is read", folder.display())] };
    Ok(Recording { imu, faults, notes, ..Recording::new(frames, Source::File) })
}

#[cfg(feature = "bag")]
fn is_bag(path: &Path) -> bool {
    bag::is_one(path)
}

#[cfg(feature = "bag")]
fn read_bag(
    path: &Path,
    topics: Option<&Topics>,
    calibration: &Calibration,
    progress: &dyn Progress,
) -> Result<Recording, DatasetError> {
    let bag::Contents { frames, imu, topics, faults, notes } =
        bag::read(path, topics, calibration, progress)?;
    Ok(Recording { imu, topics: Some(topics), faults, notes, ..Recording::new(frames, Source::Message) })
}

#[cfg(not(feature = "bag"))]
fn is_bag(path: &Path) -> bool {
    path.is_file() || path.join("metadata.yaml").exists()
}

#[cfg(not(feature = "bag"))]
fn read_bag(
    path: &Path,
    _: Option<&Topics>,
    _: &Calibration,
    _: &dyn Progress,
) -> Result<Recording, DatasetError> {
    Err(DatasetError::bad(path, "a ROS 2 bag, and this program was built without the feature 'bag'"))
}

/// The error for what is no recording.
fn no_frames(path: &Path) -> String {
    if !path.exists() {
        return "does not exist".to_owned();
    }
    if path
        .extension()
        .is_some_and(|extension| ["mp4", "mov", "avi", "mkv", "insv"].iter().any(|e| extension == *e))
    {
        return "this is a video; decode it to images with their times first".to_owned();
    }
    "no frames; a recording is a folder with cam0/data.csv or cam1/data.csv, as the EuRoC layout has them, or a ROS 2 \
     bag: a folder with metadata.yaml, or a file .mcap or .db3"
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_without_a_recording_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let calibration = Calibration::nominal();
        let message = |path: &Path, topics: Option<&Topics>| {
            Recording::read(path, topics, &calibration).unwrap_err().to_string()
        };
        assert!(message(folder.path(), None).contains("no frames"));
        assert!(message(folder.path(), Some(&Topics::default())).contains("no ROS 2 bag"));
        let part = folder.path().join("a_0.mcap");
        std::fs::write(&part, "").unwrap();
        assert!(message(folder.path(), None).contains("a_0.mcap: neither an MCAP nor an SQLite file"));
        assert!(message(&part, None).contains("a_0.mcap: no frames"));
        assert!(message(Path::new("no/such"), None).contains("no/such: does not exist"));
        let video = folder.path().join("tour.mp4");
        std::fs::write(&video, "x").unwrap();
        assert!(message(&video, None).contains("this is a video"));
        let ros1 = folder.path().join("tour.bag");
        std::fs::write(&ros1, "#ROSBAG V2.0\n").unwrap();
        let named = message(&ros1, None);
        assert!(named.contains("this is a ROS 1 bag") && named.contains("rosbags-convert"), "{named}");
    }
}
