//! `compass gravity`: the up vector, and the horizontal axes of the building.

mod pictures;

use super::cameras::{CameraArgs, Cameras};
use super::exit::Outcome;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use compass_core::Settings;
use compass_core::vision::attitude::{Axes, Vertical};
use compass_core::vision::camera::Bearing;
use compass_core::vision::level_frame::LevelFrame;
use compass_host::locator::Locator;
use compass_host::output::{Decimal, decimals};
use compass_host::up::UpFrom;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Gravity {
    #[command(flatten)]
    cameras: CameraArgs,
    /// Write pictures of the segments by vanishing point into DIR
    #[arg(long, value_name = "DIR")]
    debug_dir: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    up_in_cam0: Vec<Decimal>,
    roll_deg: Decimal,
    pitch_deg: Decimal,
    /// The source of the up vector.
    up_from: &'static str,
    #[serde(flatten)]
    image: Option<Image>,
    /// The building's horizontal axes, at right angles; `null` without a horizontal segment.
    axes: Option<[Axis; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    imu: Option<Imu>,
    milliseconds: Decimal,
}

/// The support of the up vector in the image.
#[derive(Debug, Serialize)]
struct Image {
    inliers: u16,
    inliers_per_camera: [u16; 2],
    /// Degrees of arc.
    support: Decimal,
    /// The support of the next best direction, degrees of arc.
    runner_up: Decimal,
    /// Ratio of the next best direction's support to that of the answer.
    ambiguity: Decimal,
    residual_deg: Decimal,
}

#[derive(Debug, Serialize)]
struct Axis {
    /// Counter-clockwise from the heading.
    azimuth_deg: Decimal,
    in_cam0: Vec<Decimal>,
    inliers: u16,
}

#[derive(Debug, Serialize)]
struct Imu {
    up_in_cam0: Vec<Decimal>,
    samples: usize,
    /// Length of the mean reading, m/s^2.
    acceleration: Decimal,
    /// Angle to the image's up vector, degrees.
    agreement_deg: Option<Decimal>,
}

fn number(value: f32) -> Decimal {
    Decimal(f64::from(value))
}

fn numbers(vector: &Bearing) -> Vec<Decimal> {
    decimals(vector.iter().copied().map(f64::from))
}

impl From<&Vertical> for Image {
    fn from(vertical: &Vertical) -> Self {
        Self {
            inliers: vertical.inliers.iter().sum(),
            inliers_per_camera: vertical.inliers,
            support: number(vertical.support),
            runner_up: number(vertical.runner_up),
            ambiguity: number(vertical.runner_up / vertical.support),
            residual_deg: number(vertical.residual_deg),
        }
    }
}

impl Gravity {
    pub(super) fn run(&self) -> Result<Outcome> {
        let cameras = self.cameras.load()?;
        if cameras.up.is_given() {
            bail!("--up gives what gravity is to find: use --mount to tell which side of the image is up");
        }
        let frames = cameras.frames.each_ref().map(Option::as_ref);
        let mut locator = Locator::without_site(cameras.rig, Settings::FULL);
        let mut segmented = locator.segment(frames).with_context(|| cameras.name.clone())?;
        let start = std::time::Instant::now();
        let found = cameras.up.sources.vertical(&mut segmented);
        let milliseconds = Decimal(start.elapsed().as_secs_f64() * 1e3);
        let (vertical, up) = match (found, cameras.up.sources.from, cameras.up.sources.imu) {
            (found, UpFrom::Imu, Some(gravity)) => (found.ok(), gravity.up.cast()),
            // Without vertical lines in view, gravity still gives the up vector.
            (Err(_), UpFrom::Both, Some(gravity)) => (None, gravity.up.cast()),
            (found, ..) => {
                let vertical = found.with_context(|| cameras.name.clone())?;
                (Some(vertical), vertical.up)
            }
        };
        let segments = [0, 1].map(|camera| segmented.segments(camera).to_vec());
        // Without a heading, an up vector has no horizontal axes.
        let levelled = segmented.level(&up).ok();
        let level = levelled.as_ref().map(|levelled| levelled.frame());
        let axes = levelled.and_then(|mut levelled| levelled.axes());
        let output = output(&cameras, up, vertical.as_ref(), axes.zip(level.as_ref()), milliseconds);
        if let (Some(dir), Some(level)) = (&self.debug_dir, &level) {
            let (rig, tolerance_deg) = (&cameras.rig, locator.inlier_tolerance_deg());
            pictures::Lines { frames, rig, segments, tolerance_deg, level, axes }.draw(dir)?;
        }
        self.json.emit(&output, &summary(&output))?;
        vertical.map_or(Ok(()), |vertical| cameras.up.sources.check(&vertical))?;
        Ok(Outcome::Done)
    }
}

fn output(
    cameras: &Cameras,
    up: Bearing,
    vertical: Option<&Vertical>,
    axes: Option<(Axes, &LevelFrame)>,
    milliseconds: Decimal,
) -> Output {
    let nothing = Vertical { up, inliers: [0; 2], support: 0.0, runner_up: 0.0, residual_deg: 0.0 };
    let agreement_deg = vertical.and_then(|vertical| cameras.up.sources.apart_deg(vertical)).map(Decimal);
    let axis = |(axes, level): (Axes, &LevelFrame)| {
        let [first, second] = axes.directions(level);
        let axis = |index: usize, direction: Bearing| Axis {
            azimuth_deg: number(axes.azimuth_deg + 90.0 * index as f32),
            in_cam0: numbers(&direction),
            inliers: axes.inliers[index],
        };
        [axis(0, first), axis(1, second)]
    };
    Output {
        up_in_cam0: numbers(&up),
        roll_deg: number(nothing.roll_deg()),
        pitch_deg: number(nothing.pitch_deg()),
        up_from: cameras.up.sources.from.name(),
        image: vertical.map(Image::from),
        axes: axes.map(axis),
        imu: cameras.up.sources.imu.map(|gravity| Imu {
            up_in_cam0: numbers(&gravity.up.cast()),
            samples: gravity.samples,
            acceleration: Decimal(gravity.length),
            agreement_deg,
        }),
        milliseconds,
    }
}

fn summary(output: &Output) -> String {
    let [x, y, z] = output.up_in_cam0[..] else { return String::new() };
    let mut text = format!(
        "up in cam0 {:.4} {:.4} {:.4}; roll {:.2} degrees, pitch {:.2} degrees",
        x.0, y.0, z.0, output.roll_deg.0, output.pitch_deg.0
    );
    if let Some(image) = &output.image {
        let [front, back] = image.inliers_per_camera;
        let _ = write!(text, "; {front} + {back} inliers");
    }
    text.push('\n');
    if let Some([a, b]) = &output.axes {
        let _ = writeln!(
            text,
            "building axes at {:.1} and {:.1} degrees; {} + {} inliers",
            a.azimuth_deg.0, b.azimuth_deg.0, a.inliers, b.inliers
        );
    }
    if let Some(imu) = &output.imu {
        let apart =
            imu.agreement_deg.map_or("nothing to compare with".into(), |d| format!("{:.2} degrees", d.0));
        let _ = writeln!(text, "IMU: {} readings; from the image's up {apart}", imu.samples);
    }
    text
}
