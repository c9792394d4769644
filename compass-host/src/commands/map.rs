//! `compass map build` and `compass map info`.

use super::Outcome;
use super::plan::{PlanArgs, finite};
use crate::interior::CLEARANCE_M;
use crate::output::{Decimal, JsonOption, write_file};
use crate::site::{BuildOptions, build, read_map};
use anyhow::{Context as _, Result};
use compass_core::site_map::SiteMap;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Subcommand)]
pub(super) enum Map {
    /// Build the site map of a plan
    Build(Build),
    /// Print what is in a site map
    Info(Info),
}

#[derive(Debug, clap::Args)]
pub(super) struct Build {
    #[command(flatten)]
    plan: PlanArgs,
    /// Distance between candidates in metres
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = finite, allow_hyphen_values = true)]
    spacing: f64,
    /// Distance of candidates from walls and glazing in metres
    #[arg(long, value_name = "M", default_value_t = CLEARANCE_M, value_parser = finite, allow_hyphen_values = true)]
    clearance: f64,
    /// Widest opening of the outline that still counts as closed, in metres [default: found from the plan]
    #[arg(long, value_name = "M", value_parser = finite, allow_hyphen_values = true)]
    max_gap: Option<f64>,
    /// The site map to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Write the packed plan too, as boards read it from flash
    #[arg(long, value_name = "FILE")]
    plan_out: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, clap::Args)]
pub(super) struct Info {
    /// A site map
    file: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Built {
    candidates: usize,
    bytes: usize,
    seconds: Decimal,
}

#[derive(Debug, Serialize)]
struct Described {
    candidates: usize,
    layers: u8,
    bytes: usize,
    spacing_m: Decimal,
    resolution_m: Decimal,
    origin: [Decimal; 2],
    plan_size_px: [u32; 2],
    plan_checksum: String,
    x: [Decimal; 2],
    y: [Decimal; 2],
}

impl Map {
    pub(super) fn run(&self) -> Result<Outcome> {
        match self {
            Self::Build(command) => command.run(),
            Self::Info(command) => command.run(),
        }
    }
}

impl Build {
    fn run(&self) -> Result<Outcome> {
        let started = Instant::now();
        let (raster, plan) = self.plan.load()?;
        let options =
            BuildOptions { spacing_m: self.spacing, clearance_m: self.clearance, max_gap_m: self.max_gap };
        let name = || self.plan.path().map_or_else(String::new, |p| p.display().to_string());
        let bytes = build(&raster, &plan, &options).with_context(name)?;
        write_file(&self.out, &bytes)?;
        if let Some(path) = &self.plan_out {
            write_file(path, plan.as_bytes())?;
        }
        let candidates = SiteMap::new(&bytes)?.len();
        let built =
            Built { candidates, bytes: bytes.len(), seconds: Decimal(started.elapsed().as_secs_f64()) };
        let summary = format!(
            "{}: {candidates} candidates, {} bytes, {:.2} s\n",
            self.out.display(),
            built.bytes,
            built.seconds.0
        );
        self.json.emit(&built, &summary)?;
        Ok(Outcome::Done)
    }
}

impl Info {
    fn run(&self) -> Result<Outcome> {
        let bytes = read_map(&self.file)?;
        let map = SiteMap::new(&bytes)?;
        let header = map.header();
        let (mut x, mut y) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
        for at in (0..map.len()).filter_map(|index| map.position(index)) {
            let (px, py) = (at.x.to_num::<f64>(), at.y.to_num::<f64>());
            x = [x[0].min(px), x[1].max(px)];
            y = [y[0].min(py), y[1].max(py)];
        }
        let described = Described {
            candidates: map.len(),
            layers: header.layers,
            bytes: bytes.len(),
            spacing_m: Decimal(f64::from(header.spacing_mm) / 1000.0),
            resolution_m: Decimal(f64::from(header.frame.resolution_nm) / 1e9),
            origin: [header.frame.origin.x, header.frame.origin.y].map(|v| Decimal(v.to_num())),
            plan_size_px: header.plan_size,
            plan_checksum: format!("{:08x}", header.plan_checksum),
            x: x.map(Decimal),
            y: y.map(Decimal),
        };
        let summary = format!(
            "{}: {} candidates every {} m, {} layer(s), {} bytes\nplan {} x {} cells of {} m, checksum {}\n\
             x {:.2} to {:.2} m, y {:.2} to {:.2} m\n",
            self.file.display(),
            described.candidates,
            described.spacing_m.0,
            described.layers,
            described.bytes,
            header.plan_size[0],
            header.plan_size[1],
            described.resolution_m.0,
            described.plan_checksum,
            x[0],
            x[1],
            y[0],
            y[1],
        );
        self.json.emit(&described, &summary)?;
        Ok(Outcome::Done)
    }
}
