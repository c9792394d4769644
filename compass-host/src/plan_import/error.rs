//! Why a plan could not be imported.

use crate::image_file::ImageFileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a plan could not be imported: one line, with the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlanImportError {
    /// An image could not be read or decoded.
    #[error(transparent)]
    Image(#[from] ImageFileError),
    /// A map description could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The two images of a pair differ in size.
    #[error("{}: {walls_width} x {walls_height} pixels, but {} has {plan_width} x {plan_height}",
            walls.display(), plan.display())]
    PairSize {
        /// The plan image.
        plan: PathBuf,
        /// Its pixels along x.
        plan_width: u32,
        /// Its pixels along y.
        plan_height: u32,
        /// The image of the walls alone.
        walls: PathBuf,
        /// Its pixels along x.
        walls_width: u32,
        /// Its pixels along y.
        walls_height: u32,
    },
    /// The image is one flat colour.
    #[error("{}: every pixel is {colour}; there is no plan in it", path.display())]
    OneColour {
        /// The file.
        path: PathBuf,
        /// The colour, as `#rrggbb`.
        colour: String,
    },
    /// No pixel of the image is a wall.
    #[error("{}: no walls: no pixel is darker than {dark_below} of 255 without being red", path.display())]
    NoWalls {
        /// The file.
        path: PathBuf,
        /// The first luma that is not dark (of the inverted image when the map is negated).
        dark_below: u16,
    },
    /// A map description is not YAML, or lacks a field, or a field has the wrong type.
    #[error("{}: not a ROS map description: {reason}", path.display())]
    Yaml {
        /// The description.
        path: PathBuf,
        /// What the parser said, with line and column where known, in one line.
        reason: String,
    },
    /// A value is outside what is accepted.
    #[error("{}: {field} is {value}; {wanted}", path.display())]
    Value {
        /// The plan or the map description.
        path: PathBuf,
        /// What the value is for.
        field: &'static str,
        /// The value refused.
        value: String,
        /// What would be accepted.
        wanted: &'static str,
    },
}
