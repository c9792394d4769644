//! From camera frames to window or wall in every direction: the core's steps with their buffers.

use crate::frame::{Frame, MAX_SEGMENTS, SegmentDetector};
use crate::wide::wide;
use compass_core::base::ladder::height_rungs;
use compass_core::base::raster::{BitMask, GrayImage, RgbImage};
use compass_core::vision::attitude::{self, Arc, Axes, LEAST_INLIERS, UpHint, Vertical};
use compass_core::vision::boundary::{self, BoundaryEvidence, BoundaryFinder, RangeLikelihoods};
use compass_core::vision::camera::{Bearing, Rig, View};
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::panorama::Resolution;
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::segments::{Detected, Parameters, Segment, SegmentsError};
use compass_core::vision::windows::{
    self, Buffers, Column, Edge, MAX_BOXES, MAX_UPRIGHTS, Upright, Window, WindowBox, WindowEvidence,
    WindowFinder,
};
use thiserror::Error;

/// Segments are sought this far from the optical axis, radians (95 degrees).
const FIELD: f32 = 95.0 * std::f32::consts::PI / 180.0;
/// Pixels next to the rim that its gradient reaches.
const RIM_PX: f32 = 3.0;
/// The sky must exceed the ground by more than one in so many of the whole range of brightness ranks.
const SKY_SHARE: u64 = 50;
/// Most windows of a pair of frames.
const MAX_WINDOWS: usize = 256;

/// Why nothing could be seen.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EyesError {
    /// The up vector leaves no heading.
    #[error("the up vector lies along the optical axis of cam0, or is no vector: it leaves no heading")]
    Up,
    /// Too few segments point to one vertical vanishing point.
    #[error(
        "cannot tell which way is up: fewer than {LEAST_INLIERS} segments point to one vertical vanishing point; give it with --up"
    )]
    NoVertical,
    /// The windows do not tell up from down.
    #[error(
        "cannot tell up from down: no windows, or no sky in them; give --mount upright or inverted, or --up"
    )]
    NoSky,
    /// Image and IMU tell different directions.
    #[error(
        "image and IMU disagree on up by {0:.1} degrees: is the IMU at rest, and its calibration that of this rig?"
    )]
    Disagreement(f64),
    /// The detector refused the image.
    #[error("cam{camera}: {source}")]
    Segments {
        /// Which camera.
        camera: usize,
        /// What the detector said.
        source: SegmentsError,
    },
}

/// How cam0 is mounted: which side of its image is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mount {
    /// Told from the windows: the sky is brighter than the ground.
    #[default]
    Auto,
    /// The top.
    Upright,
    /// The bottom.
    Inverted,
}

impl Mount {
    /// Roughly up in the axes of cam0, unless it is to be told from the windows.
    #[must_use]
    pub fn top(self) -> Option<Bearing> {
        let top = Bearing::new(0.0, -1.0, 0.0);
        match self {
            Self::Auto => None,
            Self::Upright => Some(top),
            Self::Inverted => Some(-top),
        }
    }
}

/// One camera's detector, mask and last result.
#[derive(Debug)]
struct Eye {
    detector: SegmentDetector,
    mask: Vec<u8>,
    view: View,
    parameters: Parameters,
    detected: Detected,
}

/// The eyes of a rig, with all buffers: made once, used for every pair of frames without allocating.
#[derive(Debug)]
pub struct Eyes {
    rig: Rig,
    resolution: Resolution,
    eyes: [Option<Eye>; 2],
    arcs: Vec<Arc>,
    arc_count: usize,
    gray: Vec<u8>,
    texture: Vec<u8>,
    columns: Vec<Column>,
    uprights: Vec<Upright>,
    boxes: Vec<WindowBox>,
    windows: Vec<Window>,
    boundary: [Vec<u8>; 2],
    ranges: Box<RangeLikelihoods>,
    /// How many uprights and boxes the last pair of frames left in the buffers.
    considered: [usize; 2],
}

/// What was seen in a pair of frames.
#[derive(Debug)]
pub struct Seen<'a> {
    /// Window or wall in every direction.
    pub sighting: WindowEvidence,
    /// The windows, around the circle.
    pub windows: &'a [Window],
    /// The level frame they are in.
    pub level: LevelFrame,
}

impl Eyes {
    /// Buffers for the cameras of a rig.
    #[must_use]
    pub fn new(rig: Rig) -> Self {
        let resolution = rig.views().map(|(_, view)| Resolution::of(view)).min_by_key(|r| r.per_degree());
        let resolution = resolution.unwrap_or(Resolution::COARSE);
        let eyes = [0, 1].map(|camera| rig.view(camera).map(Eye::new));
        Self {
            rig,
            resolution,
            eyes,
            arcs: vec![Arc::default(); 2 * MAX_SEGMENTS],
            arc_count: 0,
            gray: vec![0; resolution.cells()],
            texture: vec![0; resolution.cells()],
            columns: vec![Column::default(); resolution.columns() + 1],
            uprights: vec![Upright::default(); 4 * MAX_UPRIGHTS],
            boxes: vec![WindowBox::default(); 4 * MAX_BOXES],
            windows: vec![Window::default(); MAX_WINDOWS],
            boundary: [(); 2].map(|()| vec![0; boundary::CELLS]),
            ranges: Box::new(RangeLikelihoods::EMPTY),
            considered: [0; 2],
        }
    }

    /// The rig.
    #[must_use]
    pub const fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Size of the cells that windows count in.
    #[must_use]
    pub const fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// Finds the segments of the frames of cam0 and cam1; a missing frame has none.
    ///
    /// # Errors
    /// [`EyesError::Segments`] for a frame larger than its camera's images.
    pub fn detect(&mut self, frames: [Option<&Frame>; 2]) -> Result<(), EyesError> {
        for (camera, (eye, frame)) in self.eyes.iter_mut().zip(frames).enumerate() {
            if let Some((eye, frame)) = eye.as_mut().zip(frame) {
                let bits = BitMask::new(&eye.mask, u32::from(eye.view.width), u32::from(eye.view.height));
                let (_, detected) = eye
                    .detector
                    .detect(&frame.gray(), bits.ok().as_ref(), &eye.parameters)
                    .map_err(|source| EyesError::Segments { camera, source })?;
                eye.detected = detected;
            }
        }
        Ok(())
    }

    /// The segments of the last detection.
    #[must_use]
    pub fn segments(&self, camera: usize) -> &[Segment] {
        self.eyes.get(camera).and_then(Option::as_ref).map_or(&[], |eye| eye.detector.segments(&eye.detected))
    }

    /// Finds the windows of frames whose segments were just detected.
    ///
    /// # Errors
    /// [`EyesError::Up`].
    pub fn windows(&mut self, frames: [Option<&Frame>; 2], up: &Bearing) -> Result<Seen<'_>, EyesError> {
        let level = LevelFrame::new(up).ok_or(EyesError::Up)?;
        let buffers = Buffers {
            gray: &mut self.gray,
            texture: &mut self.texture,
            columns: &mut self.columns,
            uprights: &mut self.uprights,
            boxes: &mut self.boxes,
        };
        let mut finder =
            WindowFinder::new(buffers, self.resolution, &self.rig, level).ok_or(EyesError::Up)?;
        for (camera, (eye, frame)) in self.eyes.iter().zip(frames).enumerate() {
            let Some((eye, frame)) = eye.as_ref().zip(frame) else { continue };
            let smoothed = windows::wants_smoothed(&eye.view, self.resolution);
            let image = if smoothed { eye.detector.smoothed(&frame.gray()) } else { frame.gray() };
            add(&mut finder, camera, &image, red(frame), eye.detector.segments(&eye.detected));
        }
        let sighting = finish(finder, &mut self.windows);
        self.considered = [sighting.uprights, sighting.boxes];
        let windows = &self.windows[..sighting.count];
        Ok(Seen { sighting, windows, level })
    }

    /// Measures how far the walls are in frames whose segments were just detected, with the likeliest ceiling; the height
    /// of cam0 above the floor, in metres, helps where it is known.
    ///
    /// # Errors
    /// [`EyesError::Up`].
    pub fn ranges(
        &mut self,
        frames: [Option<&Frame>; 2],
        up: &Bearing,
        height_m: Option<f32>,
    ) -> Result<&RangeLikelihoods, EyesError> {
        let Self { rig, eyes, boundary, ranges, .. } = self;
        survey(rig, eyes, frames, up, boundary)?.likeliest(height_m.map(height_rungs), ranges);
        Ok(ranges)
    }

    /// Looks where the walls meet floor and ceiling in frames whose segments were just detected.
    ///
    /// # Errors
    /// [`EyesError::Up`].
    pub fn survey(
        &mut self,
        frames: [Option<&Frame>; 2],
        up: &Bearing,
    ) -> Result<BoundaryEvidence<'_>, EyesError> {
        survey(&self.rig, &self.eyes, frames, up, &mut self.boundary)
    }

    /// Finds which way is up from the segments just detected, near the vertical of cam0's image.
    ///
    /// # Errors
    /// [`EyesError::NoVertical`] if too few segments agree; [`EyesError::NoSky`].
    pub fn vertical(&mut self, frames: [Option<&Frame>; 2], mount: Mount) -> Result<Vertical, EyesError> {
        let hint = mount.top().map_or(UpHint::Axis(-Bearing::y()), UpHint::Up);
        let mut vertical = self.vertical_near(hint)?;
        if mount == Mount::Auto && !self.sky_is_up(frames, &vertical.up)? {
            vertical.up = -vertical.up;
        }
        Ok(vertical)
    }

    /// Finds which way is up from the segments just detected, near where it is said to be.
    ///
    /// # Errors
    /// [`EyesError::NoVertical`] if too few segments agree.
    pub fn vertical_near(&mut self, hint: UpHint) -> Result<Vertical, EyesError> {
        self.collect_arcs();
        let parameters =
            attitude::Parameters { tolerance_deg: self.tolerance_deg(), ..attitude::Parameters::default() };
        attitude::vertical(self.arcs(), hint, &parameters).ok_or(EyesError::NoVertical)
    }

    /// Largest angle between a segment and the vertical that it points to, degrees.
    #[must_use]
    pub fn tolerance_deg(&self) -> f32 {
        if self.resolution == Resolution::COARSE { 3.0 } else { 2.0 }
    }

    /// The building's axes, from the arcs that the vertical was just sought among.
    #[must_use]
    pub fn axes(&self, level: &LevelFrame) -> Option<Axes> {
        attitude::building_axes(self.arcs(), level)
    }

    fn arcs(&self) -> &[Arc] {
        &self.arcs[..self.arc_count]
    }

    fn collect_arcs(&mut self) {
        self.arc_count = 0;
        for (camera, view) in self.rig.views() {
            let Some(eye) = &self.eyes[camera] else { continue };
            let segments = eye.detector.segments(&eye.detected);
            let arcs = segments.iter().filter_map(|s| Arc::new(s, view, camera as u8));
            for (slot, arc) in self.arcs[self.arc_count..].iter_mut().zip(arcs) {
                *slot = arc;
                self.arc_count += 1;
            }
        }
    }

    /// Whether what is seen through the windows has the sky above.
    fn sky_is_up(&mut self, frames: [Option<&Frame>; 2], up: &Bearing) -> Result<bool, EyesError> {
        let count = self.windows(frames, up)?.sighting.count;
        let windows = &self.windows[..count];
        let third =
            |w: &Window| i64::from(w.columns[1] - w.columns[0]) * i64::from((w.rows[1] - w.rows[0]) / 3);
        let most = 255 * windows.iter().map(third).sum::<i64>();
        let sky = windows::sky_above(windows, &self.gray, self.resolution);
        if sky.unsigned_abs() * SKY_SHARE <= most.unsigned_abs() {
            return Err(EyesError::NoSky);
        }
        Ok(sky > 0)
    }

    /// The boxes that [`windows`](Self::windows) chose among: for pictures.
    #[must_use]
    pub fn boxes(&self) -> &[WindowBox] {
        &self.boxes[..self.considered[1]]
    }

    /// The edges that those boxes lie between, but for where the view ends: for pictures.
    #[must_use]
    pub fn edges(&self) -> Vec<Edge> {
        let mut uprights = self.uprights[..self.considered[0]].to_vec();
        let mut edges = Vec::new();
        windows::visit_edges(&mut uprights, self.resolution, |edge| edges.push(*edge));
        edges
    }

    /// Brightness ranks of the ring after [`windows`](Self::windows), row by row from the top, 0 where nothing is
    /// known: for pictures.
    #[must_use]
    pub fn ring(&self) -> Vec<u8> {
        let (columns, rows) = (self.resolution.columns(), self.resolution.rows());
        (0..columns * rows).map(|i| self.gray[i % columns * rows + i / columns]).collect()
    }
}

wide! {
    /// [`WindowFinder::add`].
    fn add(
        finder: &mut WindowFinder<'_, '_>,
        camera: usize,
        image: &GrayImage<'_>,
        red: ExclusionMask<'_>,
        segments: &[Segment],
    ) {
        finder.add(camera, image, red, segments);
    }

    /// [`WindowFinder::finish`].
    fn finish(finder: WindowFinder<'_, '_>, windows: &mut [Window]) -> WindowEvidence {
        finder.finish(windows)
    }
}

impl Eye {
    fn new(view: &View) -> Self {
        let (width, height) = (u32::from(view.width), u32::from(view.height));
        Self {
            detector: SegmentDetector::new(width, height),
            mask: field_mask(view),
            view: *view,
            parameters: windows::segment_parameters(view),
            detected: Detected { count: 0, truncated: false },
        }
    }
}

/// Where the walls meet floor and ceiling, in frames whose segments were just detected.
fn survey<'a>(
    rig: &Rig,
    eyes: &[Option<Eye>; 2],
    frames: [Option<&Frame>; 2],
    up: &Bearing,
    [edges, support]: &'a mut [Vec<u8>; 2],
) -> Result<BoundaryEvidence<'a>, EyesError> {
    let level = LevelFrame::new(up).ok_or(EyesError::Up)?;
    let mut surveyor =
        BoundaryFinder::new(boundary::Buffers { edges, support }, rig, level).ok_or(EyesError::Up)?;
    for (camera, (eye, frame)) in eyes.iter().zip(frames).enumerate() {
        let Some((eye, frame)) = eye.as_ref().zip(frame) else { continue };
        surveyor.add(camera, &eye.detector.smoothed(&frame.gray()), red(frame));
    }
    Ok(surveyor.finish())
}

/// Where a frame is red, if it has colours.
fn red(frame: &Frame) -> ExclusionMask<'_> {
    let image = frame.rgb().and_then(|rgb| RgbImage::new(rgb, frame.width(), frame.height()).ok());
    image.map_or(ExclusionMask::Unknown, ExclusionMask::Colours)
}

/// The pixels of a view within [`FIELD`] of its axis, [`RIM_PX`] left out: one bit each, as [`BitMask`] has them.
fn field_mask(view: &View) -> Vec<u8> {
    let i = view.camera.intrinsics();
    let rim = view.camera.project(&Bearing::new(FIELD.sin(), 0.0, FIELD.cos()));
    let radius = rim.map_or(f32::INFINITY, |p| (p.x - i.cx - RIM_PX) / i.fx);
    let row_bytes = BitMask::row_bytes(u32::from(view.width));
    let mut bits = vec![0; row_bytes * usize::from(view.height)];
    for (y, row) in bits.chunks_exact_mut(row_bytes).enumerate() {
        let v = (y as f32 - i.cy) / i.fy;
        for x in 0..usize::from(view.width) {
            let u = (x as f32 - i.cx) / i.fx;
            row[x / 8] |= u8::from(u * u + v * v < radius * radius) << (x % 8);
        }
    }
    bits
}
