//! Recordings in the `EuRoC` layout: `cam0/data.csv` lists the frames of `cam0/data`, likewise `cam1`;
//! `imu0/data.csv` has the readings of an IMU.
//!
//! A line of a list is `timestamp [ns],filename`; blank lines and lines that begin with `#` are skipped.

use super::imu::Readings;
use super::lines::{self, LinesError};
use super::pairs::List;
use std::path::{Path, PathBuf};

/// The frames of cam0 and cam1 and the readings of the IMU, as far as they exist.
pub(super) fn read(dir: &Path) -> Result<([List<PathBuf>; 2], Option<Readings>), LinesError> {
    let imu = dir.join("imu0").join("data.csv");
    let readings = imu.exists().then(|| Readings::read(&imu)).transpose()?;
    Ok(([list(dir, "cam0")?, list(dir, "cam1")?], readings))
}

/// The frames of one camera; empty if the recording lacks it.
fn list(dir: &Path, camera: &str) -> Result<List<PathBuf>, LinesError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_lists_are_named() {
        let folder = tempfile::tempdir().unwrap();
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
            let message = read(folder.path()).unwrap_err().to_string();
            assert!(message.contains("data.csv:3: ") && message.contains(named), "{message}");
        }
    }
}
