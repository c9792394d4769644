//! `compass windows`: the windows in one camera's frame.

use super::cameras::UpArg;
use super::debug;
use super::debug::Found;
use super::exit::Outcome;
use super::see::{WindowOutput, segments};
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::Settings;
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::segments::Parameters;
use compass_host::calibration::Calibration;
use compass_host::frame::{Frame, SegmentDetector};
use compass_host::locator::{Locator, SeeError, see};
use compass_host::paper_finder::PaperFinder;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Windows {
    /// Camera calibration: a camera chain of Kalibr, .yaml, or what Basalt and ROS write
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
    /// How to find them
    #[arg(long, value_enum, default_value_t = Method::Level)]
    method: Method,
    /// Write pictures of what was found and considered into DIR
    #[arg(long, value_name = "DIR")]
    debug_dir: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Which {
    Cam0,
    Cam1,
}

impl Which {
    const fn number(self) -> usize {
        match self {
            Self::Cam0 => 0,
            Self::Cam1 => 1,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Method {
    /// On the ring levelled by the up vector
    Level,
    /// As in the paper, along the image's own vertical
    Paper,
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
        let sizes = [0, 1].map(|camera| size.filter(|_| camera == self.camera.number()));
        let mut locator = Locator::without_site(calibration.rig(sizes)?, Settings::FULL);
        locator.watch().keeps_considered = self.debug_dir.is_some();
        let output = match self.method {
            Method::Level => self.level(&frame, &mut locator)?,
            Method::Paper => self.paper(&frame, &mut locator)?,
        };
        let mut summary = format!("{} windows\n", output.windows.len());
        for w in &output.windows {
            let _ = writeln!(summary, "{w}");
        }
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }

    /// The finder in the level frame.
    fn level(&self, frame: &Frame, locator: &mut Locator<'_>) -> Result<Output> {
        let name = || self.image.display().to_string();
        let frames = [0, 1].map(|camera| Some(frame).filter(|_| camera == self.camera.number()));
        let mut segmented = locator.segment(frames).with_context(name)?;
        let up = self.up.resolve(&mut segmented).with_context(name)?;
        let levelled = segmented.level(&up).map_err(SeeError::from).with_context(name)?;
        let level = levelled.frame();
        let mut seen = see(levelled);
        let (found, window_evidence) = (seen.windows().to_vec(), seen.window_evidence().clone());
        let (rig, resolution) = (*locator.rig(), locator.resolution());
        if let Some(dir) = &self.debug_dir {
            let considered = locator.watch().considered().context("the panorama was drawn")?;
            let segments = segments(locator, frames)?;
            let (rig, windows, window_evidence) = (&rig, &found, &window_evidence);
            let (ranges, plan) = (None, None);
            Found { frames, rig, segments, considered, level, windows, window_evidence, ranges, plan }
                .draw(dir)?;
        }
        let windows = found.iter().map(|w| WindowOutput::new(w, &rig, &level, resolution)).collect();
        Ok(Output { windows, truncated: window_evidence.truncated })
    }

    /// The finder in the unrectified image; the up vector only defines the azimuths.
    fn paper(&self, frame: &Frame, locator: &mut Locator<'_>) -> Result<Output> {
        let camera = self.camera.number();
        let name = || self.image.display().to_string();
        let mut detector = SegmentDetector::new(frame.width(), frame.height());
        let (segments, _) =
            detector.detect(&frame.gray(), None, &Parameters::default()).with_context(name)?;
        let mut finder = PaperFinder::new(frame.width(), frame.height());
        let found = finder.find(frame, segments).with_context(name)?;
        if let Some(dir) = &self.debug_dir {
            debug::paper(dir, camera, frame, &finder)?;
        }
        let frames = [0, 1].map(|camera| Some(frame).filter(|_| camera == self.camera.number()));
        let mut segmented = locator.segment(frames).with_context(name)?;
        let up = self.up.resolve(&mut segmented).with_context(name)?;
        let level = LevelFrame::new(&up).ok_or(SeeError::Up)?;
        let view = locator.rig().view(camera).context("the calibration has no such camera")?;
        let output = |w| WindowOutput::in_image(w, camera, view, &level);
        Ok(Output {
            windows: finder.windows().iter().filter_map(output).collect(),
            truncated: found.truncated,
        })
    }
}
