//! `compass fit`: constants from localizations of known poses.

use super::exit::Outcome;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use clap::Subcommand;
use compass_host::fit::{Answer, Logistic, Said, cross_validated, log_likelihood};
use compass_host::input;
use compass_host::output::Decimal;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Probabilities from which on the table counts.
const THRESHOLDS: [f64; 4] = [0.5, 0.7, 0.8, 0.9];
/// Most that a right pose is off: metres and degrees.
const RIGHT: [f64; 2] = [1.0, 30.0];

#[derive(Debug, Subcommand)]
pub(super) enum Fit {
    /// The constants of a pose's probability, from the results of `evaluate --json`
    Probability(Probability),
}

impl Fit {
    pub(super) fn run(&self) -> Result<Outcome> {
        match self {
            Self::Probability(command) => command.run(),
        }
    }
}

#[derive(Debug, clap::Args)]
pub(super) struct Probability {
    /// Results of `evaluate --json` on the plan of the building that the frames show
    #[arg(value_name = "BUILDING=RESULT", required = true, value_parser = named)]
    own: Vec<(String, PathBuf)>,
    /// The same on the plan of another building: whatever is found there is wrong
    #[arg(long, value_name = "BUILDING=RESULT", value_parser = named)]
    foreign: Vec<(String, PathBuf)>,
    #[command(flatten)]
    json: JsonOption,
}

/// Parses the name of a building and a file.
fn named(text: &str) -> Result<(String, PathBuf), String> {
    let parts = text.split_once('=').filter(|(name, file)| !name.is_empty() && !file.is_empty());
    parts
        .map(|(name, file)| (name.to_owned(), file.into()))
        .ok_or_else(|| format!("'{text}' is not BUILDING=RESULT"))
}

/// What is needed of a result of `evaluate`.
#[derive(Debug, Deserialize)]
struct Evaluated {
    results: Vec<Frame>,
}

#[derive(Debug, Deserialize)]
struct Frame {
    lead: f64,
    single: Option<Single>,
}

#[derive(Debug, Deserialize)]
struct Single {
    position_error_m: Option<f64>,
    heading_error_deg: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Output {
    answers: usize,
    foreign_answers: usize,
    buildings: Vec<String>,
    /// Log odds without a lead, and factor of the lead in 1/nat.
    log_odds: [Decimal; 2],
    covariance: [[Decimal; 2]; 2],
    /// Log likelihood of each building by a fit to the others.
    cross_validated_log_likelihood: Decimal,
    cross_validated: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    probability: Decimal,
    right: usize,
    wrong: usize,
    foreign: usize,
}

impl Probability {
    fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        let mut buildings: Vec<String> = Vec::new();
        let mut answers = Vec::new();
        let files =
            self.own.iter().map(|file| (file, false)).chain(self.foreign.iter().map(|file| (file, true)));
        for ((name, path), is_foreign) in files {
            let building = buildings.iter().position(|known| known == name).unwrap_or_else(|| {
                buildings.push(name.clone());
                buildings.len() - 1
            });
            let file = || path.display().to_string();
            let bytes = input::read_whole(path).with_context(|| format!("{}: cannot be read", file()))?;
            let evaluated: Evaluated = serde_json::from_slice(&bytes)
                .with_context(|| format!("{}: not a result of evaluate --json of this version", file()))?;
            answers.extend(evaluated.results.iter().filter_map(|frame| frame.answer(building, is_foreign)));
        }
        if buildings.len() < 2 {
            bail!("one building alone: a fit to the others needs at least two");
        }
        let Some((fitted, probabilities)) = Logistic::fit(&answers).zip(cross_validated(&answers)) else {
            bail!(
                "no fit: of {} answers, or of those of all buildings but one, all are right, all wrong, or a lead tells them apart",
                answers.len()
            );
        };
        let output = Output::new(&answers, buildings, &fitted, &probabilities);
        self.json.emit(&output, &output.summary())?;
        Ok(Outcome::Done)
    }
}

impl Frame {
    /// The answer to a frame; `None` without a pose, or on its own plan without a true one.
    fn answer(&self, building: usize, is_foreign: bool) -> Option<Answer> {
        let single = self.single.as_ref()?;
        let is_right = match (is_foreign, single.position_error_m, single.heading_error_deg) {
            (true, ..) => false,
            (false, Some(metres), Some(degrees)) => metres <= RIGHT[0] && degrees.abs() <= RIGHT[1],
            _ => return None,
        };
        Some(Answer { building, lead: self.lead, is_right, is_foreign })
    }
}

impl Output {
    fn new(answers: &[Answer], buildings: Vec<String>, fitted: &Logistic, probabilities: &[f64]) -> Self {
        let row = |at_least: &f64| {
            let Said { right, wrong, foreign } = Said::of(answers, probabilities, *at_least);
            Row { probability: Decimal(*at_least), right, wrong, foreign }
        };
        let foreign_answers = answers.iter().filter(|answer| answer.is_foreign).count();
        let covariance = fitted.covariance;
        Self {
            answers: answers.len() - foreign_answers,
            foreign_answers,
            buildings,
            log_odds: [0, 1].map(|at| Decimal(fitted.weights[at])),
            covariance: [0, 1].map(|row| [0, 1].map(|column| Decimal(covariance[(row, column)]))),
            cross_validated_log_likelihood: Decimal(
                answers.iter().zip(probabilities).map(|(answer, p)| log_likelihood(answer, *p)).sum(),
            ),
            cross_validated: THRESHOLDS.iter().map(row).collect(),
        }
    }

    fn summary(&self) -> String {
        let Self { answers, foreign_answers, buildings, log_odds, covariance, .. } = self;
        let deviation = |at: usize| covariance[at][at].0.sqrt();
        let mut text = format!(
            "{answers} answers on their own plan, {foreign_answers} on foreign plans, {} buildings: {}\n\
             log odds {:.3} + {:.5} lead (standard deviations {:.3}, {:.5})\n\
             by fits to the other buildings, log likelihood {:.1}:\n\
             probability   said and right   said and wrong   said of foreign plans\n",
            buildings.len(),
            buildings.join(", "),
            log_odds[0].0,
            log_odds[1].0,
            deviation(0),
            deviation(1),
            self.cross_validated_log_likelihood.0,
        );
        for Row { probability, right, wrong, foreign } in &self.cross_validated {
            let _ = writeln!(text, "{:>11}   {right:>14}   {wrong:>14}   {foreign:>21}", probability.0);
        }
        text
    }
}
