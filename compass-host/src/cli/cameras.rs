//! The options that every command with camera frames shares.

use super::heights::HeightArgs;
use super::notes::note;
use super::plan::{finite, pair};
use super::prior::PlaceArgs;
use super::up::{MountOption, UpFromOption};
use anyhow::{Result, bail};
use compass_core::HeightPrior;
use compass_core::vision::camera::{Bearing, Rig};
use compass_host::calibration::{Calibration, CameraNames};
use compass_host::dataset::imu::{Gravity, Readings};
use compass_host::dual_image;
use compass_host::frame::Frame;
use compass_host::locator::{SeeError, Segmented};
use compass_host::up::{UpFrom, UpSources};
use std::path::PathBuf;

/// A calibration and the frames of one or two cameras.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct CameraArgs {
    /// Camera calibration: a camera chain of Kalibr, .yaml, or what Basalt and ROS write
    #[arg(long, value_name = "FILE")]
    calib: Option<PathBuf>,
    /// Cameras of the calibration that are cam0 and cam1 [default: cam0,cam1]
    #[arg(long, value_name = "CAM0[,CAM1]")]
    cameras: Option<CameraNames>,
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
    #[command(flatten)]
    heights: HeightArgs,
    #[command(flatten)]
    pub(super) place: PlaceArgs,
}

/// The up vector, if it is given.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct UpArg {
    /// Up vector in the axes of cam0 (x right, y down, z forward) [default: from vertical lines]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    up: Option<[f64; 3]>,
    /// Which side of cam0's image is up, within 45 degrees, where it is not told by --up; a wrong one gives a mirrored
    /// answer
    #[arg(long, value_enum, default_value_t = MountOption::Auto)]
    mount: MountOption,
}

impl UpArg {
    /// The up vector in cam0: the given one, or that of the frames.
    pub(super) fn resolve(&self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Bearing, SeeError> {
        self.with(UpFrom::Image, None).resolve(segmented)
    }

    /// The given up vector, or the sources to determine it from.
    fn with(&self, from: UpFrom, imu: Option<Gravity>) -> Up {
        let given = self.up.map(|[x, y, z]| Bearing::new(x as f32, y as f32, z as f32));
        Up { given, sources: UpSources { from, mount: self.mount.into(), imu } }
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
    up_from: Option<UpFromOption>,
}

impl ImuArgs {
    fn source(&self) -> Result<UpFrom> {
        match (self.up_from.map(UpFrom::from), &self.imu) {
            (None, None) => Ok(UpFrom::Image),
            (None, Some(_)) => Ok(UpFrom::Both),
            (Some(UpFrom::Imu | UpFrom::Both), None) => {
                bail!("--up-from takes the IMU: name its file with --imu")
            }
            (Some(from), _) => Ok(from),
        }
    }

    /// The up vector from the IMU, in the axes of cam0.
    fn load(&self, calibration: &Calibration) -> Result<Option<Gravity>> {
        let Some(path) = &self.imu else { return Ok(None) };
        let readings = Readings::read(path)?;
        let gravity = readings.gravity(self.imu_seconds)?;
        let Some(gravity) = gravity.in_cam0(calibration) else {
            let (path, name) = (calibration.path.display(), calibration.name(0));
            bail!("{path}: {name}.T_cam_imu: missing (T_imu_cam too), and --imu needs one");
        };
        if let Some(fault) = readings.faults().first().first() {
            note(&format!("{} left out; the first: {}: {}", readings.faults(), fault.place, fault.problem));
        }
        Ok(Some(gravity))
    }
}

/// How to determine the up vector.
pub(super) struct Up {
    given: Option<Bearing>,
    /// The sources used without a given up vector.
    pub(super) sources: UpSources,
}

impl Up {
    pub(super) const fn is_given(&self) -> bool {
        self.given.is_some()
    }

    /// Approximate up vector in cam0, as far as it is known without the image.
    pub(super) fn hint(&self) -> Option<Bearing> {
        self.given.or_else(|| self.sources.hint())
    }

    /// The up vector in cam0: given, from the IMU, or from the frames.
    pub(super) fn resolve(&self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Bearing, SeeError> {
        self.given.map_or_else(|| Ok(self.sources.resolve(segmented)?.0), Ok)
    }

    /// The directions in cam0 that may be up, for the plan of a site to choose from.
    pub(super) fn candidates(&self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Vec<Bearing>, SeeError> {
        let given = self.given.map(|up| vec![up]);
        given.map_or_else(|| Ok(self.sources.candidates(segmented)?.0), Ok)
    }
}

/// The inputs named by the options.
pub(super) struct Taken {
    pub(super) calibration: Calibration,
    pub(super) frames: [Option<Frame>; 2],
    pub(super) up: Up,
    /// What is known of the heights.
    pub(super) heights: HeightPrior,
    /// The files of the frames, for messages.
    pub(super) name: String,
}

impl Taken {
    /// The rig for frames of the given sizes.
    pub(super) fn rig(&self) -> Result<Rig> {
        let sizes = self.frames.each_ref().map(|frame| frame.as_ref().map(|f| (f.width(), f.height())));
        Ok(self.calibration.rig(sizes)?)
    }
}

/// Frames, and the rig that took them.
pub(super) struct Cameras {
    pub(super) frames: [Option<Frame>; 2],
    pub(super) rig: Rig,
    pub(super) up: Up,
    /// What is known of the heights.
    pub(super) heights: HeightPrior,
    /// The files of the frames, for messages.
    pub(super) name: String,
}

impl CameraArgs {
    /// Whether any of its files is named.
    pub(super) fn is_given(&self) -> bool {
        [&self.calib, &self.cam0, &self.cam1].iter().any(|path| path.is_some())
    }

    /// Reads the calibration and the frames.
    pub(super) fn read(&self) -> Result<Taken> {
        let paths = [&self.cam0, &self.cam1];
        if paths.iter().all(|path| path.is_none()) {
            bail!("no frame: name one with --cam0 IMAGE, --cam1 IMAGE or both");
        }
        let Some(calib) = &self.calib else { bail!("no calibration: name one with --calib FILE") };
        let calibration = Calibration::load_cameras(calib, &self.cameras.clone().unwrap_or_default())?;
        let read = |path: &Option<PathBuf>| path.as_ref().map(|path| Frame::read(path)).transpose();
        let (cam0, cam1) = rayon::join(|| read(paths[0]), || read(paths[1]));
        let (frames, halves) = dual_image::split(&calibration, [cam0?, cam1?]);
        let files: Vec<_> = paths.into_iter().flatten().map(|path| path.display().to_string()).collect();
        let up = self.up.with(self.imu.source()?, self.imu.load(&calibration)?);
        let (heights, name) = (self.heights.prior(), files.join(", "));
        if let Some(halves) = halves {
            note(&format!("{name}: {}", halves.note()));
        }
        Ok(Taken { calibration, frames, up, heights, name })
    }

    /// Reads the calibration and the frames, and makes a rig for them.
    pub(super) fn load(&self) -> Result<Cameras> {
        let taken = self.read()?;
        let rig = taken.rig()?;
        let Taken { frames, up, heights, name, .. } = taken;
        Ok(Cameras { frames, rig, up, heights, name })
    }
}

/// Parses three finite numbers that are not all zero, `X,Y,Z`.
pub(super) fn vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<_> = text.split(',').map(|part| finite(part.trim())).collect();
    match parts[..] {
        [Ok(x), Ok(y), Ok(z)] if x.hypot(y).hypot(z) > 1e-6 => Ok([x, y, z]),
        _ => Err(format!("'{text}' is not a vector X,Y,Z")),
    }
}
