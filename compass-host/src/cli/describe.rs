//! `compass describe`: the descriptor of a position.

use super::Outcome;
use super::pictures;
use super::plan::{PlanArgs, finite, pair};
use anyhow::{Context as _, Result, anyhow};
use compass_core::base::scan::Hit;
use compass_core::descriptor::Descriptor;
use compass_host::compare::float_levels;
use compass_host::output::{Decimal, JsonOption, decimals};
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

/// Range, hit type and channels of one pose.
pub(super) struct Described {
    pub(super) range_m: [f64; 360],
    pub(super) hit: [Hit; 360],
    pub(super) channels: [[f64; 360]; 5],
}

impl Described {
    /// From a scan of the core.
    pub(super) fn fixed(scan: &compass_core::base::scan::Scan) -> Self {
        Self {
            range_m: scan.steps.map(|s| f64::from(s) * reference::march::STEP_M),
            hit: scan.hit,
            channels: float_levels(&Descriptor::from(scan)),
        }
    }

    /// |dr/dtheta| per bin by central difference, in metres per degree.
    pub(super) fn gradient_m(&self) -> [f64; 360] {
        std::array::from_fn(|j| (self.range_m[(j + 1) % 360] - self.range_m[(j + 359) % 360]).abs() / 2.0)
    }

    fn count(&self, hit: Hit) -> usize {
        self.hit.iter().filter(|&&h| h == hit).count()
    }

    fn stats(&self) -> Stats {
        let changes = (0..360).filter(|&j| self.hit[j] != self.hit[(j + 1) % 360]).count();
        Stats {
            range_min: Decimal(self.range_m.iter().copied().fold(f64::MAX, f64::min)),
            range_max: Decimal(self.range_m.iter().copied().fold(0.0, f64::max)),
            window_bins: self.count(Hit::Window),
            open_bins: self.count(Hit::Open),
            segments: changes.max(1),
            gradient_mean: Decimal(self.gradient_m().iter().sum::<f64>() / 360.0),
        }
    }
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

#[derive(Debug, Serialize)]
struct Output {
    range_m: Vec<Decimal>,
    hit: Vec<&'static str>,
    channels: Vec<Vec<Decimal>>,
    stats: Stats,
}

/// The name of a hit type in JSON.
pub(super) const fn hit_name(hit: Hit) -> &'static str {
    match hit {
        Hit::Wall => "wall",
        Hit::Window => "window",
        Hit::Open => "open",
    }
}

impl Describe {
    pub(super) fn run(&self) -> Result<Outcome> {
        let (raster, plan) = self.plan.load()?;
        let name = || self.plan.path().map_or_else(String::new, |p| p.display().to_string());
        let described = match self.engine {
            Engine::Fixed => Described::fixed(&plan.scan(self.at, self.heading).with_context(name)?),
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
                let channels = reference::descriptor(&scan);
                Described { range_m: scan.range_m, hit: scan.hit, channels }
            }
        };
        if let Some(dir) = &self.figures {
            pictures::describe(dir, &raster, self.at, self.heading, &described)?;
        }
        let output = Output {
            range_m: decimals(described.range_m),
            hit: described.hit.map(hit_name).to_vec(),
            channels: described.channels.iter().map(|c| decimals(*c)).collect(),
            stats: described.stats(),
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
