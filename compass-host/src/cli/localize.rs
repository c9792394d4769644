//! `compass localize`: floor, position and heading on a site, from frames or from a plan.

use super::Outcome;
use super::cameras::CameraArgs;
use super::plan::{Reading, finite, pair};
use anyhow::{Context as _, Result, bail};
use compass_core::descriptor::matching::Match;
use compass_core::descriptor::similarity::{Similarity, Weights};
use compass_core::map::site_map::SiteMap;
use compass_host::clock::Clock;
use compass_host::localizer::{MatchOptions, SiteAnswer, SiteLocalizer};
use compass_host::noise::disturb;
use compass_host::output::{Decimal, JsonOption};
use compass_host::site::wrapped;
use compass_host::site_file::{SiteFile, SiteFloor};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

mod sighted;

pub(super) use sighted::pose_of;

#[derive(Debug, clap::Args)]
pub(super) struct Localize {
    /// The site file, or a plain site map
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Answer "I don't know" (exit status 1) if frames leave less than this probability that the pose is right within 1 m
    #[arg(long, value_name = "P", default_value_t = 0.5, value_parser = share, allow_hyphen_values = true)]
    min_probability: f64,
    #[command(flatten)]
    query: PlanQuery,
    /// True position in metres: the errors of the answer are reported; with --from-plan that of the query
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, requires = "heading")]
    at: Option<[f64; 2]>,
    /// True heading in degrees
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true, requires = "at")]
    heading: Option<f64>,
    #[command(flatten)]
    json: JsonOption,
}

/// A query that is cast from a plan.
#[derive(Debug, Clone, clap::Args)]
struct PlanQuery {
    /// Cast the query from this plan instead of seeing it
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["calib", "cam0", "cam1"], requires = "at")]
    from_plan: Option<PathBuf>,
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
pub(super) struct Matching {
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
    pub(super) const fn options(&self) -> MatchOptions {
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

fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if (0.0..=1.0).contains(&v) { Ok(v) } else { Err("expected 0 to 1".into()) })
}

fn weights(text: &str) -> Result<Weights, String> {
    let wanted = || format!("'{text}' is not five whole numbers 0..255, one of them above 0");
    let values: Vec<u8> =
        text.split(',').map(|v| v.trim().parse()).collect::<Result<_, _>>().map_err(|_| wanted())?;
    let weights: [u8; 5] = values.try_into().map_err(|_| wanted())?;
    if weights == [0; 5] { Err(wanted()) } else { Ok(Weights(weights)) }
}

/// A pose with its score.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Pose<'a> {
    /// Where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<&'a str>,
    pub(super) x: Decimal,
    pub(super) y: Decimal,
    pub(super) heading_deg: Decimal,
    pub(super) score: Decimal,
}

impl<'a> Pose<'a> {
    pub(super) fn of(found: &Match, map: &SiteMap<'_>, floor: Option<&'a str>) -> Self {
        let at = map.position(found.candidate as usize).unwrap_or_default();
        Self {
            floor,
            x: Decimal(at.x.to_num()),
            y: Decimal(at.y.to_num()),
            heading_deg: Decimal(f64::from(found.peak.shift)),
            score: Decimal(found.peak.score().to_num()),
        }
    }

    /// Distance in metres and angle in degrees from a true pose.
    pub(super) fn error(&self, at: [f64; 2], heading_deg: f64) -> (f64, f64) {
        let turn = wrapped(self.heading_deg.0 - heading_deg);
        ((self.x.0 - at[0]).hypot(self.y.0 - at[1]), turn.abs())
    }
}

/// The matches as poses, with their floor where there are several.
fn poses<'a>(answer: &SiteAnswer, storeys: &[SiteFloor<'a>]) -> Vec<Pose<'a>> {
    let pose = |(floor, found): &(usize, Match)| {
        let storey = storeys.get(*floor)?;
        Some(Pose::of(found, &storey.map, storey.name().filter(|_| storeys.len() > 1)))
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
    /// Not seen: the query was cast from the plan.
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

impl Localize {
    pub(super) fn run(&self) -> Result<Outcome> {
        let truth = self.at.zip(self.heading);
        match (&self.query.from_plan, truth) {
            (Some(plan), Some(truth)) => self.cast(plan, truth),
            (Some(_), None) => bail!("no pose on the plan: give --at X,Y and --heading DEG"),
            (None, _) if self.cameras.is_given() => {
                sighted::run(&self.map, &self.cameras, truth, self.min_probability, &self.json)
            }
            (None, _) => {
                bail!("no query: give --calib with --cam0, --cam1 or both, or a plan with --from-plan")
            }
        }
    }

    fn cast(&self, plan_path: &Path, (at, heading): ([f64; 2], f64)) -> Result<Outcome> {
        let mut clock = Clock::start();
        let file = SiteFile::read(&self.map)?;
        let storeys = file.storeys();
        clock.stage("read_map");
        let (_, plan) = self.query.reading.load(plan_path)?;
        clock.stage("read_plan");
        let mut scan = plan.scan(at, heading).with_context(|| plan_path.display().to_string())?;
        disturb(&mut scan, self.query.noise, self.query.seed);
        clock.stage("cast");
        let mut localizer = SiteLocalizer::new(storeys.iter().map(|storey| storey.map));
        clock.stage("index");
        let answer = localizer.locate(&scan, &self.query.matching.options())?;
        clock.stage("search");
        let poses = poses(&answer, &storeys);
        // A score of 0 says nothing: no candidate resembles the query, or the query has no contrast.
        let Some(best) = poses.first().copied().filter(|best| best.score.0 > 0.0) else {
            self.json.emit(&serde_json::json!({ "candidates": [] }), "no pose found\n")?;
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
        self.json.emit(&output, &summary)?;
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

/// The time that each stage took, as it is reported.
fn milliseconds(clock: &Clock) -> BTreeMap<&'static str, Decimal> {
    clock.stages().iter().map(|(stage, ms)| (*stage, Decimal(*ms))).collect()
}
