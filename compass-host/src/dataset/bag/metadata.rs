//! `metadata.yaml`: a bag's description of itself.

use crate::image_file::one_line;
use serde::Deserialize;
use std::path::{Path, PathBuf};

const IMAGE: &str = "sensor_msgs/msg/Image";
const COMPRESSED_IMAGE: &str = "sensor_msgs/msg/CompressedImage";
const IMU: &str = "sensor_msgs/msg/Imu";

/// From this version on file names are relative to the bag's folder, before to its parent.
const BESIDE_METADATA: u32 = 4;

/// The storage format of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    Sqlite,
    Mcap,
}

/// Compression by rosbag2 itself, with zstd; chunks of MCAP are compressed by the storage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Files,
    Messages,
}

/// A topic of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    pub(super) name: String,
    /// Such as `sensor_msgs/msg/Image`.
    pub(super) kind: String,
    /// Number of messages according to the metadata.
    pub(super) count: usize,
}

impl Topic {
    pub(super) fn is_image(&self) -> bool {
        self.kind == IMAGE || self.is_compressed_image()
    }

    pub(super) fn is_compressed_image(&self) -> bool {
        self.kind == COMPRESSED_IMAGE
    }

    pub(super) fn is_imu(&self) -> bool {
        self.kind == IMU
    }
}

/// The contents of a bag.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Metadata {
    pub(super) storage: Storage,
    pub(super) compression: Compression,
    /// Paths relative to the bag's folder, in order.
    pub(super) files: Vec<PathBuf>,
    pub(super) topics: Vec<Topic>,
}

impl Metadata {
    /// Reads the file; the error says what is wrong with it.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        Self::parse(&std::fs::read_to_string(path).map_err(|error| format!("cannot be read: {error}"))?)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let Written { info } = serde_saphyr::from_str(text).map_err(|error| {
            format!("no metadata of a ROS 2 bag: {}", one_line(&error.without_snippet().to_string()))
        })?;
        let storage = match info.storage_identifier.as_str() {
            "sqlite3" => Storage::Sqlite,
            "mcap" => Storage::Mcap,
            other => {
                return Err(format!("storage_identifier: '{other}' is not known, only sqlite3 and mcap"));
            }
        };
        let compression = match info.compression_mode.to_lowercase().as_str() {
            "" | "none" => Compression::None,
            "file" => Compression::Files,
            "message" => Compression::Messages,
            other => return Err(format!("compression_mode: '{other}' is not known, only file and message")),
        };
        if compression != Compression::None && info.compression_format != "zstd" {
            return Err(format!("compression_format: '{}' is not known, only zstd", info.compression_format));
        }
        if info.relative_file_paths.is_empty() {
            return Err("relative_file_paths: names no file".to_owned());
        }
        let beside = |file: PathBuf| match file.file_name() {
            Some(name) if info.version < BESIDE_METADATA => PathBuf::from(name),
            _ => file,
        };
        let files = info.relative_file_paths.into_iter().map(beside).collect();
        let topics =
            info.topics_with_message_count.into_iter().map(Counted::topic).collect::<Result<_, _>>()?;
        Ok(Self { storage, compression, files, topics })
    }
}

#[derive(Deserialize)]
struct Written {
    #[serde(rename = "rosbag2_bagfile_information")]
    info: Information,
}

#[derive(Deserialize)]
struct Information {
    version: u32,
    storage_identifier: String,
    relative_file_paths: Vec<PathBuf>,
    topics_with_message_count: Vec<Counted>,
    #[serde(default)]
    compression_format: String,
    #[serde(default)]
    compression_mode: String,
}

#[derive(Deserialize)]
struct Counted {
    topic_metadata: Described,
    message_count: usize,
}

#[derive(Deserialize)]
struct Described {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    serialization_format: String,
}

impl Counted {
    fn topic(self) -> Result<Topic, String> {
        let Described { name, kind, serialization_format } = self.topic_metadata;
        let topic = Topic { name, kind, count: self.message_count };
        let is_ours = topic.is_image() || topic.is_imu();
        if is_ours && serialization_format != "cdr" {
            return Err(format!(
                "{}: serialization_format '{serialization_format}' is not known, only cdr",
                topic.name
            ));
        }
        Ok(topic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "\
rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  duration: {nanoseconds: 5}
  message_count: 7
  topics_with_message_count:
    - topic_metadata:
        name: /cam0
        type: sensor_msgs/msg/Image
        serialization_format: cdr
        offered_qos_profiles: \"- history: 3\\n  depth: 0\"
      message_count: 7
  compression_format: \"\"
  compression_mode: \"\"
  relative_file_paths:
    - bag/a_0.db3
    - bag/a_1.db3
";

    #[test]
    fn what_a_bag_says_is_read() {
        let topic = Topic { name: "/cam0".into(), kind: IMAGE.into(), count: 7 };
        let good = Metadata {
            storage: Storage::Sqlite,
            compression: Compression::None,
            files: vec!["bag/a_0.db3".into(), "bag/a_1.db3".into()],
            topics: vec![topic],
        };
        assert_eq!(Metadata::parse(GOOD).unwrap(), good);
        let old = Metadata::parse(&GOOD.replace("version: 5", "version: 3")).unwrap();
        assert_eq!(old.files, [PathBuf::from("a_0.db3"), PathBuf::from("a_1.db3")]);
        let packed = GOOD.replace("format: \"\"", "format: zstd").replace("mode: \"\"", "mode: FILE");
        assert_eq!(Metadata::parse(&packed).unwrap().compression, Compression::Files);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (from, to, named) in [
            ("sqlite3", "rosbag_v2", "storage_identifier: 'rosbag_v2'"),
            ("mode: \"\"", "mode: SPEED", "compression_mode: 'speed'"),
            ("format: \"\"\n  compression_mode: \"\"", "format: lz4\n  compression_mode: FILE", "'lz4'"),
            ("format: cdr", "format: xml", "/cam0: serialization_format 'xml'"),
            ("\n    - bag/a_0.db3\n    - bag/a_1.db3", " []", "names no file"),
            ("  version: 5\n", "", "version"),
            ("rosbag2_bagfile_information", "cam0", "no metadata of a ROS 2 bag"),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let problem = Metadata::parse(&GOOD.replace(from, to)).unwrap_err();
            assert!(problem.contains(named) && !problem.contains('\n'), "{to}: {problem}");
        }
    }
}
