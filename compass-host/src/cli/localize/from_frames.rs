//! The pose of camera frames.

use crate::cli::cameras::CameraArgs;
use crate::cli::exit::Outcome;
use crate::cli::json::JsonOption;
use crate::cli::notes::note;
use crate::cli::pose::{Pose, covariance, milliseconds};
use crate::cli::prior::{PlaceArgs, PriorOutput};
use anyhow::{Context as _, Result};
use compass_core::pose::{FloorLayer, ScoredPose};
use compass_core::vision::shot::Shot;
use compass_core::{Bearing, Covariance, ExclusionMask, Fix, Frame, HeightPrior, Settings, UpHint};
use compass_host::clock::Clock;
use compass_host::doubt;
use compass_host::input;
use compass_host::locator::{Locator, NoPlan, SeeError, Seen};
use compass_host::output::{Decimal, Variance, pose_bits};
use compass_host::site_file::{SiteFile, SiteFloor};
use compass_host::up_by_plan::{Placed, locate_by_plan};
use compass_host::wall_check::{WallSummary, Walls};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Names of a floor's layers in the result.
const LAYERS: [&str; 2] = ["plan", "structure"];

#[derive(Debug, Serialize)]
struct Output<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<&'a str>,
    x: Decimal,
    y: Decimal,
    heading_deg: Decimal,
    up_in_cam0: [Decimal; 3],
    camera_height_m: Decimal,
    /// The layer of the floor that explains the evidence best: the plan as drawn, or its structure alone.
    layer: &'static str,
    /// Log-likelihood ratio against no information, nats.
    score: Decimal,
    /// Bits of x, y and heading, and of the score, in hexadecimal.
    bits: String,
    margin: Decimal,
    /// Probability that the pose is within 1 m of the true one.
    probability: Decimal,
    /// Of x, y and heading, if the pose is right: m2, m rad and rad2.
    covariance: Option<[[Variance; 3]; 3]>,
    /// What was told of the pose, which restricted the search.
    #[serde(skip_serializing_if = "Option::is_none")]
    prior: Option<PriorOutput>,
    candidates: Vec<Pose<'a>>,
    /// Verdicts on the walls of the plan as drawn, from this pair of frames.
    walls: WallSummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_error_m: Option<Decimal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading_error_deg: Option<Decimal>,
    milliseconds: BTreeMap<&'static str, Decimal>,
    /// Of an uncertain answer alone.
    reason: Option<String>,
}

/// An uncertain answer.
#[derive(Debug, Serialize)]
struct Unsure<'a> {
    probability: Decimal,
    reason: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    prior: Option<PriorOutput>,
    candidates: Vec<Pose<'a>>,
}

/// The source of the frames.
pub(super) enum Input<'i> {
    /// Images and a calibration.
    Images(&'i CameraArgs),
    /// Packed frames, in the board's input format.
    Shot(&'i Path),
}

/// The results for the frames.
struct Located<'a> {
    up: Bearing,
    fix: Fix<'a>,
    /// Empty if the pose is uncertain.
    walls: Walls,
    layers: Vec<FloorLayer<'a>>,
    /// What is wrong with the frames, if the pose is uncertain.
    fault: Option<String>,
}

/// What came of the frames.
enum Found<'a> {
    /// A pose, sure or not.
    Place(Box<Located<'a>>),
    /// None, and why.
    Nothing(String),
}

/// Options of the localization.
#[derive(Debug, Clone, Copy)]
pub(super) struct Options<'o> {
    pub(super) settings: Settings,
    pub(super) place: &'o PlaceArgs,
    pub(super) truth: Option<([f64; 2], f64)>,
    pub(super) least_probability: f64,
}

impl Options<'_> {
    /// Whether a pose is said.
    fn is_sure(&self, fix: &Fix<'_>) -> bool {
        f64::from(fix.probability()) >= self.least_probability
    }
}

/// Observes, searches and reports.
pub(super) fn run(
    map: &Path,
    input: &Input<'_>,
    options: &Options<'_>,
    json: &JsonOption,
) -> Result<Outcome> {
    let mut clock = Clock::start();
    let file = SiteFile::read(map)?;
    let floors = file.floors();
    if floors.iter().any(|floor| floor.floor.is_none()) {
        return Err(NoPlan).with_context(|| map.display().to_string());
    }
    clock.stage("read_map");
    let found = match input {
        Input::Images(cameras) => of_images(map, &floors, cameras, options, &mut clock)?,
        Input::Shot(path) => of_shot(map, &floors, path, options, &mut clock)?,
    };
    let located = match found {
        Found::Place(located) => *located,
        Found::Nothing(reason) => return unsure(0.0, reason, options, Vec::new(), json),
    };
    let Located { up, fix, walls, layers, fault } = located;
    let coarse = doubt::of_maps(&floors);
    let poses = fix.poses().iter().zip(fix.covariances());
    let poses: Vec<_> = poses.map(|(scored, spread)| pose(scored, spread, &layers)).collect();
    let probability = f64::from(fix.probability());
    let best = poses.first().copied().zip(fix.best()).filter(|_| options.is_sure(&fix));
    let Some((best, scored)) = best else {
        let reason = doubt::with_fault(doubt::of_fix(&fix, options.least_probability), coarse);
        let reason = doubt::with_fault(reason, fault);
        return unsure(probability, reason, options, poses, json);
    };
    if let Some(coarse) = coarse {
        note(&format!("{}: {coarse}", map.display()));
    }
    let errors = options.truth.map(|(at, heading)| best.error(at, heading));
    let layer = usize::from(fix.layer_number().unwrap_or(0));
    let output = Output {
        floor: best.floor,
        x: best.x,
        y: best.y,
        heading_deg: best.heading_deg,
        up_in_cam0: [up.x, up.y, up.z].map(|v| Decimal(f64::from(v))),
        camera_height_m: Decimal(f64::from(fix.camera_height_m())),
        layer: LAYERS[layer.min(1)],
        score: best.score,
        bits: pose_bits(scored),
        margin: Decimal(fix.margin().to_num()),
        probability: Decimal(probability),
        covariance: best.covariance,
        prior: options.place.output(),
        candidates: poses,
        walls: WallSummary::of(&walls),
        position_error_m: errors.map(|(metres, _)| Decimal(metres)),
        heading_error_deg: errors.map(|(_, degrees)| Decimal(degrees)),
        milliseconds: milliseconds(&clock),
        reason: None,
    };
    json.emit(&output, &summary(&output, fix.covariance(), options.place))?;
    Ok(Outcome::Done)
}

/// Reports that there is no pose, and why.
fn unsure(
    probability: f64,
    reason: String,
    options: &Options<'_>,
    candidates: Vec<Pose<'_>>,
    json: &JsonOption,
) -> Result<Outcome> {
    let summary = format!("I don't know (probability {probability:.2}): {reason}\n");
    let prior = options.place.output();
    json.emit(&Unsure { probability: Decimal(probability), reason, prior, candidates }, &summary)?;
    Ok(Outcome::No)
}

fn of_images<'a>(
    map: &Path,
    floors: &[SiteFloor<'a>],
    cameras: &CameraArgs,
    options: &Options<'_>,
    clock: &mut Clock,
) -> Result<Found<'a>> {
    let cameras = cameras.load()?;
    let frames = cameras.frames.each_ref().map(Option::as_ref);
    clock.stage("read_frames");
    let mut locator = Locator::new(floors, cameras.rig, options.settings)?;
    let within = options.place.prior(map, locator.layers())?;
    let name = || cameras.name.clone();
    let mut segmented = locator.segment(frames).with_context(name)?;
    let placed = cameras
        .up
        .candidates(&mut segmented)
        .and_then(|ups| locate_by_plan(segmented, &ups, cameras.heights, &within));
    let mut located = match placed {
        Ok(placed) => Located::new(placed, floors, options),
        Err(error) if error.is_answer() => {
            let reason = format!("{}: {error}", cameras.name);
            return Ok(Found::Nothing(doubt::with_fault(reason, doubt::of_frames(frames))));
        }
        Err(error) => return Err(error).with_context(name),
    };
    if !options.is_sure(&located.fix) {
        located.fault = doubt::of_frames(frames);
    }
    clock.extend(locator.watch().milliseconds());
    located.layers = locator.layers().to_vec();
    Ok(Found::Place(Box::new(located)))
}

fn of_shot<'a>(
    map: &Path,
    floors: &[SiteFloor<'a>],
    path: &Path,
    options: &Options<'_>,
    clock: &mut Clock,
) -> Result<Found<'a>> {
    let name = || path.display().to_string();
    let bytes = input::read_whole(path).with_context(name)?;
    let shot = Shot::new(&bytes).and_then(|shot| shot.verify().map(|()| shot)).with_context(name)?;
    clock.stage("read_frames");
    let header = shot.header();
    let mut locator = Locator::new(floors, header.rig, options.settings)?;
    let within = options.place.prior(map, locator.layers())?;
    let frames = shot
        .images()
        .map(|image| image.map(|(gray, red)| Frame { gray, excluded: ExclusionMask::Mask(red) }));
    let mut segmented = locator.segment_borrowed(&frames).with_context(name)?;
    let up = segmented.vertical(UpHint::Up(header.up)).map_err(SeeError::from).with_context(name)?.up;
    let heights = header.height_m.map_or(HeightPrior::UNKNOWN, HeightPrior::camera);
    let placed = locate_by_plan(segmented, &[up], heights, &within).with_context(name)?;
    let mut located = Located::new(placed, floors, options);
    clock.extend(locator.watch().milliseconds());
    located.layers = locator.layers().to_vec();
    Ok(Found::Place(Box::new(located)))
}

impl<'a> Located<'a> {
    /// With the verdicts on walls, if the pose is sure.
    fn new(placed: Placed<'_, 'a>, floors: &[SiteFloor<'_>], options: &Options<'_>) -> Self {
        let Placed { up, mut seen, fix } = placed;
        let walls = if options.is_sure(&fix) { walls(&fix, &mut seen, floors) } else { Walls::default() };
        Self { up, fix, walls, layers: Vec::new(), fault: None }
    }
}

/// The verdicts on the walls of the plan as drawn, from the likeliest pose.
fn walls(fix: &Fix<'_>, seen: &mut Seen<'_, '_>, floors: &[SiteFloor<'_>]) -> Walls {
    let mut walls = Walls::default();
    let floor = fix.pose().and_then(|pose| floors.get(usize::from(pose.floor))?.floor);
    if let Some((plan, pose)) = floor.and_then(|floor| floor.plan(0)).zip(fix.best()) {
        seen.with_evidence(fix.heights(), |table, _| walls.add(&plan, pose, table));
    }
    walls
}

/// A pose in the JSON result, with its floor where there are several.
fn pose<'a>(scored: &ScoredPose, spread: &Covariance, layers: &[FloorLayer<'a>]) -> Pose<'a> {
    let several = layers.iter().any(|layer| layer.floor > 0);
    let layer = layers.get(usize::from(scored.layer));
    let pose = pose_of(scored, layer.map(|layer| layer.name).filter(|_| several));
    Pose { covariance: Some(covariance(spread.rows())), ..pose }
}

/// A scored pose in the JSON result, with its floor where there are several.
pub(in crate::cli) fn pose_of<'a>(scored: &ScoredPose, floor: Option<&'a str>) -> Pose<'a> {
    Pose {
        floor,
        x: Decimal(scored.at.x.to_num()),
        y: Decimal(scored.at.y.to_num()),
        heading_deg: Decimal(f64::from(scored.heading.to_microdegrees()) / 1e6),
        score: Decimal(scored.score.to_num()),
        covariance: None,
    }
}

fn summary(output: &Output<'_>, spread: Option<Covariance>, place: &PlaceArgs) -> String {
    let mut text = String::new();
    if let Some(told) = place.words() {
        let _ = writeln!(text, "searched {told}");
    }
    for (rank, pose) in output.candidates.iter().enumerate() {
        let floor = pose.floor.map_or_else(String::new, |name| format!("{name}  "));
        let _ = writeln!(
            text,
            "{:>2}. {floor}x {:8.3} m  y {:8.3} m  heading {:6.2}  score {:8.2}",
            rank + 1,
            pose.x.0,
            pose.y.0,
            pose.heading_deg.0,
            pose.score.0,
        );
    }
    let Output { probability, margin, layer, camera_height_m, .. } = output;
    let _ = writeln!(
        text,
        "probability {:.2}, margin {:.1} nats, {layer} fits best, camera {:.2} m above the floor",
        probability.0, margin.0, camera_height_m.0
    );
    if let Some(spread) = spread {
        let _ = writeln!(
            text,
            "standard deviation at most {:.2} m and {:.1} degrees, if right",
            spread.position_m(),
            spread.heading_rad().to_degrees()
        );
    }
    if let (Some(metres), Some(degrees)) = (output.position_error_m, output.heading_error_deg) {
        let _ = writeln!(text, "{:.2} m and {:.1} degrees off", metres.0, degrees.0);
    }
    let stages: Vec<_> =
        output.milliseconds.iter().map(|(stage, ms)| format!("{stage} {:.1}", ms.0)).collect();
    let _ = writeln!(text, "milliseconds: {}", stages.join(", "));
    text
}
