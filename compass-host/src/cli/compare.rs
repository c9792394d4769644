//! `compass compare`: the core against the float reference.

use super::exit::Outcome;
use super::plan::{PlanArgs, sample};
use super::progress::Bars;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::vision::camera::Camera;
use compass_host::calibration::{CalibratedCamera, Calibration};
use compass_host::compare::{Stage, camera, compare_with_progress, segments, sight};
use compass_host::output::Decimal;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Compare {
    /// Without a plan: the bundled sample building
    #[command(flatten)]
    plan: PlanArgs,
    /// Number of random interior poses
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    poses: u32,
    /// Seed of the poses
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Kalibr camera chain whose lenses are compared; without, an invented one of each model
    #[arg(long, value_name = "FILE")]
    calib: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Row {
    stage: &'static str,
    unit: &'static str,
    worst: Decimal,
    typical: Decimal,
    bound: Decimal,
    compared: usize,
    in_bounds: bool,
}

#[derive(Debug, Serialize)]
struct Output {
    in_bounds: bool,
    stages: Vec<Row>,
}

impl From<&Stage> for Row {
    fn from(stage: &Stage) -> Self {
        Self {
            stage: stage.name,
            unit: stage.unit,
            worst: Decimal(stage.worst),
            typical: Decimal(stage.typical),
            bound: Decimal(stage.bound),
            compared: stage.compared,
            in_bounds: stage.in_bounds,
        }
    }
}

impl Compare {
    fn lenses(&self) -> Result<Vec<Camera>> {
        let Some(path) = &self.calib else { return Ok(camera::nominal()) };
        let calibration = Calibration::load(path)?;
        calibration.all_valid()?;
        let lens = |camera: &CalibratedCamera| camera.core(camera.resolution).map_err(Into::into);
        calibration.cameras.iter().flatten().map(lens).collect()
    }

    pub(super) fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        let (raster, plan) = if self.plan.path().is_some() { self.plan.load()? } else { sample()? };
        let name = || self.plan.path().map_or_else(|| "sample building".into(), |p| p.display().to_string());
        let lenses = self.lenses()?;
        let places = self.plan.places();
        let mut stages =
            compare_with_progress(&raster, &plan, &places, self.poses as usize, self.seed, &Bars)
                .with_context(name)?;
        stages.extend(camera::stages(&lenses));
        stages.extend(segments::stages(&raster, &places, self.seed).with_context(name)?);
        stages.extend(sight::stages(&raster, &places, self.seed).with_context(name)?);
        let in_bounds = stages.iter().all(|s| s.in_bounds);
        let mut summary = String::new();
        let _ = writeln!(summary, "{:<48} {:>12} {:>12} {:>12}  unit", "stage", "worst", "typical", "bound");
        for s in &stages {
            let verdict = if s.in_bounds { "" } else { "  OUT OF BOUNDS" };
            let _ = writeln!(
                summary,
                "{:<48} {:>12.6} {:>12.6} {:>12.6}  {}{verdict}",
                s.name, s.worst, s.typical, s.bound, s.unit
            );
        }
        let output = Output { in_bounds, stages: stages.iter().map(Row::from).collect() };
        self.json.emit(&output, &summary)?;
        Ok(if in_bounds { Outcome::Done } else { Outcome::No })
    }
}
