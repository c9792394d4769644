//! The pipeline of `compass-core` with memory on the heap, the widest SIMD of the machine, and a timer per stage.

use crate::clock::Moment;
use crate::frame::Frame;
use crate::site_file::SiteFloor;
use crate::wide::wide;
use compass_core::locator::{self, Frames, LAYERS_OF_A_SITE, Picture, Stage, Trace};
use compass_core::pose::FloorLayer;
use compass_core::vision::attitude::LEAST_INLIERS;
use compass_core::vision::boundary::BoundaryEvidence;
use compass_core::vision::camera::{Bearing, Rig};
use compass_core::vision::panorama::Resolution;
use compass_core::vision::windows::{Edge, WindowBox, WindowEvidence, visit_edges};
use compass_core::{LocateError, Settings};
use std::collections::BTreeMap;
use thiserror::Error;

/// Why the stages before the search failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SeeError {
    /// The up vector defines no heading: it is parallel to the optical axis, zero or not finite.
    #[error("the up vector lies along the optical axis of cam0, or is no vector: it leaves no heading")]
    Up,
    /// Too few segments point to one vertical vanishing point.
    #[error(
        "cannot tell which way is up: fewer than {LEAST_INLIERS} segments point to one vertical vanishing point; give it with --up"
    )]
    NoVertical,
    /// The windows do not decide which of the two vertical directions is up.
    #[error(
        "cannot tell up from down: no windows, or no sky in them; give --mount upright or inverted, or --up"
    )]
    NoSky,
    /// The up vectors from the image and from the IMU disagree.
    #[error(
        "image and IMU disagree on up by {0:.1} degrees: is the IMU at rest, and its calibration that of this rig?"
    )]
    Disagreement(f64),
    /// The frames do not match the cameras of the rig.
    #[error(transparent)]
    Frames(LocateError),
}

impl SeeError {
    /// Whether it is an answer, "the frames do not tell", rather than bad input.
    #[must_use]
    pub const fn is_answer(&self) -> bool {
        matches!(self, Self::Disagreement(_) | Self::NoVertical | Self::NoSky)
    }
}

impl From<LocateError> for SeeError {
    fn from(error: LocateError) -> Self {
        match error {
            LocateError::Up => Self::NoVertical,
            LocateError::Axis => Self::Up,
            other => Self::Frames(other),
        }
    }
}

/// A floor of a site has no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("has no plan to refine poses on; build it anew with compass map build")]
pub struct NoPlan;

type Inner<'a> = locator::Locator<'a, Vec<u32>, Watch, LAYERS_OF_A_SITE>;
/// Frames whose line segments were found.
pub type Segmented<'l, 'f, 'a> = locator::Segmented<'l, 'f, Inner<'a>>;
/// Frames whose up vector is known.
pub type Levelled<'l, 'f, 'a> = locator::Levelled<'l, 'f, Inner<'a>>;
/// Frames with their windows, boundaries and hit types.
pub type Seen<'l, 'a> = locator::Seen<'l, Inner<'a>>;

/// Finds the poses of a rig on a site: constructed once, then used for every pair of frames without allocating.
#[derive(Debug)]
pub struct Locator<'a>(Inner<'a>);

impl<'a> Locator<'a> {
    /// A locator for the cameras of a rig on these floors.
    ///
    /// # Errors
    /// [`NoPlan`] if a floor has no plan to refine poses on, as plain site maps have none.
    ///
    /// # Panics
    /// Never: the memory is sized for the rig, and the layers of a site fit.
    pub fn new(floors: &[SiteFloor<'a>], rig: Rig, settings: Settings) -> Result<Self, NoPlan> {
        let mut locator = Self::without_site(rig, settings);
        locator.add(floors)?;
        Ok(locator)
    }

    /// A locator for the cameras of a rig that only observes, without a site to search.
    ///
    /// # Panics
    /// Never: the memory is sized for the rig.
    #[must_use]
    pub fn without_site(rig: Rig, settings: Settings) -> Self {
        let memory = vec![0; settings.memory_words_of(&rig)];
        let inner = locator::Locator::without_site(rig, settings, memory).expect("the memory is made for it");
        Self(inner.with_trace(Watch::default()))
    }

    /// A locator that searches stored evidence on these floors, without cameras.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Panics
    /// Never: the memory is sized for the settings, and the layers of a site fit.
    pub fn without_rig(floors: &[SiteFloor<'a>], settings: Settings) -> Result<Self, NoPlan> {
        let memory = vec![0; settings.memory_words(0, 0)];
        let inner = locator::Locator::without_rig(settings, memory).expect("the memory is made for it");
        let mut locator = Self(inner.with_trace(Watch::default()));
        locator.add(floors)?;
        Ok(locator)
    }

    fn add(&mut self, floors: &[SiteFloor<'a>]) -> Result<(), NoPlan> {
        for floor in floors {
            let floor = floor.floor.ok_or(NoPlan)?;
            self.0.add_layers(&floor).expect("a site has no more layers than that");
        }
        Ok(())
    }

    /// The cameras.
    #[must_use]
    pub const fn rig(&self) -> &Rig {
        self.0.rig()
    }

    /// Size of the panorama's cells.
    #[must_use]
    pub const fn resolution(&self) -> Resolution {
        self.0.resolution()
    }

    /// Largest angle between a segment and the vertical that it points to, degrees.
    #[must_use]
    pub fn inlier_tolerance_deg(&self) -> f32 {
        self.0.inlier_tolerance_deg()
    }

    /// The layers in the order that [`ScoredPose::layer`](compass_core::ScoredPose::layer) counts them.
    #[must_use]
    pub fn layers(&self) -> &[FloorLayer<'a>] {
        self.0.layers()
    }

    /// Stage times, and the window candidates if they are kept.
    pub const fn watch(&mut self) -> &mut Watch {
        self.0.trace_mut()
    }

    /// Finds the segments of the frames of cam0 and cam1; exactly the cameras of the rig must have a frame.
    ///
    /// # Errors
    /// [`SeeError::Frames`].
    pub fn segment<'l, 'f>(
        &'l mut self,
        frames: [Option<&'f Frame>; 2],
    ) -> Result<Segmented<'l, 'f, 'a>, SeeError> {
        Ok(segment(&mut self.0, &frames.map(|frame| frame.map(lent)))?)
    }

    /// [`segment`](Self::segment) for borrowed frames, as in packed ones.
    ///
    /// # Errors
    /// [`SeeError::Frames`].
    pub fn segment_borrowed<'l, 'f>(
        &'l mut self,
        frames: &Frames<'f>,
    ) -> Result<Segmented<'l, 'f, 'a>, SeeError> {
        Ok(segment(&mut self.0, frames)?)
    }

    /// The stage after observation, restored from stored evidence.
    pub fn recall<'l>(
        &'l mut self,
        boundaries: &BoundaryEvidence<'_>,
        windows: &WindowEvidence,
    ) -> Seen<'l, 'a> {
        self.0.recall(boundaries, windows)
    }
}

/// The frame as the core takes it.
fn lent(frame: &Frame) -> locator::Frame<'_> {
    locator::Frame::from(frame.gray())
}

wide! {
    fn segment<'l, 'f, 'a>(
        locator: &'l mut Inner<'a>,
        frames: &Frames<'f>,
    ) -> Result<Segmented<'l, 'f, 'a>, LocateError> {
        locator.segment(frames)
    }

    /// [`Levelled::see`](locator::Levelled::see) with the widest SIMD of this machine; the result is the same.
    pub fn see<'l, 'f, 'a>(levelled: Levelled<'l, 'f, 'a>) -> Seen<'l, 'a> {
        levelled.see()
    }

    /// [`Segmented::sky_is_above`](locator::Segmented::sky_is_above) likewise.
    pub(crate) fn sky_is_above<'l, 'f, 'a>(
        segmented: &mut Segmented<'l, 'f, 'a>,
        up: &Bearing,
    ) -> Result<Option<bool>, LocateError> {
        segmented.sky_is_above(up)
    }
}

/// Stage times, and on demand the window candidates.
#[derive(Debug, Default)]
pub struct Watch {
    started: Option<Moment>,
    milliseconds: [Option<f64>; STAGES.len()],
    /// Whether to keep the window candidates, to draw them.
    pub keeps_considered: bool,
    considered: Option<Considered>,
}

/// Stage names, in the order of the stages.
const STAGES: [&str; 6] = ["segments", "up", "windows", "ranges", "locate", "track"];

const fn index(stage: Stage) -> usize {
    match stage {
        Stage::Segments(_) => 0,
        Stage::Up => 1,
        Stage::Windows => 2,
        Stage::Boundaries => 3,
        Stage::Locate => 4,
        Stage::Track => 5,
    }
}

/// The candidates from which the windows of a pair of frames were selected.
#[derive(Debug, Clone)]
pub struct Considered {
    /// Brightness ranks of the panorama, row by row from the top, 0 where a cell is unobserved.
    pub panorama: Vec<u8>,
    /// Size of the panorama's cells.
    pub resolution: Resolution,
    /// Pairs of edges that were scored.
    pub boxes: Vec<WindowBox>,
    /// The edges that bound those boxes, except the ends of the field of view.
    pub edges: Vec<Edge>,
}

impl Watch {
    /// Milliseconds by stage since the last call.
    #[must_use]
    pub fn milliseconds(&mut self) -> BTreeMap<&'static str, f64> {
        let taken = std::mem::take(&mut self.milliseconds);
        STAGES.into_iter().zip(taken).filter_map(|(stage, ms)| Some((stage, ms?))).collect()
    }

    /// The window candidates of the last frames, if they were kept.
    #[must_use]
    pub fn considered(&mut self) -> Option<Considered> {
        self.considered.take()
    }
}

impl Trace for Watch {
    const INLINED: bool = true;

    fn begin(&mut self, _: Stage) {
        self.started = Some(Moment::now());
    }

    fn end(&mut self, stage: Stage, picture: Picture<'_>) {
        let taken = self.started.take().map_or(0.0, Moment::milliseconds);
        *self.milliseconds[index(stage)].get_or_insert(0.0) += taken;
        if let Picture::Windows { panorama, resolution, vertical_segments, boxes, .. } = picture
            && self.keeps_considered
        {
            let (columns, rows) = (resolution.columns(), resolution.rows());
            let mut edges = Vec::new();
            visit_edges(&mut vertical_segments.to_vec(), resolution, |edge| edges.push(*edge));
            self.considered = Some(Considered {
                panorama: (0..columns * rows).map(|i| panorama[i % columns * rows + i / columns]).collect(),
                resolution,
                boxes: boxes.to_vec(),
                edges,
            });
        }
    }
}
