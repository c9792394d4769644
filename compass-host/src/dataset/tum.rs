//! Trajectories as TUM lines, `timestamp tx ty tz qx qy qz qw`: seconds, metres, camera 0 to map.
//!
//! They are read in any [dialect](super::table), and as state files of `EuRoC`, in nanoseconds and with qw before qx: a
//! header tells, or 17 columns separated by commas. Timestamps keep their nanoseconds.

use super::faults::{Faults, Item};
use super::table::{self, Row, TableError, TimeUnit};
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
    Table(#[from] TableError),
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

    fn parse(row: &Row<'_>) -> Result<Self, String> {
        let Layout { columns, unit } = Layout::of(row)?;
        let mut values = [0.0; 7];
        let names = ["tx", "ty", "tz", "qx", "qy", "qz", "qw"];
        for ((value, column), name) in values.iter_mut().zip(columns).zip(names) {
            *value = row.number(column, name)?;
        }
        let [x, y, z, qx, qy, qz, qw] = values;
        let quaternion = Quaternion::new(qw, qx, qy, qz);
        let length = quaternion.norm();
        if (length - 1.0).abs() > UNIT {
            return Err(format!("quaternion has length {length:.3} instead of 1"));
        }
        Ok(Self {
            timestamp_ns: unit.map_or_else(|| row.nanoseconds(0), |unit| row.time(0, unit))?,
            position: Vector3::new(x, y, z),
            rotation: UnitQuaternion::from_quaternion(quaternion),
        })
    }
}

/// Columns of a TUM line.
const TUM: [usize; 7] = [1, 2, 3, 4, 5, 6, 7];
/// Columns of a state file of `EuRoC`: its quaternion begins with w.
const STATE: [usize; 7] = [1, 2, 3, 5, 6, 7, 4];
/// Number of columns of KITTI: three rows of a matrix.
const KITTI_COLUMNS: usize = 12;
/// Number of columns of a state file: with velocity and biases.
const STATE_COLUMNS: usize = 17;

/// Where tx, ty, tz, qx, qy, qz and qw stand, and the unit of time in the first column: of a state file either, by its
/// digits.
struct Layout {
    columns: [usize; 7],
    unit: Option<TimeUnit>,
}

impl Layout {
    fn of(row: &Row<'_>) -> Result<Self, String> {
        let told = row.told_unit(0);
        if let Some(columns) = row.header.and_then(|header| {
            let [x, y, z] = header.components(['x', 'y', 'z'], is_position)?;
            let [qx, qy, qz, qw] = header.components(['x', 'y', 'z', 'w'], is_quaternion)?;
            Some([x, y, z, qx, qy, qz, qw])
        }) {
            let is_state = row.header.is_some_and(|header| header.find(|name| name == "q_rs_w").is_some());
            return Ok(Self { columns, unit: told.or((!is_state).then_some(TimeUnit::Seconds)) });
        }
        if row.len() == STATE_COLUMNS && row.has_commas() {
            return Ok(Self { columns: STATE, unit: told });
        }
        if row.len() == KITTI_COLUMNS && row.header.is_none() {
            return Err("has 12 fields, which looks like a pose of KITTI: it has no time".to_owned());
        }
        if row.len() > TUM[6] {
            return Ok(Self { columns: TUM, unit: told.or(Some(TimeUnit::Seconds)) });
        }
        Err(format!("has {} fields; the eight of 'timestamp tx ty tz qx qy qz qw' are needed", row.len()))
    }
}

fn is_quaternion(name: &str) -> bool {
    (name.starts_with('q') || ["quat", "orientation", "rot"].iter().any(|part| name.contains(part)))
        && !name.contains("cov")
}

fn is_position(name: &str) -> bool {
    let begins = name.len() == 1 || name.starts_with(['p', 't']) || name.contains("pos");
    begins && !is_quaternion(name) && !["time", "twist", "cov"].iter().any(|part| name.contains(part))
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
/// As [`read`], and [`TableError::Line`] for a pose that fails the check.
pub fn read_checked(
    path: &Path,
    check: impl FnMut(&Pose) -> Result<(), String>,
) -> Result<Vec<Pose>, TumError> {
    let (poses, visited) = visit(path, check)?;
    match visited.rejected.into_iter().next() {
        Some((line, problem)) => Err(TableError::Line { path: path.to_path_buf(), line, problem }.into()),
        None => Ok(poses),
    }
}

/// Reads a trajectory and leaves out the lines that are no pose.
///
/// # Errors
/// [`TumError`]: a file that cannot be read or has no pose.
pub fn read_tolerant(path: &Path) -> Result<(Vec<Pose>, Faults), TumError> {
    let (poses, visited) = visit(path, |_| Ok(()))?;
    let mut faults = Faults::default();
    faults.count_used(Item::Pose, visited.taken);
    for (line, problem) in visited.rejected {
        faults.add_line(Item::Pose, path, line, problem);
    }
    Ok((poses, faults))
}

fn visit(
    path: &Path,
    mut check: impl FnMut(&Pose) -> Result<(), String>,
) -> Result<(Vec<Pose>, table::Visited), TumError> {
    let mut poses = Vec::new();
    let visited = table::visit(path, |row| {
        let pose = Pose::parse(row)?;
        check(&pose)?;
        poses.push(pose);
        Ok(())
    })?;
    if poses.is_empty() { Err(TumError::Empty { path: path.to_path_buf() }) } else { Ok((poses, visited)) }
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
            ("1 0 0 0 0 1 0 0 0 0 1 0", "looks like a pose of KITTI"),
            ("100000000000 2 3 4 0 0 0 1", "looks like nanoseconds"),
            ("1 2 3 4 0 0 0 2", "length 2.000"),
        ] {
            let message = written(&format!("# head\n{line}\n")).unwrap_err().to_string();
            assert!(message.contains("poses.tum:2: ") && message.contains(named), "{message}");
        }
        assert!(written("# nothing\n").unwrap_err().to_string().contains("no pose"));
    }

    #[test]
    fn dialects_and_state_files_are_read() {
        let expected = Pose {
            timestamp_ns: 1_500_000_000,
            position: Vector3::new(1.0, 2.0, 3.0),
            rotation: UnitQuaternion::from_quaternion(Quaternion::new(0.5, 0.5, -0.5, 0.5)),
        };
        let zeros = ",0".repeat(9);
        for text in [
            "1.5,1,2,3,0.5,-0.5,0.5,0.5\n".to_owned(),
            "timestamp\ttx\tty\ttz\tqx\tqy\tqz\tqw\n1.5\t1\t2\t3\t0.5\t-0.5\t0.5\t0.5\n".to_owned(),
            "1,5;1;2;3;0,5;-0,5;0,5;0,5\n".to_owned(),
            "# timestamp [ns] tx ty tz qx qy qz qw\n1500000000 1 2 3 0.5 -0.5 0.5 0.5\n".to_owned(),
            "t,px,py,pz,qw,qx,qy,qz\n1.5,1,2,3,0.5,0.5,-0.5,0.5\n".to_owned(),
            format!("1500000000,1,2,3,0.5,0.5,-0.5,0.5{zeros}\n"),
            "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n\
             1500000000,1,2,3,0.5,0.5,-0.5,0.5\n"
                .to_owned(),
            "%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,field.pose.orientation.x,\
             field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w\n\
             1.5,1,2,3,0.5,-0.5,0.5,0.5\n"
                .to_owned(),
        ] {
            let poses = written(&text).unwrap();
            let [found] = poses[..] else { panic!("{text}: {poses:?}") };
            assert_eq!(found.timestamp_ns, expected.timestamp_ns, "{text}");
            assert!((found.position - expected.position).amax() < 1e-12, "{text}");
            assert!(found.rotation.angle_to(&expected.rotation) < 1e-9, "{text}");
        }
    }

    #[test]
    fn bad_lines_may_be_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.tum");
        std::fs::write(&path, "1 2 3 4 0 0 0 1\n2 nan nan nan nan nan nan nan\n").unwrap();
        let (poses, faults) = read_tolerant(&path).unwrap();
        assert_eq!((poses.len(), faults.to_string()), (1, "1 of 2 poses".to_owned()));
        assert!(faults.first()[0].place.ends_with("poses.tum:2"));
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
