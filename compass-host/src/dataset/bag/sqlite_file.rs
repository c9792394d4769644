//! A file of a bag in rosbag2's `SQLite` storage: `topics` (`id`, `name`) and `messages` (`id`, `topic_id`, `data`).

use super::place::{Place, Take};
use rusqlite::blob::Blob;
use rusqlite::{Connection, OpenFlags, Result};
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

/// Passes the messages of these topics to `take`; the error is about the file, or what `take` returned.
pub(super) fn visit(path: &Path, topics: &[String], take: &mut Take<'_>) -> Result<(), String> {
    let database = open(path).map_err(problem)?;
    let wanted = numbers(&database, topics).map_err(problem)?;
    let mut statement = database.prepare("SELECT id, topic_id FROM messages ORDER BY id").map_err(problem)?;
    let mut rows = statement.query([]).map_err(problem)?;
    let mut reused: Option<Blob<'_>> = None;
    while let Some(row) = rows.next().map_err(problem)? {
        let (id, topic): (i64, i64) = row.try_into().map_err(problem)?;
        let Some(&topic) = wanted.get(&topic) else { continue };
        let data = match reused.take() {
            Some(mut blob) => blob.reopen(id).map(|()| blob),
            None => blob(&database, id),
        };
        take(topic, Place::Row(id), reused.insert(data.map_err(problem)?))?;
    }
    Ok(())
}

/// Fetches the message of a row.
pub(super) fn fetch(path: &Path, id: i64) -> Result<Vec<u8>, String> {
    let database = open(path).map_err(problem)?;
    let mut data = Vec::new();
    let mut blob = blob(&database, id).map_err(problem)?;
    blob.read_to_end(&mut data).map_err(|error| error.to_string())?;
    Ok(data)
}

fn open(path: &Path) -> Result<Connection> {
    Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX)
}

/// The ids of our topics in the file; a split bag may list a topic twice.
fn numbers(database: &Connection, topics: &[String]) -> Result<HashMap<i64, usize>> {
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
