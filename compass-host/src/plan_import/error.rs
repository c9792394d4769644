//! Why a plan could not be imported.

use crate::image_file::ImageFileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a plan could not be imported: one line that names the file at fault.
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
        /// The system's error.
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
    /// A drawing is not of its format, or too large once it is unfolded.
    #[error("{}: not a {format} drawing that can be read: {reason}", path.display())]
    Drawing {
        /// The file.
        path: PathBuf,
        /// The format by the file's name.
        format: &'static str,
        /// The reader's message.
        reason: String,
    },
    /// This build of the program does not read the format.
    #[error("{}: this build does not read {format}; build it with --features {feature}", path.display())]
    Feature {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// The Cargo feature that reads it.
        feature: &'static str,
    },
    /// An option that means nothing for the format of the plan.
    #[error("{}: {option} does not apply to {format}", path.display())]
    Option {
        /// The plan.
        path: PathBuf,
        /// The option, by its name on the command line.
        option: &'static str,
        /// The format.
        format: &'static str,
    },
    /// Two options that say the same of the plan.
    #[error("{}: {} and {} say the same of {format}; give one", path.display(), options[0], options[1])]
    Repeated {
        /// The plan.
        path: PathBuf,
        /// The options, by their names on the command line.
        options: [&'static str; 2],
        /// The format.
        format: &'static str,
    },
    /// The file is of a format that is not read, or not under this name.
    #[error("{}: {what}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is, and what to do with it.
        what: &'static str,
    },
    /// Nothing tells the scale of a drawing on paper.
    #[error("{}: nothing tells its scale: add --scale 1:100, or --scale-points X1,Y1,X2,Y2,METRES", path.display())]
    Scale {
        /// The drawing.
        path: PathBuf,
    },
    /// No layer of a drawing shows walls.
    #[error("{}: no layer shows walls; --layers-wall says which do, of: {}", path.display(), listed(layers))]
    NoWallLayer {
        /// The drawing.
        path: PathBuf,
        /// The names of its layers.
        layers: Vec<String>,
    },
    /// A drawing has too many pixels.
    #[error(
        "{}: {:.0} x {:.0} m are too many pixels; a coarser --resolution, another --unit or fewer layers may help",
        path.display(), sides_m[0], sides_m[1]
    )]
    DrawingSize {
        /// The drawing.
        path: PathBuf,
        /// Its sides in metres.
        sides_m: [f64; 2],
    },
    /// No stroke of the plan is as thick as asked.
    #[error("{}: no walls: no stroke is {thickness_m} m thick", path.display())]
    NoThickWalls {
        /// The file.
        path: PathBuf,
        /// The least thickness of a wall, metres.
        thickness_m: f64,
    },
    /// A map description is not YAML, or lacks a field, or a field has the wrong type.
    #[error("{}: not a ROS map description: {reason}", path.display())]
    Yaml {
        /// The description.
        path: PathBuf,
        /// The parser's message, with line and column where known, in one line.
        reason: String,
    },
    /// A value is out of the accepted range.
    #[error("{}: {field} is {value}; {wanted}", path.display())]
    Value {
        /// The plan or the map description.
        path: PathBuf,
        /// The meaning of the value.
        field: &'static str,
        /// The rejected value.
        value: String,
        /// The accepted values.
        wanted: &'static str,
    },
}

/// Names in one line.
fn listed(names: &[String]) -> String {
    if names.is_empty() { "none, as nothing is drawn".into() } else { names.join(", ") }
}
