//! `compass simulate`: dual-fisheye frames rendered from a plan.

use super::exit::Outcome;
use super::plan::{PlanArgs, finite, size};
use super::progress::Bars;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use compass_core::vision::camera::Rig;
use compass_host::calibration::{Calibration, NOMINAL_YAML};
use compass_host::dataset::tum::{self, Pose};
use compass_host::output::{Decimal, write_file, write_png};
use compass_host::plan_import::PlanRaster;
use compass_host::simulate::dataset::{self, Format};
use compass_host::simulate::{Renderer, Scene, SceneOptions};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct Simulate {
    #[command(flatten)]
    plan: PlanArgs,
    /// Kalibr calibration of the cameras [default: an invented rig, written to DIR/calibration.yaml]
    #[arg(long, value_name = "FILE")]
    calib: Option<PathBuf>,
    /// Poses of cam0 in the map: timestamp tx ty tz qx qy qz qw
    #[arg(long, value_name = "TUM")]
    poses: PathBuf,
    /// Where to write the dataset
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Size of the frames; the calibration is scaled to it [default: the calibrated one]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Where clutter and people are, which walls are missing, and the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Materials, windows, colours and brightness [default: the seed]
    #[arg(long, value_name = "N")]
    style: Option<u64>,
    /// Height of the ceiling above the floor in metres
    #[arg(long, value_name = "M", default_value_t = 2.75, value_parser = finite)]
    ceiling: f64,
    /// z of the floor in the map, in metres
    #[arg(long, value_name = "Z", default_value_t = 0.0, value_parser = finite, allow_hyphen_values = true)]
    floor: f64,
    /// Boxes per 100 square metres
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(..=200))]
    clutter: u32,
    /// People around the cameras in each frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=50))]
    people: u32,
    /// Nobody carries the rig
    #[arg(long)]
    no_operator: bool,
    /// Share of the interior walls thinner than 0.2 m that is not built, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    missing: f64,
    /// Rays along a side of a pixel [default: 2 up to 800 pixels of width, 1 above]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4))]
    samples: Option<u16>,
    /// Quality of the JPEG frames
    #[arg(long, value_name = "Q", default_value_t = 90, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
    /// Write PNG instead of JPEG
    #[arg(long, conflicts_with = "quality")]
    png: bool,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    frames: usize,
    cameras: usize,
    width: u32,
    height: u32,
    seconds: Decimal,
}

impl Simulate {
    pub(super) fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        let (raster, _) = self.plan.load()?;
        let poses = self.poses(&raster)?;
        let calibration =
            self.calib.as_deref().map_or_else(|| Ok(Calibration::nominal()), Calibration::load)?;
        calibration.all_valid()?;
        let (rig, (width, height)) = self.rig(&calibration)?;
        let start = Instant::now();
        let scene = Scene::in_places(&self.scene_options(), &raster, &self.plan.places())
            .with_context(|| self.plan.path().unwrap_or(Path::new("")).display().to_string())?;
        let renderer = Renderer::new(&scene, &rig, self.samples);
        let format = if self.png { Format::Png } else { Format::Jpeg(self.quality) };
        dataset::write(&self.out, &renderer, &poses, format, &Bars)?;
        write_png(&self.out.join("as_built.png"), &scene.as_built())?;
        if self.calib.is_none() {
            write_file(&self.out.join("calibration.yaml"), NOMINAL_YAML.as_bytes())?;
        }
        let (seconds, cameras) = (start.elapsed().as_secs_f64(), renderer.cameras().count());
        let summary = format!(
            "{} poses, {cameras} cameras of {width} x {height} pixels in {seconds:.1} s: {}\n",
            poses.len(),
            self.out.display()
        );
        let output = Output { frames: poses.len(), cameras, width, height, seconds: Decimal(seconds) };
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }

    /// The cameras for frames of the requested size, and the size of the first.
    fn rig(&self, calibration: &Calibration) -> Result<(Rig, (u32, u32))> {
        let sizes = calibration.cameras.each_ref().map(|camera| {
            let calibrated = camera.as_ref()?.resolution;
            Some(self.size.unwrap_or(calibrated))
        });
        let rig = calibration.rig(sizes)?;
        Ok((rig, sizes.into_iter().flatten().next().unwrap_or_default()))
    }

    fn scene_options(&self) -> SceneOptions {
        SceneOptions {
            seed: self.seed,
            style: self.style.unwrap_or(self.seed),
            ceiling_m: self.ceiling,
            floor_m: self.floor,
            clutter: self.clutter,
            people: self.people,
            operator: !self.no_operator,
            missing: self.missing,
        }
    }

    /// The poses, if all of them are possible in this building.
    fn poses(&self, raster: &PlanRaster) -> Result<Vec<Pose>> {
        if !(1.0..=50.0).contains(&self.ceiling) {
            bail!("--ceiling is {} m; 1 to 50 are accepted", self.ceiling);
        }
        let mut times = BTreeSet::new();
        let poses = tum::read_checked(&self.poses, |pose| {
            if !times.insert(pose.timestamp_ns) {
                return Err("another pose has the same timestamp".to_owned());
            }
            self.problem(pose, raster).map_or(Ok(()), Err)
        })?;
        Ok(poses)
    }

    /// Why a camera cannot be at the position of a pose, if so.
    fn problem(&self, pose: &Pose, raster: &PlanRaster) -> Option<String> {
        let [x, y, z] = pose.position.into();
        let [x0, y0] = raster.origin;
        let side = |cells: u32| f64::from(cells) * raster.resolution_m;
        let (x1, y1) = (x0 + side(raster.width), y0 + side(raster.height));
        if !(x0..=x1).contains(&x) || !(y0..=y1).contains(&y) {
            return Some(format!(
                "({x:.3}, {y:.3}) is off the plan, which reaches from ({x0}, {y0}) to ({x1}, {y1})"
            ));
        }
        let height = z - self.floor;
        let inside = height > 0.05 && height < self.ceiling - 0.05;
        (!inside).then(|| {
            format!(
                "tz is {z:.3} m: not between the floor at {} and the ceiling {} m above it",
                self.floor, self.ceiling
            )
        })
    }
}

/// Parses a number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| format!("'{text}' is not a number from 0 to 1"))
}
