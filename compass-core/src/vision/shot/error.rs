//! Errors of reading and writing a shot.

use crate::base::ladder::HEIGHTS_M;
use crate::vision::camera::CameraError;
use core::fmt;

/// Version of the format.
pub(super) const VERSION: u32 = 1;

/// Error of reading or writing a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ShotError {
    /// The bytes do not start with the magic of a shot.
    Magic,
    /// The format version is this one, not the supported one.
    Version(u32),
    /// The checksum of the header does not match it.
    HeaderChecksum,
    /// The up vector is 0 or not finite.
    Up,
    /// The height of the camera is outside [`HEIGHTS_M`].
    Height,
    /// The number of a camera's lens model is unknown.
    Lens(u32),
    /// The model of this camera's lens has more parameters than the format holds.
    LensParameters(usize),
    /// A lens or the rig is invalid.
    Camera(CameraError),
    /// An image is missing, differs in size from its view, or belongs to a camera that the rig lacks.
    Image,
    /// The number of bytes differs from that of the header.
    Length,
    /// The checksum of the whole shot does not match.
    Checksum,
}

impl fmt::Display for ShotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("shot magic is missing: not a file of packed frames"),
            Self::Version(v) => write!(f, "shot version is {v}, this program reads {VERSION}"),
            Self::HeaderChecksum => f.write_str("shot header checksum does not match: the header is damaged"),
            Self::Up => f.write_str("shot up vector is 0 or not finite"),
            Self::Height => {
                let [least, most] = HEIGHTS_M;
                write!(f, "shot camera height is outside {least} to {most} m")
            }
            Self::Lens(number) => write!(f, "shot lens number {number} is unknown"),
            Self::LensParameters(camera) => {
                write!(f, "the lens of camera {camera} has more parameters than packed frames can hold")
            }
            Self::Camera(error) => error.fmt(f),
            Self::Image => f.write_str("shot images do not match the rig's cameras"),
            Self::Length => f.write_str(
                "shot length does not match its header: the file is truncated or has trailing bytes",
            ),
            Self::Checksum => f.write_str("shot checksum does not match: the file is damaged"),
        }
    }
}

impl core::error::Error for ShotError {}
