//! Windows in the level frame, in one panorama of both cameras.
//!
//! frames -> panorama (planes of brightness rank and texture) -> edges (near-vertical segments) -> boxes (pairs of edges,
//! scored) -> choice around the circle -> hit type and log odds of 360 bins.
//!
//! Vertical means along the up vector, sizes are angles, and gray levels are relative to the frame: the result is
//! independent of tilt and of exposure. A box over several windows has a lower score than the sum of theirs.

mod boxes;
mod choose;
mod edges;
#[cfg(any(test, feature = "introspect"))]
mod introspect;
mod panorama;
mod planes;
mod tuning;
mod upright;
mod window;

pub use boxes::WindowBox;
pub use choose::Column;
pub use edges::{Edge, VerticalSegment};
#[cfg(any(test, feature = "introspect"))]
pub use introspect::{image_box, visit_edges};
pub use window::Window;

use crate::base::confidence::Confidence;
use crate::base::num::{BINS, LogOdds, LogWeight, count_as_i32, log_odds};
use crate::base::raster::GrayImage;
use crate::base::scan::Hit;
use crate::vision::camera::Rig;
use crate::vision::level_frame::LevelFrame;
use crate::vision::panorama::{Resolution, pixels_per_degree};
use crate::vision::projector::CameraView;
use crate::vision::sample::ExclusionMask;
use crate::vision::segments::{Parameters, Segment};
use boxes::Planes;
use edges::{FINE, MAX_EDGES};
use heapless::Vec;
use tuning::{LEAST_SCORE, RIM_DEG, SEEN_DEG, SKY_SHARE, WIDEST_DEG};

/// Capacity of [`Buffers::vertical_segments`] that suffices for both cameras in built-up scenes.
pub const MAX_VERTICAL_SEGMENTS: usize = 512;
/// Capacity of [`Buffers::boxes`] that suffices in built-up scenes.
pub const MAX_BOXES: usize = 2048;

/// Memory lent to a [`WindowFinder`]; its initial contents are ignored.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// [`Resolution::cells`] elements: gray levels, then brightness ranks.
    pub gray: &'a mut [u8],
    /// [`Resolution::cells`] elements: texture.
    pub texture: &'a mut [u8],
    /// [`Resolution::columns`] + 1 elements.
    pub columns: &'a mut [Column],
    /// Up to [`MAX_VERTICAL_SEGMENTS`] elements; fewer may truncate the result.
    pub vertical_segments: &'a mut [VerticalSegment],
    /// Up to [`MAX_BOXES`] elements; fewer may truncate the result.
    pub boxes: &'a mut [WindowBox],
}

/// Window or wall per direction, as hit type and as log odds.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WindowEvidence {
    /// Number of windows found.
    pub count: usize,
    /// Whether a buffer was full: windows may be missing.
    pub truncated: bool,
    /// Hit type of bin j, at heading + j degrees counter-clockwise. Bins not seen are walls of confidence 0.
    pub hit: [Hit; BINS],
    /// Confidence of the hit type: 0 where neither camera sees, or an excluded pixel hides the building.
    pub confidence: Confidence,
    /// Log odds of a window per bin, -4 to 4 nats; 0 where not seen.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub evidence: [LogOdds; BINS],
    /// Class of the strongest upright edge per bin: 1 for the weakest sixth of directions to 6, 0 where not seen.
    pub upright_edges: [u8; BINS],
    /// Number of near-vertical segments left in [`Buffers::vertical_segments`], for diagnostic images.
    pub vertical_segments: usize,
    /// Number of boxes left in [`Buffers::boxes`], for diagnostic images.
    pub boxes: usize,
}

impl WindowEvidence {
    /// Evidence of no direction. Every byte is 0.
    pub const NOTHING: Self = Self {
        count: 0,
        truncated: false,
        hit: [Hit::Open; BINS],
        confidence: Confidence::NONE,
        evidence: [LogOdds::ZERO; BINS],
        upright_edges: [0; BINS],
        vertical_segments: 0,
        boxes: 0,
    };
}

/// Finds windows in the frames of a rig, added one camera at a time.
///
/// # Formats
/// Gray levels and segments to log odds: scores of boxes and evidence are I8F8 nats, positions whole cells of the
/// [`Resolution`].
///
/// # Cost
/// Measured as `windows` in `targets/budget.txt`.
///
/// # References
/// Boxes are chosen by weighted interval scheduling: J. Kleinberg and E. Tardos, "Algorithm Design", 2005, section 6.1.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Bearing, Camera, CameraError, ExclusionMask, GrayImage, Hit, Intrinsics, Rig, View};
/// # use compass_core::vision::level_frame::LevelFrame;
/// # use compass_core::vision::panorama::Resolution;
/// # use compass_core::vision::windows::*;
/// // A blank frame of camera 0, which looks ahead.
/// let intrinsics = Intrinsics { fx: 10.0, fy: 10.0, cx: 19.5, cy: 19.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 40, 40);
/// let rig = Rig::new([Some(view), None])?;
/// let (resolution, level) = (Resolution::of(&view), LevelFrame::new(&-Bearing::y()).unwrap());
/// let buffers = Buffers {
///     gray: &mut vec![0; resolution.cells()],
///     texture: &mut vec![0; resolution.cells()],
///     columns: &mut vec![Column::EMPTY; resolution.columns() + 1],
///     vertical_segments: &mut [VerticalSegment::EMPTY; 9],
///     boxes: &mut [WindowBox::EMPTY; 9],
/// };
/// let mut finder = WindowFinder::new(buffers, resolution, &rig, level).unwrap();
/// finder.add(0, &GrayImage::new(&[99; 1600], 40, 40).unwrap(), ExclusionMask::Unknown, &[]);
/// let found = finder.finish(&mut [Window::EMPTY; 9]);
/// // Walls, known ahead and unknown behind.
/// assert_eq!((found.count, found.hit[0], found.truncated), (0, Hit::Wall, false));
/// assert_eq!((found.confidence.sixteenths()[0], found.confidence.sixteenths()[180]), (15, 0));
/// # Ok::<(), CameraError>(())
/// ```
#[derive(Debug)]
pub struct WindowFinder<'a, 'r> {
    buffers: Buffers<'a>,
    resolution: Resolution,
    rig: &'r Rig,
    level: LevelFrame,
    vertical_segments: usize,
    truncated: bool,
}

impl<'a, 'r> WindowFinder<'a, 'r> {
    /// Starts a pair of frames. `rig` has the cameras whose frames will be added, and no others. `None` if a buffer is
    /// too short.
    #[must_use]
    pub fn new(
        mut buffers: Buffers<'a>,
        resolution: Resolution,
        rig: &'r Rig,
        level: LevelFrame,
    ) -> Option<Self> {
        let (cells, columns) = (resolution.cells(), resolution.columns() + 1);
        buffers.gray = buffers.gray.get_mut(..cells)?;
        buffers.texture = buffers.texture.get_mut(..cells)?;
        buffers.columns = buffers.columns.get_mut(..columns)?;
        buffers.gray.fill(0);
        Some(Self { buffers, resolution, rig, level, vertical_segments: 0, truncated: false })
    }

    // Inlined down to the loops over cells, like `segments::detect` and for the same reason.
    /// Adds one camera: its frame, smoothed if [`wants_smoothed`], and its segments. Ignores a camera that the rig lacks.
    ///
    /// # Cost
    /// At most one bilinear sample per cell and one projection per 64 cells of the panorama.
    #[inline(always)]
    pub fn add(
        &mut self,
        camera: usize,
        image: &GrayImage<'_>,
        excluded: ExclusionMask<'_>,
        segments: &[Segment],
    ) {
        let Some(view) = self.rig.view(camera) else { return };
        let seen = CameraView { rig: self.rig, camera, level: self.level, image, excluded };
        panorama::draw(self.buffers.gray, self.resolution, &seen);
        let vertical = |segment| edges::vertical_segment(segment, view, &self.level, self.resolution);
        for segment in segments.iter().filter_map(vertical) {
            match self.buffers.vertical_segments.get_mut(self.vertical_segments) {
                Some(slot) => {
                    *slot = segment;
                    self.vertical_segments += 1;
                }
                None => self.truncated = true,
            }
        }
    }

    /// Finds the windows, at most as many as `windows` holds, in clockwise order.
    ///
    /// # Accuracy
    /// Among the boxes that do not cross the cut of the circle, the chosen ones have the largest total score, and the log
    /// odds are exact max-marginals of it (test `finds_the_best_choice`).
    ///
    /// # Cost
    /// A fixed number of passes over the cells; for each pair of at most 192 edges at most 32 columns of the box between
    /// them and of each flank; for each column the boxes that start or end there.
    #[inline(always)]
    pub fn finish(mut self, windows: &mut [Window]) -> WindowEvidence {
        let upright_edges = upright::classes(self.buffers.gray, self.resolution);
        planes::normalize(self.buffers.gray, self.buffers.texture, self.resolution);
        let planes =
            Planes { rank: self.buffers.gray, texture: self.buffers.texture, resolution: self.resolution };
        let mut edges = Vec::new();
        let vertical = self.buffers.vertical_segments.get_mut(..self.vertical_segments).unwrap_or(&mut []);
        self.truncated |= !edges::gather(vertical, self.resolution, &mut edges);
        self.truncated |= !add_rims(&planes, &mut edges);
        let (proposed, all) = propose(&planes, &edges, self.buffers.boxes);
        self.truncated |= !all;
        let boxes = self.buffers.boxes.get_mut(..proposed).unwrap_or(&mut []);
        let cut = choose::choose(boxes, self.buffers.columns);
        let mut found = WindowEvidence {
            truncated: self.truncated,
            hit: [Hit::Wall; BINS],
            upright_edges,
            vertical_segments: self.vertical_segments,
            boxes: proposed,
            ..WindowEvidence::NOTHING
        };
        let mut confidence = [0; BINS];
        let mut covered = Covered::default();
        for b in choose::chosen(boxes, self.buffers.columns) {
            covered.add(b, self.resolution);
            match windows.get_mut(found.count) {
                Some(slot) => {
                    *slot = window(b, self.rig, &self.level, self.resolution);
                    found.count += 1;
                }
                None => found.truncated = true,
            }
        }
        windows.get_mut(..found.count).unwrap_or(&mut []).reverse();
        let bins = found.hit.iter_mut().zip(&mut found.evidence).zip(&mut confidence);
        for (bin, ((hit, evidence), confidence)) in bins.enumerate() {
            if let Some((seen, odds)) = direction(bin, &planes, &covered, (self.buffers.columns, cut)) {
                *hit = seen;
                *evidence = log_odds(odds);
                *confidence = confidence_of(odds);
            }
        }
        found.confidence = Confidence::new(&confidence);
        found
    }
}

/// Parameters of the segment detector for a view: lower thresholds than ELSED's, and a shorter window for small images.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Camera, CameraError, Intrinsics, View};
/// use compass_core::vision::windows::segment_parameters;
///
/// let intrinsics = Intrinsics { fx: 116.0, fy: 116.0, cx: 183.5, cy: 179.5 };
/// let small = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 368, 360);
/// assert_eq!(segment_parameters(&small).min_length, 8);
/// # Ok::<(), CameraError>(())
/// ```
#[must_use]
pub fn segment_parameters(view: &crate::vision::camera::View) -> Parameters {
    let parameters = Parameters { gradient_threshold: 20, anchor_threshold: 4, ..Parameters::default() };
    if Resolution::of(view) == Resolution::COARSE {
        return Parameters { min_length: 8, ..parameters };
    }
    parameters
}

/// Whether the upper third of the windows is brighter than the lower third, as sky is than ground: `Some(false)` means that
/// the up vector has the wrong sign; `None` without windows, or if the difference of mean rank is below 1/50 of the range.
/// `rank` is [`Buffers::gray`] after [`WindowFinder::finish`].
///
/// ```
/// use compass_core::vision::panorama::Resolution;
/// use compass_core::vision::windows::{Window, sky_is_above};
///
/// // One column with a window of rows 0 to 29, the upper third bright.
/// let mut rank = vec![0; Resolution::COARSE.cells()];
/// rank[..10].fill(200);
/// let window = Window { columns: [0, 1], rows: [0, 30], ..Window::EMPTY };
/// assert_eq!(sky_is_above(&[window], &rank, Resolution::COARSE), Some(true));
/// assert_eq!(sky_is_above(&[], &rank, Resolution::COARSE), None);
/// ```
#[must_use]
pub fn sky_is_above(windows: &[Window], rank: &[u8], resolution: Resolution) -> Option<bool> {
    let (columns, height) = (resolution.columns(), resolution.rows());
    let sum = |window: &Window, rows: core::ops::Range<u16>| -> i64 {
        let of_window = (window.columns[0]..window.columns[1]).map(|c| usize::from(c) % columns * height);
        let cells = |start: usize| {
            rank.get(start + usize::from(rows.start)..start + usize::from(rows.end)).unwrap_or(&[]).iter()
        };
        of_window.flat_map(cells).map(|rank| i64::from(*rank)).sum()
    };
    let third = |window: &Window| window.rows[1].saturating_sub(window.rows[0]) / 3;
    let contrast = |window: &Window| {
        let ([top, bottom], third) = (window.rows, third(window));
        sum(window, top..top + third) - sum(window, bottom - third..bottom)
    };
    let cells = |window: &Window| {
        u64::from(window.columns[1].saturating_sub(window.columns[0])) * u64::from(third(window))
    };
    let sky: i64 = windows.iter().map(contrast).sum();
    let most = 255 * windows.iter().map(cells).sum::<u64>();
    (sky.unsigned_abs() * SKY_SHARE > most).then_some(sky > 0)
}

/// Whether a panorama of this resolution samples the view's image at a stride above 1.5 pixels, so that it needs the
/// smoothed image against aliasing.
///
/// ```
/// # use compass_core::vision::camera::Equidistant;
/// # use compass_core::{Camera, CameraError, Intrinsics, View};
/// use compass_core::vision::panorama::Resolution;
/// use compass_core::vision::windows::wants_smoothed;
///
/// // 7.5 pixels per degree.
/// let intrinsics = Intrinsics { fx: 430.0, fy: 430.0, cx: 703.5, cy: 690.5 };
/// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 1408, 1382);
/// assert!(wants_smoothed(&view, Resolution::FINE));
/// # Ok::<(), CameraError>(())
/// ```
#[must_use]
pub fn wants_smoothed(view: &crate::vision::camera::View, resolution: Resolution) -> bool {
    pixels_per_degree(view) > 1.5 * resolution.per_degree() as f32
}

/// Scores all pairs of edges that may be windows; returns the number of boxes, and whether all fit.
#[inline(always)]
fn propose(planes: &Planes<'_>, edges: &[Edge], boxes: &mut [WindowBox]) -> (usize, bool) {
    let fine = FINE * planes.resolution.per_degree_i32();
    let (turn, widest) = (360 * fine, WIDEST_DEG * fine);
    let mut count = 0;
    for (i, left) in edges.iter().enumerate() {
        let onward = edges.iter().skip(i + 1).copied();
        let around = edges.iter().take(i).map(|e| Edge { x: e.x + turn, ..*e });
        for right in onward.chain(around) {
            if right.x - left.x > widest {
                break;
            }
            let Some(b) = boxes::propose(planes, left, &right) else { continue };
            if b.score <= LEAST_SCORE {
                continue;
            }
            let Some(slot) = boxes.get_mut(count) else { return (count, false) };
            *slot = b;
            count += 1;
        }
    }
    (count, true)
}

/// Number of known cells of a column between two elevations, and number of cells.
#[inline(always)]
fn known(planes: &Planes<'_>, column: usize, [low, high]: [i32; 2]) -> (usize, usize) {
    let resolution = planes.resolution;
    let rows = resolution.row_of(high)..resolution.row_of(low);
    let start = column * resolution.rows();
    let cells = planes.rank.get(start + rows.start..start + rows.end).unwrap_or(&[]);
    (cells.iter().filter(|rank| **rank > 0).count(), rows.len())
}

/// Inserts an edge of all rows at each end of the view, in order of columns; false if the list is full.
fn add_rims(planes: &Planes<'_>, edges: &mut Vec<Edge, MAX_EDGES>) -> bool {
    let columns = planes.resolution.columns();
    let open = |column: usize| {
        let (known, all) = known(planes, column, RIM_DEG);
        5 * known > 4 * all
    };
    let mut before = open(columns - 1);
    for column in 0..columns {
        let here = open(column);
        if here != before {
            let x = count_as_i32(column) * FINE;
            let edge = Edge { x, top: 0, bottom: count_as_i32(planes.resolution.rows()) * FINE, rim: true };
            let at = edges.iter().position(|e| e.x > x).unwrap_or(edges.len());
            if edges.insert(at, edge).is_err() {
                return false;
            }
        }
        before = here;
    }
    true
}

/// A box as a window.
fn window(b: &WindowBox, rig: &Rig, level: &LevelFrame, resolution: Resolution) -> Window {
    let columns = [b.start, b.end];
    let rows = [b.top, b.bottom];
    let radians = core::f32::consts::PI / 180.0;
    let mut window = Window { columns, rows, score: b.score, camera: 0 };
    let ([right, left], [sill, lintel]) = (window.azimuth_deg(resolution), window.elevation_deg(resolution));
    let middle = level.bearing((right + left) * 0.5 * radians, (sill + lintel) * 0.5 * radians);
    let nearness = |number: usize| rig.view(number).map_or(-2.0, |view| view.rotation.tr_mul(&middle).z);
    window.camera = u16::from(nearness(1) > nearness(0));
    window
}

/// One bit per column of the finest panorama: whether a chosen window covers it.
#[derive(Debug)]
struct Covered([u32; 45]);

impl Default for Covered {
    fn default() -> Self {
        Self([0; 45])
    }
}

impl Covered {
    fn add(&mut self, b: &WindowBox, resolution: Resolution) {
        for column in (b.start..b.end).map(|c| usize::from(c) % resolution.columns()) {
            if let Some(word) = self.0.get_mut(column / 32) {
                *word |= 1 << (column % 32);
            }
        }
    }

    fn has(&self, column: usize) -> bool {
        self.0.get(column / 32).is_some_and(|word| word >> (column % 32) & 1 == 1)
    }
}

/// Hit type and log odds of one bin, from the columns within half a degree of it; `None` if it is not seen.
fn direction(
    bin: usize,
    planes: &Planes<'_>,
    covered: &Covered,
    (columns, cut): (&[Column], usize),
) -> Option<(Hit, LogWeight)> {
    let per_degree = planes.resolution.per_degree();
    let first = (180 + BINS - bin) * per_degree - per_degree / 2;
    let of_bin = (first..first + per_degree).map(|column| column % planes.resolution.columns());
    let (mut windows, mut seen, mut odds) = (0, 0, LogWeight::ZERO);
    for column in of_bin {
        windows += usize::from(covered.has(column));
        let (known, all) = known(planes, column, SEEN_DEG);
        seen += usize::from(2 * known >= all);
        odds += choose::evidence(columns, cut, column);
    }
    let odds = odds / planes.resolution.per_degree_i32();
    if 2 * windows >= per_degree {
        return Some((Hit::Window, odds));
    }
    (2 * seen >= per_degree).then_some((Hit::Wall, odds))
}

/// |tanh(odds / 2)| in sixteenths, at least 1: the difference between the probabilities of window and wall.
fn confidence_of(odds: LogWeight) -> u8 {
    /// Bits of log odds from which the difference rounds to 2/16, 3/16 and so on up to 16/16.
    const STEPS: [u32; 15] = [48, 81, 114, 148, 183, 221, 260, 303, 350, 403, 463, 537, 632, 771, 1061];
    1 + STEPS.iter().map(|step| u8::from(odds.to_bits().unsigned_abs() >= *step)).sum::<u8>()
}
