//! What a user should know of a plan although it was read.

use super::ink::Ink;
use crate::drawing::unit::{Unit, UnitSource};
use crate::image_file::{Pixels, Samples};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Share of dark pixels from which a drawing may be white on dark, percent.
const MOSTLY_DARK_PERCENT: u64 = 60;

/// Least difference of the largest and smallest channel of a coloured pixel.
const LEAST_CHROMA: u8 = 96;

/// What a user should know of a plan although it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PlanNote {
    /// A map description names an image that is not there; one of that name beside it was taken.
    ImageBeside {
        /// The description.
        description: PathBuf,
        /// The image that it names.
        named: PathBuf,
        /// The image that was taken.
        taken: PathBuf,
    },
    /// The image that a map description names is not in its folder.
    ImageElsewhere {
        /// The description.
        description: PathBuf,
        /// The image.
        image: PathBuf,
    },
    /// An image was read by itself although a map description lies beside it.
    DescriptionBeside {
        /// The image.
        image: PathBuf,
        /// The description.
        description: PathBuf,
        /// Metres per pixel that it says.
        resolution_m: f64,
        /// Metres per pixel that were taken.
        taken_m: f64,
    },
    /// Most pixels are wall.
    MostlyDark {
        /// The image.
        path: PathBuf,
        /// Percent of the pixels.
        percent: u64,
    },
    /// Coloured pixels that are no glazing.
    Coloured {
        /// The image.
        path: PathBuf,
        /// Their most frequent colour.
        colour: [u8; 3],
        /// Pixels of about that colour.
        pixels: u64,
        /// Whether they count as wall.
        is_wall: bool,
    },
    /// Strokes that are too thin for walls were removed, as asked.
    Cleaned {
        /// The plan.
        path: PathBuf,
        /// The least thickness of a wall, metres.
        thickness_m: f64,
        /// Percent of the wall pixels that were removed.
        percent: u64,
        /// The number of connected pieces that they are.
        pieces: usize,
        /// Cavities between two lines that were filled and are now wall.
        cavities: usize,
    },
    /// Layers of a drawing whose names say nothing.
    UnknownLayers {
        /// The drawing.
        path: PathBuf,
        /// The layers.
        layers: Vec<UnknownLayer>,
        /// Whether they count as walls, because no other layer does; else they are left out.
        taken_for_walls: bool,
    },
    /// Objects of a drawing that are not read.
    Unread {
        /// The drawing.
        path: PathBuf,
        /// Their kinds and how many there are of each.
        kinds: Vec<(String, usize)>,
    },
    /// The unit of a drawing is guessed or doubtful.
    Unit {
        /// The drawing.
        path: PathBuf,
        /// The unit that was taken.
        unit: Unit,
        /// The longer side of what is drawn, in metres.
        side_m: f64,
    },
    /// Nothing tells the scale of a drawing.
    Scale {
        /// The drawing.
        path: PathBuf,
        /// Metres that a unit counts as.
        unit_m: f64,
    },
    /// Model space holds drawings apart from each other.
    SeveralDrawings {
        /// The drawing file.
        path: PathBuf,
        /// Least and greatest x and y of each that is kept, in metres.
        extents_m: Vec<[[f64; 2]; 2]>,
        /// How many small ones were left out.
        left_out: usize,
    },
    /// The drawing is too large for the usual resolution.
    Coarser {
        /// The drawing.
        path: PathBuf,
        /// Metres per pixel that were taken.
        resolution_m: f64,
        /// Sides of what is drawn, in metres.
        sides_m: [f64; 2],
    },
}

/// A layer whose name says nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownLayer {
    /// Its name.
    pub name: String,
    /// Its lines and areas.
    pub entities: usize,
    /// Sides of their extent in metres.
    pub sides_m: [f64; 2],
}

impl fmt::Display for UnknownLayer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.sides_m;
        write!(f, "'{}' ({} entities, {width:.1} x {height:.1} m)", self.name, self.entities)
    }
}

impl fmt::Display for PlanNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ImageBeside { description, named, taken } => {
                let [description, named, taken] = [description, named, taken].map(|path| path.display());
                write!(f, "{description}: {named} does not exist; {taken} is taken")
            }
            Self::ImageElsewhere { description, image } => {
                let [description, image] = [description, image].map(|path| path.display());
                write!(f, "{description}: its image is {image}, outside of its folder")
            }
            Self::DescriptionBeside { image, description, resolution_m, taken_m } => {
                let [image, description] = [image, description].map(|path| path.display());
                write!(
                    f,
                    "{image}: {description} beside it says {resolution_m} m per pixel, {taken_m} is taken; \
                     name {description} as the plan to use it"
                )
            }
            Self::MostlyDark { path, percent } => write!(
                f,
                "{}: {percent} % of the pixels are wall; if this drawing is white on dark, add --invert",
                path.display()
            ),
            Self::Coloured { path, colour: [r, g, b], pixels, is_wall } => write!(
                f,
                "{}: {pixels} pixels are coloured like {r:02x}{g:02x}{b:02x} and count as {}; \
                 --glazing-color and --door-color say what colours mean",
                path.display(),
                if *is_wall { "wall" } else { "free" }
            ),
            Self::Cleaned { path, thickness_m, percent, pieces, cavities } => write!(
                f,
                "{}: strokes thinner than {thickness_m} m removed: {percent} % of the wall pixels (pieces: {pieces}); \
                 cavities between two lines filled: {cavities}",
                path.display()
            ),
            Self::UnknownLayers { path, layers, taken_for_walls } => {
                let layers: Vec<String> = layers.iter().map(ToString::to_string).collect();
                let taken = if *taken_for_walls { "taken for walls" } else { "left out" };
                write!(
                    f,
                    "{}: {taken}, as their names say nothing: layers {}; --layers-wall and its like say what they are",
                    path.display(),
                    layers.join(", ")
                )
            }
            Self::Unread { path, kinds } => {
                let kinds: Vec<String> =
                    kinds.iter().map(|(kind, count)| format!("{count} x {kind}")).collect();
                write!(
                    f,
                    "{}: not read: {}; explode them into lines in the CAD program if they are walls",
                    path.display(),
                    kinds.join(", ")
                )
            }
            Self::Unit { path, unit, side_m } => {
                let source = match unit.source {
                    UnitSource::Guessed => "the file names no unit; from its size",
                    _ => "the file says that",
                };
                write!(
                    f,
                    "{}: {source} a unit is 1 {unit}, and the plan is {side_m:.1} m long; --unit says another",
                    path.display()
                )
            }
            Self::Scale { path, unit_m } => write!(
                f,
                "{}: nothing tells its scale: a unit counts as {unit_m} m, as a pixel of a picture does; \
                 --scale 1:100, --unit or --scale-points say another",
                path.display()
            ),
            Self::SeveralDrawings { path, extents_m, left_out } => {
                let extents: Vec<String> = extents_m
                    .iter()
                    .map(|[[x0, y0], [x1, y1]]| format!("{x0:.1},{y0:.1} to {x1:.1},{y1:.1}"))
                    .collect();
                write!(
                    f,
                    "{}: {} drawings apart from each other, at {} m; {left_out} small ones left out",
                    path.display(),
                    extents.len(),
                    extents.join(" and at ")
                )
            }
            Self::Coarser { path, resolution_m, sides_m: [width, height] } => write!(
                f,
                "{}: {width:.0} x {height:.0} m is large: {resolution_m} m per pixel is taken; --resolution says another",
                path.display()
            ),
        }
    }
}

/// A note on a drawing that may be white on dark, by the percentage of its pixels that are wall.
pub(super) fn mostly_dark(path: &Path, percent: u64) -> Option<PlanNote> {
    (percent >= MOSTLY_DARK_PERCENT).then(|| PlanNote::MostlyDark { path: path.to_path_buf(), percent })
}

/// A note on the most frequent colour that is no glazing and no door, if there are lines of it.
pub(super) fn coloured(path: &Path, pixels: &Pixels, ink: &Ink) -> Option<PlanNote> {
    let Samples::Rgb(rgb) = &pixels.samples else { return None };
    let pixels = rgb.as_chunks::<3>().0;
    // Similar colours count as one, named by the first of them.
    let mut found = BTreeMap::<[u8; 3], ([u8; 3], u64)>::new();
    for &pixel in pixels.iter().filter(|pixel| is_coloured(**pixel) && !ink.is_named(**pixel)) {
        found.entry(pixel.map(|value| value >> 5)).or_insert((pixel, 0)).1 += 1;
    }
    let (colour, count) = found.into_values().max_by_key(|(_, count)| *count)?;
    let enough = count >= 20.max(pixels.len() as u64 / 10_000);
    let is_wall = ink.is_dark(ink.level_of(colour));
    enough.then(|| PlanNote::Coloured { path: path.to_path_buf(), colour, pixels: count, is_wall })
}

fn is_coloured(pixel: [u8; 3]) -> bool {
    let (least, most) = pixel.iter().fold((255, 0), |(least, most), &v| (v.min(least), v.max(most)));
    most - least >= LEAST_CHROMA
}
