//! Accelerometer readings, and the direction of gravity in them.
//!
//! A row of a file, as `EuRoC` datasets have it (`imu0/data.csv`), is `timestamp [ns], w_RS_S_x, w_RS_S_y, w_RS_S_z
//! [rad s^-1], a_RS_S_x, a_RS_S_y, a_RS_S_z [m s^-2]`, in any [dialect](super::table); a header may name the columns in
//! another order. Rows whose acceleration is no number are left out. At rest an accelerometer reads 9.81 upwards.

use super::faults::{Faults, Item};
use super::table::{self, Row, TableError};
use crate::calibration::Calibration;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest deviation of a mean reading from [`GRAVITY`], m/s^2: a larger one means motion or another unit.
const ODD: f64 = 1.0;
/// Standard gravity, m/s^2.
pub const GRAVITY: f64 = 9.806_65;

/// Why readings give no up vector: one line that names the file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImuError {
    /// No reading in the requested time span.
    #[error("{}: no reading{}", path.display(), span.map(between).unwrap_or_default())]
    Empty {
        /// The file, or another name of the source.
        path: PathBuf,
        /// First and last second of the requested span, if there was one.
        span: Option<[f64; 2]>,
    },
    /// The mean is not gravity.
    #[error(
        "{}: the mean acceleration is {length:.2} m/s^2: no gravity (it moves, or the unit is another)",
        path.display()
    )]
    NoGravity {
        /// The file, or another name of the source.
        path: PathBuf,
        /// Length of the mean, m/s^2.
        length: f64,
    },
}

fn between([from, to]: [f64; 2]) -> String {
    format!(" from {from} to {to} s")
}

/// The mean of accelerometer readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// Unit vector that points up, in the axes of the IMU.
    pub up: Vector3<f64>,
    /// Length of the mean, m/s^2.
    pub length: f64,
    /// Number of readings.
    pub samples: usize,
}

impl Gravity {
    /// The up vector in the axes of cam0; `None` if the calibration has no extrinsics of the IMU.
    #[must_use]
    pub fn in_cam0(&self, calibration: &Calibration) -> Option<Self> {
        let rotation = calibration.cameras[0].as_ref()?.from_imu?;
        Some(Self { up: rotation.transform_vector(&self.up), ..*self })
    }
}

/// An accelerometer reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time by the IMU's clock, nanoseconds.
    pub timestamp_ns: u64,
    /// Acceleration in the axes of the IMU, m/s^2; finite.
    pub acceleration: Vector3<f64>,
}

/// The readings of a recording.
#[derive(Debug, Clone)]
pub struct Readings {
    /// The file, or another name of the source.
    path: PathBuf,
    /// In order of time.
    readings: Vec<Reading>,
    faults: Faults,
}

impl Readings {
    /// Readings from another source, in any order; messages name it `path`.
    #[must_use]
    pub fn new(path: PathBuf, mut readings: Vec<Reading>) -> Self {
        readings.sort_by_key(|reading| reading.timestamp_ns);
        let mut faults = Faults::default();
        faults.count_used(Item::Reading, readings.len());
        Self { path, readings, faults }
    }

    /// Reads a file; rows that are no reading are left out.
    ///
    /// # Errors
    /// [`TableError`]: a file that cannot be read, or in which no row is a reading.
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let mut readings = Vec::new();
        let visited = table::visit(path, |row| {
            readings.push(parse(row)?);
            Ok(())
        })?;
        let mut read = Self::new(path.to_path_buf(), readings);
        for (line, problem) in visited.rejected {
            read.faults.add_line(Item::Reading, path, line, problem);
        }
        Ok(read)
    }

    /// The rows that were left out.
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// The mean of all readings, or of those within `span`: its first and last second by their clock.
    ///
    /// # Errors
    /// [`ImuError`]: no reading at all, or a mean that is not gravity.
    pub fn gravity(&self, span: Option<[f64; 2]>) -> Result<Gravity, ImuError> {
        let is_asked_for = |reading: &&Reading| {
            span.is_none_or(|[from, to]| (from..=to).contains(&(reading.timestamp_ns as f64 / 1e9)))
        };
        self.mean(self.readings.iter().filter(is_asked_for), span)
    }

    /// The mean of the readings within `reach_ns` of a time, both in nanoseconds of their clock.
    ///
    /// # Errors
    /// [`ImuError`]: no reading there, or a mean that is not gravity.
    pub fn gravity_near(&self, time_ns: u64, reach_ns: u64) -> Result<Gravity, ImuError> {
        let [from, to] = [time_ns.saturating_sub(reach_ns), time_ns.saturating_add(reach_ns)];
        let first = self.readings.partition_point(|reading| reading.timestamp_ns < from);
        let near = self.readings[first..].iter().take_while(|reading| reading.timestamp_ns <= to);
        self.mean(near, Some([from, to].map(|ns| ns as f64 / 1e9)))
    }

    fn mean<'a>(
        &self,
        readings: impl Iterator<Item = &'a Reading>,
        span: Option<[f64; 2]>,
    ) -> Result<Gravity, ImuError> {
        let add = |(sum, count), reading: &Reading| (sum + reading.acceleration, count + 1);
        let (sum, samples) = readings.fold((Vector3::zeros(), 0_usize), add);
        if samples == 0 {
            return Err(ImuError::Empty { path: self.path.clone(), span });
        }
        let mean = sum / samples as f64;
        let length = mean.norm();
        if (length - GRAVITY).abs() > ODD {
            return Err(ImuError::NoGravity { path: self.path.clone(), length });
        }
        Ok(Gravity { up: mean / length, length, samples })
    }
}

/// Columns of the acceleration without a header.
const ACCELERATION: [usize; 3] = [4, 5, 6];

fn parse(row: &Row<'_>) -> Result<Reading, String> {
    let is_acceleration = |name: &str| {
        let begins = name.starts_with('a') && !name.starts_with("ang") || name.contains("acc");
        begins && !name.contains("cov")
    };
    let named = row.header.and_then(|header| header.components(['x', 'y', 'z'], is_acceleration));
    let columns = named.unwrap_or(ACCELERATION);
    if row.len() <= columns[2] {
        return Err(format!(
            "has {} fields; timestamp, three rates and three accelerations are needed",
            row.len()
        ));
    }
    let [x, y, z] = columns.map(|column| row.number(column, "acceleration"));
    Ok(Reading { timestamp_ns: row.nanoseconds(0)?, acceleration: Vector3::new(x?, y?, z?) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
                          a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";

    fn mean(text: &str, span: Option<[f64; 2]>) -> Result<Gravity, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.csv");
        std::fs::write(&path, text).unwrap();
        let readings = Readings::read(&path).map_err(|error| error.to_string())?;
        readings.gravity(span).map_err(|error| error.to_string())
    }

    #[test]
    fn the_mean_of_what_is_asked_for_counts() {
        let text = format!(
            "{HEADER}1000000000,0,0,0,0.5,0,9.8\r\n2000000000, 0.1,0,0, -0.5, 0, 9.8\n\n3000000000,0,0,0,9.8,0,0\n"
        );
        let first = mean(&text, Some([1.0, 2.0])).unwrap();
        assert_eq!((first.samples, first.up), (2, Vector3::z()));
        assert!((first.length - 9.8).abs() < 1e-12);
        assert_eq!(mean(&text, Some([2.5, 9.0])).unwrap().up, Vector3::x());
        let all = mean(&text, None).unwrap_err();
        assert!(all.contains("m/s^2: no gravity"), "thrown about: {all}");
    }

    #[test]
    fn readings_near_a_time_are_those_within_reach() {
        let upright = |timestamp_ns| Reading { timestamp_ns, acceleration: GRAVITY * Vector3::z() };
        let aside = |timestamp_ns| Reading { timestamp_ns, acceleration: GRAVITY * Vector3::x() };
        let readings =
            Readings::new("imu".into(), vec![aside(29), upright(40), upright(20), upright(30), aside(9)]);
        let near = |time, reach| readings.gravity_near(time, reach);
        assert_eq!((near(40, 10).unwrap().samples, near(40, 10).unwrap().up), (2, Vector3::z()));
        assert_eq!(near(5, 10).unwrap().up, Vector3::x(), "time does not go below zero");
        assert!(near(50, 9).unwrap_err().to_string().starts_with("imu: no reading from "));
        assert!(near(30, 1).unwrap_err().to_string().contains("no gravity"), "it tips over");
    }

    #[test]
    fn bad_readings_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.csv");
        let text = "1,0,0,0,0,0,9.81\n2,nan,nan,nan,nan,nan,nan\n3,0,0,0,0,0\n4,nan,0,0,0,0,9.81\n";
        std::fs::write(&path, text).unwrap();
        let readings = Readings::read(&path).unwrap();
        assert_eq!(readings.faults().to_string(), "2 of 4 readings", "a rate is not read");
        assert!(readings.faults().first()[0].place.ends_with("data.csv:2"));
        assert_eq!(readings.gravity(None).unwrap().samples, 2);
    }

    #[test]
    fn other_orders_and_units_are_read() {
        for text in [
            "time [s];ax;ay;az;gx;gy;gz;temperature\n1,5;0;0;9,81;1;2;3;20\n",
            "#t [s] linear_acceleration.x linear_acceleration.y linear_acceleration.z\n1.5 0 0 9.81\n",
            "1.5,1,2,3,0,0,9.81,20\n",
            "timestamp,angular_x,angular_y,angular_z,acc_x,acc_y,acc_z\n1500000000,1,2,3,0,0,9.81\n",
        ] {
            let gravity = mean(text, Some([1.4, 1.6])).unwrap();
            assert_eq!((gravity.samples, gravity.up, gravity.length), (1, Vector3::z(), 9.81), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let message = |text: &str, span| mean(text, span).unwrap_err();
        assert!(message(HEADER, None).ends_with("data.csv: no reading"));
        let one = "1,0,0,0,0,0,9.81\n";
        assert!(message(one, Some([5.0, 6.5])).ends_with("no reading from 5 to 6.5 s"));
        for (line, what) in [
            ("1,0,0,0,0,9.81", "6 fields"),
            ("-1,0,0,0,0,0,9.81", "timestamp is '-1'"),
            ("1,0,0,0,0,0,nan", "acceleration is 'nan'"),
            ("1,0,0,0,0,0,x", "acceleration is 'x'"),
        ] {
            let found = message(&format!("{HEADER}{line}\n"), None);
            assert!(found.contains("data.csv:2: ") && found.contains(what), "{found}");
        }
        assert!(
            message("1,0,0,0,0,0,1\n", None).contains("mean acceleration is 1.00 m/s^2"),
            "in units of g"
        );
        let missing = Readings::read(Path::new("no/such.csv")).unwrap_err().to_string();
        assert!(missing.starts_with("no/such.csv: cannot be read"), "{missing}");
    }
}
