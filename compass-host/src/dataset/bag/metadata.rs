//! `metadata.yaml`: a bag's description of itself.

use super::topic::Topic;
use crate::image_file::one_line;
use crate::input;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// From this version on file names are relative to the bag's folder, before to its parent.
const BESIDE_METADATA: u32 = 4;

/// The contents of a bag. Storage and compression are recognised by the files themselves.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Metadata {
    /// Paths relative to the bag's folder, in order.
    pub(super) files: Vec<PathBuf>,
    pub(super) topics: Vec<Topic>,
}

impl Metadata {
    /// Reads the file; the error says what is wrong with it.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let limit = input::limits().settings_bytes;
        Self::parse(&input::read_text(path, limit).map_err(|error| format!("cannot be read: {error}"))?)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let Written { info } = serde_saphyr::from_str(text).map_err(|error| {
            format!("no metadata of a ROS 2 bag: {}", one_line(&error.without_snippet().to_string()))
        })?;
        if !info.compression_mode.is_empty() && !["", "zstd"].contains(&info.compression_format.as_str()) {
            return Err(format!("compression_format: '{}' is not known, only zstd", info.compression_format));
        }
        if info.relative_file_paths.is_empty() {
            return Err("relative_file_paths: names no file".to_owned());
        }
        let beside = |file: PathBuf| match file.file_name() {
            Some(name) if info.version < BESIDE_METADATA => PathBuf::from(name),
            _ => file,
        };
        let files: Vec<_> = info.relative_file_paths.into_iter().map(beside).collect();
        if let Some(outside) = files.iter().find(|file| !input::is_within(file)) {
            return Err(format!("relative_file_paths: {} is outside of the bag", outside.display()));
        }
        let topics = info.topics_with_message_count.into_iter().map(Topic::from).collect();
        Ok(Self { files, topics })
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

impl From<Counted> for Topic {
    fn from(counted: Counted) -> Self {
        let Described { name, kind, serialization_format } = counted.topic_metadata;
        Self { name, written_kind: kind, format: serialization_format, count: counted.message_count }
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
        let topic = Topic {
            name: "/cam0".into(),
            written_kind: "sensor_msgs/msg/Image".into(),
            format: "cdr".into(),
            count: 7,
        };
        let good = Metadata { files: vec!["bag/a_0.db3".into(), "bag/a_1.db3".into()], topics: vec![topic] };
        assert_eq!(Metadata::parse(GOOD).unwrap(), good);
        let old = Metadata::parse(&GOOD.replace("version: 5", "version: 3")).unwrap();
        assert_eq!(old.files, [PathBuf::from("a_0.db3"), PathBuf::from("a_1.db3")]);
        let packed = GOOD.replace("format: \"\"", "format: zstd").replace("mode: \"\"", "mode: FILE");
        assert_eq!(Metadata::parse(&packed).unwrap(), good);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (from, to, named) in [
            ("format: \"\"\n  compression_mode: \"\"", "format: lz4\n  compression_mode: FILE", "'lz4'"),
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
