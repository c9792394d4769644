//! Watching the stages.

use crate::pose::Fix;
use crate::pose::track::Estimate;
use crate::vision::attitude::Vertical;
use crate::vision::boundary::BoundaryEvidence;
use crate::vision::panorama::Resolution;
use crate::vision::segments::Segment;
use crate::vision::windows::{VerticalSegment, Window, WindowBox, WindowEvidence};

/// A stage of the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Line segments of the frame of this camera.
    Segments(u8),
    /// The up vector.
    Up,
    /// Windows.
    Windows,
    /// Boundaries of floor and ceiling.
    Boundaries,
    /// Search and refinement.
    Locate,
    /// The belief over a sequence.
    Track,
}

impl Stage {
    /// A name of lower-case letters.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Segments(0) => "segments",
            Self::Segments(_) => "segments_back",
            Self::Up => "up",
            Self::Windows => "windows",
            Self::Boundaries => "ranges",
            Self::Locate => "locate",
            Self::Track => "track",
        }
    }
}

/// What a stage found: for pictures, checksums and comparisons.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Picture<'a> {
    /// The segments of a frame.
    Segments(&'a [Segment]),
    /// The up vector, if enough segments point to one.
    Up(Option<&'a Vertical>),
    /// The windows, and what was considered.
    Windows {
        /// The windows, from left to right around the circle.
        windows: &'a [Window],
        /// Window or wall in every direction.
        evidence: &'a WindowEvidence,
        /// Brightness ranks of the panorama, column by column, 0 where nothing is known.
        panorama: &'a [u8],
        /// Size of the panorama's cells.
        resolution: Resolution,
        /// Near-vertical segments.
        vertical_segments: &'a [VerticalSegment],
        /// Pairs of edges that were scored as windows.
        boxes: &'a [WindowBox],
    },
    /// Boundaries of floor and ceiling.
    Boundaries(&'a BoundaryEvidence<'a>),
    /// The pose, its alternatives and the heights.
    Fix(&'a Fix<'a>),
    /// Where the sequence has come to.
    Estimate(Option<&'a Estimate>),
}

/// Sees when stages begin and end, and what they find. The default is to do nothing: `()`.
pub trait Trace {
    /// Whether the loops over pixels are compiled into the functions that call [`Locator::segment`](super::Locator::segment)
    /// and [`Levelled::see`](super::Levelled::see): a caller compiled for wider vectors then has them wider. Takes more code
    /// and stack.
    const INLINED: bool = false;

    /// A stage begins.
    #[inline(always)]
    fn begin(&mut self, stage: Stage) {
        let _ = stage;
    }

    /// A stage has ended, with what it found.
    #[inline(always)]
    fn end(&mut self, stage: Stage, picture: Picture<'_>) {
        let _ = (stage, picture);
    }
}

impl Trace for () {}

impl<T: Trace> Trace for &mut T {
    const INLINED: bool = T::INLINED;

    fn begin(&mut self, stage: Stage) {
        (**self).begin(stage);
    }

    fn end(&mut self, stage: Stage, picture: Picture<'_>) {
        (**self).end(stage, picture);
    }
}
