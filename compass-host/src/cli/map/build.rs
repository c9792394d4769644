//! `compass map build`: a plan becomes a site file of one floor.

use crate::cli::exit::Outcome;
use crate::cli::json::JsonOption;
use crate::cli::plan::{PlanArgs, finite};
use crate::cli::progress::Bars;
use anyhow::{Context as _, Result};
use compass_core::map::site::{MAX_NAME_BYTES, Site, is_name};
use compass_host::interior::CLEARANCE_M;
use compass_host::output::{Decimal, check_file, write_file};
use compass_host::plan_import::Imported;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, StructureError};
use compass_host::site::{BuildOptions, PackedPlan};
use compass_host::site_file::{floor_bytes_with_progress, floor_name};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Build {
    #[command(flatten)]
    plan: PlanArgs,
    /// Name of the floor, at most 23 bytes [default: the plan's file name without its extension]
    #[arg(long, value_name = "NAME", value_parser = name, allow_hyphen_values = true)]
    name: Option<String>,
    /// Distance between candidates in metres
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = finite, allow_hyphen_values = true)]
    spacing: f64,
    /// Distance of candidates from walls and glazing in metres
    #[arg(long, value_name = "M", default_value_t = CLEARANCE_M, value_parser = finite, allow_hyphen_values = true)]
    clearance: f64,
    /// Widest opening of the outline that still counts as closed, in metres [default: found from the plan]
    #[arg(long, value_name = "M", value_parser = finite, allow_hyphen_values = true)]
    max_gap: Option<f64>,
    /// Layers of the floor: 1 the plan as drawn, 2 its structure alone as well, where it can be told
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
    layers: u8,
    /// Thinnest wall of the structure in metres, where layers of a drawing do not say which walls it has
    #[arg(long, value_name = "M", default_value_t = DEFAULT_THICKNESS_M, value_parser = finite, allow_hyphen_values = true)]
    thickness: f64,
    /// The site file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the packed plan too, as a file of its own
    #[arg(long, value_name = "FILE")]
    plan_out: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Built {
    candidates: usize,
    layers: usize,
    bytes: usize,
    seconds: Decimal,
}

/// The second layer, or why it is missing.
enum Structure {
    Packed(PackedPlan),
    None(String),
}

impl Build {
    pub(super) fn run(&self) -> Result<Outcome> {
        check_file(&self.out)?;
        let started = Instant::now();
        let imported = self.plan.import(false)?;
        let path = self.plan.path().unwrap_or(Path::new(""));
        let raster = &imported.plan;
        let plan = PackedPlan::new(raster).with_context(|| path.display().to_string())?;
        let options = BuildOptions {
            spacing_m: self.spacing,
            clearance_m: self.clearance,
            max_gap_m: self.max_gap,
            places: self.plan.places(),
        };
        let structure = self.structure(&imported, &plan).with_context(|| path.display().to_string())?;
        let name = self.name.clone().unwrap_or_else(|| floor_name(path));
        let bytes = floor_bytes_with_progress(&name, raster, &plan, structure.packed(), &options, &Bars)
            .with_context(|| path.display().to_string())?;
        write_file(&self.out, &bytes)?;
        if let Some(path) = &self.plan_out {
            write_file(path, plan.as_bytes())?;
        }
        let floor = Site::new(&bytes)?.floor(0).context("a site file has a floor")?;
        let built = Built {
            candidates: floor.map().len(),
            layers: floor.layers(),
            bytes: bytes.len(),
            seconds: Decimal(started.elapsed().as_secs_f64()),
        };
        self.json.emit(&built, &self.summary(&built, &structure))?;
        Ok(Outcome::Done)
    }

    fn structure(&self, imported: &Imported, plan: &PackedPlan) -> Result<Structure> {
        if self.layers == 1 {
            return Ok(Structure::None("as asked".into()));
        }
        let kept = match imported.structure(self.thickness, &self.plan.places()) {
            Ok(kept) => plan.second_layer(&kept)?,
            Err(error @ StructureError::Thickness(_)) => return Err(error.into()),
            Err(error) => return Ok(Structure::None(format!("no structure: {error}"))),
        };
        let whole = || Structure::None("all of the plan is structure".into());
        Ok(kept.map_or_else(whole, Structure::Packed))
    }

    fn summary(&self, built: &Built, structure: &Structure) -> String {
        let layers = match structure {
            Structure::Packed(_) => "2 layers".into(),
            Structure::None(why) => format!("1 layer ({why})"),
        };
        let Built { candidates, bytes, seconds, .. } = built;
        format!(
            "{}: {candidates} candidates, {layers}, {bytes} bytes, {:.2} s\n",
            self.out.display(),
            seconds.0
        )
    }
}

impl Structure {
    const fn packed(&self) -> Option<&PackedPlan> {
        match self {
            Self::Packed(plan) => Some(plan),
            Self::None(_) => None,
        }
    }
}

fn name(text: &str) -> Result<String, String> {
    let wanted = || format!("expected 1 to {MAX_NAME_BYTES} bytes without control characters");
    if is_name(text) { Ok(text.into()) } else { Err(wanted()) }
}
