//! Records as lines of a file, so that an interrupted run continues.

use super::error::{EvaluateError, Result};
use super::record::Record;
use crate::input;
use crate::output::write_file;
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The finished records, in memory and as `frames.jsonl`.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    fingerprints: HashMap<u64, String>,
    inner: Mutex<(File, HashMap<u64, Record>)>,
}

impl Journal {
    /// Opens a journal for frames with these fingerprints. Lines are dropped that have another fingerprint, are not
    /// `whole`, are damaged or cannot be parsed.
    ///
    /// # Errors
    /// Names the file.
    pub fn open(
        path: &Path,
        fingerprints: HashMap<u64, String>,
        whole: impl Fn(&Record) -> bool,
    ) -> Result<Self> {
        let text = match read(path) {
            Err(EvaluateError::ReadJournal { source, .. }) if source.kind() == ErrorKind::NotFound => {
                String::new()
            }
            text => text?,
        };
        let mut records = HashMap::new();
        let mut kept = String::new();
        for line in text.lines() {
            let Some(record) = parsed(line) else { continue };
            let known = fingerprints.get(&record.timestamp_ns);
            if known == Some(&record.fingerprint)
                && !records.contains_key(&record.timestamp_ns)
                && whole(&record)
            {
                kept.push_str(line);
                kept.push('\n');
                records.insert(record.timestamp_ns, record);
            }
        }
        write_file(path, kept.as_bytes())?;
        let file = OpenOptions::new().append(true).open(path);
        let file = file.map_err(|source| EvaluateError::WriteJournal { path: path.to_path_buf(), source })?;
        Ok(Self { path: path.to_path_buf(), fingerprints, inner: Mutex::new((file, records)) })
    }

    /// Takes over records of another journal: of frames that have none yet, with their fingerprints, for which `take` does
    /// what else is needed and agrees. Returns the number of lines there, and of records taken.
    ///
    /// # Errors
    /// Names the file.
    pub fn merge(&self, other: &Path, take: impl Fn(&Record) -> Result<bool>) -> Result<[usize; 2]> {
        let text = read(other)?;
        let mut taken = 0;
        for record in text.lines().filter_map(parsed) {
            let is_wanted = self.fingerprints.get(&record.timestamp_ns) == Some(&record.fingerprint)
                && self.get(record.timestamp_ns).is_none();
            if is_wanted && take(&record)? {
                self.add(record)?;
                taken += 1;
            }
        }
        Ok([text.lines().count(), taken])
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lock().1.len()
    }

    /// Whether there are no records.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The record of a frame.
    #[must_use]
    pub fn get(&self, timestamp_ns: u64) -> Option<Record> {
        self.lock().1.get(&timestamp_ns).cloned()
    }

    /// Adds a record under its frame's fingerprint.
    ///
    /// # Errors
    /// Names the file.
    pub fn add(&self, mut record: Record) -> Result<()> {
        record.fingerprint = self.fingerprints.get(&record.timestamp_ns).cloned().unwrap_or_default();
        let line = sealed(&serde_json::to_string(&record)?) + "\n";
        let mut inner = self.lock();
        let written = inner.0.write_all(line.as_bytes());
        written.map_err(|source| EvaluateError::WriteJournal { path: self.path.clone(), source })?;
        inner.1.insert(record.timestamp_ns, record);
        Ok(())
    }

    /// A panic of another thread leaves only whole lines.
    fn lock(&self) -> MutexGuard<'_, (File, HashMap<u64, Record>)> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The lines of a journal.
fn read(path: &Path) -> Result<String> {
    input::read(path, input::limits().table_bytes)
        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
        .map_err(|source| EvaluateError::ReadJournal { path: path.to_path_buf(), source })
}

/// What separates the checksum of a line from the record.
const SEAL: &str = ",\"checksum\":\"";

/// A record in JSON with its checksum as last field.
fn sealed(record: &str) -> String {
    let open = record.strip_suffix('}').unwrap_or(record);
    format!("{open}{SEAL}{}\"}}", Fingerprint::EMPTY.of(open.as_bytes()).text())
}

/// The record of a line, if its checksum is right.
fn parsed(line: &str) -> Option<Record> {
    let (open, _) = line.rsplit_once(SEAL)?;
    let record = format!("{open}}}");
    (sealed(&record) == line).then(|| serde_json::from_str(&record).ok()).flatten()
}

/// A running 64-bit FNV-1a hash: it tells accidents, not forgeries.
#[derive(Debug, Clone, Copy)]
pub struct Fingerprint(u64);

impl Fingerprint {
    /// The hash of nothing.
    pub const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    /// A hash of the program that runs: another build may find other results.
    #[must_use]
    pub fn new() -> Self {
        let program = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
        Self::EMPTY.of(env!("CARGO_PKG_VERSION").as_bytes()).of(&program)
    }

    /// Adds these bytes and their number.
    #[must_use]
    pub fn of(self, bytes: &[u8]) -> Self {
        let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        Self(bytes.iter().chain(&(bytes.len() as u64).to_le_bytes()).fold(self.0, step))
    }

    /// The hash as hexadecimal text.
    #[must_use]
    pub fn text(self) -> String {
        format!("{:016x}", self.0)
    }
}

impl Default for Fingerprint {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn record(timestamp_ns: u64) -> Record {
        Record {
            timestamp_ns,
            fingerprint: String::new(),
            problem: None,
            is_unreadable: false,
            halves: None,
            up: Some([0.1, -0.9, 0.3]),
            up_from: crate::up::UpFrom::Both,
            height_m: 1.7,
            height: 2,
            ceiling: 0,
            covariance: None,
            single: vec![super::super::Found { layer: 1, x: -5 << 32, y: 7, heading: u32::MAX, score: -3 }],
            rival: Some(7),
            oracle: Vec::new(),
            evidence: None,
            paper: [None; crate::evaluate::PAPER.len()],
            milliseconds: BTreeMap::from([("locate".to_owned(), 12.25)]),
        }
    }

    #[test]
    fn an_interrupted_journal_continues() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames.jsonl");
        let prints = |text: &str| HashMap::from([1, 2, 3].map(|time| (time, text.to_owned())));
        let journal = Journal::open(&path, prints("a"), |_| true).unwrap();
        for time in [1, 2, 3] {
            journal.add(record(time)).unwrap();
        }
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
        let journal = Journal::open(&path, prints("a"), |record| record.timestamp_ns != 2).unwrap();
        assert_eq!(journal.len(), 1, "the last line was cut off, the second is not whole");
        assert_eq!(journal.get(1), Some(Record { fingerprint: "a".into(), ..record(1) }));
        journal.add(record(3)).unwrap();
        assert_eq!(Journal::open(&path, prints("a"), |_| true).unwrap().len(), 2);
        let other = Journal::open(&folder.path().join("other.jsonl"), prints("a"), |_| true).unwrap();
        other.add(record(1)).unwrap();
        assert_eq!(other.merge(&path, |record| Ok(record.timestamp_ns != 2)).unwrap(), [2, 1]);
        assert_eq!((other.len(), other.get(3)), (2, journal.get(3)));
        assert!(other.merge(&folder.path().join("absent"), |_| Ok(true)).is_err());
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to) in
            [("\"x\":-21474836480", "\"x\":-21474836481"), ("checksum", "checksun"), ("\"}", "\"")]
        {
            assert!(text.contains(from), "{from}");
            std::fs::write(&path, text.replace(from, to)).unwrap();
            assert!(Journal::open(&path, prints("a"), |_| true).unwrap().is_empty(), "{to}");
        }
        std::fs::write(&path, &text).unwrap();
        assert_eq!(Journal::open(&path, prints("a"), |_| true).unwrap().len(), 2);
        assert!(Journal::open(&path, prints("b"), |_| true).unwrap().is_empty());
    }
}
