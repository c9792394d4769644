//! `compass compare-hits`: the observed hit types against those of the plan at a known pose.

use super::cameras::CameraArgs;
use super::exit::Outcome;
use super::plan::{PlanArgs, finite, pair};
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::Settings;
use compass_core::base::num::BINS;
use compass_core::base::scan::{Hit, Scan};
use compass_core::vision::windows::WindowEvidence;
use compass_host::cross_modal::CrossModal;
use compass_host::figures::{self, Curve, HitComparison, Shifts};
use compass_host::locator::{Locator, SeeError, see};
use compass_host::output::{Decimal, create_dir};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct CompareHits {
    #[command(flatten)]
    plan: PlanArgs,
    /// Position of cam0 in metres
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Heading of cam0 in degrees, counter-clockwise from +x
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    heading: f64,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Write the pictures of the comparison into DIR
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    windows_per_camera: [usize; 2],
    window_bins: WindowBins,
    agreeing_bins: Agreeing,
    cosine: Scores,
    centred: Scores,
    /// Heading of the frames less the given one.
    peak_shift_deg: i32,
}

#[derive(Debug, Serialize)]
struct WindowBins {
    seen: usize,
    plan: usize,
}

#[derive(Debug, Serialize)]
struct Agreeing {
    count: usize,
    /// Number of observed bins.
    of: usize,
    share: Decimal,
}

#[derive(Debug, Serialize)]
struct Scores {
    at_zero: Decimal,
    peak: Decimal,
}

impl Scores {
    fn new(scores: &[f64; BINS]) -> Self {
        let peak = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self { at_zero: Decimal(scores[0]), peak: Decimal(peak) }
    }
}

impl CompareHits {
    pub(super) fn run(&self) -> Result<Outcome> {
        let cameras = self.cameras.load()?;
        let (_, plan) = self.plan.load()?;
        let name = || self.plan.path().map_or_else(String::new, |p| p.display().to_string());
        let scan = plan.scan(self.at, self.heading).with_context(name)?;
        let frames = cameras.frames.each_ref().map(Option::as_ref);
        let mut locator = Locator::without_site(cameras.rig, Settings::FULL);
        let mut segmented = locator.segment(frames).with_context(|| cameras.name.clone())?;
        let up = cameras.up.resolve(&mut segmented).with_context(|| cameras.name.clone())?;
        let levelled = segmented.level(&up).map_err(SeeError::from).with_context(|| cameras.name.clone())?;
        let mut seen = see(levelled);
        let windows = seen.windows();
        let windows_per_camera = [0, 1].map(|camera| windows.iter().filter(|w| w.camera == camera).count());
        let WindowEvidence { hit, confidence, .. } = seen.window_evidence();
        let compared = CrossModal::new(hit, confidence, &scan);
        if let Some(dir) = &self.figures {
            draw(dir, hit, &scan, &compared)?;
        }
        let count = compared.known.iter().zip(hit).filter(|(known, hit)| **known && **hit == Hit::Window);
        let (agreeing, of) = (compared.agreeing, compared.seen());
        let output = Output {
            windows_per_camera,
            window_bins: WindowBins { seen: count.count(), plan: scan.count(Hit::Window) },
            agreeing_bins: Agreeing {
                count: agreeing,
                of,
                share: Decimal(agreeing as f64 / of.max(1) as f64),
            },
            cosine: Scores::new(&compared.cosine),
            centred: Scores::new(&compared.centred),
            peak_shift_deg: compared.peak_shift_deg(),
        };
        self.json.emit(&output, &summary(&output))?;
        Ok(Outcome::Done)
    }
}

fn draw(dir: &Path, seen: &[Hit; BINS], plan: &Scan, compared: &CrossModal) -> Result<()> {
    create_dir(dir)?;
    let hits = HitComparison {
        first_label: "seen",
        first: seen,
        second_label: "plan",
        second: &plan.hit,
        known: Some(&compared.known),
        cosine: compared.cosine[0],
        centred: compared.centred[0],
    };
    figures::draw_hits_linear(&dir.join("hits-linear.png"), &hits)?;
    figures::draw_hits_polar(&dir.join("hits-polar.png"), &hits)?;
    let curve = |label, score| Curve { label, score };
    let curves = [curve("plain", &compared.cosine), curve("centred", &compared.centred)];
    figures::draw_correlation(&dir.join("correlation.png"), &curves, Shifts::Signed)?;
    Ok(())
}

fn summary(output: &Output) -> String {
    let Output { windows_per_camera: [cam0, cam1], window_bins, agreeing_bins, cosine, centred, .. } = output;
    let scores = |s: &Scores| format!("{:.3} at the pose, {:.3} at its peak", s.at_zero.0, s.peak.0);
    format!(
        "windows        {cam0} in cam0, {cam1} in cam1\n\
         window bins    {} seen, {} in the plan\n\
         agreeing bins  {} of the {} seen ({:.1} %)\n\
         cosine         {}\n\
         centred        {}\n\
         peak shift     {} degrees\n",
        window_bins.seen,
        window_bins.plan,
        agreeing_bins.count,
        agreeing_bins.of,
        agreeing_bins.share.0 * 100.0,
        scores(cosine),
        scores(centred),
        output.peak_shift_deg
    )
}
