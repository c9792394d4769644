//! The stages of the eyes: from two frames of 368 x 360 pixels to window or wall in every direction.
//!
//! Memory is shared as on a board: once the segments of both frames are known, the detector's buffers hold the ring.

use compass_core::attitude::{self, Arc, Hint, Vertical};
use compass_core::boundary::{self, Survey, Surveyor};
use compass_core::camera::{Bearing, Camera, Intrinsics, KannalaBrandt, Rig, View};
use compass_core::num::BINS;
use compass_core::raster::{BitMask, GrayImage};
use compass_core::segments::{self, Segment, detect};
use compass_core::windows::level::{
    self, Buffers, Column, Finder, Level, Red, Resolution, Sighting, Upright, Window, WindowBox,
};

/// Size of the frames.
pub(crate) const WIDTH: u16 = 368;
/// Size of the frames.
pub(crate) const HEIGHT: u16 = 360;
const PIXELS: usize = segments::pixels(WIDTH as u32, HEIGHT as u32);
const TRAIL: usize = segments::trail_len(WIDTH as u32, HEIGHT as u32);
/// Most segments of a frame.
const SEGMENTS: usize = 512;
const ARCS: usize = 2 * SEGMENTS;
const UPRIGHTS: usize = 256;
const BOXES: usize = 1024;
const WINDOWS: usize = 64;
const RING: Resolution = Resolution::COARSE;

/// The frames of both cameras: gray levels, and a mask of what is red.
pub(crate) static FRAMES: [(&[u8], &[u8]); 2] = [
    (
        include_bytes!("../../../tests/vectors/frame_368x360_cam0.gray"),
        include_bytes!("../../../tests/vectors/frame_368x360_cam0.red"),
    ),
    (
        include_bytes!("../../../tests/vectors/frame_368x360_cam1.gray"),
        include_bytes!("../../../tests/vectors/frame_368x360_cam1.red"),
    ),
];

/// The memory of the eyes.
#[derive(Debug)]
pub struct Eyes {
    cells: [u16; PIXELS],
    smoothed: [u8; PIXELS],
    trail: [u32; TRAIL],
    pub(crate) segments: [[Segment; SEGMENTS]; 2],
    pub(crate) counts: [usize; 2],
    arcs: [Arc; ARCS],
    pub(crate) vertical: Option<Vertical>,
    uprights: [Upright; UPRIGHTS],
    boxes: [WindowBox; BOXES],
    columns: [Column; RING.columns() + 1],
    pub(crate) windows: [Window; WINDOWS],
    pub(crate) sighting: Option<Sighting>,
    /// Bins of which floor or ceiling was seen.
    known: [bool; BINS],
}

impl Eyes {
    pub(crate) const fn new() -> Self {
        Self {
            cells: [0; PIXELS],
            smoothed: [0; PIXELS],
            trail: [0; TRAIL],
            segments: [[Segment::EMPTY; SEGMENTS]; 2],
            counts: [0; 2],
            arcs: [Arc::EMPTY; ARCS],
            vertical: None,
            uprights: [Upright::EMPTY; UPRIGHTS],
            boxes: [WindowBox::EMPTY; BOXES],
            columns: [Column::EMPTY; RING.columns() + 1],
            windows: [Window::EMPTY; WINDOWS],
            sighting: None,
            known: [false; BINS],
        }
    }

    /// Segments of one frame.
    pub(crate) fn detect(&mut self, camera: usize) {
        let mut workspace = segments::Workspace {
            cells: &mut self.cells,
            smoothed: &mut self.smoothed,
            trail: &mut self.trail,
        };
        let parameters = level::segment_parameters(rig().view(camera).expect("there are two"));
        let found = detect(&gray(camera), None, &parameters, &mut workspace, &mut self.segments[camera]);
        self.counts[camera] = found.expect("the buffers are made for the frame").count;
    }

    /// The up vector, from the segments of both.
    pub(crate) fn level(&mut self) {
        let rig = rig();
        let mut count = 0;
        for (camera, view) in rig.views() {
            let segments = &self.segments[camera][..self.counts[camera]];
            let arcs = segments.iter().filter_map(|segment| Arc::new(segment, view, camera as u8));
            for (slot, arc) in self.arcs[count..].iter_mut().zip(arcs) {
                *slot = arc;
                count += 1;
            }
        }
        // The rig hangs upside down.
        let hint = Hint::Up(Bearing::new(0.0, 1.0, 0.0));
        let parameters = attitude::Parameters { tolerance_deg: 3.0, ..attitude::Parameters::default() };
        self.vertical = attitude::vertical(&self.arcs[..count], hint, &parameters);
    }

    /// The windows around.
    pub(crate) fn look(&mut self) {
        let Some(level) = self.vertical.and_then(|vertical| Level::new(&vertical.up)) else { return };
        let rig = rig();
        let buffers = Buffers {
            gray: &mut self.smoothed,
            texture: bytemuck::cast_slice_mut(&mut self.cells),
            columns: &mut self.columns,
            uprights: &mut self.uprights,
            boxes: &mut self.boxes,
        };
        let mut finder = Finder::new(buffers, RING, &rig, level).expect("a ring fits the frame's buffers");
        for (camera, (_, red)) in FRAMES.iter().enumerate() {
            let segments = &self.segments[camera][..self.counts[camera]];
            finder.add(camera, &gray(camera), Red::Mask(red_mask(red)), segments);
        }
        self.sighting = Some(finder.finish(&mut self.windows));
    }

    /// How far the walls are; the ring is no longer needed.
    pub(crate) fn survey(&mut self) {
        let Some(level) = self.vertical.and_then(|vertical| Level::new(&vertical.up)) else { return };
        let rig = rig();
        let buffers = boundary::Buffers {
            edges: &mut self.smoothed,
            support: bytemuck::cast_slice_mut(&mut self.cells),
        };
        let mut surveyor = Surveyor::new(buffers, &rig, level).expect("the raster fits the frame's buffers");
        for (camera, (_, red)) in FRAMES.iter().enumerate() {
            surveyor.add(camera, &gray(camera), Red::Mask(red_mask(red)));
        }
        self.known = *surveyor.finish().known();
    }

    /// What was seen of floor and ceiling.
    pub(crate) fn evidence(&self) -> Survey<'_> {
        let cells: &[u8] = bytemuck::cast_slice(&self.cells);
        Survey::new(&cells[..boundary::CELLS], self.known).expect("as many cells as it has")
    }
}

fn red_mask(red: &'static [u8]) -> BitMask<'static> {
    BitMask::new(red, WIDTH.into(), HEIGHT.into()).expect("the mask is of the frame's size")
}

fn gray(camera: usize) -> GrayImage<'static> {
    GrayImage::new(FRAMES[camera].0, WIDTH.into(), HEIGHT.into()).expect("the frame has its size")
}

/// The nominal rig of `compass-host`, for frames half as wide and high.
fn rig() -> Rig {
    let view = |[fx, fy, cx, cy]: [f32; 4], k| {
        let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, k).expect("a usual lens");
        View::new(Camera::KannalaBrandt(lens), WIDTH, HEIGHT)
    };
    let front = view([116.0, 116.1, 182.95, 179.9], [0.024, -0.0105, -0.0016, 0.000_14]);
    let mut back = view([116.25, 116.3, 183.65, 179.2], [0.025, -0.0107, -0.001_55, 0.000_13]);
    back.rotation = nalgebra::Matrix3::new(
        -0.999_975,
        0.005_025,
        0.004_975,
        0.005,
        0.999_974_7,
        -0.005_025,
        -0.005,
        -0.005,
        -0.999_974_9,
    );
    back.position = nalgebra::Vector3::new(0.0012, -0.0007, -0.038);
    Rig::new([Some(front), Some(back)]).expect("the rotation is one")
}
