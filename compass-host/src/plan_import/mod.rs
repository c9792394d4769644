//! Floor plans from image files: a wall mask and a glazing mask, south row first.
//!
//! Supported are one image (dark = wall, red = glazing), a pair of images of one size (glazing = what the plan has
//! beyond the walls), a ROS `map_server` description (`.yaml`), and vector drawings, whose layers say what is wall.
//! `classify` classifies pixels, `vector` draws lines; this module checks everything else.

mod bits;
mod cavities;
mod classify;
mod clean;
mod clusters;
// Without one of the readers some of its scales are not used.
#[cfg_attr(not(all(feature = "cad", feature = "drawings")), allow(dead_code))]
mod drawing_file;
mod error;
mod foreign;
mod ink;
mod layers;
mod line_walls;
mod note;
mod paint;
mod painter;
mod pieces;
mod raster;
mod ros_map;
pub mod structure;
mod summary;
pub mod survey;
mod turned;
mod vector;

pub use crate::drawing::unit::{NAMED_UNITS, Unit, UnitSource};
pub use error::PlanImportError;
pub use layers::{EmptyPattern, LayerPattern, LayerRole, LayerRoles};
pub use note::{PlanNote, UnknownLayer};
pub use raster::PlanRaster;
pub use summary::{DrawingOptions, LayerSummary};

use std::path::{Path, PathBuf};

use crate::image_file::{self, DecodeError, ImageFileError, Pixels};
use crate::input::{self, limits};
use crate::interior::Places;
use classify::Masks;
use drawing_file::DrawingFormat;
use ink::{Ink, Tone};
use structure::{Bearing, StructureError, keep_structure_inside};

/// Metres per pixel when neither the options nor a map description say otherwise.
pub const DEFAULT_RESOLUTION_M: f64 = 0.01;

/// Finest and coarsest metres per pixel accepted.
pub const RESOLUTION_RANGE_M: std::ops::RangeInclusive<f64> = 0.001..=4.0;

/// Luma below which a pixel is dark, unless the options say otherwise.
pub const DEFAULT_DARK_BELOW: u8 = 128;

/// `R - max(G, B)` from which a pixel is red, unless the options say otherwise.
pub const DEFAULT_RED_EXCESS: u8 = 60;

/// The location of a plan and how to read it.
#[derive(Debug, Clone)]
pub struct PlanOptions {
    /// An image, a ROS `map_server` description ending in `.yaml` or `.yml`, or a drawing ending in `.dxf`, `.dwg`,
    /// `.svg` or `.pdf`.
    pub plan: PathBuf,
    /// An image of the same size with the walls alone; glazing is what the plan has beyond it.
    pub walls: Option<PathBuf>,
    /// Metres per pixel; `None`: the map description's, or [`DEFAULT_RESOLUTION_M`].
    pub resolution_m: Option<f64>,
    /// Metres per pixel of an image or per unit of a drawing, measured between two points of it.
    pub scale_points_m: Option<f64>,
    /// Map position in metres of the outer corner of the bottom-left pixel; `None`: the map
    /// description's, or (0, 0).
    pub origin: Option<[f64; 2]>,
    /// A pixel is dark when its luma is below this. A map description's `occupied_thresh` replaces it.
    pub dark_below: u8,
    /// A pixel is red when `R - max(G, B)` is at least this.
    pub red_excess: u8,
    /// The colour of glazing, RGB; `None`: red.
    pub glazing: Option<[u8; 3]>,
    /// The colour of doors, RGB: they count as open. `None`: doors have no colour of their own.
    pub door: Option<[u8; 3]>,
    /// Whether the drawing is light on dark. With a map description: the opposite of what that says.
    pub invert: bool,
    /// Thickness in metres of the thinnest strokes that are walls: thinner ones are removed, such as text, dimension lines
    /// and door arcs. At least 1.5 pixels, at most 2 m; `None`: all that is dark is wall.
    pub min_thickness_m: Option<f64>,
    /// How a vector drawing is read.
    pub drawing: DrawingOptions,
}

impl PlanOptions {
    /// Options for the plan in `plan` with the default thresholds.
    #[must_use]
    pub fn new(plan: impl Into<PathBuf>) -> Self {
        Self {
            plan: plan.into(),
            walls: None,
            resolution_m: None,
            scale_points_m: None,
            origin: None,
            dark_below: DEFAULT_DARK_BELOW,
            red_excess: DEFAULT_RED_EXCESS,
            glazing: None,
            door: None,
            invert: false,
            min_thickness_m: None,
            drawing: DrawingOptions::default(),
        }
    }
}

/// Reads the plan that `options` describe.
///
/// # Errors
/// [`PlanImportError`]: a file that is missing, not an image or truncated; a plan of one colour or without walls; a
/// pair of two sizes; a map description with missing or rejected fields; a resolution outside [`RESOLUTION_RANGE_M`]
/// or an origin that is not finite; a least thickness out of its range, or one that no stroke of the plan has.
pub fn load(options: &PlanOptions) -> Result<PlanRaster, PlanImportError> {
    import(options).map(|imported| imported.plan)
}

/// A plan, and what was understood of its file.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Imported {
    /// The plan.
    pub plan: PlanRaster,
    /// The layers of a drawing; empty for images.
    pub layers: Vec<LayerSummary>,
    /// What a user should know although the plan was read.
    pub notes: Vec<PlanNote>,
    /// What is drawn but no part of the plan, as walls, if the options ask for it; `None` for images.
    pub left_out: Option<PlanRaster>,
    /// Doors of a drawing, as walls, where a layer shows them.
    pub doors: Option<PlanRaster>,
    bearing: Option<Bearing>,
}

impl Imported {
    /// Whether the layers of a drawing say what is structure.
    #[must_use]
    pub const fn has_structure(&self) -> bool {
        self.bearing.is_some()
    }

    /// The structure: what the layers of a drawing call so, and of other walls those at least `thickness_m` thick;
    /// with the glazing of the facade. `places` say what is inside, where they name anything.
    ///
    /// # Errors
    /// [`StructureError`].
    pub fn structure(&self, thickness_m: f64, places: &Places) -> Result<PlanRaster, StructureError> {
        match &self.bearing {
            Some(bearing) => bearing.structure(&self.plan, thickness_m, places),
            None => keep_structure_inside(&self.plan, thickness_m, places),
        }
    }

    const fn image(plan: PlanRaster, notes: Vec<PlanNote>) -> Self {
        Self { plan, layers: Vec::new(), notes, left_out: None, doors: None, bearing: None }
    }
}

/// [`load`], with what was understood of the file.
///
/// # Errors
/// As [`load`].
pub fn import(options: &PlanOptions) -> Result<Imported, PlanImportError> {
    check_options(options)?;
    match DrawingFormat::of(&options.plan) {
        Some(format) => import_drawing(options, format),
        None => load_image(options).map(|(plan, notes)| Imported::image(plan, notes)),
    }
}

/// A plan from an image or a map description.
fn load_image(options: &PlanOptions) -> Result<(PlanRaster, Vec<PlanNote>), PlanImportError> {
    let Source { image, resolution_m, origin, yaw, ink, note } = Source::of(options)?;
    let mut notes = Vec::from_iter(note);
    check_resolution(&options.plan, resolution_m)?;
    check_origin(&options.plan, origin)?;
    let plan = read_image(&image)?;
    let mut masks = match &options.walls {
        None => classify::one_image(&plan, &ink),
        Some(path) => {
            let walls = read_image(path)?;
            check_pair(&image, &plan, path, &walls)?;
            check_colours(path, &walls)?;
            classify::pair(&plan, &walls, &ink)
        }
    };
    let (pixels, wall_pixels) = (u64::from(plan.width) * u64::from(plan.height), masks.wall_pixels());
    if wall_pixels == 0 {
        check_colours(&image, &plan)?;
        let path = options.walls.clone().unwrap_or(image);
        return Err(PlanImportError::NoWalls { path, dark_below: ink.dark_below });
    }
    if wall_pixels == pixels {
        check_colours(&image, &plan)?;
    }
    if !is_yaml(&options.plan) && options.walls.is_none() {
        notes.extend(note::mostly_dark(&image, 100 * wall_pixels / pixels));
        notes.extend(note::coloured(&image, &plan, &ink));
    }
    if let Some(thickness_m) = options.min_thickness_m {
        let size = [plan.width, plan.height];
        notes.push(only_thick(&options.plan, &mut masks, size, thickness_m, resolution_m)?);
    }
    let Masks { walls, windows } = masks;
    let raster = PlanRaster { width: plan.width, height: plan.height, walls, windows, resolution_m, origin };
    match turned::turned(raster, yaw) {
        Some(raster) => Ok((raster, notes)),
        None => Err(PlanImportError::Value {
            path: options.plan.clone(),
            field: "yaw of origin",
            value: yaw.to_string(),
            wanted: "the turned map would have more than 65535 pixels on a side",
        }),
    }
}

/// Decodes an image; the error says what the file is instead, where that is known.
fn read_image(path: &Path) -> Result<Pixels, PlanImportError> {
    image_file::read(path, limits().plan_pixels).map_err(|error| {
        let is_image = !matches!(&error, ImageFileError::Decode { problem: DecodeError::NotAnImage, .. });
        let what = if is_image { None } else { foreign::recognise(path) };
        what.map_or(error.into(), |what| PlanImportError::Foreign { path: path.to_path_buf(), what })
    })
}

/// The plan image and how to read it, after merging options, map description and defaults.
struct Source {
    image: PathBuf,
    resolution_m: f64,
    origin: [f64; 2],
    yaw: f64,
    ink: Ink,
    note: Option<PlanNote>,
}

impl Source {
    /// Colours as the options say, of a drawing that says nothing itself.
    fn plain_ink(options: &PlanOptions) -> Ink {
        Ink {
            tone: if options.invert { Tone::Negative } else { Tone::Positive },
            mean: false,
            dark_below: u16::from(options.dark_below),
            red_excess: options.red_excess,
            glazing: options.glazing,
            door: options.door,
        }
    }

    fn of(options: &PlanOptions) -> Result<Self, PlanImportError> {
        let plain = Self::plain_ink(options);
        if !is_yaml(&options.plan) {
            return Ok(Self {
                image: options.plan.clone(),
                resolution_m: options.resolution_m.or(options.scale_points_m).unwrap_or(DEFAULT_RESOLUTION_M),
                origin: options.origin.unwrap_or_default(),
                yaw: 0.0,
                ink: plain,
                note: description_beside(options),
            });
        }
        let map = ros_map::read(&options.plan)?;
        let tone = match (map.tone, options.invert) {
            (Tone::Positive, true) => Tone::Negative,
            (Tone::Negative, true) => Tone::Positive,
            (tone, _) => tone,
        };
        let description = options.plan.clone();
        let note = match &map.named {
            Some(named) => {
                Some(PlanNote::ImageBeside { description, named: named.clone(), taken: map.image.clone() })
            }
            None if map.is_elsewhere => {
                Some(PlanNote::ImageElsewhere { description, image: map.image.clone() })
            }
            None => None,
        };
        Ok(Self {
            resolution_m: options.resolution_m.or(options.scale_points_m).unwrap_or(map.resolution_m),
            origin: options.origin.unwrap_or(map.origin),
            yaw: map.yaw,
            ink: Ink { tone, mean: true, dark_below: map.dark_below(), ..plain },
            note,
            image: map.image,
        })
    }
}

/// A note on the map description that names the image, where it lies beside it and nothing else tells the resolution.
fn description_beside(options: &PlanOptions) -> Option<PlanNote> {
    let taken_m =
        options.resolution_m.or(options.scale_points_m).is_none().then_some(DEFAULT_RESOLUTION_M)?;
    let candidates = ["yaml", "yml"].map(|end| options.plan.with_extension(end));
    let found = candidates.into_iter().find_map(|path| ros_map::read(&path).ok().map(|map| (path, map)));
    let (description, map) = found?;
    (map.image.file_name() == options.plan.file_name()).then(|| PlanNote::DescriptionBeside {
        image: options.plan.clone(),
        description,
        resolution_m: map.resolution_m,
        taken_m,
    })
}

/// Refuses options that mean nothing for the format: a plan would be another than the caller thinks.
fn check_options(options: &PlanOptions) -> Result<(), PlanImportError> {
    let DrawingOptions { layers, unit_m, scale, page, .. } = &options.drawing;
    let format = DrawingFormat::of(&options.plan);
    let (is_drawing, is_page) = (format.is_some(), format.is_some_and(DrawingFormat::is_page));
    let refused = [
        (options.walls.is_some() && is_drawing, "--walls"),
        (!layers.told.is_empty() && !is_drawing, "--layers-wall and its like"),
        (unit_m.is_some() && !is_drawing, "--unit"),
        (scale.is_some() && !is_page, "--scale"),
        (*page != 1 && format != Some(DrawingFormat::Pdf), "--page"),
    ];
    let by_points = options.scale_points_m.is_some();
    let repeated = [
        (by_points && !is_drawing && options.resolution_m.is_some(), ["--scale-points", "--resolution"]),
        (by_points && is_drawing && unit_m.is_some(), ["--scale-points", "--unit"]),
        (by_points && scale.is_some(), ["--scale-points", "--scale"]),
        (unit_m.is_some() && scale.is_some(), ["--unit", "--scale"]),
    ];
    let (path, format) = (options.plan.clone(), format.map_or("an image", DrawingFormat::name));
    if let Some((_, option)) = refused.into_iter().find(|(is_so, _)| *is_so) {
        return Err(PlanImportError::Option { path, option, format });
    }
    match repeated.into_iter().find(|(is_so, _)| *is_so) {
        Some((_, options)) => Err(PlanImportError::Repeated { path, options, format }),
        None => Ok(()),
    }
}

/// A plan from a vector drawing.
fn import_drawing(options: &PlanOptions, format: DrawingFormat) -> Result<Imported, PlanImportError> {
    let path = &options.plan;
    input::find(path).map_err(|source| PlanImportError::Read { path: path.clone(), source })?;
    if let Some(resolution_m) = options.resolution_m {
        check_resolution(path, resolution_m)?;
    }
    check_origin(path, options.origin.unwrap_or_default())?;
    let told = drawing_file::Told {
        unit_m: options.scale_points_m.or(options.drawing.unit_m),
        resolution_m: options.resolution_m,
    };
    let opened = drawing_file::open(path, format, &options.drawing, &told)?;
    let ink = Source::plain_ink(options);
    let mut vector =
        vector::import(path, opened.drawing, &options.drawing, &ink, opened.resolution_m, options.origin)?;
    vector.notes.extend(opened.note);
    let vector::Vector { mut plan, bearing, layers, mut notes, left_out, doors } = vector;
    if let Some(thickness_m) = options.min_thickness_m {
        let mut masks = Masks { walls: plan.walls, windows: plan.windows };
        let size = [plan.width, plan.height];
        notes.push(only_thick(path, &mut masks, size, thickness_m, plan.resolution_m)?);
        (plan.walls, plan.windows) = (masks.walls, masks.windows);
    }
    Ok(Imported { plan, layers, notes, left_out, doors, bearing })
}

/// Removes strokes that are too thin for walls; a note on how much that was.
fn only_thick(
    path: &Path,
    masks: &mut Masks,
    size: [u32; 2],
    thickness_m: f64,
    resolution_m: f64,
) -> Result<PlanNote, PlanImportError> {
    let Some(side) = clean::square(thickness_m, resolution_m) else {
        return Err(PlanImportError::Value {
            path: path.to_path_buf(),
            field: "least thickness",
            value: thickness_m.to_string(),
            wanted: "metres from 1.5 pixels to 2 m are accepted",
        });
    };
    let clean::Cleaned { percent, pieces, cavities } = clean::clean(masks, size, side, resolution_m);
    let path = path.to_path_buf();
    if masks.wall_pixels() == 0 {
        return Err(PlanImportError::NoThickWalls { path, thickness_m });
    }
    Ok(PlanNote::Cleaned { path, thickness_m, percent, pieces, cavities })
}

fn is_yaml(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("yaml") || end.eq_ignore_ascii_case("yml"))
}

fn check_resolution(path: &Path, resolution_m: f64) -> Result<(), PlanImportError> {
    if RESOLUTION_RANGE_M.contains(&resolution_m) {
        return Ok(());
    }
    Err(PlanImportError::Value {
        path: path.to_path_buf(),
        field: "resolution",
        value: resolution_m.to_string(),
        wanted: "metres per pixel from 0.001 to 4 are accepted",
    })
}

fn check_origin(path: &Path, origin: [f64; 2]) -> Result<(), PlanImportError> {
    if origin.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(PlanImportError::Value {
        path: path.to_path_buf(),
        field: "origin",
        value: format!("{},{}", origin[0], origin[1]),
        wanted: "two finite numbers of metres are needed",
    })
}

fn check_pair(
    plan_path: &Path,
    plan: &Pixels,
    walls_path: &Path,
    walls: &Pixels,
) -> Result<(), PlanImportError> {
    if (plan.width, plan.height) == (walls.width, walls.height) {
        return Ok(());
    }
    Err(PlanImportError::PairSize {
        plan: plan_path.to_path_buf(),
        plan_width: plan.width,
        plan_height: plan.height,
        walls: walls_path.to_path_buf(),
        walls_width: walls.width,
        walls_height: walls.height,
    })
}

fn check_colours(path: &Path, pixels: &Pixels) -> Result<(), PlanImportError> {
    match pixels.only_colour() {
        None => Ok(()),
        Some([r, g, b]) => Err(PlanImportError::OneColour {
            path: path.to_path_buf(),
            colour: format!("#{r:02x}{g:02x}{b:02x}"),
        }),
    }
}

#[cfg(test)]
mod tests;
