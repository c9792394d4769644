//! The options that every command with camera frames shares.

use super::plan::{finite, pair};
use crate::calibration::Calibration;
use crate::dataset::imu::{self, Gravity};
use crate::eyes::{Eyes, EyesError, Mount};
use crate::frame::Frame;
use anyhow::{Result, bail};
use compass_core::attitude::{Hint, Vertical};
use compass_core::boundary::HEIGHTS_M;
use compass_core::camera::Bearing;
use std::path::PathBuf;
use thiserror::Error;

/// A calibration and the frames of one or two cameras.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct CameraArgs {
    /// Camera calibration: a Kalibr camera-imu chain .yaml
    #[arg(long, value_name = "FILE")]
    calib: Option<PathBuf>,
    /// Frame of cam0
    #[arg(long, value_name = "IMAGE")]
    cam0: Option<PathBuf>,
    /// Frame of cam1
    #[arg(long, value_name = "IMAGE")]
    cam1: Option<PathBuf>,
    #[command(flatten)]
    up: UpArg,
    #[command(flatten)]
    imu: ImuArgs,
    /// Height of cam0 above the floor in metres [default: estimated]
    #[arg(long, value_name = "M", value_parser = height, allow_hyphen_values = true)]
    camera_height: Option<f32>,
}

/// The up vector, if it is given.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct UpArg {
    /// Up vector in the axes of cam0 (x right, y down, z forward) [default: from vertical lines]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    up: Option<[f64; 3]>,
    /// Which side of cam0's image is up, within 45 degrees, where it is not told by --up; a wrong one gives a mirrored
    /// answer
    #[arg(long, value_enum, default_value_t = Mount::Auto)]
    mount: Mount,
}

impl UpArg {
    /// The up vector in cam0: that given, or that of the frames whose segments were just detected.
    pub(super) fn resolve(&self, eyes: &mut Eyes, frames: [Option<&Frame>; 2]) -> Result<Bearing> {
        match self.up {
            Some([x, y, z]) => Ok(Bearing::new(x as f32, y as f32, z as f32)),
            None => Ok(eyes.vertical(frames, self.mount)?.up),
        }
    }

    /// The vertical of the frames whose segments were just detected.
    fn vertical(&self, eyes: &mut Eyes, frames: [Option<&Frame>; 2]) -> Result<Vertical, EyesError> {
        eyes.vertical(frames, self.mount)
    }
}

/// An accelerometer beside the cameras.
#[derive(Debug, Clone, clap::Args)]
struct ImuArgs {
    /// Readings of the calibration's IMU (imu0/data.csv: time in ns, rates, accelerations), whose mean tells up: at rest
    /// or nearly
    #[arg(long, value_name = "FILE", conflicts_with = "up")]
    imu: Option<PathBuf>,
    /// Take the readings from second T0 to T1 of their own clock [default: all]
    #[arg(long, value_name = "T0,T1", value_parser = pair, requires = "imu")]
    imu_seconds: Option<[f64; 2]>,
    /// What tells up; both: the image, near where the IMU says [default: both with --imu, else image]
    #[arg(long, value_enum, conflicts_with = "up")]
    up_from: Option<UpFrom>,
}

/// What tells up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum UpFrom {
    Image,
    Imu,
    Both,
}

impl UpFrom {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Image => "image",
            Self::Imu => "imu",
            Self::Both => "both",
        }
    }
}

impl ImuArgs {
    fn source(&self) -> Result<UpFrom> {
        match (self.up_from, &self.imu) {
            (None, None) => Ok(UpFrom::Image),
            (None, Some(_)) => Ok(UpFrom::Both),
            (Some(UpFrom::Imu | UpFrom::Both), None) => {
                bail!("--up-from takes the IMU: name its file with --imu")
            }
            (Some(from), _) => Ok(from),
        }
    }

    /// Gravity in the axes of cam0.
    fn load(&self, calibration: &Calibration) -> Result<Option<Gravity>> {
        let Some(path) = &self.imu else { return Ok(None) };
        let gravity = imu::gravity(path, self.imu_seconds)?;
        let Some(turn) = calibration.cameras[0].as_ref().and_then(|camera| camera.from_imu) else {
            bail!("{}: cam0.T_cam_imu: missing, and --imu needs it", calibration.path.display());
        };
        Ok(Some(Gravity { up: turn.transform_vector(&gravity.up), ..gravity }))
    }
}

/// How up is told.
pub(super) struct Up {
    told: UpArg,
    pub(super) from: UpFrom,
    /// What the IMU says, in the axes of cam0.
    pub(super) imu: Option<Gravity>,
}

/// Largest angle between the up vectors of image and IMU that are both right, degrees.
const AGREEING_DEG: f64 = 10.0;

/// The vertical that the image has near this direction, or if there is none, near its own top or bottom: so that an IMU
/// that is wrong by much is found out.
fn near(eyes: &mut Eyes, up: Bearing) -> Result<Vertical, EyesError> {
    eyes.vertical_near(Hint::Up(up)).or_else(|_| {
        let mut vertical = eyes.vertical_near(Hint::Axis(Bearing::y()))?;
        if vertical.up.dot(&up) < 0.0 {
            vertical.up = -vertical.up;
        }
        Ok(vertical)
    })
}

/// Image and IMU tell different directions: an answer, but "no".
#[derive(Debug, Error)]
#[error(
    "image and IMU disagree on up by {0:.1} degrees: is the IMU at rest, and its calibration that of this rig?"
)]
pub struct Disagreement(f64);

impl Up {
    pub(super) const fn is_given(&self) -> bool {
        self.told.up.is_some()
    }

    /// The up vector in cam0: that given, that of the IMU, or that of the frames whose segments were just detected.
    pub(super) fn resolve(&self, eyes: &mut Eyes, frames: [Option<&Frame>; 2]) -> Result<Bearing> {
        if self.is_given() {
            return self.told.resolve(eyes, frames);
        }
        let mut vertical = || self.vertical(eyes, frames);
        match (self.from, self.imu) {
            (UpFrom::Imu, Some(gravity)) => Ok(gravity.up.cast()),
            (UpFrom::Both, Some(gravity)) => match vertical() {
                Ok(vertical) => self.check(&vertical).map(|()| vertical.up),
                // Where nothing upright is in view, gravity still is.
                Err(EyesError::NoVertical) => Ok(gravity.up.cast()),
                Err(error) => Err(error.into()),
            },
            _ => Ok(vertical()?.up),
        }
    }

    /// What the image says, near where the IMU does if it is asked.
    pub(super) fn vertical(
        &self,
        eyes: &mut Eyes,
        frames: [Option<&Frame>; 2],
    ) -> Result<Vertical, EyesError> {
        match (self.from, self.imu) {
            (UpFrom::Imu | UpFrom::Both, Some(gravity)) => near(eyes, gravity.up.cast()),
            _ => self.told.vertical(eyes, frames),
        }
    }

    /// Degrees between what image and IMU say.
    pub(super) fn apart_deg(&self, vertical: &Vertical) -> Option<f64> {
        let imu = self.imu?.up;
        let image = vertical.up.cast::<f64>().normalize();
        Some(imu.cross(&image).norm().atan2(imu.dot(&image)).to_degrees())
    }

    /// Refuses an up vector that image and IMU disagree on.
    pub(super) fn check(&self, vertical: &Vertical) -> Result<()> {
        let apart =
            self.apart_deg(vertical).filter(|apart| self.from == UpFrom::Both && *apart > AGREEING_DEG);
        apart.map_or(Ok(()), |apart| Err(Disagreement(apart).into()))
    }
}

/// Frames, and the eyes for them.
pub(super) struct Cameras {
    pub(super) frames: [Option<Frame>; 2],
    pub(super) eyes: Eyes,
    pub(super) up: Up,
    /// Height of cam0 above the floor in metres, where it is known.
    pub(super) height_m: Option<f32>,
    /// The files of the frames, for messages.
    pub(super) name: String,
}

impl CameraArgs {
    /// Whether any of its files is named.
    pub(super) fn is_given(&self) -> bool {
        [&self.calib, &self.cam0, &self.cam1].iter().any(|path| path.is_some())
    }

    /// Reads the calibration and the frames.
    pub(super) fn load(&self) -> Result<Cameras> {
        let paths = [&self.cam0, &self.cam1];
        if paths.iter().all(|path| path.is_none()) {
            bail!("no frame: name one with --cam0 IMAGE, --cam1 IMAGE or both");
        }
        let Some(calib) = &self.calib else { bail!("no calibration: name one with --calib FILE") };
        let calibration = Calibration::load(calib)?;
        let [cam0, cam1] = paths.map(|path| path.as_ref().map(|path| Frame::read(path)).transpose());
        let frames = [cam0?, cam1?];
        let rig = calibration.rig(frames.each_ref().map(|f| f.as_ref().map(|f| (f.width(), f.height()))))?;
        let files: Vec<_> = paths.into_iter().flatten().map(|path| path.display().to_string()).collect();
        let up = Up { told: self.up.clone(), from: self.imu.source()?, imu: self.imu.load(&calibration)? };
        let height_m = self.camera_height;
        Ok(Cameras { frames, eyes: Eyes::new(rig), up, height_m, name: files.join(", ") })
    }
}

/// A height of the camera within what can be told apart.
pub(super) fn height(text: &str) -> Result<f32, String> {
    let [least, most] = HEIGHTS_M;
    let metres = finite(text)? as f32;
    let good = (least..=most).contains(&metres);
    if good { Ok(metres) } else { Err(format!("expected {least} to {most} metres")) }
}

/// Three finite numbers that are not all zero, `X,Y,Z`.
pub(super) fn vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<_> = text.split(',').map(|part| finite(part.trim())).collect();
    match parts[..] {
        [Ok(x), Ok(y), Ok(z)] if x.hypot(y).hypot(z) > 1e-6 => Ok([x, y, z]),
        _ => Err(format!("'{text}' is not a vector X,Y,Z")),
    }
}
