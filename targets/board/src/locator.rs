//! The steps from frames to a pose, in their order.

use crate::scratch::{self, Search};
use compass_core::vision::attitude::{Arc, UpHint, Parameters, Vertical, vertical};
use compass_core::vision::boundary::{BoundaryEvidence, BoundaryFinder};
use compass_core::vision::camera::{Rig, View};
use compass_core::pose::{ScoredPose, FloorLayer};
use compass_core::pose::locate::{self, Effort, Fix, HeightPrior, Work};
use compass_core::base::num::{BINS, Metres, Nats, Point, Turn};
use compass_core::base::raster::GrayImage;
use compass_core::vision::segments::{Segment, detect};
use compass_core::map::site::Site;
use compass_core::pose::track::{self, Estimate, Motion, Track};
use compass_core::vision::windows::{WindowFinder, WindowEvidence, Window, segment_parameters};
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::panorama::Resolution;
use core::fmt;

/// Most windows around.
const WINDOWS: usize = 64;
/// Modes that the search keeps.
const POOL: usize = 64;
/// Segments of coarse frames point to the vertical within so many degrees.
const COARSE_TOLERANCE_DEG: f32 = 3.0;
/// A mode of which every byte is zero, so that a static [`Locator`] takes no flash.
const BLANK: ScoredPose =
    ScoredPose { layer: 0, at: Point::new(Metres::ZERO, Metres::ZERO), heading: Turn::ZERO, score: Nats::ZERO };

/// What one camera saw.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Gray levels, of the size that the rig's view says.
    pub gray: GrayImage<'a>,
    /// Where it is red: safety gear in the way of a window.
    pub red: ExclusionMask<'a>,
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A camera of the rig has no frame, or there is a frame of a camera that the rig does not have.
    Camera,
    /// A frame is not of the size that the rig says.
    Size,
    /// The scratch is shorter than [`words`](crate::words) for the frames and their ring.
    Memory,
    /// No direction is up: too few upright lines were seen.
    Up,
    /// The step before was not done.
    Order,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "frames are not those of the rig's cameras",
            Self::Size => "frame size is not the one that the rig says",
            Self::Memory => "memory is too small for the frames",
            Self::Up => "too few upright lines to tell which way is up",
            Self::Order => "the step before was not done",
        })
    }
}

impl core::error::Error for Error {}

/// How far a pair of frames has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Done {
    Nothing,
    Segments,
    LevelFrame,
    Windows,
    RangeLikelihoods,
}

/// Finds poses in pairs of frames: `M` is `[u32; words(WIDTH, HEIGHT, RING)]`, or such a slice lent.
///
/// [`see`](Self::see) and then [`locate`](Self::locate) do all; the steps of which seeing consists are there for those
/// who measure each. Of a frame with more than `SEGMENTS` line segments the first count. Every byte of a new one but the
/// scratch is zero.
#[derive(Debug)]
pub struct Locator<M, const SEGMENTS: usize = 512> {
    done: Done,
    segments: [[Segment; SEGMENTS]; 2],
    counts: [Option<usize>; 2],
    arcs: [[Arc; SEGMENTS]; 2],
    vertical: Option<Vertical>,
    windows: [Window; WINDOWS],
    sighting: WindowEvidence,
    /// Bins of which floor or ceiling was seen.
    known: [bool; BINS],
    pool: [ScoredPose; POOL],
    scratch: M,
}

impl<M, const SEGMENTS: usize> Locator<M, SEGMENTS> {
    /// With scratch memory; what it holds does not matter.
    #[must_use]
    pub const fn new(scratch: M) -> Self {
        Self {
            done: Done::Nothing,
            segments: [[Segment::EMPTY; SEGMENTS]; 2],
            counts: [None; 2],
            arcs: [[Arc::EMPTY; SEGMENTS]; 2],
            vertical: None,
            windows: [Window::EMPTY; WINDOWS],
            sighting: WindowEvidence::NOTHING,
            known: [false; BINS],
            pool: [BLANK; POOL],
            scratch,
        }
    }

    /// The scratch, for whoever has it only after the rest is in its place.
    pub const fn scratch_mut(&mut self) -> &mut M {
        &mut self.scratch
    }

    /// Line segments of a camera's frame.
    #[must_use]
    pub fn segments(&self, camera: usize) -> &[Segment] {
        detected(&self.segments, &self.counts, camera).unwrap_or_default()
    }

    /// Which way is up, once that is known.
    #[must_use]
    pub const fn vertical(&self) -> Option<&Vertical> {
        self.vertical.as_ref()
    }

    /// The windows around, and window or wall in every direction, once they are known.
    #[must_use]
    pub fn sighting(&self) -> Option<(&[Window], &WindowEvidence)> {
        self.reached(Done::Windows).ok()?;
        Some((self.windows.get(..self.sighting.count)?, &self.sighting))
    }

    fn reached(&self, step: Done) -> Result<(), Error> {
        if self.done >= step { Ok(()) } else { Err(Error::Order) }
    }
}

impl<M: AsMut<[u32]> + AsRef<[u32]>, const SEGMENTS: usize> Locator<M, SEGMENTS> {
    /// All that is seen in a pair of frames; `up` tells roughly how the rig is held.
    ///
    /// # Errors
    /// [`Error`], but not [`Error::Order`].
    pub fn see(&mut self, rig: &Rig, frames: &[Option<Frame<'_>>; 2], up: UpHint) -> Result<(), Error> {
        for (camera, frame) in frames.iter().enumerate() {
            match (rig.view(camera), frame) {
                (Some(_), Some(frame)) => self.detect(rig, camera, frame)?,
                (None, None) => {}
                _ => return Err(Error::Camera),
            }
        }
        self.level(rig, up)?;
        self.look(rig, frames)?;
        self.survey(rig, frames)
    }

    /// The line segments of one frame: the first step, for each camera of the rig.
    ///
    /// # Errors
    /// [`Error`], but not [`Error::Up`] and [`Error::Order`].
    pub fn detect(&mut self, rig: &Rig, camera: usize, frame: &Frame<'_>) -> Result<(), Error> {
        if self.done > Done::Segments {
            self.counts = [None; 2];
        }
        self.done = Done::Segments;
        let view = rig.view(camera).ok_or(Error::Camera)?;
        check(view, frame)?;
        let (Some(found), Some(count)) = (self.segments.get_mut(camera), self.counts.get_mut(camera)) else {
            return Err(Error::Camera);
        };
        let (width, height) = (frame.gray.width(), frame.gray.height());
        let mut workspace = scratch::detector(self.scratch.as_mut(), width, height).ok_or(Error::Memory)?;
        let detected = detect(&frame.gray, None, &segment_parameters(view), &mut workspace, found);
        *count = Some(detected.map_err(|_| Error::Memory)?.count);
        Ok(())
    }

    /// The up vector, from the segments of all cameras.
    ///
    /// # Errors
    /// [`Error::Order`] if the segments of a camera are missing; [`Error::Up`].
    pub fn level(&mut self, rig: &Rig, up: UpHint) -> Result<(), Error> {
        self.reached(Done::Segments)?;
        self.done = Done::Segments;
        let mut slots = self.arcs.as_flattened_mut().iter_mut();
        let mut count = 0;
        for (camera, view) in rig.views() {
            let segments = detected(&self.segments, &self.counts, camera).ok_or(Error::Order)?;
            let arcs = segments.iter().filter_map(|s| Arc::new(s, view, camera as u8));
            for (arc, slot) in arcs.zip(&mut slots) {
                *slot = arc;
                count += 1;
            }
        }
        let arcs = self.arcs.as_flattened().get(..count).unwrap_or_default();
        let mut parameters = Parameters::default();
        if resolution(rig) == Resolution::COARSE {
            parameters.tolerance_deg = COARSE_TOLERANCE_DEG;
        }
        self.vertical = vertical(arcs, up, &parameters);
        self.frame()?;
        self.done = Done::LevelFrame;
        Ok(())
    }

    /// The windows around.
    ///
    /// # Errors
    /// [`Error::Order`] before [`level`](Self::level); [`Error::Camera`], [`Error::Memory`].
    pub fn look(&mut self, rig: &Rig, frames: &[Option<Frame<'_>>; 2]) -> Result<(), Error> {
        self.reached(Done::LevelFrame)?;
        self.done = Done::LevelFrame;
        let level = self.frame()?;
        let ring = resolution(rig);
        let buffers = scratch::ring(self.scratch.as_mut(), ring).ok_or(Error::Memory)?;
        let mut finder = WindowFinder::new(buffers, ring, rig, level).ok_or(Error::Memory)?;
        for (camera, view) in rig.views() {
            let frame = frame_of(frames, camera, view)?;
            let segments = detected(&self.segments, &self.counts, camera).ok_or(Error::Order)?;
            finder.add(camera, &frame.gray, frame.red, segments);
        }
        self.sighting = finder.finish(&mut self.windows);
        self.done = Done::Windows;
        Ok(())
    }

    /// How far the walls are.
    ///
    /// # Errors
    /// [`Error::Order`] before [`look`](Self::look); [`Error::Camera`], [`Error::Memory`].
    pub fn survey(&mut self, rig: &Rig, frames: &[Option<Frame<'_>>; 2]) -> Result<(), Error> {
        self.reached(Done::Windows)?;
        self.done = Done::Windows;
        let level = self.frame()?;
        let buffers = scratch::raster(self.scratch.as_mut()).ok_or(Error::Memory)?;
        let mut surveyor = BoundaryFinder::new(buffers, rig, level).ok_or(Error::Memory)?;
        for (camera, view) in rig.views() {
            let frame = frame_of(frames, camera, view)?;
            surveyor.add(camera, &frame.gray, frame.red);
        }
        self.known = *surveyor.finish().known();
        self.done = Done::RangeLikelihoods;
        Ok(())
    }

    /// What was seen of floor and ceiling, once that is known.
    #[must_use]
    pub fn evidence(&self) -> Option<BoundaryEvidence<'_>> {
        self.reached(Done::RangeLikelihoods).ok()?;
        BoundaryEvidence::new(scratch::support(self.scratch.as_ref())?, self.known)
    }

    /// The pose that explains best what was seen.
    ///
    /// # Errors
    /// [`Error::Order`] if nothing was [seen](Self::see); [`Error::Memory`].
    pub fn locate(&mut self, layers: &[FloorLayer<'_>], room: HeightPrior, effort: Effort) -> Result<Fix, Error> {
        self.reached(Done::RangeLikelihoods)?;
        let Search { support, ranges, table, rows } =
            Search::new(self.scratch.as_mut()).ok_or(Error::Memory)?;
        let survey = BoundaryEvidence::new(support, self.known).ok_or(Error::Memory)?;
        let mut work = Work { ranges, table, rows, pool: &mut self.pool, effort };
        Ok(locate::locate(&survey, room, &self.sighting, layers, &mut work))
    }

    /// Takes what was seen and the [pose](Self::locate) found in it into a belief over the sequence of frames; `seconds`
    /// and `motion` are those since the frames before.
    ///
    /// # Errors
    /// [`Error::Order`] if nothing was [seen](Self::see); [`Error::Memory`].
    pub fn track(
        &mut self,
        track: &mut Track,
        layers: &[FloorLayer<'_>],
        fix: &Fix,
        seconds: f32,
        motion: Option<Motion>,
    ) -> Result<Option<Estimate>, Error> {
        self.reached(Done::RangeLikelihoods)?;
        let Search { support, ranges, table, .. } =
            Search::new(self.scratch.as_mut()).ok_or(Error::Memory)?;
        let survey = BoundaryEvidence::new(support, self.known).ok_or(Error::Memory)?;
        survey.ranges(fix.ceiling, ranges);
        compass_core::pose::evidence::weigh(ranges, fix.height, &self.sighting, table);
        let modes = fix.answer.modes();
        Ok(track.step(layers, &track::Frame { table, modes, seconds, motion }))
    }

    /// The level frame; the optical axis of camera 0 must not be upright.
    fn frame(&self) -> Result<LevelFrame, Error> {
        self.vertical.and_then(|vertical| LevelFrame::new(&vertical.up)).ok_or(Error::Up)
    }
}

/// The segments of a camera's frame; `None` before they were sought.
fn detected<'a, const SEGMENTS: usize>(
    segments: &'a [[Segment; SEGMENTS]; 2],
    counts: &[Option<usize>; 2],
    camera: usize,
) -> Option<&'a [Segment]> {
    let count = counts.get(camera).copied().flatten()?;
    segments.get(camera)?.get(..count)
}

/// The frame of a camera.
fn frame_of<'f, 'a>(
    frames: &'f [Option<Frame<'a>>; 2],
    camera: usize,
    view: &View,
) -> Result<&'f Frame<'a>, Error> {
    let frame = frames.get(camera).and_then(Option::as_ref).ok_or(Error::Camera)?;
    check(view, frame)?;
    Ok(frame)
}

/// Whether a frame is what its view says.
fn check(view: &View, frame: &Frame<'_>) -> Result<(), Error> {
    let size = [frame.gray.width(), frame.gray.height()];
    if size == [view.width, view.height].map(u32::from) { Ok(()) } else { Err(Error::Size) }
}

/// That of the ring: what the coarsest camera holds.
fn resolution(rig: &Rig) -> Resolution {
    let coarse = rig.views().any(|(_, view)| Resolution::of(view) == Resolution::COARSE);
    if coarse { Resolution::COARSE } else { Resolution::FINE }
}

/// All layers of all floors of a site, in the order that [`ScoredPose::layer`] counts them.
pub fn layers<'a>(site: &Site<'a>) -> impl Iterator<Item = FloorLayer<'a>> + use<'a> {
    let floors = site.floors().enumerate();
    floors.flat_map(|(number, floor)| {
        let layers = (0..floor.layers()).zip(core::iter::repeat(floor));
        layers.filter_map(move |(layer, floor)| {
            let plan = floor.plan(layer)?;
            Some(FloorLayer { map: *floor.map(), number: layer as u8, plan, floor: number as u8 })
        })
    })
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::words;
    use compass_core::vision::camera::{Bearing, Camera, Intrinsics, KannalaBrandt};
    use std::vec;

    type Small<'a> = Locator<&'a mut [u32]>;

    const UP: UpHint = UpHint::Up(Bearing::new(0.0, -1.0, 0.0));

    /// One camera of 64 x 48 pixels.
    fn rig() -> Rig {
        let lens = KannalaBrandt::new(Intrinsics { fx: 30.0, fy: 30.0, cx: 32.0, cy: 24.0 }, [0.0; 4]);
        Rig::new([Some(View::new(Camera::KannalaBrandt(lens.unwrap()), 64, 48)), None]).unwrap()
    }

    fn frame(pixels: &[u8], height: u32) -> Option<Frame<'_>> {
        Some(Frame { gray: GrayImage::new(pixels, 64, height).unwrap(), red: ExclusionMask::Unknown })
    }

    #[test]
    fn frames_of_368_by_360_take_less_than_512_kib() {
        let bytes = size_of::<Locator<[u32; words(368, 360, Resolution::COARSE)]>>();
        // Beside it a track and the stack, of which no step takes more than 16 KiB.
        assert!(bytes + size_of::<Track>() + (16 << 10) < 480 << 10, "{bytes}");
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let pixels = [90; 64 * 48];
        let mut scratch = vec![0; words(64, 48, Resolution::COARSE)];
        let mut small = Small::new(&mut scratch);
        let mut see = |frames| small.see(&rig(), &frames, UP);
        assert_eq!(see([None, None]), Err(Error::Camera));
        assert_eq!(see([frame(&pixels, 48), frame(&pixels, 48)]), Err(Error::Camera));
        assert_eq!(see([frame(&pixels, 40), None]), Err(Error::Size));
        assert_eq!(see([frame(&pixels, 48), None]), Err(Error::Up), "gray alone has no lines");
        let mut short = Small::new(&mut scratch[..1000]);
        assert_eq!(short.see(&rig(), &[frame(&pixels, 48), None], UP), Err(Error::Memory));
    }

    #[test]
    fn steps_have_an_order() {
        let pixels = [90; 64 * 48];
        let mut scratch = vec![0; words(64, 48, Resolution::COARSE)];
        let mut small = Small::new(&mut scratch);
        let frames = [frame(&pixels, 48), None];
        assert_eq!(small.level(&rig(), UP), Err(Error::Order));
        small.detect(&rig(), 0, &frames[0].unwrap()).unwrap();
        assert_eq!(small.look(&rig(), &frames), Err(Error::Order));
        assert_eq!(small.survey(&rig(), &frames), Err(Error::Order));
        assert!(small.sighting().is_none() && small.evidence().is_none());
        let fix = small.locate(&[], HeightPrior::default(), Effort::LITTLE);
        assert_eq!(fix.err(), Some(Error::Order));
    }
}
