//! `compass windows`: the windows in one camera's frame.

use super::Outcome;
use super::cameras::UpArg;
use super::see::WindowOutput;
use crate::calibration::Calibration;
use crate::eyes::Eyes;
use crate::frame::Frame;
use crate::output::JsonOption;
use anyhow::{Context as _, Result};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Windows {
    /// Camera calibration: a Kalibr camera-imu chain .yaml
    #[arg(long, value_name = "FILE")]
    calib: PathBuf,
    /// Which camera the frame is of
    #[arg(long, value_enum)]
    camera: Which,
    /// The frame
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    #[command(flatten)]
    up: UpArg,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Which {
    Cam0,
    Cam1,
}

#[derive(Debug, Serialize)]
struct Output {
    windows: Vec<WindowOutput>,
    truncated: bool,
}

impl Windows {
    pub(super) fn run(&self) -> Result<Outcome> {
        let calibration = Calibration::load(&self.calib)?;
        let frame = Frame::read(&self.image)?;
        let size = Some((frame.width(), frame.height()));
        let (sizes, frames) = match self.camera {
            Which::Cam0 => ([size, None], [Some(&frame), None]),
            Which::Cam1 => ([None, size], [None, Some(&frame)]),
        };
        let mut eyes = Eyes::new(calibration.rig(sizes)?);
        eyes.detect(frames).with_context(|| self.image.display().to_string())?;
        let up = self.up.resolve(&mut eyes, frames)?;
        let seen = eyes.windows(frames, &up)?;
        let truncated = seen.sighting.truncated;
        let level = seen.level;
        let found = seen.windows.to_vec();
        let windows: Vec<_> = found.iter().map(|w| WindowOutput::new(w, &eyes, &level)).collect();
        let mut summary = format!("{} windows\n", windows.len());
        for w in &windows {
            let _ = writeln!(summary, "{w}");
        }
        self.json.emit(&Output { windows, truncated }, &summary)?;
        Ok(Outcome::Done)
    }
}
