//! Trajectories as TUM lines, `timestamp tx ty tz qx qy qz qw`: seconds, metres, camera 0 to map.
//!
//! Blank lines and lines that begin with `#` are skipped. Timestamps keep their nanoseconds.

use super::lines::{self, LinesError};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest deviation of a quaternion's norm from 1: allows for values rounded to two decimals.
const UNIT: f64 = 0.02;

/// Nanoseconds in a second.
const NANOSECONDS: u64 = 1_000_000_000;

/// Why a trajectory could not be read: one line that names the file and the line at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TumError {
    /// The file cannot be read, or a line is not a pose.
    #[error(transparent)]
    Lines(#[from] LinesError),
    /// The file has no pose.
    #[error("{}: no pose in it; lines of 'timestamp tx ty tz qx qy qz qw' are needed", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

/// A pose of camera 0: x right, y down, z forward in the camera; x right, y up, z up in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Time in nanoseconds.
    pub timestamp_ns: u64,
    /// Position of the camera in the map, metres.
    pub position: Vector3<f64>,
    /// Rotates directions in the camera into directions in the map.
    pub rotation: UnitQuaternion<f64>,
}

impl Pose {
    /// The pose at `position` (metres) with the optical axis towards `heading_deg` (counter-clockwise from +x), raised
    /// by `pitch_deg`, and the camera then rolled by `roll_deg` clockwise about its forward axis: at 0 it is upright,
    /// at 180 upside down.
    #[must_use]
    pub fn looking(
        timestamp_ns: u64,
        position: [f64; 3],
        heading_deg: f64,
        pitch_deg: f64,
        roll_deg: f64,
    ) -> Self {
        // Columns: right, down and forward of an upright camera facing +x.
        let upright = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let turn = |axis: Vector3<f64>, degrees: f64| {
            let half = degrees.to_radians() / 2.0;
            let (sin, cos) = (libm::sin(half), libm::cos(half));
            UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, axis * sin))
        };
        let upright = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(upright));
        let rotation = turn(Vector3::z(), heading_deg)
            * turn(Vector3::y(), -pitch_deg)
            * upright
            * turn(Vector3::z(), roll_deg);
        Self { timestamp_ns, position: Vector3::from(position), rotation }
    }

    /// Degrees counter-clockwise from +x to the optical axis, projected on the floor: -180 to 180.
    #[must_use]
    pub fn heading_deg(&self) -> f64 {
        let forward = self.rotation * Vector3::z();
        libm::atan2(forward.y, forward.x).to_degrees()
    }

    /// The map's up vector in the camera.
    #[must_use]
    pub fn up_in_camera(&self) -> Vector3<f64> {
        self.rotation.inverse() * Vector3::z()
    }

    /// The pose as a TUM line, without the line end.
    #[must_use]
    pub fn line(&self) -> String {
        let (t, q) = (self.position, self.rotation.coords);
        let (seconds, rest) = (self.timestamp_ns / NANOSECONDS, self.timestamp_ns % NANOSECONDS);
        format!(
            "{seconds}.{rest:09} {:.6} {:.6} {:.6} {:.9} {:.9} {:.9} {:.9}",
            t.x, t.y, t.z, q.x, q.y, q.z, q.w
        )
    }

    fn parse(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [time, numbers @ ..] = words.as_slice() else { return Err("empty".to_owned()) };
        let Ok(numbers): Result<&[&str; 7], _> = numbers.try_into() else {
            return Err(format!(
                "has {} fields; the eight of 'timestamp tx ty tz qx qy qz qw' are needed",
                words.len()
            ));
        };
        let mut values = [0.0; 7];
        for ((value, word), name) in
            values.iter_mut().zip(numbers).zip(["tx", "ty", "tz", "qx", "qy", "qz", "qw"])
        {
            let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
            *value = number.ok_or_else(|| format!("{name} is '{word}', no finite number"))?;
        }
        let [x, y, z, qx, qy, qz, qw] = values;
        let quaternion = Quaternion::new(qw, qx, qy, qz);
        let length = quaternion.norm();
        if (length - 1.0).abs() > UNIT {
            return Err(format!("quaternion has length {length:.3} instead of 1"));
        }
        Ok(Self {
            timestamp_ns: nanoseconds(time)
                .ok_or_else(|| format!("timestamp is '{time}', no number of seconds from 0 up"))?,
            position: Vector3::new(x, y, z),
            rotation: UnitQuaternion::from_quaternion(quaternion),
        })
    }
}

/// Nanoseconds from a decimal number of seconds, exact unless it has an exponent.
fn nanoseconds(text: &str) -> Option<u64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(fraction) || whole.len() + fraction.len() == 0 {
        let seconds = text.parse::<f64>().ok().filter(|s| (0.0..1e10).contains(s))?;
        return Some((seconds * NANOSECONDS as f64).round() as u64);
    }
    let seconds: u64 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let padded: String = fraction.chars().chain(std::iter::repeat('0')).take(9).collect();
    seconds.checked_mul(NANOSECONDS)?.checked_add(padded.parse().ok()?)
}

/// Reads a trajectory, in the order of its lines.
///
/// # Errors
/// [`TumError`]: a file that cannot be read or has no pose, or a line that is not a pose.
pub fn read(path: &Path) -> Result<Vec<Pose>, TumError> {
    read_checked(path, |_| Ok(()))
}

/// Reads a trajectory and applies a check to each pose, which returns what is wrong with it.
///
/// # Errors
/// As [`read`], and [`LinesError::Line`] for a pose that fails the check.
pub fn read_checked(
    path: &Path,
    mut check: impl FnMut(&Pose) -> Result<(), String>,
) -> Result<Vec<Pose>, TumError> {
    let mut poses = Vec::new();
    lines::visit(path, |line| {
        let pose = Pose::parse(line)?;
        check(&pose)?;
        poses.push(pose);
        Ok(())
    })?;
    if poses.is_empty() { Err(TumError::Empty { path: path.to_path_buf() }) } else { Ok(poses) }
}

/// Formats a trajectory as text.
#[must_use]
pub fn text<'a>(poses: impl IntoIterator<Item = &'a Pose>) -> String {
    let mut text = String::from("# timestamp tx ty tz qx qy qz qw\n");
    for pose in poses {
        let _ = writeln!(text, "{}", pose.line());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str) -> Result<Vec<Pose>, TumError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.tum");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn poses_round_trip() {
        let poses = [
            Pose::looking(1_700_000_000_123_456_789, [1.5, -2.25, 1.6], 74.0, 3.0, 185.0),
            Pose::looking(5, [0.0; 3], -120.0, 0.0, 0.0),
        ];
        let back = written(&text(&poses)).unwrap();
        for (a, b) in poses.iter().zip(&back) {
            assert_eq!(a.timestamp_ns, b.timestamp_ns);
            assert!((a.position - b.position).amax() < 1e-6 && a.rotation.angle_to(&b.rotation) < 1e-7);
        }
        assert_eq!(back.len(), 2);
        assert_eq!(written("\n# x\r\n 1e3 0 0 0 0 0 0 1\r\n").unwrap()[0].timestamp_ns, 1_000_000_000_000);
    }

    #[test]
    fn bad_lines_are_named() {
        for (line, named) in [
            ("1 2 3 4 0 0 0", "7 fields"),
            ("1 2 x 4 0 0 0 1", "ty is 'x'"),
            ("1 2 inf 4 0 0 0 1", "ty is 'inf'"),
            ("-1 2 3 4 0 0 0 1", "timestamp is '-1'"),
            ("1 2 3 4 0 0 0 2", "length 2.000"),
        ] {
            let message = written(&format!("# head\n{line}\n")).unwrap_err().to_string();
            assert!(message.contains("poses.tum:2: ") && message.contains(named), "{message}");
        }
        assert!(written("# nothing\n").unwrap_err().to_string().contains("no pose"));
    }

    #[test]
    fn looking_says_where_forward_and_up_are() {
        let pose = Pose::looking(0, [0.0; 3], 30.0, 0.0, 180.0);
        assert!((pose.heading_deg() - 30.0).abs() < 1e-9);
        assert!((pose.up_in_camera() - Vector3::y()).amax() < 1e-9, "up is the image's down");
        let upright = Pose::looking(0, [0.0; 3], 30.0, 10.0, 0.0);
        let forward = upright.rotation * Vector3::z();
        assert!((forward.z - 10f64.to_radians().sin()).abs() < 1e-9, "raised");
        assert!(upright.up_in_camera().y < -0.98);
        // Clockwise about the forward axis: the camera's right moves down.
        let rolled = Pose::looking(0, [0.0; 3], 0.0, 0.0, 10.0);
        assert!((rolled.rotation * Vector3::x()).z < -0.1);
    }
}
