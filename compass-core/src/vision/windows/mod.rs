//! Windows in the level frame: both cameras on one ring of azimuth and elevation.
//!
//! frames -> ring (planes of brightness rank and texture) -> edges (near-vertical segments) -> boxes (pairs of edges,
//! scored) -> choice around the circle -> hit type and evidence of 360 bins.
//!
//! "Vertical" is towards the up vector, sizes are angles, and every level is relative to the frame: neither a tilted
//! or upside-down mounting nor the exposure matters. A box that swallows several windows loses to the sum of its parts.

mod boxes;
mod choose;
mod edges;
mod planes;
mod ring;

pub use boxes::WindowBox;
pub use choose::Column;
pub use edges::{Edge, Upright};

use crate::base::confidence::Confidence;
use crate::base::num::{BINS, LogOdds, LogWeight, log_odds};
use crate::base::raster::GrayImage;
use crate::base::scan::Hit;
use crate::vision::camera::{Pixel, Rig};
use crate::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use crate::vision::panorama::{Resolution, TOP_DEG, pixels_per_degree};
use crate::vision::projector::CameraView;
use crate::vision::sample::ExclusionMask;
use crate::vision::segments::{Parameters, Segment};
use boxes::{LEAST_SCORE, Planes, WIDEST_DEG};
use bytemuck::{Pod, Zeroable};
use edges::{FINE, MAX_EDGES};
use heapless::Vec;

/// Most near-vertical segments of both cameras that [`Buffers::uprights`] need hold in a built-up scene.
pub const MAX_UPRIGHTS: usize = 512;
/// Most boxes that [`Buffers::boxes`] need hold in a built-up scene.
pub const MAX_BOXES: usize = 2048;
/// A column of the ring is seen if half of its cells between these elevations are, degrees.
const SEEN_DEG: [i32; 2] = [-3, 5];
/// The view ends where less than 4/5 of a column between these elevations is seen, degrees.
const RIM_DEG: [i32; 2] = [-4, 6];

/// Memory lent to a [`WindowFinder`]; what it holds before does not matter.
#[derive(Debug)]
pub struct Buffers<'a> {
    /// [`Resolution::cells`] elements: brightness.
    pub gray: &'a mut [u8],
    /// [`Resolution::cells`] elements: texture.
    pub texture: &'a mut [u8],
    /// [`Resolution::columns`] + 1 elements.
    pub columns: &'a mut [Column],
    /// Up to [`MAX_UPRIGHTS`] elements; fewer may truncate the result.
    pub uprights: &'a mut [Upright],
    /// Up to [`MAX_BOXES`] elements; fewer may truncate the result.
    pub boxes: &'a mut [WindowBox],
}

/// A window on the ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct Window {
    /// First column and the one after the last, clockwise; the latter may lie beyond the ring's last.
    pub columns: [u16; 2],
    /// First row and the one after the last, downwards.
    pub rows: [u16; 2],
    /// Log odds that it is a window.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub score: LogOdds,
    /// The camera that sees its middle.
    pub camera: u16,
}

impl Window {
    /// For buffers.
    pub const EMPTY: Self = Self { columns: [0; 2], rows: [0; 2], score: LogOdds::ZERO, camera: 0 };

    /// Azimuths in degrees counter-clockwise from the heading, from the right edge to the left; the first within
    /// -180 to 180.
    #[must_use]
    pub fn azimuth_deg(&self, resolution: Resolution) -> [f32; 2] {
        let [left, right] = self.columns.map(|c| 180.0 - f32::from(c) / resolution.per_degree() as f32);
        let turn = if right < -180.0 { 360.0 } else { 0.0 };
        [right + turn, left + turn]
    }

    /// Elevations in degrees, from sill to lintel.
    #[must_use]
    pub fn elevation_deg(&self, resolution: Resolution) -> [f32; 2] {
        let [top, bottom] = self.rows.map(|r| TOP_DEG as f32 - f32::from(r) / resolution.per_degree() as f32);
        [bottom, top]
    }
}

/// Window or wall in each direction.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WindowEvidence {
    /// Number of windows written.
    pub count: usize,
    /// Whether a list overflowed: windows may be missing.
    pub truncated: bool,
    /// Window or wall of bin j, heading + j degrees counter-clockwise. What is not seen says wall, with confidence 0.
    pub hit: [Hit; BINS],
    /// How sure that is: 0 for what neither camera sees, or safety gear hides.
    pub confidence: Confidence,
    /// Log odds of a window in each bin, within -4 to 4 nats; 0 where nothing is seen.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub evidence: [LogOdds; BINS],
    /// Number of near-vertical segments left in [`Buffers::uprights`]: for pictures of what was considered.
    pub uprights: usize,
    /// Number of boxes left in [`Buffers::boxes`].
    pub boxes: usize,
}

impl WindowEvidence {
    /// Nothing was seen. Every byte is zero.
    pub const NOTHING: Self = Self {
        count: 0,
        truncated: false,
        hit: [Hit::Open; BINS],
        confidence: Confidence::NONE,
        evidence: [LogOdds::ZERO; BINS],
        uprights: 0,
        boxes: 0,
    };
}

/// Finds windows in the frames of a rig, one camera after the other.
#[derive(Debug)]
pub struct WindowFinder<'a, 'r> {
    buffers: Buffers<'a>,
    resolution: Resolution,
    rig: &'r Rig,
    level: LevelFrame,
    uprights: usize,
    truncated: bool,
}

impl<'a, 'r> WindowFinder<'a, 'r> {
    /// Begins a pair of frames; `rig` has the cameras that will be given, and no others. `None` if a buffer is
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
        Some(Self { buffers, resolution, rig, level, uprights: 0, truncated: false })
    }

    // Inlined down to the loops over cells, as [`crate::vision::segments::detect`] is and for the same reason.
    /// Adds what one camera sees: its frame, or the smoothed one where [`wants_smoothed`] says so, and its segments.
    #[inline(always)]
    pub fn add(
        &mut self,
        camera: usize,
        image: &GrayImage<'_>,
        red: ExclusionMask<'_>,
        segments: &[Segment],
    ) {
        let Some(view) = self.rig.view(camera) else { return };
        let seen = CameraView { rig: self.rig, camera, level: self.level, image, excluded: red };
        ring::draw(self.buffers.gray, self.resolution, &seen);
        for upright in segments.iter().filter_map(|s| edges::upright(s, view, &self.level, self.resolution)) {
            match self.buffers.uprights.get_mut(self.uprights) {
                Some(slot) => {
                    *slot = upright;
                    self.uprights += 1;
                }
                None => self.truncated = true,
            }
        }
    }

    /// Finds the windows, at most as many as `windows` holds, from left to right around the circle.
    ///
    /// # Cost
    /// Passes over the cells; for each pair of at most 192 edges no more than 32 columns of the box between them and of
    /// each of its flanks; for each column the boxes that begin or end there.
    #[inline(always)]
    pub fn finish(mut self, windows: &mut [Window]) -> WindowEvidence {
        planes::normalize(self.buffers.gray, self.buffers.texture, self.resolution);
        let planes =
            Planes { rank: self.buffers.gray, texture: self.buffers.texture, resolution: self.resolution };
        let mut edges = Vec::new();
        let uprights = self.buffers.uprights.get_mut(..self.uprights).unwrap_or(&mut []);
        self.truncated |= !edges::gather(uprights, self.resolution, &mut edges);
        self.truncated |= !add_rims(&planes, &mut edges);
        let (proposed, all) = propose(&planes, &edges, self.buffers.boxes);
        self.truncated |= !all;
        let boxes = self.buffers.boxes.get_mut(..proposed).unwrap_or(&mut []);
        let cut = choose::choose(boxes, self.buffers.columns);
        let mut sighting = WindowEvidence {
            truncated: self.truncated,
            hit: [Hit::Wall; BINS],
            uprights: self.uprights,
            boxes: proposed,
            ..WindowEvidence::NOTHING
        };
        let mut confidence = [0; BINS];
        let mut covered = Covered::default();
        for b in choose::chosen(boxes, self.buffers.columns) {
            covered.add(b, self.resolution);
            match windows.get_mut(sighting.count) {
                Some(slot) => {
                    *slot = window(b, self.rig, &self.level, self.resolution);
                    sighting.count += 1;
                }
                None => sighting.truncated = true,
            }
        }
        windows.get_mut(..sighting.count).unwrap_or(&mut []).reverse();
        let bins = sighting.hit.iter_mut().zip(&mut sighting.evidence).zip(&mut confidence);
        for (bin, ((hit, evidence), confidence)) in bins.enumerate() {
            if let Some((judged, odds)) = judge(bin, &planes, &covered, (self.buffers.columns, cut)) {
                *hit = judged;
                *evidence = log_odds(odds);
                *confidence = sureness(odds);
            }
        }
        sighting.confidence = Confidence::new(&confidence);
        sighting
    }
}

/// Visits the edges that near-vertical segments make, as [`WindowFinder::finish`] gathered them, from left to right; not
/// those where the view ends.
pub fn visit_edges(uprights: &mut [Upright], resolution: Resolution, visit: impl FnMut(&Edge)) {
    let mut edges = Vec::new();
    edges::gather(uprights, resolution, &mut edges);
    edges.iter().for_each(visit);
}

/// What to look for when detecting the segments of a view: faint edges too, and short ones if the image is small.
#[must_use]
pub fn segment_parameters(view: &crate::vision::camera::View) -> Parameters {
    let usual = Parameters { gradient_threshold: 20, anchor_threshold: 4, ..Parameters::default() };
    if Resolution::of(view) == Resolution::COARSE {
        return Parameters { min_length: 8, ..usual };
    }
    usual
}

/// The sky must exceed the ground by more than one in this many of the whole range of brightness ranks.
const SKY_SHARE: u64 = 50;

/// Whether what lies outside the windows is brighter above than below, as sky and ground are: `Some(false)` says that up
/// and down were exchanged; `None` without windows, or if neither is brighter. `rank` is [`Buffers::gray`] after
/// [`WindowFinder::finish`].
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

/// Whether a ring at this resolution skips pixels of the view's image, so that it is to be drawn from the smoothed one.
#[must_use]
pub fn wants_smoothed(view: &crate::vision::camera::View, resolution: Resolution) -> bool {
    pixels_per_degree(view) > 1.5 * resolution.per_degree() as f32
}

/// All pairs of edges that may be windows, scored; their number, and whether there was room for all.
#[inline(always)]
fn propose(planes: &Planes<'_>, edges: &[Edge], boxes: &mut [WindowBox]) -> (usize, bool) {
    let fine = FINE * planes.resolution.per_degree() as i32;
    let (turn, widest) = (360 * fine, WIDEST_DEG as i32 * fine);
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

/// Known cells of a column between two elevations, and how many there are.
#[inline(always)]
fn known(planes: &Planes<'_>, column: usize, [low, high]: [i32; 2]) -> (usize, usize) {
    let resolution = planes.resolution;
    let row = |elevation: i32| (TOP_DEG - elevation) as usize * resolution.per_degree();
    let rows = row(high)..row(low);
    let start = column * resolution.rows();
    let cells = planes.rank.get(start + rows.start..start + rows.end).unwrap_or(&[]);
    (cells.iter().filter(|rank| **rank > 0).count(), rows.len())
}

/// Adds an edge of all heights where the view ends, keeping the order; false if there is no room.
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
            let x = column as i32 * FINE;
            let edge = Edge { x, top: 0, bottom: planes.resolution.rows() as i32 * FINE, rim: true };
            let at = edges.iter().position(|e| e.x > x).unwrap_or(edges.len());
            if edges.insert(at, edge).is_err() {
                return false;
            }
        }
        before = here;
    }
    true
}

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

/// The smallest box in a camera's image, `[x0, y0, x1, y1]` in pixels, around a window; `None` if no part of its outline
/// falls in the image.
#[must_use]
pub fn image_box(window: &Window, rig: &Rig, level: &LevelFrame, resolution: Resolution) -> Option<[f32; 4]> {
    /// Points along each side.
    const POINTS: usize = 9;
    let view = rig.view(usize::from(window.camera))?;
    let radians = core::f32::consts::PI / 180.0;
    let ([right, left], [sill, lintel]) = (window.azimuth_deg(resolution), window.elevation_deg(resolution));
    let along =
        |from: f32, to: f32, k: usize| (from + (to - from) * (k as f32 / (POINTS - 1) as f32)) * radians;
    let (most_x, most_y) = (f32::from(view.width) - 1.0, f32::from(view.height) - 1.0);
    let mut extent: Option<[f32; 4]> = None;
    for (u, v) in (0..POINTS * POINTS).map(|k| (k % POINTS, k / POINTS)) {
        let bearing = level.bearing(along(right, left, u), along(sill, lintel, v));
        let seen = view.rotation.tr_mul(&(bearing * NOMINAL_RANGE_M - view.position));
        let Some(Pixel { x, y }) = view.camera.project(&seen) else { continue };
        let (x, y) = (x.max(0.0).min(most_x), y.max(0.0).min(most_y));
        let [x0, y0, x1, y1] = extent.unwrap_or([x, y, x, y]);
        extent = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
    }
    extent
}

/// One bit for each column of the finest ring: whether a window chosen covers it.
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
fn judge(
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
    let odds = odds / per_degree as i32;
    if 2 * windows >= per_degree {
        return Some((Hit::Window, odds));
    }
    (2 * seen >= per_degree).then_some((Hit::Wall, odds))
}

/// tanh of half the log odds, in sixteenths, at least 1: by how much the likelier hit type exceeds the other.
fn sureness(odds: LogWeight) -> u8 {
    /// Bits of log odds from which the share rounds to 2/16, 3/16 ... 16/16.
    const STEPS: [u32; 15] = [48, 81, 114, 148, 183, 221, 260, 303, 350, 403, 463, 537, 632, 771, 1061];
    1 + STEPS.iter().filter(|step| odds.to_bits().unsigned_abs() >= **step).count() as u8
}
