//! `compass see`: what the cameras see in every direction, as the descriptor that localization compares.

use super::Outcome;
use super::cameras::CameraArgs;
use super::debug::Found;
use super::plan::PoseOnPlan;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::windows::ImageWindow;
use compass_core::vision::camera::{Pixel, View};
use compass_core::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use compass_core::vision::windows::{Window, image_box};
use compass_host::compare::float_levels;
use compass_host::eyes::{Eyes, EyesError};
use compass_host::output::{Decimal, decimals};
use compass_host::plan_descriptor::hit_name;
use compass_host::site::wrapped;
use compass_host::visual_descriptor::VisualDescriptor;
use serde::Serialize;
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

/// A window as it is reported.
#[derive(Debug, Serialize)]
pub(super) struct WindowOutput {
    camera: &'static str,
    #[serde(rename = "box")]
    pixels: Option<[Decimal; 4]>,
    azimuth_deg: [Decimal; 2],
    elevation_deg: [Decimal; 2],
    /// Log odds that it is a window, nats; of the paper's finder its own score.
    score: Decimal,
}

impl WindowOutput {
    pub(super) fn new(window: &Window, eyes: &Eyes, level: &LevelFrame) -> Self {
        let resolution = eyes.resolution();
        let degrees = |pair: [f32; 2]| pair.map(|v| Decimal(f64::from(v)));
        Self {
            camera: if window.camera == 0 { "cam0" } else { "cam1" },
            pixels: image_box(window, eyes.rig(), level, resolution)
                .map(|b| b.map(|v| Decimal(f64::from(v)))),
            azimuth_deg: degrees(window.azimuth_deg(resolution)),
            elevation_deg: degrees(window.elevation_deg(resolution)),
            score: Decimal(f64::from(window.score) / 256.0),
        }
    }
}

impl WindowOutput {
    /// A window of the paper's finder: its azimuths are those of the middles of its sides, its elevations those of the
    /// middles of top and bottom.
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
        // An upside-down camera has the counter-clockwise end at its right.
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
    /// The descriptor; where a range is not known, that of the nearest direction stands in.
    channels: Vec<Vec<Decimal>>,
    range_m: Vec<Option<Decimal>>,
    hit: Vec<Option<&'static str>>,
    /// Of the descriptor's bins, 0 to 1.
    confidence: Vec<Decimal>,
    camera_height_m: Decimal,
    /// `given`, or `assumed` for a room of usual height.
    camera_height: &'static str,
    ceiling_height_m: Decimal,
    /// Log odds of a window, nats.
    evidence: Vec<Decimal>,
    up_in_cam0: Vec<Decimal>,
    windows: Vec<WindowOutput>,
    truncated: bool,
    /// By stage.
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
        let mut cameras = self.cameras.load()?;
        let plan = self.plan.scan()?;
        let frames = cameras.frames.each_ref().map(Option::as_ref);
        let mut stages = [const { Vec::new() }; 4];
        let mut last = None;
        for _ in 0..self.repeat {
            time(&mut stages[0], || cameras.eyes.detect(frames))?;
            let up = time(&mut stages[1], || cameras.up.resolve(&mut cameras.eyes, frames))
                .with_context(|| cameras.name.clone())?;
            let seen = time(&mut stages[2], || cameras.eyes.windows(frames, &up))
                .with_context(|| cameras.name.clone())?;
            let (sighting, level, chosen) = (seen.sighting, seen.level, seen.windows.to_vec());
            let height_m = cameras.height_m;
            let surroundings = time(&mut stages[3], || {
                let ranges = cameras.eyes.ranges(frames, &up, height_m)?;
                Ok::<_, EyesError>(VisualDescriptor::new(ranges, &sighting, height_m))
            })?;
            last = Some((sighting, level, chosen, surroundings));
        }
        let (sighting, level, chosen, surroundings) = last.context("--repeat 0 looks at nothing")?;
        let [segments, level_ms, windows_ms, ranges] = stages.map(median);
        let windows: Vec<_> = chosen.iter().map(|w| WindowOutput::new(w, &cameras.eyes, &level)).collect();
        if let Some(dir) = &self.debug_dir {
            let (eyes, plan, surroundings) = (&cameras.eyes, plan.as_ref(), Some(&surroundings));
            Found {
                frames,
                eyes,
                level,
                windows: &chosen,
                sighting: &sighting,
                descriptor: surroundings,
                plan,
            }
            .draw(dir)?;
        }
        let (up, VisualDescriptor { height, ranges: found, hit, scan, confidence }) =
            (level.up(), &surroundings);
        let output = Output {
            channels: float_levels(&Descriptor::from(scan)).map(decimals).into(),
            range_m: found.iter().map(|range| range.map(|r| Decimal(f64::from(r.metres)))).collect(),
            hit: hit.iter().map(|hit| hit.map(hit_name)).collect(),
            confidence: decimals(confidence.sixteenths().iter().map(|c| f64::from(*c) / 16.0)),
            camera_height_m: Decimal(f64::from(height.camera_m)),
            camera_height: if height.given { "given" } else { "assumed" },
            ceiling_height_m: Decimal(f64::from(height.ceiling_m)),
            evidence: decimals(sighting.evidence.iter().map(|e| f64::from(*e) / 256.0)),
            up_in_cam0: decimals([up.x, up.y, up.z].map(f64::from)),
            windows,
            truncated: sighting.truncated,
            milliseconds: Milliseconds { segments, up: level_ms, windows: windows_ms, ranges },
        };
        self.json.emit(&output, &summary(&output))?;
        Ok(Outcome::Done)
    }
}

/// Runs `work` and notes the milliseconds it took.
fn time<T>(times: &mut Vec<f64>, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    times.push(start.elapsed().as_secs_f64() * 1e3);
    result
}

fn median(mut times: Vec<f64>) -> Decimal {
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
