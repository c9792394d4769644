//! `compass describe`: the descriptor of a position.

use super::exit::Outcome;
use super::pictures;
use super::plan::{PlanArgs, finite, pair};
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, anyhow};
use compass_host::output::{Decimal, decimals};
use compass_host::plan_descriptor::{self, PlanDescriptor, hit_name};
use compass_host::reference;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Describe {
    #[command(flatten)]
    plan: PlanArgs,
    /// Position in metres
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Heading in degrees, counter-clockwise from +x
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite, allow_hyphen_values = true)]
    heading: f64,
    /// Which implementation: the fixed-point core, or the float reference
    #[arg(long, value_enum, default_value_t = Engine::Fixed)]
    engine: Engine,
    /// Write the pictures of this descriptor into DIR
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    Fixed,
    Float,
}

#[derive(Debug, Serialize)]
struct Stats {
    range_min: Decimal,
    range_max: Decimal,
    window_bins: usize,
    open_bins: usize,
    segments: usize,
    gradient_mean: Decimal,
}

impl From<plan_descriptor::Stats> for Stats {
    fn from(stats: plan_descriptor::Stats) -> Self {
        Self {
            range_min: Decimal(stats.range_min_m),
            range_max: Decimal(stats.range_max_m),
            window_bins: stats.window_bins,
            open_bins: stats.open_bins,
            segments: stats.segments,
            gradient_mean: Decimal(stats.gradient_mean_m),
        }
    }
}

#[derive(Debug, Serialize)]
struct Output {
    range_m: Vec<Decimal>,
    hit: Vec<&'static str>,
    channels: Vec<Vec<Decimal>>,
    stats: Stats,
}

impl Describe {
    pub(super) fn run(&self) -> Result<Outcome> {
        let (raster, plan) = self.plan.load()?;
        let name = || self.plan.path().map_or_else(String::new, |p| p.display().to_string());
        let described = match self.engine {
            Engine::Fixed => PlanDescriptor::from(&plan.scan(self.at, self.heading).with_context(name)?),
            Engine::Float => {
                let float = reference::Plan::new(
                    &raster.walls_mask(),
                    &raster.windows_mask(),
                    raster.resolution_m,
                    raster.origin,
                );
                let [x, y] = self.at;
                let scan = float.scan(x, y, self.heading).ok_or_else(|| {
                    let what = float.hit_at(x, y).map_or("outside the plan", |_| "inside a wall or glazing");
                    anyhow!("{}: at {x},{y}: position is {what}", name())
                })?;
                PlanDescriptor::from(&scan)
            }
        };
        if let Some(dir) = &self.figures {
            pictures::describe(dir, &raster, self.at, self.heading, &described)?;
        }
        let output = Output {
            range_m: decimals(described.range_m),
            hit: described.hit.map(hit_name).to_vec(),
            channels: described.channels.iter().map(|c| decimals(*c)).collect(),
            stats: described.stats().into(),
        };
        self.json.emit(&output, &self.summary(&output.stats))?;
        Ok(Outcome::Done)
    }

    fn summary(&self, stats: &Stats) -> String {
        let mut text = String::new();
        let [x, y] = self.at;
        let _ = writeln!(text, "position       {x:.3}, {y:.3} m, heading {:.1} degrees", self.heading);
        let _ = writeln!(text, "range          {:.2} to {:.2} m", stats.range_min.0, stats.range_max.0);
        let _ = writeln!(text, "window bins    {} of 360", stats.window_bins);
        let _ = writeln!(text, "open bins      {} of 360", stats.open_bins);
        let _ = writeln!(text, "segments       {} runs of equal hit type", stats.segments);
        let _ = writeln!(text, "mean gradient  {:.3} m per degree", stats.gradient_mean.0);
        text
    }
}
