//! Why a calibration could not be read or used.

use compass_core::vision::camera::CameraError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a calibration could not be read or used: one line that names the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not a calibration of a known form.
    #[error("{}: {reason}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What it is instead, or where it stops to be YAML; in one line.
        reason: String,
    },
    /// A field is missing or invalid.
    #[error("{}: {field}: {problem}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field, such as `cam0.intrinsics`.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The image has another aspect ratio than the calibrated one.
    #[error(
        "{}: {camera} is calibrated for {} x {} pixels, the image has {} x {}: not the same shape{hint}",
        path.display(), calibrated.0, calibrated.1, image.0, image.1
    )]
    Shape {
        /// The file.
        path: PathBuf,
        /// Name of the camera.
        camera: String,
        /// Width and height in the file.
        calibrated: (u32, u32),
        /// Width and height of the image.
        image: (u32, u32),
        /// A hint at the cause, or empty.
        hint: &'static str,
    },
    /// The core rejected the rig.
    #[error("{}: {source}", path.display())]
    Rig {
        /// The file.
        path: PathBuf,
        /// The core's error.
        source: CameraError,
    },
}

/// A field that is missing or invalid, and why. A camera with one is refused when it is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Refusal {
    /// The field with its path in the file, such as `cam0.intrinsics`.
    pub(super) field: String,
    /// What is wrong with it.
    pub(super) problem: String,
}

impl Refusal {
    pub(super) fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { field: field.into(), problem: problem.into() }
    }

    /// The same about a field of `owner`.
    pub(super) fn of(self, owner: &str) -> Self {
        let dot = if self.field.is_empty() { "" } else { "." };
        Self { field: format!("{owner}{dot}{}", self.field), ..self }
    }

    /// The error about a file.
    pub(super) fn within(self, path: PathBuf) -> CalibrationError {
        CalibrationError::Field { path, field: self.field, problem: self.problem }
    }
}
