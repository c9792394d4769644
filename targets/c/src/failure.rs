//! Why a call was refused.

use crate::status::CompassStatus;
use compass_core::map::plan::MarchError;
use compass_core::{CameraError, LocateError, SiteError};
use core::fmt;

/// Why a call was refused: what `compass_last_error` says.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Failure {
    /// This argument is null.
    Null(&'static str),
    /// This argument is not aligned to its type.
    Alignment(&'static str),
    /// This setting, and its least and largest value.
    Setting(&'static str, u32, u32),
    /// The settings name no preset.
    Preset,
    /// Images of so many pixels cannot be counted on every target.
    Pixels {
        camera: u8,
    },
    Site(SiteError),
    /// There is no camera of this number.
    CameraNumber(u8),
    /// The lens of this camera is of an unknown model.
    Model(u8),
    Camera(u8, CameraError),
    /// The axes of camera 0 are not its own.
    FirstCamera,
    /// Gray levels or mask of this camera's frame have another number of bytes than its size asks for.
    FrameBytes {
        camera: u8,
        part: &'static str,
        expected: usize,
        found: usize,
    },
    Locate(LocateError),
    /// What is wrong with the prior.
    Prior(&'static str),
    /// Which step is missing.
    Order(&'static str),
    /// No window shows which side the sky is on.
    NoSky,
    Nowhere,
    /// What is wrong with seconds or motion.
    Motion(&'static str),
    /// No such floor and layer.
    Floor {
        floor: u8,
        layer: u8,
    },
    March(MarchError),
}

impl Failure {
    /// Its code.
    pub(crate) const fn status(&self) -> CompassStatus {
        match self {
            Self::Null(_) => CompassStatus::Null,
            Self::Alignment(_) => CompassStatus::Alignment,
            Self::Setting(..) | Self::Preset => CompassStatus::Settings,
            Self::Site(_) => CompassStatus::Site,
            Self::Pixels { .. }
            | Self::CameraNumber(_)
            | Self::Model(_)
            | Self::Camera(..)
            | Self::FirstCamera => CompassStatus::Camera,
            Self::FrameBytes { .. } => CompassStatus::Frame,
            Self::Locate(error) => locate_status(error),
            Self::Prior(_) => CompassStatus::Prior,
            Self::Order(_) => CompassStatus::Order,
            Self::NoSky => CompassStatus::Up,
            Self::Nowhere => CompassStatus::Nowhere,
            Self::Motion(_) => CompassStatus::Motion,
            Self::Floor { .. } => CompassStatus::Floor,
            Self::March(MarchError::Occupied) => CompassStatus::Occupied,
            Self::March(_) => CompassStatus::Outside,
        }
    }
}

const fn locate_status(error: &LocateError) -> CompassStatus {
    match error {
        LocateError::Memory { .. } => CompassStatus::Memory,
        LocateError::Setting { .. } => CompassStatus::Settings,
        LocateError::Layers { .. } => CompassStatus::Layers,
        LocateError::Up => CompassStatus::Up,
        LocateError::Axis => CompassStatus::Axis,
        // Camera and size, and errors to come: frames that do not fit.
        _ => CompassStatus::Frame,
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(name) => write!(f, "{name} is null"),
            Self::Alignment(name) => write!(f, "{name} is not aligned to its type"),
            Self::Setting(name, least, most) => write!(f, "setting {name} lies outside {least} to {most}"),
            Self::Preset => f.write_str("the settings name no preset: start from compass_settings"),
            Self::Pixels { camera } => {
                write!(f, "cam{camera}: an image has more than {} pixels", crate::types::COMPASS_MAX_PIXELS)
            }
            Self::Site(error) => error.fmt(f),
            Self::CameraNumber(number) => write!(f, "there is no cam{number}: cameras are 0 and 1"),
            Self::Model(camera) => write!(f, "cam{camera}: the model of the lens is unknown"),
            Self::Camera(camera, error) => write!(f, "cam{camera}: {error}"),
            Self::FirstCamera => f.write_str(
                "cam0: rotation is not the identity, or position is not zero: the axes are its own",
            ),
            Self::FrameBytes { camera, part, expected, found } => {
                write!(f, "the {part} of cam{camera}'s frame has {found} bytes, its size asks for {expected}")
            }
            Self::Locate(error) => error.fmt(f),
            Self::Prior(text) | Self::Order(text) | Self::Motion(text) => f.write_str(text),
            Self::NoSky => f.write_str("no window shows on which side the sky is"),
            Self::Nowhere => f.write_str("no candidate fits what was seen"),
            Self::Floor { floor, layer } => write!(f, "no site has a layer {layer} of floor {floor}"),
            Self::March(error) => error.fmt(f),
        }
    }
}

impl From<LocateError> for Failure {
    fn from(error: LocateError) -> Self {
        Self::Locate(error)
    }
}

impl From<SiteError> for Failure {
    fn from(error: SiteError) -> Self {
        Self::Site(error)
    }
}

impl From<MarchError> for Failure {
    fn from(error: MarchError) -> Self {
        Self::March(error)
    }
}
