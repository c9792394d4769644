//! Recordings in the `EuRoC` layout: `cam0/data.csv` lists the frames of `cam0/data`, likewise `cam1`;
//! `imu0/data.csv` has the readings of an IMU. The folder may lie in one named `mav0`, as sequences are unpacked.
//!
//! A row of a list is `timestamp [ns],filename`, in any [dialect](super::table).

use super::faults::{Faults, Item};
use super::imu::Readings;
use super::pairs::List;
use super::table::{self, Header, Row, TableError};
use crate::input::is_within;
use std::path::{Path, PathBuf};

/// The folder within that of a sequence.
const INNER: &str = "mav0";

/// The contents of a folder.
pub(super) struct Contents {
    /// The frames of both cameras.
    pub(super) frames: [List<PathBuf>; 2],
    /// The accelerometer, if there is one.
    pub(super) imu: Option<Readings>,
    /// What was left out.
    pub(super) faults: Faults,
}

/// Where the recording is: the folder itself, or the one within it.
pub(super) fn folder(dir: &Path) -> PathBuf {
    let inner = dir.join(INNER);
    if inner.is_dir() { inner } else { dir.to_path_buf() }
}

/// The frames of two cameras and the readings of the IMU, as far as they exist.
pub(super) fn read(dir: &Path, cameras: [Option<&str>; 2]) -> Result<Contents, TableError> {
    let imu = dir.join("imu0").join("data.csv");
    let imu = imu.exists().then(|| Readings::read(&imu)).transpose()?;
    let mut faults = imu.as_ref().map(|imu| imu.faults().clone()).unwrap_or_default();
    let mut frames = [List::new(), List::new()];
    for (frames, camera) in frames.iter_mut().zip(cameras) {
        if let Some(camera) = camera {
            *frames = list(dir, camera, &mut faults)?;
        }
    }
    Ok(Contents { frames, imu, faults })
}

/// The frames of one camera; empty if the recording lacks it.
fn list(dir: &Path, camera: &str, faults: &mut Faults) -> Result<List<PathBuf>, TableError> {
    let path = dir.join(camera).join("data.csv");
    if !path.exists() {
        return Ok(List::new());
    }
    let mut frames = List::new();
    let visited = table::visit(&path, |row| {
        let (time, name) = parse(row)?;
        let file = file(&dir.join(camera), name)?;
        // The first of two frames at one time stays.
        match frames.entry(time) {
            std::collections::btree_map::Entry::Occupied(_) => {
                Err(format!("another frame has the timestamp {time}"))
            }
            std::collections::btree_map::Entry::Vacant(free) => {
                free.insert(file);
                Ok(())
            }
        }
    })?;
    faults.count_used(Item::Frame, frames.len());
    for (line, problem) in visited.rejected {
        faults.add_line(Item::Frame, &path, line, problem);
    }
    Ok(frames)
}

fn parse<'a>(row: &Row<'a>) -> Result<(u64, &'a str), String> {
    if row.len() < 2 {
        return Err("expected 'timestamp [ns],filename'".to_owned());
    }
    let time = row.nanoseconds(0)?;
    let named =
        |header: &Header| header.find(|name| ["file", "image"].iter().any(|part| name.contains(part)));
    let column = row.header.and_then(named).unwrap_or(1);
    Ok((time, row.cell(column).ok_or("filename is missing")?))
}

/// The file of a frame: in the folder `data`, or where its name says.
fn file(camera: &Path, name: &str) -> Result<PathBuf, String> {
    let by_name = Path::new(name).file_name().map(|name| camera.join("data").join(name));
    let there = by_name.filter(|file| file.is_file());
    if !is_within(Path::new(name)) {
        // As on another machine; a list does not choose files of this one.
        return there.ok_or_else(|| format!("{name} is outside of the recording"));
    }
    let beside = camera.join("data").join(name);
    let others = [camera.join(name), camera.join("..").join(name)];
    let mut candidates = [beside.clone()].into_iter().chain(others);
    let named = candidates.find(|file| file.is_file()).or(there);
    named.ok_or_else(|| format!("{} does not exist", beside.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(list: &str) -> Result<Contents, TableError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("cam1/data")).unwrap();
        for name in ["a.png", "b.png"] {
            std::fs::write(folder.path().join("cam1/data").join(name), "").unwrap();
        }
        std::fs::write(folder.path().join("cam1/data.csv"), list).unwrap();
        read(folder.path(), [None, Some("cam1")])
    }

    #[test]
    fn bad_rows_are_left_out_and_named() {
        for (line, named) in [
            ("7", "'timestamp [ns],filename'"),
            ("x,b.png", "timestamp is 'x'"),
            ("-7,b.png", "timestamp is '-7'"),
            ("7,", "filename is missing"),
            ("7,c.png", "c.png does not exist"),
            ("6,b.png", "another frame"),
        ] {
            let Contents { frames, faults, .. } =
                listed(&format!("#timestamp [ns],filename\n6,a.png\n{line}\n")).unwrap();
            assert_eq!(faults.to_string(), "1 of 2 frames", "{line}");
            let fault = &faults.first()[0];
            assert!(fault.place.ends_with("cam1/data.csv:3"), "{fault:?}");
            assert!(fault.problem.contains(named), "{fault:?}");
            assert_eq!(frames[1].keys().copied().collect::<Vec<_>>(), [6]);
            assert!(frames[1][&6].ends_with("a.png"), "the first stays");
        }
        let all = listed("7,c.png\n8,d.png\n").map(|_| ()).unwrap_err().to_string();
        assert!(all.contains("data.csv:1: ") && all.contains("c.png does not exist"), "{all}");
    }

    #[test]
    fn lists_of_other_programs_are_read() {
        for list in [
            "timestamp,filename\n6,a.png\n7,b.png\n",
            "timestamp;exposure;image\n6;100;a.png\n7;100;b.png\n",
            "6\ta.png\n7\tb.png\n",
            "\"6\",\"cam1/data/a.png\",9\n\"7\",\"data/b.png\",9\n",
            "0.000000006 a.png\n0.000000007 b.png\n",
            "6,/home/robot/cam1/data/a.png\n7,/home/robot/cam1/data/b.png\n",
        ] {
            let Contents { frames, faults, .. } = listed(list).unwrap();
            assert!(faults.is_empty(), "{list}: {faults:?}");
            let found: Vec<_> = frames[1]
                .iter()
                .map(|(time, file)| (*time, file.file_name().unwrap().to_str().unwrap().to_owned()))
                .collect();
            assert_eq!(found, [(6, "a.png".to_owned()), (7, "b.png".to_owned())], "{list}");
        }
    }

    #[test]
    fn a_sequence_as_unpacked_is_looked_into() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(super::folder(folder.path()), folder.path());
        std::fs::create_dir(folder.path().join("mav0")).unwrap();
        assert_eq!(super::folder(folder.path()), folder.path().join("mav0"));
    }
}
