//! `compass gravity`: which way is up, and how the building's axes lie.

use super::Outcome;
use super::cameras::CameraArgs;
use crate::output::{Decimal, JsonOption, decimals};
use anyhow::{Context as _, Result, bail};
use serde::Serialize;

#[derive(Debug, clap::Args)]
pub(super) struct Gravity {
    #[command(flatten)]
    cameras: CameraArgs,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    up_in_cam0: Vec<Decimal>,
    roll_deg: Decimal,
    pitch_deg: Decimal,
    inliers: u16,
    inliers_per_camera: [u16; 2],
    residual_deg: Decimal,
    /// Support of the next best direction over that of the answer.
    ambiguity: Decimal,
    milliseconds: Decimal,
}

impl Gravity {
    pub(super) fn run(&self) -> Result<Outcome> {
        let mut cameras = self.cameras.load()?;
        if cameras.up.is_given() {
            bail!("--up gives what gravity is to find: use --mount to tell which side of the image is up");
        }
        let frames = cameras.frames.each_ref().map(Option::as_ref);
        cameras.eyes.detect(frames)?;
        let start = std::time::Instant::now();
        let vertical =
            cameras.eyes.vertical(frames, cameras.up.mount()).with_context(|| cameras.name.clone())?;
        let milliseconds = Decimal(start.elapsed().as_secs_f64() * 1e3);
        let number = |v: f32| Decimal(f64::from(v));
        let up = vertical.up;
        let output = Output {
            up_in_cam0: decimals([up.x, up.y, up.z].map(f64::from)),
            roll_deg: number(vertical.roll_deg()),
            pitch_deg: number(vertical.pitch_deg()),
            inliers: vertical.inliers.iter().sum(),
            inliers_per_camera: vertical.inliers,
            residual_deg: number(vertical.residual_deg),
            ambiguity: number(vertical.runner_up / vertical.support),
            milliseconds,
        };
        let summary = format!(
            "up in cam0 {:.4} {:.4} {:.4}; roll {:.2} degrees, pitch {:.2} degrees; {} + {} inliers\n",
            up.x, up.y, up.z, output.roll_deg.0, output.pitch_deg.0, vertical.inliers[0], vertical.inliers[1]
        );
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }
}
