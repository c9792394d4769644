//! A file of a bag in MCAP storage: records, most of them in chunks, which may be compressed with zstd or lz4.

use super::place::{Found, Place, Take};
use super::topic::Topic;
use crate::guard;
use crate::input;
use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, Summary};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::ControlFlow::{self, Break, Continue};
use std::path::Path;

/// Largest read at a time, bytes: the length field of a damaged record may have any value.
const READ_BYTES: usize = 1 << 20;
/// Longest record or unpacked chunk, bytes: its buffer is allocated before it is filled.
fn record_bytes() -> usize {
    usize::try_from(input::limits().message_bytes).unwrap_or(usize::MAX)
}

/// Bytes of a record's header: opcode and length.
const HEAD: usize = 9;
/// Bytes before the first record.
const MAGIC: u64 = 8;

/// What a reader makes of a file; its panic is an error of the file.
fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    guard::guarded(read).unwrap_or_else(|| Err(format!("not a whole MCAP file: {}", guard::GAVE_UP)))
}

/// The topics of a file by name: from its summary, or of a file without one from all its records.
pub(super) fn topics(path: &Path) -> Result<Vec<Topic>, String> {
    guarded(|| read_topics(path))
}

fn read_topics(path: &Path) -> Result<Vec<Topic>, String> {
    let file = input::open(path).map_err(|error| error.to_string())?;
    if let Ok(Some(summary)) = summary(&file)
        && !summary.channels.is_empty()
    {
        let counts = summary.stats.map(|stats| stats.channel_message_counts).unwrap_or_default();
        let topic = |channel: &mcap::Channel<'_>| Topic {
            name: channel.topic.clone(),
            written_kind: channel.schema.as_ref().map_or(String::new(), |schema| schema.name.clone()),
            format: channel.message_encoding.clone(),
            count: counts.get(&channel.id).map_or(0, |count| usize::try_from(*count).unwrap_or_default()),
        };
        return Ok(by_name(summary.channels.values().map(|channel| topic(channel))));
    }
    let (mut schemas, mut channels) = (HashMap::new(), Vec::new());
    let file = input::open(path).map_err(|error| error.to_string())?;
    let options = LinearReaderOptions::default().with_record_length_limit(record_bytes());
    let read = records(file, options, |opcode, data| {
        // Others are not asked to be right.
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            match parse(opcode, data)? {
                Record::Schema { header, .. } => {
                    schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => channels.push(channel),
                _ => {}
            }
        }
        Ok(if opcode == op::DATA_END { Break(()) } else { Continue(()) })
    });
    // Of a file that is cut off, the topics up to there count.
    match read {
        Err(problem) if channels.is_empty() => Err(problem),
        _ => Ok(by_name(channels.into_iter().map(|channel| Topic {
            written_kind: schemas.get(&channel.schema_id).cloned().unwrap_or_default(),
            name: channel.topic,
            format: channel.message_encoding,
            count: 0,
        }))),
    }
}

fn by_name(topics: impl Iterator<Item = Topic>) -> Vec<Topic> {
    let topics: BTreeMap<_, _> = topics.map(|topic| (topic.name.clone(), topic)).collect();
    topics.into_values().collect()
}

fn summary(mut file: &File) -> Result<Option<Summary>, McapError> {
    let mut options = SummaryReaderOptions::default().with_record_length_limit(record_bytes());
    if let Ok(data) = file.metadata() {
        options = options.with_file_size(data.len());
    }
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(bytes) => {
                let read = file.read(reader.insert(bytes))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    Ok(reader.finish())
}

/// What of a file could not be read.
#[derive(Debug, Default)]
pub(super) struct Damage {
    /// Chunks in the middle.
    pub(super) chunks: Vec<String>,
    /// Why the end is missing.
    pub(super) end: Option<String>,
}

/// Passes the messages of these topics to `take`; damaged chunks are passed over.
pub(super) fn visit(path: &Path, topics: &[String], take: &mut Take<'_>) -> Result<Damage, String> {
    guarded(|| visit_records(path, topics, take))
}

fn visit_records(path: &Path, topics: &[String], take: &mut Take<'_>) -> Result<Damage, String> {
    let file = input::open(path).map_err(|error| error.to_string())?;
    let mut channels = Channels { topics, numbers: HashMap::new() };
    let (mut offset, mut damage) = (MAGIC, Damage::default());
    let whole =
        LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(record_bytes());
    let ended = records(file, whole, |opcode, data| {
        let here = offset;
        offset += (HEAD + data.len()) as u64;
        match opcode {
            op::CHUNK => {
                // Decompressed by a reader of a file that has this record alone.
                let head = [&[opcode][..], &(data.len() as u64).to_le_bytes()].concat();
                let mut before = 0;
                let read = records(head.chain(data), part(), |opcode, data| {
                    let place = Place::Record { offset: here, before };
                    before += u32::from(opcode == op::MESSAGE);
                    channels.take(opcode, data, place, take).map(Continue)
                });
                if let Err(problem) = read.map(|_: Option<()>| ()) {
                    damage.chunks.push(format!("the chunk at byte {here} is left out: {problem}"));
                }
                Ok(Continue(()))
            }
            // The rest of the file is the summary with its indices.
            op::DATA_END => Ok(Break(())),
            _ => channels.take(opcode, data, Place::Record { offset: here, before: 0 }, take).map(Continue),
        }
    });
    damage.end = match ended {
        Ok(Some(())) => None,
        Ok(None) => Some(problem(&McapError::UnexpectedEof)),
        Err(problem) => Some(problem),
    };
    Ok(damage)
}

/// Fetches a message of the record or chunk that begins at `offset`: the one with `before` messages before it there.
pub(super) fn fetch(path: &Path, offset: u64, before: u32) -> Result<Vec<u8>, String> {
    guarded(|| fetch_record(path, offset, before))
}

fn fetch_record(path: &Path, offset: u64, mut before: u32) -> Result<Vec<u8>, String> {
    let mut file = input::open(path).map_err(|error| error.to_string())?;
    file.seek(SeekFrom::Start(offset)).map_err(|error| error.to_string())?;
    let found = records(file, part(), |opcode, data| match (opcode, before) {
        (op::MESSAGE, 0) => Ok(Break(message(data)?.1.to_vec())),
        (op::MESSAGE, _) => {
            before -= 1;
            Ok(Continue(()))
        }
        _ => Ok(Continue(())),
    })?;
    found.ok_or_else(|| "the message is gone".to_owned())
}

/// The channels of a file by topic.
struct Channels<'a> {
    topics: &'a [String],
    numbers: HashMap<u16, usize>,
}

impl Channels<'_> {
    fn take(&mut self, opcode: u8, data: &[u8], place: Place, take: &mut Take<'_>) -> Result<(), String> {
        match opcode {
            op::CHANNEL => {
                if let Record::Channel(channel) = parse(opcode, data)?
                    && let Some(topic) = self.topics.iter().position(|topic| *topic == channel.topic)
                {
                    self.numbers.insert(channel.id, topic);
                }
                Ok(())
            }
            op::MESSAGE => {
                let (header, mut data) = message(data)?;
                if let Some(&topic) = self.numbers.get(&header.channel_id) {
                    take(Found { topic, place, recorded_ns: header.log_time, bytes: &mut data });
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// The header and the payload of a message.
fn message(record: &[u8]) -> Result<(MessageHeader, &[u8]), String> {
    match parse(op::MESSAGE, record)? {
        Record::Message { header, data: Cow::Borrowed(data) } => Ok((header, data)),
        _ => Err(problem(&McapError::UnexpectedEof)),
    }
}

fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, String> {
    mcap::parse_record(opcode, data).map_err(|error| problem(&error))
}

/// Options for a record alone; a chunk is checked before its messages are passed on.
fn part() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(record_bytes())
}

/// Passes records to `take` until it breaks; `None` if it never does.
fn records<B>(
    mut input: impl Read,
    options: LinearReaderOptions,
    mut take: impl FnMut(u8, &[u8]) -> Result<ControlFlow<B>, String>,
) -> Result<Option<B>, String> {
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| problem(&error))? {
            LinearReadEvent::ReadRequest(bytes) => {
                let read =
                    input.read(reader.insert(bytes.min(READ_BYTES))).map_err(|error| error.to_string())?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => {
                if let Break(value) = take(opcode, data)? {
                    return Ok(Some(value));
                }
            }
        }
    }
    Ok(None)
}

fn problem(error: &McapError) -> String {
    format!("not a whole MCAP file: {error}")
}
