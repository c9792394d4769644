//! The options that every command with a plan shares.

use super::notes::note;
pub(super) use super::places::pair;
use super::places::{PlacesArgs, numbers};
use super::progress::Waiting;
use anyhow::{Context as _, Result};
use compass_core::base::scan::Scan;
use compass_host::interior::Places;
use compass_host::plan_import::{
    self, DrawingOptions, Imported, LayerPattern, LayerRole, LayerRoles, NAMED_UNITS, PlanOptions, PlanRaster,
};
use compass_host::site::PackedPlan;
use std::path::{Path, PathBuf};

/// How a plan file is read.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct Reading {
    /// Raster of the same size with the walls alone; glazing is what the plan has beyond it
    #[arg(long, value_name = "FILE")]
    walls: Option<PathBuf>,
    /// Metres per pixel [default: 0.01, or what the ROS .yaml says]
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    resolution: Option<f64>,
    /// Metres per pixel, or per unit of a drawing, from two points of it and the metres between them
    #[arg(
        long,
        value_name = "X1,Y1,X2,Y2,METRES",
        value_parser = metres_per_pixel,
        allow_hyphen_values = true
    )]
    scale_points: Option<f64>,
    /// Map position of the outer corner of the bottom-left pixel in metres [default: 0,0]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    origin: Option<[f64; 2]>,
    /// Luma below which a pixel is dark, 0..255
    #[arg(long, value_name = "N", default_value_t = plan_import::DEFAULT_DARK_BELOW)]
    dark_below: u8,
    /// Excess of red over the larger of green and blue from which a pixel is glazing, 0..255
    #[arg(long, value_name = "N", default_value_t = plan_import::DEFAULT_RED_EXCESS)]
    red_excess: u8,
    /// Colour of glazing, in place of red
    #[arg(long, value_name = "RRGGBB", value_parser = colour)]
    glazing_color: Option<[u8; 3]>,
    /// Colour of doors, which count as open
    #[arg(long, value_name = "RRGGBB", value_parser = colour)]
    door_color: Option<[u8; 3]>,
    /// The drawing is light on dark (of a ROS map: the opposite of its negate)
    #[arg(long)]
    invert: bool,
    /// Remove from a picture strokes thinner than M metres: text, dimension lines, door arcs, furniture, hatching
    #[arg(long, value_name = "M", value_parser = finite, allow_hyphen_values = true)]
    min_thickness: Option<f64>,
    #[command(flatten)]
    drawing: Layers,
    /// Keep only the structure: what layers of a drawing call so, and walls at least M metres thick, with the glazing
    /// of the facade [default without a value: 0.25]
    #[arg(long, value_name = "M", num_args = 0..=1, default_missing_value = "0.25", value_parser = finite)]
    structure: Option<f64>,
    #[command(flatten)]
    places: PlacesArgs,
}

/// What the layers of a CAD drawing are. PATTERNS: names separated by commas, without case, * for any letters and ? for
/// one; of several that match the longest counts, and names that none matches are looked up in a table.
#[derive(Debug, Clone, clap::Args)]
struct Layers {
    /// Layers that show walls
    #[arg(long, value_name = "PATTERNS", value_delimiter = ',')]
    layers_wall: Vec<LayerPattern>,
    /// Layers that show the structure: outer walls, columns, concrete
    #[arg(long, value_name = "PATTERNS", value_delimiter = ',')]
    layers_structure: Vec<LayerPattern>,
    /// Layers that show glazing
    #[arg(long, value_name = "PATTERNS", value_delimiter = ',')]
    layers_glazing: Vec<LayerPattern>,
    /// Layers that show doors, which count as open
    #[arg(long, value_name = "PATTERNS", value_delimiter = ',')]
    layers_door: Vec<LayerPattern>,
    /// Layers that are no part of the plan
    #[arg(long, value_name = "PATTERNS", value_delimiter = ',')]
    layers_ignore: Vec<LayerPattern>,
    /// Unit of the drawing, in place of what the file says: mm, cm, dm, m, in or ft
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<f64>,
    /// Scale of a drawing on paper, .svg or .pdf
    #[arg(long, value_name = "1:N", value_parser = scale)]
    scale: Option<f64>,
    /// Page of a .pdf
    #[arg(long, value_name = "N", default_value_t = 1)]
    page: usize,
}

impl Layers {
    fn options(&self) -> DrawingOptions {
        let told = [
            (&self.layers_wall, LayerRole::Wall),
            (&self.layers_structure, LayerRole::Structure),
            (&self.layers_glazing, LayerRole::Glazing),
            (&self.layers_door, LayerRole::Door),
            (&self.layers_ignore, LayerRole::Ignored),
        ];
        let told =
            told.into_iter().flat_map(|(patterns, role)| patterns.iter().map(move |p| (p.clone(), role)));
        DrawingOptions {
            layers: LayerRoles { told: told.collect() },
            unit_m: self.unit,
            scale: self.scale,
            page: self.page,
            with_left_out: false,
        }
    }
}

impl Reading {
    /// Reads a plan; what a user should know of it goes to standard error. `with_left_out`: for a picture of it.
    fn import(&self, plan: &Path, with_left_out: bool) -> Result<Imported> {
        let mut options = PlanOptions::new(plan);
        options.walls.clone_from(&self.walls);
        options.resolution_m = self.resolution;
        options.scale_points_m = self.scale_points;
        options.origin = self.origin;
        options.dark_below = self.dark_below;
        options.red_excess = self.red_excess;
        options.glazing = self.glazing_color;
        options.door = self.door_color;
        options.invert = self.invert;
        options.min_thickness_m = self.min_thickness;
        options.drawing = DrawingOptions { with_left_out, ..self.drawing.options() };
        let waiting = Waiting::for_work("reading the plan");
        let mut imported = plan_import::import(&options)?;
        drop(waiting);
        imported.notes.iter().for_each(|text| note(&text.to_string()));
        if let Some(thickness_m) = self.structure {
            imported.plan = imported
                .structure(thickness_m, &self.places.places())
                .with_context(|| plan.display().to_string())?;
        }
        Ok(imported)
    }

    /// Reads and packs a plan.
    pub(super) fn load(&self, plan: &Path) -> Result<(PlanRaster, PackedPlan)> {
        let raster = self.import(plan, false)?.plan;
        let packed = PackedPlan::new(&raster).with_context(|| plan.display().to_string())?;
        Ok((raster, packed))
    }
}

/// A plan file, by position or by `--plan`, and how it is read.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PlanArgs {
    /// Floor plan: dark = wall, red = glazing; a ROS map .yaml; or a drawing .dxf, .dwg, .svg or .pdf
    #[arg(value_name = "PLAN", conflicts_with = "plan_option")]
    plan: Option<PathBuf>,
    /// The same, as an option
    #[arg(long = "plan", id = "plan_option", value_name = "FILE")]
    plan_option: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

impl PlanArgs {
    /// The file, if one was named.
    pub(super) fn path(&self) -> Option<&Path> {
        self.plan.as_deref().or(self.plan_option.as_deref())
    }

    /// What is said to be inside.
    pub(super) fn places(&self) -> Places {
        self.reading.places.places()
    }

    /// Reads and packs the plan.
    pub(super) fn load(&self) -> Result<(PlanRaster, PackedPlan)> {
        self.reading.load(self.named()?)
    }

    /// Reads the plan; `with_left_out`: for a picture of it.
    pub(super) fn import(&self, with_left_out: bool) -> Result<Imported> {
        self.reading.import(self.named()?, with_left_out)
    }

    fn named(&self) -> Result<&Path> {
        self.path().context("no plan: name one as PLAN or with --plan FILE")
    }
}

/// A pose on a plan to hold something against; all or nothing.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PoseOnPlan {
    /// Floor plan to hold it against: dark = wall, red = glazing; a ROS map .yaml; or a drawing .dxf, .dwg, .svg or .pdf
    #[arg(long, value_name = "FILE", requires = "at", requires = "heading")]
    plan: Option<PathBuf>,
    /// Position on the plan in metres
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, requires = "plan")]
    at: Option<[f64; 2]>,
    /// Heading on the plan in degrees, counter-clockwise from +x
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true, requires = "plan")]
    heading: Option<f64>,
    #[command(flatten)]
    reading: Reading,
}

impl PoseOnPlan {
    /// The scan of the plan at that pose, if it was named.
    pub(super) fn scan(&self) -> Result<Option<Scan>> {
        let (Some(path), Some(at), Some(heading)) = (&self.plan, self.at, self.heading) else {
            return Ok(None);
        };
        let (_, packed) = self.reading.load(path)?;
        packed.scan(at, heading).with_context(|| path.display().to_string()).map(Some)
    }
}

/// Parses two whole numbers, `WxH`.
pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once('x').and_then(|(w, h)| w.parse().ok().zip(h.parse().ok()));
    let good = sides.filter(|(w, h)| (1..=20_000).contains(w) && (1..=20_000).contains(h));
    good.ok_or_else(|| format!("'{text}' is not WxH with sides of 1 to 20000 pixels"))
}

/// Metres per pixel from two points in pixels and the metres between them, `X1,Y1,X2,Y2,METRES`.
fn metres_per_pixel(text: &str) -> Result<f64, String> {
    let wanted = || format!("'{text}' is not two pixels and the metres between them, X1,Y1,X2,Y2,METRES");
    let [x1, y1, x2, y2, metres] = numbers(text).ok_or_else(wanted)?;
    let pixels = (x2 - x1).hypot(y2 - y1);
    if pixels < 1.0 || metres <= 0.0 {
        return Err(format!("'{text}': the points must be a pixel or more apart, and the metres above 0"));
    }
    Ok(metres / pixels)
}

/// Parses a colour, `RRGGBB` in hexadecimal.
fn colour(text: &str) -> Result<[u8; 3], String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let bits = (digits.len() == 6).then(|| u32::from_str_radix(digits, 16).ok()).flatten();
    let bits = bits.ok_or_else(|| format!("'{text}' is not a colour RRGGBB in hexadecimal digits"))?;
    let [_, colour @ ..] = bits.to_be_bytes();
    Ok(colour)
}

/// How many times smaller than the building a drawing is, `1:N`.
fn scale(text: &str) -> Result<f64, String> {
    let times = text.strip_prefix("1:").and_then(|times| times.parse::<f64>().ok());
    times
        .filter(|times| (1.0..=10_000.0).contains(times))
        .ok_or_else(|| format!("'{text}' is no scale such as 1:100"))
}

/// Metres of a unit by its name.
fn unit(text: &str) -> Result<f64, String> {
    let found = NAMED_UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
    let names = || NAMED_UNITS.map(|(name, _)| name).join(", ");
    found.map(|(_, metres)| *metres).ok_or_else(|| format!("'{text}' is not one of the units {}", names()))
}

/// Parses a finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("'{text}' is not a finite number")),
    }
}

/// The sample building as a plan.
pub(super) fn sample() -> Result<(PlanRaster, PackedPlan)> {
    let raster = PlanRaster::from(compass_host::sample::building());
    let packed = PackedPlan::new(&raster)?;
    Ok((raster, packed))
}
