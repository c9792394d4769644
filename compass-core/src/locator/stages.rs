//! The stages as types: each is made by the one before it alone.

use super::error::Error;
use super::memory::{Layout, Look};
use super::settings::Smoothing;
use super::trace::{Picture, Stage, Trace};
use super::{Found, Frames, Locator};
use crate::base::raster::{BitMask, GrayImage};
use crate::pose::evidence::{EvidenceTable, HitEvidence, weigh};
use crate::pose::heights::{HeightPrior, Heights};
use crate::pose::locate::{Work, locate};
use crate::pose::track::{Estimate, Motion, Observation, Track};
use crate::pose::{Fix, FloorLayer, PosePrior};
use crate::vision::attitude::{self, Arc, MOST_VERTICALS, UpHint, Vertical, vertical, verticals};
use crate::vision::boundary::{BoundaryEvidence, BoundaryFinder};
use crate::vision::camera::{Bearing, CAMERAS};
use crate::vision::lens_field;
use crate::vision::level_frame::LevelFrame;
use crate::vision::sample::ExclusionMask;
use crate::vision::segments::{self, Segment, detect, smooth};
use crate::vision::windows::{
    Window, WindowEvidence, WindowFinder, segment_parameters, sky_is_above, wants_smoothed,
};
use heapless::Vec;

/// Frames whose line segments were found.
#[derive(Debug)]
pub struct Segmented<'l, 'f, L> {
    locator: &'l mut L,
    frames: Frames<'f>,
}

/// Frames of which it is known which way is up.
#[derive(Debug)]
pub struct Levelled<'l, 'f, L> {
    pub(super) locator: &'l mut L,
    frames: Frames<'f>,
    pub(super) frame: LevelFrame,
    vertical: Option<Vertical>,
}

/// Frames of which is known what they show: windows, and the boundaries of floor and ceiling.
#[derive(Debug)]
pub struct Seen<'l, L> {
    pub(super) locator: &'l mut L,
}

impl<'l, 'f, 'a, M, T, const LAYERS: usize> Segmented<'l, 'f, Locator<'a, M, T, LAYERS>>
where
    M: AsRef<[u32]> + AsMut<[u32]>,
    T: Trace,
{
    #[inline(always)]
    pub(super) fn new(locator: &'l mut Locator<'a, M, T, LAYERS>, frames: Frames<'f>) -> Self {
        locator.found.segments = [0; CAMERAS];
        for (number, camera, frame) in [(0, 0, &frames[0]), (1, 1, &frames[1])] {
            let Some(frame) = frame else { continue };
            locator.trace.begin(Stage::Segments(number));
            if T::INLINED {
                detect_in(locator, camera, &frame.gray);
            } else {
                detect_apart(locator, camera, &frame.gray);
            }
            let (trace, memory) = (&mut locator.trace, locator.memory.as_mut());
            let found = segments_of(&locator.settings.layout(&locator.rig), &locator.found, memory, camera);
            trace.end(Stage::Segments(number), Picture::Segments(found));
        }
        Self { locator, frames }
    }

    /// Line segments of a camera's frame.
    #[must_use]
    pub fn segments(&mut self, camera: usize) -> &[Segment] {
        let Locator { settings, rig, found, memory, .. } = &mut *self.locator;
        segments_of(&settings.layout(rig), found, memory.as_mut(), camera)
    }

    /// The vertical vanishing point near a hint.
    ///
    /// # Errors
    /// [`Error::Up`] if too few segments point to one.
    #[inline(never)]
    pub fn vertical(&mut self, hint: UpHint) -> Result<Vertical, Error> {
        let parameters = self.begin_up();
        let found = vertical(arcs(self.locator), hint, &parameters);
        self.locator.trace.end(Stage::Up, Picture::Up(found.as_ref()));
        found.ok_or(Error::Up)
    }

    /// The directions that may be vertical, at least 30 degrees apart: that of [`vertical`](Self::vertical) first, then by
    /// descending [support](Vertical::support) times [prior](UpHint::prior); near a hint that is [`UpHint::Up`] no other one
    /// is more than 45 degrees from it. Empty if too few segments point to one.
    ///
    /// To try each, [`level`](Self::level) what [`by_ref`](Self::by_ref) gives.
    #[inline(never)]
    pub fn verticals(&mut self, hint: UpHint) -> Vec<Vertical, MOST_VERTICALS> {
        let parameters = self.begin_up();
        let found = verticals(arcs(self.locator), hint, &parameters);
        self.locator.trace.end(Stage::Up, Picture::Up(found.first()));
        found
    }

    fn begin_up(&mut self) -> attitude::Parameters {
        self.locator.trace.begin(Stage::Up);
        self.locator.found.arcs = collect_arcs(self.locator);
        let tolerance_deg = self.locator.settings.tolerance_deg(self.locator.resolution);
        attitude::Parameters { tolerance_deg, ..attitude::Parameters::default() }
    }

    /// The same frames, lent: further stages leave the segments, so another up vector can be tried after them.
    pub fn by_ref(&mut self) -> Segmented<'_, 'f, Locator<'a, M, T, LAYERS>> {
        Segmented { locator: self.locator, frames: self.frames }
    }

    /// Next stage, with the vertical vanishing point near a hint.
    ///
    /// # Errors
    /// [`Error::Up`], [`Error::Axis`].
    pub fn level_near(mut self, hint: UpHint) -> Result<Levelled<'l, 'f, Locator<'a, M, T, LAYERS>>, Error> {
        let vertical = self.vertical(hint)?;
        let levelled = self.level(&vertical.up)?;
        Ok(Levelled { vertical: Some(vertical), ..levelled })
    }

    /// Next stage, with an up vector that is known: in the axes of camera 0, of any length.
    ///
    /// # Errors
    /// [`Error::Axis`].
    pub fn level(self, up: &Bearing) -> Result<Levelled<'l, 'f, Locator<'a, M, T, LAYERS>>, Error> {
        let frame = LevelFrame::new(up).ok_or(Error::Axis)?;
        Ok(Levelled { locator: self.locator, frames: self.frames, frame, vertical: None })
    }

    /// Whether what is seen through the windows has the sky above, if up is there; `None` without windows, or if neither
    /// side is brighter.
    ///
    /// # Errors
    /// [`Error::Axis`].
    #[inline(always)]
    pub fn sky_is_above(&mut self, up: &Bearing) -> Result<Option<bool>, Error> {
        let frame = LevelFrame::new(up).ok_or(Error::Axis)?;
        find_windows(self.locator, &self.frames, frame);
        let (layout, resolution) = (self.locator.memory_map(), self.locator.resolution);
        let count = self.locator.found.windows.count;
        let Some(look) = layout.windows(self.locator.memory.as_mut(), resolution) else { return Ok(None) };
        Ok(sky_is_above(look.kept.windows.get(..count).unwrap_or_default(), look.buffers.gray, resolution))
    }
}

impl<'l, 'a, M, T, const LAYERS: usize> Levelled<'l, '_, Locator<'a, M, T, LAYERS>>
where
    M: AsRef<[u32]> + AsMut<[u32]>,
    T: Trace,
{
    /// The gravity-aligned axes.
    #[must_use]
    pub const fn frame(&self) -> LevelFrame {
        self.frame
    }

    /// The vertical that they are from, unless up was known.
    #[must_use]
    pub const fn vertical(&self) -> Option<&Vertical> {
        self.vertical.as_ref()
    }

    /// Next stage: windows, and the boundaries of floor and ceiling.
    #[inline(always)]
    pub fn see(self) -> Seen<'l, Locator<'a, M, T, LAYERS>> {
        let Self { locator, frames, frame, .. } = self;
        locator.trace.begin(Stage::Windows);
        find_windows(locator, &frames, frame);
        trace_windows(locator);
        locator.trace.begin(Stage::Boundaries);
        find_boundaries(locator, &frames, frame);
        let seen = Seen { locator };
        seen.trace_boundaries()
    }
}

impl<'l, 'a, M, T, const LAYERS: usize> Seen<'l, Locator<'a, M, T, LAYERS>>
where
    M: AsRef<[u32]> + AsMut<[u32]>,
    T: Trace,
{
    fn trace_boundaries(self) -> Self {
        let layout = self.locator.memory_map();
        let (trace, memory) = (&mut self.locator.trace, self.locator.memory.as_mut());
        let evidence = layout.search(memory).and_then(|search| BoundaryEvidence::new(search.evidence));
        if let Some(evidence) = evidence {
            trace.end(Stage::Boundaries, Picture::Boundaries(&evidence));
        }
        self
    }

    /// Window or wall in every direction.
    #[must_use]
    pub fn window_evidence(&self) -> &WindowEvidence {
        &self.locator.found.windows
    }

    /// The windows, from left to right around the circle.
    #[must_use]
    pub fn windows(&mut self) -> &[Window] {
        let (layout, count) = (self.locator.memory_map(), self.locator.found.windows.count);
        let windows = layout.split(self.locator.memory.as_mut()).map(|(kept, _)| kept.windows);
        windows.unwrap_or_default().get(..count).unwrap_or_default()
    }

    /// Where floor and ceiling end, in every direction.
    #[must_use]
    pub fn boundaries(&mut self) -> Option<BoundaryEvidence<'_>> {
        let layout = self.locator.memory_map();
        BoundaryEvidence::new(layout.search(self.locator.memory.as_mut())?.evidence)
    }

    /// The pose that explains best what was seen, over all layers.
    #[must_use]
    pub fn locate(&mut self, known: HeightPrior) -> Fix<'a> {
        self.locate_within(known, &PosePrior::UNKNOWN)
    }

    /// The pose that explains best what was seen, of those where it is known to be.
    #[inline(never)]
    #[must_use]
    pub fn locate_within(&mut self, known: HeightPrior, within: &PosePrior) -> Fix<'a> {
        self.locator.trace.begin(Stage::Locate);
        let Locator { layers, settings, rig, found, memory, .. } = &mut *self.locator;
        let effort = settings.effort(known.camera_m().is_some());
        let search = settings.layout(rig).search(memory.as_mut());
        let fix = search.and_then(|search| {
            let boundaries = BoundaryEvidence::new(search.evidence)?;
            let mut work = Work {
                table: search.table,
                headings: settings.headings,
                rows: search.rows,
                pool: search.pool,
                effort,
            };
            Some(locate(&boundaries, known, within, &found.windows, layers, &mut work))
        });
        let fix = fix.unwrap_or_else(|| Fix::nothing(known, *within));
        self.locator.trace.end(Stage::Locate, Picture::Fix(&fix));
        fix
    }

    /// Takes what was seen and the [pose](Self::locate) found in it into a belief over a sequence of frames.
    ///
    /// `fix` is that of these frames. `seconds` and `motion` are those since the frames before, 0 s for the first; without
    /// motion the robot may have walked as fast as a person. The layers are the same in each call.
    #[inline(never)]
    pub fn track(
        &mut self,
        track: &mut Track,
        fix: &Fix<'_>,
        seconds: f32,
        motion: Option<Motion>,
    ) -> Option<Estimate> {
        self.locator.trace.begin(Stage::Track);
        let estimate = self.with_evidence(fix.heights(), |table, layers| {
            let observation = Observation { table, poses: fix.poses(), seconds, motion };
            track.step(layers, &observation)
        });
        let estimate = estimate.flatten();
        self.locator.trace.end(Stage::Track, Picture::Estimate(estimate.as_ref()));
        estimate
    }

    /// What was seen as evidence for some heights, and the layers.
    pub fn with_evidence<R>(
        &mut self,
        heights: Heights,
        read: impl FnOnce(&EvidenceTable, &[FloorLayer<'a>]) -> R,
    ) -> Option<R> {
        let Locator { layers, settings, rig, found, memory, .. } = &mut *self.locator;
        let search = settings.layout(rig).search(memory.as_mut())?;
        let [camera, ratio] = heights.to_rungs();
        let (boundaries, hits) = (BoundaryEvidence::new(search.evidence)?, HitEvidence::new(&found.windows));
        weigh(&boundaries, [camera, camera.saturating_add(ratio)], &hits, search.table);
        Some(read(search.table, layers))
    }
}

/// The segments that were found in a camera's frame.
fn segments_of<'m>(layout: &Layout, found: &Found, memory: &'m mut [u32], camera: usize) -> &'m [Segment] {
    let kept = layout.split(memory).map(|(kept, _)| kept.segments);
    let [front, back] = kept.unwrap_or_default();
    let segments = if camera == 0 { front } else { back };
    let count = found.segments.get(camera).copied().unwrap_or(0);
    segments.get(..count).unwrap_or_default()
}

/// [`detect_in`] with code and stack of its own.
#[inline(never)]
fn detect_apart<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    camera: usize,
    image: &GrayImage<'_>,
) {
    detect_in(locator, camera, image);
}

/// The segments of a camera's frame.
#[inline(always)]
fn detect_in<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    camera: usize,
    image: &GrayImage<'_>,
) {
    let Locator { settings, rig, found, memory, .. } = locator;
    let (Some(view), Some(count)) = (rig.view(camera), found.segments.get_mut(camera)) else { return };
    let Some(mut lent) = settings.layout(rig).detector(memory.as_mut(), camera) else { return };
    let mask = settings.lens_field_mask.then(|| {
        lens_field::fill_mask(view, lent.mask);
        BitMask::new(lent.mask, image.width(), image.height()).ok()
    });
    let detected =
        detect(image, mask.flatten().as_ref(), &segment_parameters(view), &mut lent.workspace, lent.found);
    *count = detected.map_or(0, |detected| detected.count);
}

/// Turns the segments into arcs of great circles; their number.
#[inline(never)]
pub(super) fn collect_arcs<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
) -> usize {
    let Locator { settings, rig, found, memory, .. } = locator;
    let Some((segments, arcs)) = settings.layout(rig).arcs(memory.as_mut()) else { return 0 };
    let mut count = 0;
    let mut slots = arcs.iter_mut();
    for (camera, view) in rig.views() {
        let found = segments.get(camera).zip(found.segments.get(camera));
        let segments = found.and_then(|(segments, count)| segments.get(..*count)).unwrap_or_default();
        let arcs = segments.iter().filter_map(|segment| Arc::new(segment, view, u32::from(camera > 0)));
        for (arc, slot) in arcs.zip(&mut slots) {
            *slot = arc;
            count += 1;
        }
    }
    count
}

pub(super) fn arcs<'l, M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &'l mut Locator<'_, M, T, LAYERS>,
) -> &'l [Arc] {
    let Locator { settings, rig, found, memory, .. } = locator;
    let arcs = settings.layout(rig).arcs(memory.as_mut()).map(|(_, arcs)| arcs);
    arcs.unwrap_or_default().get(..found.arcs).unwrap_or_default()
}

/// The windows in the panorama of both frames.
#[inline(always)]
fn find_windows<M: AsMut<[u32]>, T: Trace, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    if T::INLINED {
        find_windows_in(locator, frames, frame);
    } else {
        find_windows_apart(locator, frames, frame);
    }
}

/// [`find_windows_in`] with code and stack of its own.
#[inline(never)]
fn find_windows_apart<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    find_windows_in(locator, frames, frame);
}

#[inline(always)]
fn find_windows_in<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    let Locator { settings, rig, resolution, found, memory, .. } = locator;
    let Some(look) = settings.layout(rig).windows(memory.as_mut(), *resolution) else { return };
    let Look { kept, buffers, smoothing: (pixels, row) } = look;
    let Some(mut finder) = WindowFinder::new(buffers, *resolution, rig, frame) else { return };
    for (camera, view) in rig.views() {
        let Some(frame) = frames.get(camera).and_then(Option::as_ref) else { continue };
        let smoothed = if wants_smoothed(view, *resolution) {
            smoothed(settings.smoothing, &frame.gray, kept.smoothed.get(camera), pixels, row)
        } else {
            None
        };
        let segments = kept.segments.get(camera).zip(found.segments.get(camera));
        let segments = segments.and_then(|(segments, count)| segments.get(..*count)).unwrap_or_default();
        finder.add(camera, smoothed.as_ref().unwrap_or(&frame.gray), frame.excluded, segments);
    }
    found.windows = finder.finish(kept.windows);
}

/// A frame smoothed, if that is wanted: as the detector left it, or anew.
#[inline(always)]
fn smoothed<'m>(
    smoothing: Smoothing,
    image: &GrayImage<'_>,
    kept: Option<&'m &'m mut [u8]>,
    pixels: &'m mut [u8],
    row: &mut [u16],
) -> Option<GrayImage<'m>> {
    let (width, height) = (image.width(), image.height());
    let count = segments::pixels(width, height);
    match smoothing {
        Smoothing::Off => None,
        Smoothing::Again => {
            let out = pixels.get_mut(..count)?;
            smooth(image, row, out);
            GrayImage::new(out, width, height).ok()
        }
        Smoothing::Kept => GrayImage::new(kept?.get(..count)?, width, height).ok(),
    }
}

fn trace_windows<M: AsMut<[u32]>, T: Trace, const LAYERS: usize>(locator: &mut Locator<'_, M, T, LAYERS>) {
    let Locator { settings, rig, resolution, found, trace, memory, .. } = locator;
    let Some(look) = settings.layout(rig).windows(memory.as_mut(), *resolution) else { return };
    let evidence = &found.windows;
    let picture = Picture::Windows {
        windows: look.kept.windows.get(..evidence.count).unwrap_or_default(),
        evidence,
        panorama: look.buffers.gray,
        resolution: *resolution,
        vertical_segments: look
            .buffers
            .vertical_segments
            .get(..evidence.vertical_segments)
            .unwrap_or_default(),
        boxes: look.buffers.boxes.get(..evidence.boxes).unwrap_or_default(),
    };
    trace.end(Stage::Windows, picture);
}

/// The boundaries of floor and ceiling in both frames.
#[inline(always)]
fn find_boundaries<M: AsMut<[u32]>, T: Trace, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    if T::INLINED {
        find_boundaries_in(locator, frames, frame);
    } else {
        find_boundaries_apart(locator, frames, frame);
    }
}

/// [`find_boundaries_in`] with code and stack of its own.
#[inline(never)]
fn find_boundaries_apart<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    find_boundaries_in(locator, frames, frame);
}

#[inline(always)]
fn find_boundaries_in<M: AsMut<[u32]>, T, const LAYERS: usize>(
    locator: &mut Locator<'_, M, T, LAYERS>,
    frames: &Frames<'_>,
    frame: LevelFrame,
) {
    let Locator { settings, rig, memory, .. } = locator;
    let Some(lent) = settings.layout(rig).boundary(memory.as_mut()) else { return };
    let buffers = lent.buffers();
    let Some(mut finder) = BoundaryFinder::new(buffers, rig, frame) else { return };
    for (camera, _) in rig.views() {
        let Some(frame) = frames.get(camera).and_then(Option::as_ref) else { continue };
        // In excluded pixels too: a mask over floor or skirting board would hide the edge that is sought.
        finder.add(camera, &frame.gray, ExclusionMask::Unknown);
    }
    let _ = finder.finish();
}
