//! A file of a bag in rosbag2's `SQLite` storage: `topics` (`id`, `name`, `type`, `serialization_format`) and `messages`
//! (`id`, `topic_id`, `timestamp`, `data`).
//!
//! Files are opened as immutable: nothing is written beside them, and a folder without write permission will do. A
//! write-ahead log with contents needs a [copy].

use super::place::{Found, Place, Take};
use super::topic::Topic;
use crate::input::limits;
use crate::temporary::Temporary;
use rusqlite::blob::Blob;
use rusqlite::config::DbConfig;
use rusqlite::{Connection, OpenFlags, Result};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::Read;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Steps of the database's machine between two calls of the handler that ends a query without end.
const STEPS_PER_CALL: i32 = 1_000_000;
/// Bytes of the file for each such call: a row takes some ten steps, and at least as many bytes.
const BYTES_PER_CALL: u64 = 10_000;

/// The topics of a file.
pub(super) fn topics(path: &Path) -> Result<Vec<Topic>, String> {
    let database = open(path)?;
    let read = || {
        let mut statement =
            database.prepare("SELECT name, type, serialization_format FROM topics ORDER BY id")?;
        let rows = statement.query_map([], |row| {
            Ok(Topic { name: row.get(0)?, written_kind: row.get(1)?, format: row.get(2)?, count: 0 })
        })?;
        let mut topics = rows.collect::<Result<Vec<_>>>()?;
        // Only progress needs the counts; what is damaged is found and named by the visit.
        let _ = count(&database, &mut topics);
        Ok(topics)
    };
    read().map_err(problem)
}

/// Counts the messages of the topics.
fn count(database: &Connection, topics: &mut [Topic]) -> Result<()> {
    let names: Vec<&str> = topics.iter().map(|topic| topic.name.as_str()).collect();
    let ids = numbers(database, &names)?;
    let mut statement = database.prepare("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id")?;
    let rows = statement.query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?)))?;
    for row in rows {
        let (id, count) = row?;
        if let Some(&topic) = ids.get(&id) {
            topics[topic].count += usize::try_from(count).unwrap_or_default();
        }
    }
    Ok(())
}

/// Passes the messages of these topics to `take`; the error is about the rest of the file.
pub(super) fn visit(path: &Path, topics: &[String], take: &mut Take<'_>) -> Result<(), String> {
    let database = open(path)?;
    let names: Vec<&str> = topics.iter().map(String::as_str).collect();
    let wanted = numbers(&database, &names).map_err(problem)?;
    let query = "SELECT id, topic_id, timestamp FROM messages ORDER BY id";
    let mut statement = database.prepare(query).map_err(problem)?;
    let mut rows = statement.query([]).map_err(problem)?;
    let mut reused: Option<Blob<'_>> = None;
    while let Some(row) = rows.next().map_err(problem)? {
        let (id, topic, recorded): (i64, i64, i64) = row.try_into().map_err(problem)?;
        let Some(&topic) = wanted.get(&topic) else { continue };
        let data = match reused.take() {
            Some(mut blob) => blob.reopen(id).map(|()| blob),
            None => blob(&database, id),
        };
        let bytes = reused.insert(data.map_err(problem)?);
        let recorded_ns = u64::try_from(recorded).unwrap_or_default();
        take(Found { topic, place: Place::Row(id), recorded_ns, bytes });
    }
    Ok(())
}

/// Fetches the message of a row.
pub(super) fn fetch(path: &Path, id: i64) -> Result<Vec<u8>, String> {
    // Its tables were checked when the row was found.
    let database = connect(path).map_err(problem)?;
    let mut data = Vec::new();
    let mut blob = blob(&database, id).map_err(problem)?;
    let (bytes, limit) = (u64::from(blob.size().max(0).unsigned_abs()), limits().message_bytes);
    if bytes > limit {
        return Err(format!(
            "a message of {bytes} bytes, more than the limit of {limit}; --raise-limits raises it"
        ));
    }
    blob.read_to_end(&mut data).map_err(|error| error.to_string())?;
    Ok(data)
}

/// The file with its write-ahead log in a folder of its own, if the log has contents: a reader has to merge it.
pub(super) fn copy(path: &Path) -> std::io::Result<Option<(Temporary<TempDir>, PathBuf)>> {
    let log = beside(path, "-wal");
    if std::fs::metadata(&log).map_or(0, |data| data.len()) == 0 {
        return Ok(None);
    }
    let folder = Temporary::folder()?;
    let database = folder.path().join("bag.db3");
    std::fs::copy(path, &database)?;
    std::fs::copy(log, beside(&database, "-wal"))?;
    // The log is merged once; then the copy is as immutable as any other file.
    let merged = Connection::open(&database)
        .and_then(|database| database.execute_batch("PRAGMA journal_mode = DELETE").map(|()| database))
        .and_then(|database| database.close().map_err(|(_, error)| error));
    merged.map_err(std::io::Error::other)?;
    Ok(Some((folder, database)))
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

/// Opens a file that has the tables of a bag: a view in their place may run for ever.
fn open(path: &Path) -> Result<Connection, String> {
    let database = connect(path).map_err(problem)?;
    let query = "SELECT COUNT(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages')";
    let tables: i64 = database.query_row(query, [], |row| row.get(0)).map_err(problem)?;
    match tables {
        2 => Ok(database),
        _ => Err("not an SQLite file of a ROS 2 bag: it lacks a table topics or messages".to_owned()),
    }
}

fn connect(path: &Path) -> Result<Connection> {
    let flags =
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let mut database = Connection::open_with_flags(uri(path), flags)?;
    // Without this a file that is shorter than its header says is refused; with it, its whole pages are read.
    database.pragma_update(None, "writable_schema", "ON")?;
    // The file is a stranger's: what its schema says is not executed, and no query outlasts the file.
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false)?;
    let mut calls = std::fs::metadata(path).map_or(0, |data| data.len()) / BYTES_PER_CALL + 100;
    database.progress_handler(
        STEPS_PER_CALL,
        Some(move || {
            calls = calls.saturating_sub(1);
            calls == 0
        }),
    )?;
    Ok(database)
}

/// The address of a file that nobody writes to: bytes with a meaning in addresses are escaped.
fn uri(path: &Path) -> String {
    let mut uri = String::from("file:");
    for byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/-_.".contains(byte) {
            uri.push(char::from(*byte));
        } else {
            let _ = write!(uri, "%{byte:02x}");
        }
    }
    uri + "?immutable=1"
}

/// The ids of our topics in the file; a split bag may list a topic twice.
fn numbers(database: &Connection, topics: &[&str]) -> Result<HashMap<i64, usize>> {
    let mut statement = database.prepare("SELECT id, name FROM topics")?;
    let rows = statement.query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, String>(1)?)))?;
    let mut wanted = HashMap::new();
    for row in rows {
        let (id, name) = row?;
        if let Some(topic) = topics.iter().position(|topic| *topic == name) {
            wanted.insert(id, topic);
        }
    }
    Ok(wanted)
}

fn blob(database: &Connection, id: i64) -> Result<Blob<'_>> {
    database.blob_open("main", "messages", "data", id, true)
}

#[expect(clippy::needless_pass_by_value, reason = "the argument of map_err")]
fn problem(error: rusqlite::Error) -> String {
    format!("not a whole SQLite file of a ROS 2 bag: {error}")
}
