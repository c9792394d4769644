//! `compass localize`: floor, position and heading on a site, from frames or from a plan.

mod from_frames;
mod from_plan;

use super::cameras::CameraArgs;
use super::exit::Outcome;
use super::plan::{finite, pair};
use crate::cli::json::JsonOption;
use anyhow::{Result, bail};
use compass_core::Settings;
use std::path::PathBuf;

pub(super) use from_frames::pose_of;

use from_frames::{Input, Options};

#[derive(Debug, clap::Args)]
pub(super) struct Localize {
    /// The site file, or a plain site map
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Packed frames (compass pack) instead of --calib, --cam0 and --cam1: what a board is given
    #[arg(long, value_name = "FILE", conflicts_with_all = ["calib", "cam0", "cam1", "from_plan"])]
    shot: Option<PathBuf>,
    /// How thorough to be: full is what pays on a computer, board what a microcontroller has the memory for
    #[arg(long, value_enum, default_value_t = Preset::Full)]
    settings: Preset,
    /// Answer "I don't know" (exit status 1) if frames leave less than this probability that the pose is right within 1 m
    #[arg(long, value_name = "P", default_value_t = 0.5, value_parser = share, allow_hyphen_values = true)]
    min_probability: f64,
    #[command(flatten)]
    query: from_plan::PlanQuery,
    /// True position in metres: the errors of the answer are reported; with --from-plan that of the query
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, requires = "heading")]
    at: Option<[f64; 2]>,
    /// True heading in degrees
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true, requires = "at")]
    heading: Option<f64>,
    #[command(flatten)]
    json: JsonOption,
}

/// [`Settings`] by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Preset {
    Full,
    Board,
}

impl From<Preset> for Settings {
    fn from(preset: Preset) -> Self {
        match preset {
            Preset::Full => Self::FULL,
            Preset::Board => Self::BOARD,
        }
    }
}

impl Localize {
    pub(super) fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        let truth = self.at.zip(self.heading);
        if self.query.from_plan.is_some() && self.cameras.place.words().is_some() {
            bail!("--near, --heading-near and --floor restrict the search for frames: not with --from-plan");
        }
        let input = match (&self.query.from_plan, truth) {
            (Some(plan), Some(truth)) => return self.query.run(&self.map, plan, truth, &self.json),
            (Some(_), None) => bail!("no pose on the plan: give --at X,Y and --heading DEG"),
            (None, _) => match &self.shot {
                Some(shot) => Input::Shot(shot),
                None if self.cameras.is_given() => Input::Images(&self.cameras),
                None => {
                    bail!("no query: give --calib with --cam0, --cam1 or both, or a plan with --from-plan")
                }
            },
        };
        let options = Options {
            settings: self.settings.into(),
            place: &self.cameras.place,
            truth,
            least_probability: self.min_probability,
        };
        from_frames::run(&self.map, &input, &options, &self.json)
    }
}

fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if (0.0..=1.0).contains(&v) { Ok(v) } else { Err("expected 0 to 1".into()) })
}
