//! What a user should know of a plan although it was read.

use super::ink::Ink;
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
}

impl fmt::Display for PlanNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ImageBeside { description, named, taken } => {
                let [description, named, taken] = [description, named, taken].map(|path| path.display());
                write!(f, "{description}: {named} does not exist; {taken} is taken")
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
