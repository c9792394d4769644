//! ROS 2 bags for tests, in the format of rosbag2.

use byteorder::LittleEndian;
use mcap::records::MessageHeader;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;

/// The storage of a bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// `SQLite`.
    Sqlite,
    /// `SQLite`, each file compressed as a whole.
    SqlitePackedFiles,
    /// `SQLite`, each message compressed.
    SqlitePackedMessages,
    /// MCAP without chunks.
    McapPlain,
    /// MCAP with uncompressed chunks.
    McapChunks,
    /// MCAP with chunks compressed by zstd.
    McapZstd,
    /// MCAP with chunks compressed by lz4.
    McapLz4,
    /// MCAP, each message compressed.
    McapPackedMessages,
}

impl Layout {
    /// All storages.
    pub const ALL: [Self; 8] = [
        Self::Sqlite,
        Self::SqlitePackedFiles,
        Self::SqlitePackedMessages,
        Self::McapPlain,
        Self::McapChunks,
        Self::McapZstd,
        Self::McapLz4,
        Self::McapPackedMessages,
    ];

    const fn is_sqlite(self) -> bool {
        matches!(self, Self::Sqlite | Self::SqlitePackedFiles | Self::SqlitePackedMessages)
    }

    const fn mode(self) -> &'static str {
        match self {
            Self::SqlitePackedFiles => "FILE",
            Self::SqlitePackedMessages | Self::McapPackedMessages => "MESSAGE",
            _ => "",
        }
    }

    fn file(self, number: usize) -> String {
        let extension = if self.is_sqlite() { "db3" } else { "mcap" };
        let packed = if self == Self::SqlitePackedFiles { ".zstd" } else { "" };
        format!("bag_{number}.{extension}{packed}")
    }
}

/// A topic and its messages in CDR.
#[derive(Debug, Clone)]
struct Topic {
    name: String,
    kind: &'static str,
    /// Messages by recording time, nanoseconds.
    messages: BTreeMap<u64, Vec<u8>>,
}

/// A bag under construction.
#[derive(Debug, Clone, Default)]
pub struct Bag {
    topics: Vec<Topic>,
}

impl Bag {
    /// An empty bag.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a topic of a type such as `sensor_msgs/msg/Imu`, and returns its index.
    pub fn topic(&mut self, name: &str, kind: &'static str) -> usize {
        self.topics.push(Topic { name: name.into(), kind, messages: BTreeMap::new() });
        self.topics.len() - 1
    }

    /// Adds a message of a topic: a header with the stamp, then `body`. Its recording time is a little later than the
    /// stamp.
    ///
    /// # Panics
    /// When it cannot be encoded.
    pub fn push(&mut self, topic: usize, stamp_ns: u64, body: &impl Serialize) {
        let stamp = (stamp_ns / 1_000_000_000, stamp_ns % 1_000_000_000);
        let header = ((stamp.0 as i32, stamp.1 as u32), "frame");
        let body = cdr_encoding::to_vec::<_, LittleEndian>(&(header, body)).expect("message is encoded");
        let recorded = stamp_ns + 1_000_003 * (1 + topic as u64);
        self.push_raw(topic, recorded, [&[0, 1, 0, 0][..], &body].concat());
    }

    /// Adds a message without changes.
    pub fn push_raw(&mut self, topic: usize, recorded_ns: u64, message: Vec<u8>) {
        self.topics[topic].messages.insert(recorded_ns, message);
    }

    /// Adds a `sensor_msgs/msg/Image`, its rows `step` bytes apart.
    pub fn push_image(
        &mut self,
        topic: usize,
        stamp_ns: u64,
        size: (u32, u32),
        encoding: &str,
        step: u32,
        data: &[u8],
    ) {
        self.push(topic, stamp_ns, &(size.1, size.0, encoding, 0_u8, step, data));
    }

    /// Adds a `sensor_msgs/msg/Image` of one pixel with this stamp, recorded at another time.
    ///
    /// # Panics
    /// When it cannot be encoded.
    pub fn push_image_at(&mut self, topic: usize, stamp_ns: u64, recorded_ns: u64) {
        let stamp = ((stamp_ns / 1_000_000_000) as i32, (stamp_ns % 1_000_000_000) as u32);
        let message = ((stamp, "frame"), 1_u32, 1_u32, "mono8", 0_u8, 1_u32, &[7_u8][..]);
        let body = cdr_encoding::to_vec::<_, LittleEndian>(&message).expect("message is encoded");
        self.push_raw(topic, recorded_ns, [&[0, 1, 0, 0][..], &body].concat());
    }

    /// Adds a `sensor_msgs/msg/CompressedImage`.
    pub fn push_compressed(&mut self, topic: usize, stamp_ns: u64, file: &[u8]) {
        self.push(topic, stamp_ns, &("jpeg", file));
    }

    /// Adds a `sensor_msgs/msg/Imu`.
    pub fn push_imu(&mut self, topic: usize, stamp_ns: u64, acceleration: [f64; 3]) {
        self.push(topic, stamp_ns, &([0.0; 4], [0.0; 9], [0.0; 3], [0.0; 9], acceleration, [0.0; 9]));
    }

    /// Writes the bag into a folder, which is created: two files, the second of which begins half way through.
    ///
    /// # Panics
    /// When it cannot be written.
    pub fn write(&self, folder: &Path, layout: Layout) {
        std::fs::create_dir_all(folder).expect("folder of the bag is made");
        let mut all: Vec<(u64, usize, &[u8])> = Vec::new();
        for (number, topic) in self.topics.iter().enumerate() {
            all.extend(topic.messages.iter().map(|(time, message)| (*time, number, &message[..])));
        }
        all.sort_unstable();
        for (number, part) in all.chunks(all.len().div_ceil(2).max(1)).enumerate() {
            let path = folder.join(layout.file(number));
            let pack = layout.mode() == "MESSAGE";
            let packed =
                |data: &[u8]| if pack { zstd::encode_all(data, 1).expect("packed") } else { data.to_vec() };
            let part = part.iter().map(|(time, topic, data)| (*time, *topic, packed(data)));
            match layout {
                Layout::Sqlite | Layout::SqlitePackedMessages => self.write_sqlite(&path, part),
                Layout::SqlitePackedFiles => {
                    let plain = path.with_extension("");
                    self.write_sqlite(&plain, part);
                    let bytes = std::fs::read(&plain).expect("file is read");
                    std::fs::write(&path, zstd::encode_all(&bytes[..], 1).expect("packed"))
                        .expect("file is written");
                    std::fs::remove_file(plain).expect("file is removed");
                }
                _ => self.write_mcap(&path, layout, part),
            }
        }
        let files = all.len().clamp(1, 2);
        std::fs::write(folder.join("metadata.yaml"), self.metadata(layout, files))
            .expect("metadata is written");
    }

    fn write_sqlite(&self, path: &Path, messages: impl Iterator<Item = (u64, usize, Vec<u8>)>) {
        let mut database = rusqlite::Connection::open(path).expect("database is made");
        let tables = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
                      CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                        timestamp INTEGER NOT NULL, data BLOB NOT NULL);
                      CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
        database.execute_batch(tables).expect("tables are made");
        let transaction = database.transaction().expect("transaction");
        for (number, topic) in self.topics.iter().enumerate() {
            let row = (number as i64 + 1, &topic.name, topic.kind, "cdr", "");
            transaction.execute("INSERT INTO topics VALUES (?, ?, ?, ?, ?)", row).expect("topic is written");
        }
        for (time, topic, data) in messages {
            let row = (topic as i64 + 1, time as i64, data);
            let insert = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)";
            transaction.execute(insert, row).expect("message is written");
        }
        transaction.commit().expect("transaction ends");
    }

    fn write_mcap(&self, path: &Path, layout: Layout, messages: impl Iterator<Item = (u64, usize, Vec<u8>)>) {
        let compression = match layout {
            Layout::McapZstd => Some(mcap::Compression::Zstd),
            Layout::McapLz4 => Some(mcap::Compression::Lz4),
            _ => None,
        };
        let options =
            mcap::WriteOptions::new().compression(compression).use_chunks(layout != Layout::McapPlain);
        // Several messages per chunk.
        let options = options.chunk_size(Some(2000)).profile("ros2");
        let mut writer = options.create(File::create(path).expect("file is made")).expect("file is begun");
        let channel = |topic: &Topic| {
            let schema = writer.add_schema(topic.kind, "ros2msg", b"").expect("schema is written");
            writer.add_channel(schema, &topic.name, "cdr", &BTreeMap::new()).expect("channel is written")
        };
        let channels: Vec<u16> = self.topics.iter().map(channel).collect();
        for (time, topic, data) in messages {
            let channel_id = channels[topic];
            let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &data).expect("message is written");
        }
        writer.finish().expect("file is ended");
    }

    fn metadata(&self, layout: Layout, files: usize) -> String {
        let storage = if layout.is_sqlite() { "sqlite3" } else { "mcap" };
        let mode = layout.mode();
        let mut text = format!(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: {storage}\n  \
             compression_format: \"{}\"\n  compression_mode: \"{mode}\"\n  relative_file_paths:\n",
            if mode.is_empty() { "" } else { "zstd" }
        );
        for number in 0..files {
            let _ = writeln!(text, "    - {}", layout.file(number));
        }
        text.push_str("  topics_with_message_count:\n");
        for Topic { name, kind, messages } in &self.topics {
            let _ = writeln!(
                text,
                "    - topic_metadata:\n        name: {name}\n        type: {kind}\n        \
                 serialization_format: cdr\n        offered_qos_profiles: \"\"\n      message_count: {}",
                messages.len()
            );
        }
        text
    }
}
