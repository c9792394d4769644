//! Recordings in the `EuRoC` layout: `cam0/data.csv` lists the frames of `cam0/data`, likewise `cam1`.
//!
//! A line of a list is `timestamp [ns],filename`; blank lines and lines that begin with `#` are passed over.

use super::lines::{self, LinesError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Half the spacing of frames when there is but one, nanoseconds.
const ALONE_NS: u64 = 25_000_000;

/// Why a recording could not be read: one line, with the file and the line at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A list cannot be read, or a line of it is no frame.
    #[error(transparent)]
    Lines(#[from] LinesError),
    /// There is no list, or no frame in any.
    #[error("{}: no frames; cam0/data.csv or cam1/data.csv must list some, as the EuRoC layout has them", dir.display())]
    Empty {
        /// The folder.
        dir: PathBuf,
    },
}

/// The frames of one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// Time of the frame of cam0, of cam1 where there is none, in nanoseconds.
    pub timestamp_ns: u64,
    /// The files of cam0 and cam1; at least one is there.
    pub files: [Option<PathBuf>; 2],
}

/// Frames by time.
type List = BTreeMap<u64, PathBuf>;

/// Reads the lists of a recording and pairs the frames of the cameras, each with the nearest in time if that is within
/// half the spacing of the frames; frames without such a partner stand alone. In the order of time.
///
/// # Errors
/// [`DatasetError`]: a list that cannot be read, a line that is no frame or names a missing file, or no frames.
pub fn read(dir: &Path) -> Result<Vec<Shot>, DatasetError> {
    let [cam0, cam1] = [list(dir, "cam0")?, list(dir, "cam1")?];
    let shots = pair(&cam0, &cam1);
    if shots.is_empty() { Err(DatasetError::Empty { dir: dir.to_path_buf() }) } else { Ok(shots) }
}

/// The frames of one camera; none if the recording lacks it.
fn list(dir: &Path, camera: &str) -> Result<List, LinesError> {
    let path = dir.join(camera).join("data.csv");
    if !path.exists() {
        return Ok(List::new());
    }
    let mut frames = List::new();
    lines::visit(&path, |line| {
        let (time, name) = parse(line)?;
        let file = dir.join(camera).join("data").join(name);
        if !file.is_file() {
            return Err(format!("{} does not exist", file.display()));
        }
        match frames.insert(time, file) {
            Some(_) => Err(format!("another frame has the timestamp {time}")),
            None => Ok(()),
        }
    })?;
    Ok(frames)
}

fn parse(line: &str) -> Result<(u64, &str), String> {
    let (time, name) = line.split_once(',').ok_or("expected 'timestamp [ns],filename'")?;
    let time = time.trim();
    let time = time.parse().map_err(|_| format!("timestamp is '{time}', no whole number of nanoseconds"))?;
    let name = name.trim();
    if name.is_empty() { Err("filename is missing".to_owned()) } else { Ok((time, name)) }
}

fn pair(cam0: &List, cam1: &List) -> Vec<Shot> {
    let reach = half_spacing(cam0).max(half_spacing(cam1));
    let partner = |of: &List, time: u64| nearest(of, time).filter(|other| other.abs_diff(time) <= reach);
    let mut shots = Vec::new();
    for (&time, file) in cam0 {
        // Only where each is the other's nearest, so that no frame is used twice.
        let other = partner(cam1, time).filter(|&other| nearest(cam0, other) == Some(time));
        let files = [Some(file.clone()), other.and_then(|other| cam1.get(&other).cloned())];
        shots.push(Shot { timestamp_ns: time, files });
    }
    for (&time, file) in cam1.iter().filter(|(time, _)| partner(cam0, **time).is_none()) {
        shots.push(Shot { timestamp_ns: time, files: [None, Some(file.clone())] });
    }
    shots.sort_by_key(|shot| shot.timestamp_ns);
    shots
}

/// The time of the nearest frame, the earlier of two.
fn nearest(list: &List, time: u64) -> Option<u64> {
    let before = list.range(..=time).next_back();
    let after = list.range(time..).next();
    before.into_iter().chain(after).map(|(&other, _)| other).min_by_key(|other| other.abs_diff(time))
}

/// Half the median time between frames.
fn half_spacing(list: &List) -> u64 {
    let times: Vec<u64> = list.keys().copied().collect();
    let mut gaps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).map_or(ALONE_NS, |gap| gap / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times: &[u64]) -> List {
        times.iter().map(|&time| (time, PathBuf::from(time.to_string()))).collect()
    }

    #[test]
    fn frames_pair_with_the_nearest() {
        let shots = pair(&of(&[0, 100, 200, 300]), &of(&[3, 104, 260, 420]));
        let found: Vec<_> = shots
            .iter()
            .map(|shot| {
                let name = |n: usize| shot.files[n].as_ref().map(|file: &PathBuf| file.to_str().unwrap());
                (shot.timestamp_ns, name(0), name(1))
            })
            .collect();
        let expected = [
            (0, Some("0"), Some("3")),
            (100, Some("100"), Some("104")),
            (200, Some("200"), None),
            (300, Some("300"), Some("260")),
            (420, None, Some("420")),
        ];
        assert_eq!(found, expected);
        assert_eq!(pair(&of(&[]), &of(&[5])).len(), 1);
    }

    #[test]
    fn bad_lists_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let message = || read(folder.path()).unwrap_err().to_string();
        assert!(message().contains("no frames"));
        std::fs::create_dir_all(folder.path().join("cam1/data")).unwrap();
        std::fs::write(folder.path().join("cam1/data/a.png"), "").unwrap();
        for (line, named) in [
            ("7", "'timestamp [ns],filename'"),
            ("x,a.png", "timestamp is 'x'"),
            ("7,", "filename is missing"),
            ("7,b.png", "b.png does not exist"),
            ("6,a.png", "another frame"),
        ] {
            let text = format!("#timestamp [ns],filename\n6,a.png\n{line}\n");
            std::fs::write(folder.path().join("cam1/data.csv"), text).unwrap();
            assert!(message().contains("data.csv:3: ") && message().contains(named), "{}", message());
        }
    }
}
