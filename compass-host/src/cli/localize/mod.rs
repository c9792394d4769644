//! `compass localize`: floor, position and heading on a site, from frames or from a plan.

mod from_frames;
mod from_plan;

use super::Outcome;
use super::cameras::CameraArgs;
use super::plan::{finite, pair};
use crate::cli::json::JsonOption;
use anyhow::{Result, bail};
use std::path::PathBuf;

pub(super) use from_frames::pose_of;

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

impl Localize {
    pub(super) fn run(&self) -> Result<Outcome> {
        let truth = self.at.zip(self.heading);
        match (&self.query.from_plan, truth) {
            (Some(plan), Some(truth)) => self.query.run(&self.map, plan, truth, &self.json),
            (Some(_), None) => bail!("no pose on the plan: give --at X,Y and --heading DEG"),
            (None, _) if self.cameras.is_given() => {
                from_frames::run(&self.map, &self.cameras, truth, self.min_probability, &self.json)
            }
            (None, _) => {
                bail!("no query: give --calib with --cam0, --cam1 or both, or a plan with --from-plan")
            }
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if (0.0..=1.0).contains(&v) { Ok(v) } else { Err("expected 0 to 1".into()) })
}
