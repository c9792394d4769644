//! A recording: pairs of frames in time, and an accelerometer beside them, from a folder in the `EuRoC` layout or
//! from a ROS 2 bag. Frames are decoded when they are needed.

#[cfg(feature = "bag")]
use super::bag::{self, read as read_bag};
use super::euroc;
use super::imu::Readings;
use super::lines::LinesError;
use super::pairs::{List, pair};
pub use super::topics::Topics;
use crate::calibration::Calibration;
use crate::frame::Frame;
use crate::image_file::ImageFileError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What tells a bag from other folders.
pub(super) const METADATA: &str = "metadata.yaml";

/// Why a recording could not be read: one line, with the file and the place at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A list cannot be read, or a line of it is no frame or reading.
    #[error(transparent)]
    Lines(#[from] LinesError),
    /// A frame cannot be read.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// The folder, or a file of a bag, is not as it should be.
    #[error("{}: {problem}", path.display())]
    Bad {
        /// The folder or file.
        path: PathBuf,
        /// What is wrong with it, and where.
        problem: String,
    },
}

impl DatasetError {
    pub(super) fn bad(path: &Path, problem: impl Into<String>) -> Self {
        Self::Bad { path: path.to_path_buf(), problem: problem.into() }
    }
}

/// The frames of one moment.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Time of the frame of cam0, of cam1 where there is none, in nanoseconds.
    pub timestamp_ns: u64,
    /// The frames of cam0 and cam1; at least one is there.
    pub images: [Option<Source>; 2],
}

/// Where a frame is.
#[derive(Debug, Clone)]
pub enum Source {
    /// In a file of its own.
    File(PathBuf),
    /// In a bag.
    #[cfg(feature = "bag")]
    Message(bag::Message),
}

impl Source {
    /// Reads and decodes the frame.
    ///
    /// # Errors
    /// [`DatasetError`] with the file and, in a bag, topic and time of a frame that is not there or damaged.
    pub fn read(&self) -> Result<Frame, DatasetError> {
        match self {
            Self::File(path) => Ok(Frame::read(path)?),
            #[cfg(feature = "bag")]
            Self::Message(message) => message.read(),
        }
    }

    /// Tells this frame from others, and from what may later be in its place.
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
    /// The accelerometer, where there is one.
    pub imu: Option<Readings>,
    /// What was taken from a bag.
    pub topics: Option<Topics>,
}

impl Recording {
    /// Reads what a recording consists of, and pairs the frames of the cameras: each with the nearest in time if that
    /// is within half the spacing of the frames; frames without such a partner stand alone. The topics of a bag are those
    /// that `topics` names, else those of the calibration, else the only ones there are.
    ///
    /// # Errors
    /// [`DatasetError`]: a file that cannot be read or is damaged, a list that names a missing file, a bag without the
    /// topics, or no frames.
    pub fn read(
        dir: &Path,
        topics: Option<&Topics>,
        calibration: &Calibration,
    ) -> Result<Self, DatasetError> {
        if dir.join(METADATA).exists() {
            return read_bag(dir, topics, calibration);
        }
        if topics.is_some() {
            return Err(DatasetError::bad(
                dir,
                format!("no ROS 2 bag: {METADATA} is missing; topics are its"),
            ));
        }
        let (lists, imu) = euroc::read(dir)?;
        let lists =
            lists.map(|list| list.into_iter().map(|(time, file)| (time, Source::File(file))).collect());
        match Self::new(&lists, imu, None) {
            recording if recording.shots.is_empty() => Err(DatasetError::bad(dir, no_frames(dir))),
            recording => Ok(recording),
        }
    }

    pub(super) fn new(lists: &[List<Source>; 2], imu: Option<Readings>, topics: Option<Topics>) -> Self {
        let shot = |(timestamp_ns, images)| Shot { timestamp_ns, images };
        Self { shots: pair(lists).into_iter().map(shot).collect(), imu, topics }
    }
}

#[cfg(not(feature = "bag"))]
fn read_bag(dir: &Path, _: Option<&Topics>, _: &Calibration) -> Result<Recording, DatasetError> {
    Err(DatasetError::bad(dir, "a ROS 2 bag, and this program was built without the feature 'bag'"))
}

/// What is wrong with a folder that has neither lists nor metadata.
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
    fn a_folder_that_is_no_recording_is_told_so() {
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
