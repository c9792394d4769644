//! `compass see`: observes hit type and range in every direction, as the descriptor used by localization.

use super::cameras::{CameraArgs, Cameras};
use super::debug::{Found, boundaries};
use super::exit::Outcome;
use super::plan::PoseOnPlan;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::Settings;
use compass_core::base::num::CellNats;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::windows::ImageWindow;
use compass_core::vision::camera::{Pixel, Rig, View};
use compass_core::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use compass_core::vision::panorama::Resolution;
use compass_core::vision::segments::Segment;
use compass_core::vision::windows::{Window, WindowEvidence, image_box};
use compass_host::compare::float_levels;
use compass_host::frame::Frame;
use compass_host::locator::{Locator, SeeError, see};
use compass_host::output::{Decimal, decimals};
use compass_host::plan_descriptor::hit_name;
use compass_host::site::wrapped;
use compass_host::visual_descriptor::VisualDescriptor;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct See {
    #[command(flatten)]
    cameras: CameraArgs,
    /// Look N times and report the median time of each stage
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeat: u32,
    /// Write pictures of what was found and considered into DIR; with --plan, also what the plan says
    #[arg(long, value_name = "DIR")]
    debug_dir: Option<PathBuf>,
    #[command(flatten)]
    plan: PoseOnPlan,
    #[command(flatten)]
    json: JsonOption,
}

/// A window in the JSON result.
#[derive(Debug, Serialize)]
pub(super) struct WindowOutput {
    camera: &'static str,
    #[serde(rename = "box")]
    pixels: Option<[Decimal; 4]>,
    azimuth_deg: [Decimal; 2],
    elevation_deg: [Decimal; 2],
    /// Log odds of being a window, nats; the paper's finder reports its own score.
    score: Decimal,
}

impl WindowOutput {
    pub(super) fn new(window: &Window, rig: &Rig, level: &LevelFrame, resolution: Resolution) -> Self {
        let degrees = |pair: [f32; 2]| pair.map(|v| Decimal(f64::from(v)));
        Self {
            camera: if window.camera == 0 { "cam0" } else { "cam1" },
            pixels: image_box(window, rig, level, resolution).map(|b| b.map(|v| Decimal(f64::from(v)))),
            azimuth_deg: degrees(window.azimuth_deg(resolution)),
            elevation_deg: degrees(window.elevation_deg(resolution)),
            score: Decimal(f64::from(window.score)),
        }
    }
}

impl WindowOutput {
    /// A window of the paper's finder: azimuths at the midpoints of its sides, elevations at the midpoints of top and
    /// bottom.
    pub(super) fn in_image(
        window: &ImageWindow,
        camera: usize,
        view: &View,
        level: &LevelFrame,
    ) -> Option<Self> {
        let [x0, y0, x1, y1] = [window.x0, window.y0, window.x1, window.y1].map(f32::from);
        let (x, y) = (x0.midpoint(x1), y0.midpoint(y1));
        let direction = |x: f32, y: f32| {
            let bearing = view.camera.unproject(Pixel { x: x - 0.5, y: y - 0.5 })?;
            let point = view.rotation * bearing * NOMINAL_RANGE_M + view.position;
            let (azimuth, elevation) = level.direction(&point.normalize());
            Some([azimuth, elevation].map(|angle| f64::from(angle).to_degrees()))
        };
        let (left, right) = (direction(x0, y)?[0], direction(x1, y)?[0]);
        let (top, bottom) = (direction(x, y0)?[1], direction(x, y1)?[1]);
        // In an upside-down camera the counter-clockwise end is at the right.
        let turn = wrapped(left - right);
        let from = if turn >= 0.0 { right } else { left };
        Some(Self {
            camera: if camera == 0 { "cam0" } else { "cam1" },
            pixels: Some([x0, y0, x1, y1].map(|v| Decimal(f64::from(v)))),
            azimuth_deg: [from, from + turn.abs()].map(Decimal),
            elevation_deg: [top.min(bottom), top.max(bottom)].map(Decimal),
            score: Decimal(f64::from(window.score)),
        })
    }
}

impl fmt::Display for WindowOutput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.azimuth_deg.map(|v| v.0);
        let [sill, lintel] = self.elevation_deg.map(|v| v.0);
        write!(
            f,
            "{}: azimuth {from:7.2} to {to:7.2}, elevation {sill:6.2} to {lintel:6.2}, score {:5.2}",
            self.camera, self.score.0
        )
    }
}

#[derive(Debug, Serialize)]
struct Output {
    /// The descriptor; an unknown range is replaced by that of the nearest direction.
    channels: Vec<Vec<Decimal>>,
    range_m: Vec<Option<Decimal>>,
    hit: Vec<Option<&'static str>>,
    /// Confidence of the descriptor's bins, 0 to 1.
    confidence: Vec<Decimal>,
    camera_height_m: Decimal,
    /// `given`, or `assumed` from a typical room height.
    camera_height: &'static str,
    ceiling_height_m: Decimal,
    /// Log odds of a window, nats.
    evidence: Vec<Decimal>,
    up_in_cam0: Vec<Decimal>,
    windows: Vec<WindowOutput>,
    truncated: bool,
    /// Milliseconds by stage.
    milliseconds: Milliseconds,
}

#[derive(Debug, Serialize)]
struct Milliseconds {
    segments: Decimal,
    up: Decimal,
    windows: Decimal,
    ranges: Decimal,
}

impl See {
    pub(super) fn run(&self) -> Result<Outcome> {
        let cameras = self.cameras.load()?;
        let plan = self.plan.scan()?;
        let frames = cameras.frames.each_ref().map(Option::as_ref);
        let mut locator = Locator::without_site(cameras.rig, Settings::FULL);
        locator.watch().keeps_considered = self.debug_dir.is_some();
        let mut times = Vec::new();
        let mut last = None;
        for _ in 0..self.repeat {
            let (seen, described) = observe(&mut locator, &cameras).with_context(|| cameras.name.clone())?;
            let mut stages = locator.watch().milliseconds();
            *stages.entry("ranges").or_default() += described;
            times.push(stages);
            last = Some(seen);
        }
        let Observation { level, evidence, windows: chosen, descriptor, boundaries } =
            last.context("--repeat 0 looks at nothing")?;
        let (rig, resolution) = (*locator.rig(), locator.resolution());
        let windows: Vec<_> = chosen.iter().map(|w| WindowOutput::new(w, &rig, &level, resolution)).collect();
        if let Some(dir) = &self.debug_dir {
            let (plan, ranges) = (plan.as_ref(), Some((&descriptor, &boundaries[..])));
            let segments = segments(&mut locator, frames)?;
            let considered = locator.watch().considered().context("the panorama was drawn")?;
            let (rig, windows, window_evidence) = (&rig, &chosen, &evidence);
            Found { frames, rig, segments, considered, level, windows, window_evidence, ranges, plan }
                .draw(dir)?;
        }
        let [segments, level_ms, windows_ms, ranges] =
            ["segments", "up", "windows", "ranges"].map(|stage| median(&times, stage));
        let (up, VisualDescriptor { height, ranges: found, hit, scan, confidence }) =
            (level.up(), &descriptor);
        let output = Output {
            channels: float_levels(&Descriptor::from(scan)).map(decimals).into(),
            range_m: found.iter().map(|range| range.map(|r| Decimal(f64::from(r.metres)))).collect(),
            hit: hit.iter().map(|hit| hit.map(hit_name)).collect(),
            confidence: decimals(confidence.sixteenths().iter().map(|c| f64::from(*c) / 16.0)),
            camera_height_m: Decimal(f64::from(height.camera_m)),
            camera_height: if height.given { "given" } else { "assumed" },
            ceiling_height_m: Decimal(f64::from(height.ceiling_m)),
            evidence: decimals(evidence.evidence.iter().map(|e| f64::from(*e))),
            up_in_cam0: decimals([up.x, up.y, up.z].map(f64::from)),
            windows,
            truncated: evidence.truncated,
            milliseconds: Milliseconds { segments, up: level_ms, windows: windows_ms, ranges },
        };
        self.json.emit(&output, &summary(&output))?;
        Ok(Outcome::Done)
    }
}

/// The observation of one pair of frames.
struct Observation {
    level: LevelFrame,
    evidence: WindowEvidence,
    windows: Vec<Window>,
    descriptor: VisualDescriptor,
    boundaries: Vec<CellNats>,
}

/// Observes once; also returns the milliseconds that the descriptor took.
fn observe(locator: &mut Locator<'_>, cameras: &Cameras) -> Result<(Observation, f64), SeeError> {
    let mut segmented = locator.segment(cameras.frames.each_ref().map(Option::as_ref))?;
    let up = cameras.up.resolve(&mut segmented)?;
    let levelled = segmented.level(&up)?;
    let level = levelled.frame();
    let mut seen = see(levelled);
    let (evidence, windows) = (seen.window_evidence().clone(), seen.windows().to_vec());
    let start = Instant::now();
    let descriptor = VisualDescriptor::of(&mut seen, cameras.heights);
    let described = start.elapsed().as_secs_f64() * 1e3;
    let boundaries = boundaries(&mut seen);
    Ok((Observation { level, evidence, windows, descriptor, boundaries }, described))
}

/// The segments of both frames.
pub(super) fn segments(
    locator: &mut Locator<'_>,
    frames: [Option<&Frame>; 2],
) -> Result<[Vec<Segment>; 2], SeeError> {
    let mut segmented = locator.segment(frames)?;
    Ok([0, 1].map(|camera| segmented.segments(camera).to_vec()))
}

/// The median time of a stage over all repetitions.
fn median(times: &[BTreeMap<&str, f64>], stage: &str) -> Decimal {
    let mut times: Vec<_> = times.iter().map(|stages| stages.get(stage).copied().unwrap_or(0.0)).collect();
    times.sort_by(f64::total_cmp);
    Decimal(times.get(times.len() / 2).copied().unwrap_or(0.0))
}

fn summary(output: &Output) -> String {
    let bins = |name: Option<&str>| output.hit.iter().filter(|hit| **hit == name).count();
    let mut text = format!(
        "{} windows; of 360 directions {} window, {} wall, {} unknown\n",
        output.windows.len(),
        bins(Some("window")),
        bins(Some("wall")),
        bins(None)
    );
    for window in &output.windows {
        let _ = writeln!(text, "{window}");
    }
    let mut known: Vec<_> = output.range_m.iter().flatten().map(|range| range.0).collect();
    known.sort_by(f64::total_cmp);
    if let [nearest, .., farthest] = known[..] {
        let median = known[known.len() / 2];
        let _ =
            write!(text, "{} ranges, {nearest:.2} to {farthest:.2} m, median {median:.2} m; ", known.len());
    }
    let (camera, ceiling) = (output.camera_height_m.0, output.ceiling_height_m.0);
    let _ = writeln!(text, "camera {camera:.2} m high ({}), room {ceiling:.2} m", output.camera_height);
    let Milliseconds { segments, up, windows, ranges } = &output.milliseconds;
    let _ = writeln!(
        text,
        "segments {:.1} ms, up {:.1} ms, windows {:.1} ms, ranges {:.1} ms",
        segments.0, up.0, windows.0, ranges.0
    );
    text
}
