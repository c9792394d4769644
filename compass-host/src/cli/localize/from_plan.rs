//! The pose of a query that is cast from a plan: the paper's matching.

use crate::cli::exit::Outcome;
use crate::cli::json::JsonOption;
use crate::cli::plan::{Reading, finite};
use crate::cli::pose::{Pose, milliseconds};
use anyhow::{Context as _, Result};
use compass_core::descriptor::matching::Match;
use compass_core::descriptor::similarity::{Similarity, Weights};
use compass_host::clock::Clock;
use compass_host::localizer::{MatchOptions, SiteAnswer, SiteLocalizer};
use compass_host::noise::disturb;
use compass_host::output::Decimal;
use compass_host::site_file::{SiteFile, SiteFloor};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A query that is cast from a plan.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PlanQuery {
    /// Cast the query from this plan instead of seeing it
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["calib", "cam0", "cam1"], requires = "at")]
    pub(super) from_plan: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Disturb the query: at level 1, 3 % of range noise, 5 % of hit types mistaken, two occluders
    #[arg(long, value_name = "LEVEL", default_value_t = 0.0, value_parser = level, allow_hyphen_values = true)]
    noise: f64,
    /// Seed of the disturbance
    #[arg(long, value_name = "N", default_value_t = 0, allow_hyphen_values = true)]
    seed: u64,
    #[command(flatten)]
    matching: Matching,
}

/// How to match.
#[derive(Debug, Clone, clap::Args)]
struct Matching {
    /// Cosine of the descriptors as they are (the paper's), or after each channel's mean is removed
    #[arg(long, value_enum, default_value_t = Kind::Centred)]
    similarity: Kind,
    /// Relative weights of the five channels, 0..255 each
    #[arg(long, value_name = "A,B,C,D,E", default_value = "16,16,16,16,16", value_parser = weights)]
    weights: Weights,
    /// Leave out all but about N candidates of each floor, those of the nearest transition signatures
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), allow_hyphen_values = true)]
    prefilter: Option<u32>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Kind {
    Plain,
    Centred,
}

impl Matching {
    const fn options(&self) -> MatchOptions {
        let similarity = match self.similarity {
            Kind::Plain => Similarity::Plain,
            Kind::Centred => Similarity::Centred,
        };
        MatchOptions { similarity, weights: self.weights, prefilter: self.prefilter }
    }
}

fn level(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if (0.0..=10.0).contains(&v) { Ok(v) } else { Err("expected 0 to 10".into()) })
}

fn weights(text: &str) -> Result<Weights, String> {
    let wanted = || format!("'{text}' is not five whole numbers 0..255, one of them above 0");
    let values: Vec<u8> =
        text.split(',').map(|v| v.trim().parse()).collect::<Result<_, _>>().map_err(|_| wanted())?;
    let weights: [u8; 5] = values.try_into().map_err(|_| wanted())?;
    if weights == [0; 5] { Err(wanted()) } else { Ok(Weights(weights)) }
}

/// The matches as poses, with their floor where there are several.
fn poses<'a>(answer: &SiteAnswer, floors: &[SiteFloor<'a>]) -> Vec<Pose<'a>> {
    let pose = |(number, found): &(usize, Match)| {
        let floor = floors.get(*number)?;
        Some(Pose::of(found, &floor.map, floor.name().filter(|_| floors.len() > 1)))
    };
    answer.matches.iter().filter_map(pose).collect()
}

#[derive(Debug, Serialize)]
struct Output<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<&'a str>,
    x: Decimal,
    y: Decimal,
    heading_deg: Decimal,
    /// Always `null`: the query was cast from the plan.
    up_in_cam0: Option<[Decimal; 3]>,
    score: Decimal,
    margin: Decimal,
    candidates: Vec<Pose<'a>>,
    position_error_m: Decimal,
    heading_error_deg: Decimal,
    scored: u32,
    exhaustive: bool,
    milliseconds: BTreeMap<&'static str, Decimal>,
}

impl PlanQuery {
    /// Casts the query, searches and reports.
    pub(super) fn run(
        &self,
        map: &Path,
        plan_path: &Path,
        (at, heading): ([f64; 2], f64),
        json: &JsonOption,
    ) -> Result<Outcome> {
        let mut clock = Clock::start();
        let file = SiteFile::read(map)?;
        let floors = file.floors();
        clock.stage("read_map");
        let (_, plan) = self.reading.load(plan_path)?;
        clock.stage("read_plan");
        let mut scan = plan.scan(at, heading).with_context(|| plan_path.display().to_string())?;
        disturb(&mut scan, self.noise, self.seed);
        clock.stage("cast");
        let mut localizer = SiteLocalizer::new(floors.iter().map(|floor| floor.map));
        clock.stage("index");
        let answer = localizer.locate(&scan, &self.matching.options());
        clock.stage("search");
        let poses = poses(&answer, &floors);
        // A score of 0 carries no information: no candidate resembles the query, or the query has no contrast.
        let Some(best) = poses.first().copied().filter(|best| best.score.0 > 0.0) else {
            json.emit(&serde_json::json!({ "candidates": [] }), "no pose found\n")?;
            return Ok(Outcome::No);
        };
        let summary = summary(&poses, &answer, &clock, (at, heading));
        let (position_error, heading_error) = best.error(at, heading);
        let output = Output {
            floor: best.floor,
            x: best.x,
            y: best.y,
            heading_deg: best.heading_deg,
            up_in_cam0: None,
            score: best.score,
            margin: Decimal(answer.margin().to_num()),
            candidates: poses,
            position_error_m: Decimal(position_error),
            heading_error_deg: Decimal(heading_error),
            scored: answer.scored,
            exhaustive: answer.exhaustive,
            milliseconds: milliseconds(&clock),
        };
        json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }
}

fn summary(poses: &[Pose<'_>], answer: &SiteAnswer, clock: &Clock, (at, heading): ([f64; 2], f64)) -> String {
    let mut text = String::new();
    for (rank, pose) in poses.iter().enumerate() {
        let (metres, degrees) = pose.error(at, heading);
        let floor = pose.floor.map_or_else(String::new, |name| format!("{name}  "));
        let _ = writeln!(
            text,
            "{:>2}. {floor}x {:8.3} m  y {:8.3} m  heading {:5.1}  score {:.4}  ({metres:.2} m, {degrees:.1} degrees off)",
            rank + 1,
            pose.x.0,
            pose.y.0,
            pose.heading_deg.0,
            pose.score.0,
        );
    }
    let margin: f64 = answer.margin().to_num();
    let search = clock.stages().get("search").copied().unwrap_or(0.0);
    let _ = writeln!(text, "margin {margin:.4}, {} candidates scored, search {search:.1} ms", answer.scored);
    text
}
