//! The plan of a session, and what is seen from a place in it.

use crate::message::{Reply, floats, reply};
use compass_host::interior::Places;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
use compass_host::plan_import::{PlanOptions, import};
use compass_host::sample::building;
use compass_host::site_file::floor_name;
use compass_host::{PackError, PackedPlan, PlanDescriptor, PlanRaster};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Most pixels along a side of the picture of a plan.
const PICTURE_PIXELS: u32 = 2048;
/// Most pixels of a plan: a page has less memory than a computer.
const MOST_PIXELS: u64 = 100_000_000;

/// A plan with its two layers.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) name: String,
    pub(crate) raster: PlanRaster,
    pub(crate) packed: PackedPlan,
    pub(crate) structure: Option<PackedPlan>,
    notes: Vec<String>,
}

/// How a file is read, as far as the page asks.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Options {
    /// Metres per pixel.
    resolution: Option<f64>,
    /// N of a drawing's scale 1:N.
    scale: Option<f64>,
    /// Strokes thinner than that many metres are removed.
    min_thickness: Option<f64>,
    /// Whether the plan is light on dark.
    invert: bool,
}

#[derive(Serialize)]
struct Described<'a> {
    name: &'a str,
    /// Metres.
    size: [f64; 2],
    /// Metres, of the outer corner at the bottom left.
    origin: [f64; 2],
    resolution: f64,
    /// Whether the plan has a second layer.
    has_structure: bool,
    notes: &'a [String],
    /// Pixels of the picture that comes with it: a byte a pixel, north up, 0 free, 1 wall, 2 glazing.
    picture: [u32; 2],
}

impl Plan {
    /// The plan in a file that was lent.
    pub(crate) fn read(file: &str, options: &Options) -> Result<Self, String> {
        let mut told = PlanOptions::new(file);
        told.resolution_m = options.resolution;
        told.min_thickness_m = options.min_thickness;
        told.drawing.scale = options.scale;
        told.invert = options.invert;
        let imported = import(&told).map_err(|error| error.to_string())?;
        let pixels = u64::from(imported.plan.width) * u64::from(imported.plan.height);
        if pixels > MOST_PIXELS {
            return Err(format!(
                "{file}: {pixels} pixels are more than a page has memory for ({MOST_PIXELS}); the compass command reads it"
            ));
        }
        let structure = imported.structure(DEFAULT_THICKNESS_M, &Places::default()).ok();
        let notes = imported.notes.iter().map(ToString::to_string).collect();
        Self::of(&floor_name(Path::new(file)), imported.plan, structure, notes)
    }

    /// The sample building of the command's demo.
    pub(crate) fn sample() -> Result<Self, String> {
        let raster = PlanRaster::from(building());
        let structure = keep_structure(&raster, DEFAULT_THICKNESS_M).ok();
        Self::of("sample", raster, structure, Vec::new())
    }

    fn of(
        name: &str,
        raster: PlanRaster,
        structure: Option<PlanRaster>,
        notes: Vec<String>,
    ) -> Result<Self, String> {
        let failed = |error: PackError| format!("{name}: {error}");
        let packed = PackedPlan::new(&raster).map_err(failed)?;
        let structure =
            structure.map(|kept| packed.second_layer(&kept)).transpose().map_err(failed)?.flatten();
        Ok(Self { name: name.to_owned(), raster, packed, structure, notes })
    }

    /// The plan with a picture of it.
    pub(crate) fn describe(&self) -> Reply {
        let PlanRaster { width, height, resolution_m, origin, .. } = self.raster;
        let step = width.max(height).div_ceil(PICTURE_PIXELS).max(1);
        let picture = [width.div_ceil(step), height.div_ceil(step)];
        let json = Described {
            name: &self.name,
            size: [width, height].map(|side| f64::from(side) * resolution_m),
            origin,
            resolution: resolution_m,
            has_structure: self.structure.is_some(),
            notes: &self.notes,
            picture,
        };
        reply(&json, &self.picture(picture, step))
    }

    /// A byte a pixel, from the north: of the `step` by `step` pixels of the plan glazing if one is, else wall if one is.
    fn picture(&self, [columns, rows]: [u32; 2], step: u32) -> Vec<u8> {
        let (walls, windows) = (self.raster.walls_mask(), self.raster.windows_mask());
        let cell = |column: u32, row: u32| {
            let inside = |at: u32, side: u32| at * step..((at + 1) * step).min(side);
            let mut kind = 0;
            for y in inside(row, self.raster.height) {
                for x in inside(column, self.raster.width) {
                    kind = kind.max(if windows.get(x, y) { 2 } else { u8::from(walls.get(x, y)) });
                }
            }
            kind
        };
        (0..rows)
            .rev()
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(x, y)| cell(x, y))
            .collect()
    }

    /// What surrounds a place: 360 ranges in metres, 360 hit types (0 open, 1 window, 2 wall) and the 5 x 360 descriptor.
    pub(crate) fn scan(&self, at: [f64; 2], heading_deg: f64) -> Result<Reply, String> {
        let scan = self.packed.scan(at, heading_deg).map_err(|error| error.to_string())?;
        let PlanDescriptor { range_m, hit, channels } = PlanDescriptor::from(&scan);
        let hits = hit.iter().map(|hit| f64::from(*hit as u8));
        let values = range_m.into_iter().chain(hits).chain(channels.into_iter().flatten());
        Ok(reply(&(), &floats(values)))
    }
}
