//! Why there is no pose.

use crate::pose::MAX_POOL;
use crate::pose::locate::MAX_REFINED;
use core::fmt;

/// Why the pipeline refuses what it was given, or cannot tell which way is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// The memory is too small for frames and settings.
    Memory {
        /// Bytes that it lacks.
        missing_bytes: usize,
    },
    /// A setting is out of its range.
    Setting {
        /// Which.
        field: Field,
        /// Least and most that it may be.
        range: [usize; 2],
    },
    /// The images of a camera are too large.
    Side {
        /// Number of the camera.
        camera: u8,
        /// Largest width and height, pixels.
        most: u32,
    },
    /// The site has more layers than the locator holds.
    Layers {
        /// As many as it holds.
        most: usize,
    },
    /// A frame is missing, or is of a camera that the rig does not have.
    Camera {
        /// Number of the camera.
        camera: u8,
        /// Whether the rig has the camera, and its frame is missing.
        missing: bool,
    },
    /// A frame is not of the size that the rig says.
    Size {
        /// Number of the camera.
        camera: u8,
        /// Width and height that the rig says, pixels.
        expected: [u32; 2],
        /// Width and height of the frame, pixels.
        found: [u32; 2],
    },
    /// The exclusion mask of a frame is not of the frame's size.
    Mask {
        /// Number of the camera.
        camera: u8,
        /// Width and height of the frame, pixels.
        expected: [u32; 2],
        /// Width and height of the mask, pixels.
        found: [u32; 2],
    },
    /// Fewer segments than needed point to one vertical vanishing point.
    Up,
    /// The up vector lies along the optical axis of camera 0, which leaves no heading, or is no vector.
    Axis,
}

/// A field of [`Settings`](super::Settings), or of its [`Effort`](crate::pose::locate::Effort), that has a range.
// No string in the error: on a board its `Debug` would add 5 KB of code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[expect(missing_docs, reason = "the names of the fields")]
pub enum Field {
    Segments,
    VerticalSegments,
    Boxes,
    Windows,
    Pool,
    InlierToleranceDeg,
    RefinedPoses,
    RefinedFully,
    Rays,
}

impl Field {
    /// Least and most that it may be; the inlier tolerance at least 0.1 degrees.
    #[must_use]
    pub const fn range(self) -> [usize; 2] {
        match self {
            // Products with the sizes of elements fit 32 bits.
            Self::Segments | Self::VerticalSegments | Self::Boxes | Self::Windows => [1, 65_536],
            // With fewer poses the second best, which makes a probability honest, may be missing.
            Self::Pool => [64, MAX_POOL],
            Self::RefinedPoses => [8, MAX_REFINED],
            Self::RefinedFully => [1, MAX_REFINED],
            Self::InlierToleranceDeg => [0, 45],
            // At least 10 of 360 rays are left.
            Self::Rays => [4, 36],
        }
    }

    /// The name of the field.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Segments => "segments",
            Self::VerticalSegments => "vertical_segments",
            Self::Boxes => "boxes",
            Self::Windows => "windows",
            Self::Pool => "pool",
            Self::InlierToleranceDeg => "inlier_tolerance_deg",
            Self::RefinedPoses => "refined_poses",
            Self::RefinedFully => "refined_fully",
            Self::Rays => "rays",
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Memory { missing_bytes } => {
                write!(f, "memory is too small for the frames: {missing_bytes} bytes are missing")
            }
            Self::Setting { field, range: [least, most] } => {
                write!(f, "the setting `{}` is not between {least} and {most}", field.name())
            }
            Self::Side { camera, most } => {
                write!(f, "the images of cam{camera} are wider or higher than {most} pixels")
            }
            Self::Layers { most } => write!(f, "the site has more than {most} layers"),
            Self::Camera { camera, missing: true } => write!(f, "the frame of cam{camera} is missing"),
            Self::Camera { camera, missing: false } => {
                write!(f, "there is a frame of cam{camera}, which the rig does not have")
            }
            Self::Size { camera, expected: [width, height], found: [x, y] } => {
                write!(f, "the frame of cam{camera} has {x} x {y} pixels, the rig says {width} x {height}")
            }
            Self::Mask { camera, expected: [width, height], found: [x, y] } => {
                write!(f, "the mask of cam{camera} has {x} x {y} pixels, its frame {width} x {height}")
            }
            Self::Up => f.write_str("too few vertical lines to tell which way is up"),
            Self::Axis => f.write_str(
                "the up vector lies along the optical axis of cam0, or is no vector: it leaves no heading",
            ),
        }
    }
}

impl core::error::Error for Error {}
