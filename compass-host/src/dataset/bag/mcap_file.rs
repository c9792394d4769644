//! A file of a bag in MCAP storage: records, most of them in chunks, which may be compressed with zstd or lz4.

use super::place::{Place, Take};
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::ControlFlow::{self, Break, Continue};
use std::path::Path;

/// Largest read at a time, bytes: the length field of a damaged record may have any value.
const READ_BYTES: usize = 1 << 20;
/// Longest record of a chunk, bytes: its buffer is allocated before it is decompressed.
const RECORD_BYTES: usize = 1 << 28;
/// Bytes of a record's header: opcode and length.
const HEAD: usize = 9;
/// Bytes before the first record.
const MAGIC: u64 = 8;

/// Passes the messages of these topics to `take`; the error is about the file, or what `take` returned.
pub(super) fn visit(path: &Path, topics: &[String], take: &mut Take<'_>) -> Result<(), String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let mut channels = Channels { topics, numbers: HashMap::new() };
    let mut offset = MAGIC;
    let whole = LinearReaderOptions::default().with_emit_chunks(true);
    let ended = records(file, whole, |opcode, data| {
        let here = offset;
        offset += (HEAD + data.len()) as u64;
        match opcode {
            op::CHUNK => {
                // Decompressed by a reader of a file that has this record alone.
                let head = [&[opcode][..], &(data.len() as u64).to_le_bytes()].concat();
                let mut before = 0;
                records(head.chain(data), part(), |opcode, data| {
                    let place = Place::Record { offset: here, before };
                    before += u32::from(opcode == op::MESSAGE);
                    channels.take(opcode, data, place, take).map(Continue)
                })
                .map(|_: Option<()>| Continue(()))
            }
            // The rest of the file is the summary with its indices.
            op::DATA_END => Ok(Break(())),
            _ => channels.take(opcode, data, Place::Record { offset: here, before: 0 }, take).map(Continue),
        }
    })?;
    ended.ok_or_else(|| problem(&McapError::UnexpectedEof))
}

/// Fetches a message of the record or chunk that begins at `offset`: the one with `before` messages before it there.
pub(super) fn fetch(path: &Path, offset: u64, mut before: u32) -> Result<Vec<u8>, String> {
    let mut file = File::open(path).map_err(|error| error.to_string())?;
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
                let (channel, mut data) = message(data)?;
                self.numbers.get(&channel).map_or(Ok(()), |&topic| take(topic, place, &mut data))
            }
            _ => Ok(()),
        }
    }
}

/// The channel and the payload of a message.
fn message(record: &[u8]) -> Result<(u16, &[u8]), String> {
    match parse(op::MESSAGE, record)? {
        Record::Message { header, data: Cow::Borrowed(data) } => Ok((header.channel_id, data)),
        _ => Err(problem(&McapError::UnexpectedEof)),
    }
}

fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, String> {
    mcap::parse_record(opcode, data).map_err(|error| problem(&error))
}

/// The error for a truncated file.
fn part() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(RECORD_BYTES)
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
