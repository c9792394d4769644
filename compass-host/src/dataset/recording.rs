//! A recording: pairs of frames in time, and accelerometer readings, from a folder in the `EuRoC` layout or from a ROS
//! 2 bag. Frames are decoded on demand.

#[cfg(feature = "bag")]
use super::bag;
pub use super::error::DatasetError;
use super::euroc;
use super::imu::Readings;
use super::pairs::{List, pair};
pub use super::topics::Topics;
use crate::calibration::Calibration;
use crate::frame::Frame;
use crate::progress::{Progress, Silent};
use std::path::{Path, PathBuf};

/// The file that distinguishes a bag from other folders.
const METADATA: &str = "metadata.yaml";

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

    /// Identifies this frame among others, and detects that its data were replaced.
    #[must_use]
    pub fn identity(&self) -> String {
        match self {
            Self::File(path) => {
                format!("{} {:?}", path.display(), std::fs::metadata(path).map(|data| data.len()).ok())
            }
            #[cfg(feature = "bag")]
            Self::Message(message) => message.identity(),
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
}

impl Recording {
    /// Reads the index of a recording and pairs the frames of the cameras: each with the nearest in time if that is
    /// within half the spacing of the frames; frames without such a partner stay single. The topics of a bag are those
    /// that `topics` names, else those of the calibration, else the only candidates.
    ///
    /// # Errors
    /// [`DatasetError`]: a file that cannot be read or is damaged, a list that names a missing file, a bag without the
    /// topics, or no frames.
    pub fn read(
        dir: &Path,
        topics: Option<&Topics>,
        calibration: &Calibration,
    ) -> Result<Self, DatasetError> {
        Self::read_with_progress(dir, topics, calibration, &Silent)
    }

    /// [`Recording::read`] with progress reports.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_with_progress(
        dir: &Path,
        topics: Option<&Topics>,
        calibration: &Calibration,
        progress: &dyn Progress,
    ) -> Result<Self, DatasetError> {
        if dir.join(METADATA).exists() {
            return read_bag(dir, topics, calibration, progress);
        }
        if topics.is_some() {
            return Err(DatasetError::bad(
                dir,
                format!("no ROS 2 bag: {METADATA} is missing; topics are its"),
            ));
        }
        let (lists, imu) = euroc::read(dir)?;
        match Self::new(lists, Source::File, imu, None) {
            recording if recording.shots.is_empty() => Err(DatasetError::bad(dir, no_frames(dir))),
            recording => Ok(recording),
        }
    }

    fn new<T>(
        lists: [List<T>; 2],
        source: fn(T) -> Source,
        imu: Option<Readings>,
        topics: Option<Topics>,
    ) -> Self {
        let sources = lists.map(|list| list.into_iter().map(|(time, place)| (time, source(place))).collect());
        let shot = |(timestamp_ns, images)| Shot { timestamp_ns, images };
        Self { shots: pair(&sources).into_iter().map(shot).collect(), imu, topics }
    }
}

#[cfg(feature = "bag")]
fn read_bag(
    dir: &Path,
    topics: Option<&Topics>,
    calibration: &Calibration,
    progress: &dyn Progress,
) -> Result<Recording, DatasetError> {
    let bag::Contents { frames, imu, topics } =
        bag::read(dir, &dir.join(METADATA), topics, calibration, progress)?;
    Ok(Recording::new(frames, Source::Message, imu, Some(topics)))
}

#[cfg(not(feature = "bag"))]
fn read_bag(
    dir: &Path,
    _: Option<&Topics>,
    _: &Calibration,
    _: &dyn Progress,
) -> Result<Recording, DatasetError> {
    Err(DatasetError::bad(dir, "a ROS 2 bag, and this program was built without the feature 'bag'"))
}

/// The error for a folder that has neither lists nor metadata.
fn no_frames(dir: &Path) -> String {
    let is_of_bag = |path: PathBuf| {
        path.extension()
            .is_some_and(|extension| ["db3", "mcap", "zstd"].iter().any(|known| extension == *known))
    };
    let has_parts =
        std::fs::read_dir(dir).is_ok_and(|entries| entries.flatten().any(|entry| is_of_bag(entry.path())));
    match has_parts {
        true => {
            format!("{METADATA} is missing beside the files of a ROS 2 bag; 'ros2 bag reindex' writes it")
        }
        false => format!(
            "no frames; a recording is a folder with cam0/data.csv or cam1/data.csv, as the EuRoC layout has them, or \
             with {METADATA} of a ROS 2 bag"
        ),
    }
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
        assert!(message(folder.path(), None).contains("metadata.yaml is missing"));
        assert!(message(&part, None).contains("a_0.mcap: no frames"), "not the folder, but its file");
    }
}
