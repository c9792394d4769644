//! The ring: what both cameras see, as a panorama of azimuth and elevation levelled by the up vector.
//!
//! Its cells lie column by column, so that what is measured between two heights is contiguous. Columns go clockwise,
//! from 180 degrees at the left border of the first; rows go down.

use crate::camera::{Bearing, Rig, View};
use crate::raster::{BitMask, GrayImage, RgbImage, is_red};
use nalgebra::{Matrix3, Vector3};

/// Elevation of the upper border of row 0, degrees.
pub const TOP_DEG: i32 = 35;
/// Elevation of the lower border of the last row, degrees.
pub const BOTTOM_DEG: i32 = -30;
/// Bearings further than this from a camera's axis are left to nobody: cosine of 95 degrees.
pub(super) const RIM_COS: f32 = -0.087_155_74;
/// Distance, in metres, at which the baseline between the cameras is made good exactly. What stands
/// elsewhere, at r metres, comes out by baseline |1/r - 1/6| radians aside at worst: 0.8 degrees at 2 m
/// and 0.4 degrees far away for 40 mm, beside the camera, and nothing behind it.
pub const NOMINAL_RANGE_M: f32 = 6.0;
/// The projection is computed for every so many-th border of a cell, and interpolated between: 2 or 4 degrees.
const SIDE: usize = 8;
/// Most rows of that grid, both borders included.
const GRID_ROWS: usize = Resolution::FINE.rows().div_ceil(SIDE) + 1;
/// Nodes that trail by more border on no cell that is this camera's: between opposite corners of 4 by 4 degrees a lead
/// changes by at most twice the sine of 5.7 degrees, and by very little for the cameras' distance.
const BEHIND: f32 = -0.22;
/// Fraction bits of a position in the image.
pub(crate) const SUBPIXEL: u32 = 8;

/// Size of a ring's cells: their number in a degree, 2 or 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Resolution(PerDegree);

/// The numbers there can be: whatever is divided by one of them is not divided by 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum PerDegree {
    Two = 2,
    Four = 4,
}

impl Resolution {
    /// Quarters of a degree: for lenses of 4 pixels and more a degree.
    pub const FINE: Self = Self(PerDegree::Four);
    /// Halves of a degree: for lenses of 2 pixels a degree.
    pub const COARSE: Self = Self(PerDegree::Two);

    /// The resolution that does not ask more of a camera than its image holds.
    #[must_use]
    pub fn of(view: &View) -> Self {
        if pixels_per_degree(view) < 3.0 { Self::COARSE } else { Self::FINE }
    }

    /// Cells in a degree.
    #[must_use]
    pub const fn per_degree(self) -> usize {
        self.0 as usize
    }

    /// Columns of a ring.
    #[must_use]
    pub const fn columns(self) -> usize {
        360 * self.per_degree()
    }

    /// Rows of a ring.
    #[must_use]
    pub const fn rows(self) -> usize {
        (TOP_DEG - BOTTOM_DEG) as usize * self.per_degree()
    }

    /// Cells of a ring.
    #[must_use]
    pub const fn cells(self) -> usize {
        self.columns() * self.rows()
    }
}

/// Pixels in a degree at the middle of a view.
pub(super) fn pixels_per_degree(view: &View) -> f32 {
    view.camera.intrinsics().fx * (core::f32::consts::PI / 180.0)
}

/// The level frame in camera 0: forward is its optical axis brought to the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Rows are forward, left and up, unit vectors in camera 0.
    axes: Matrix3<f32>,
}

impl Level {
    /// From the up vector in camera 0, of any length; `None` if it is not finite, zero, or along the
    /// optical axis, which leaves no heading.
    #[must_use]
    pub fn new(up: &Bearing) -> Option<Self> {
        let unit = |v: Vector3<f32>| {
            let length = libm::sqrtf(v.dot(&v));
            (length.is_finite() && length > 1e-3).then(|| v / length)
        };
        let up = unit(*up)?;
        let axis = Vector3::z();
        let forward = unit(axis - up * up.z)?;
        let left = up.cross(&forward);
        Some(Self { axes: Matrix3::from_rows(&[forward.transpose(), left.transpose(), up.transpose()]) })
    }

    /// The up vector in camera 0.
    #[must_use]
    pub fn up(&self) -> Bearing {
        self.axes.row(2).transpose()
    }

    /// The unit vector in camera 0 at an azimuth (counter-clockwise seen from above) and elevation, radians.
    #[must_use]
    pub fn bearing(&self, azimuth: f32, elevation: f32) -> Bearing {
        self.bearing_of(libm::sincosf(azimuth), libm::sincosf(elevation))
    }

    /// The same from sine and cosine of both.
    fn bearing_of(&self, (sin_a, cos_a): (f32, f32), (sin_e, cos_e): (f32, f32)) -> Bearing {
        self.axes.tr_mul(&Vector3::new(cos_e * cos_a, cos_e * sin_a, sin_e))
    }

    /// Azimuth and elevation, radians, of a unit vector in camera 0.
    #[must_use]
    pub fn direction(&self, bearing: &Bearing) -> (f32, f32) {
        let level = self.axes * bearing;
        (libm::atan2f(level.y, level.x), libm::asinf(level.z.clamp(-1.0, 1.0)))
    }
}

/// Where red is, for what is to be left out as safety gear.
#[derive(Debug, Clone, Copy)]
pub enum Red<'a> {
    /// Not known: nothing is left out.
    Unknown,
    /// Judged by [`is_red`] from the colours of the image.
    Colours(RgbImage<'a>),
    /// Set where the image is red.
    Mask(BitMask<'a>),
}

impl Red<'_> {
    /// At a position in 1/256 px.
    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> bool {
        // What is left of the image or above it lies beyond its other border as well.
        let (x, y) = ((x >> SUBPIXEL) as u32, (y >> SUBPIXEL) as u32);
        match self {
            Self::Unknown => false,
            Self::Colours(image) => is_red(image.pixel(x, y)),
            Self::Mask(mask) => mask.get(x, y),
        }
    }
}

/// Where bearings of the level frame fall in one camera's image.
pub(crate) struct Projector<'a> {
    view: &'a View,
    rival: Option<&'a View>,
    level: Level,
}

/// A point of the projection grid: position in 1/256 px, and how much nearer to this camera's axis than to the
/// other's it is (cosines times 2^14).
#[derive(Clone, Copy, Default)]
pub(crate) struct Node {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) lead: i32,
    pub(crate) usable: bool,
}

impl<'a> Projector<'a> {
    /// For one camera of a rig; `None` if it has no such camera.
    pub(crate) fn new(rig: &'a Rig, camera: usize, level: Level) -> Option<Self> {
        Some(Self { view: rig.view(camera)?, rival: rig.view(1 - camera.min(1)), level })
    }

    /// From sine and cosine of azimuth and elevation.
    pub(crate) fn node(&self, azimuth: (f32, f32), elevation: (f32, f32)) -> Node {
        let bearing = self.level.bearing_of(azimuth, elevation);
        let seen_from = |view: &View| -> Bearing {
            let b = view.rotation.tr_mul(&(bearing * NOMINAL_RANGE_M - view.position));
            b / libm::sqrtf(b.dot(&b))
        };
        let mine = seen_from(self.view);
        // Leaving the rim of the field counts as losing to the other camera.
        let within = (mine.z - RIM_COS) * 8.0;
        let lead = |lead: f32| (lead * 16_384.0) as i32;
        if mine.z <= RIM_COS - 0.05 {
            return Node { lead: lead(within), ..Node::default() };
        }
        let ahead = self.rival.map_or(1.0, |rival| mine.z - seen_from(rival).z);
        // The lens is what costs: where the other camera is far ahead nothing will be looked up.
        let pixel = if ahead > BEHIND { self.view.camera.project(&mine) } else { None };
        let scale = (1 << SUBPIXEL) as f32;
        // Within 2^13 pixels, so that weights of 9 bits fit as well.
        let fixed = |v: f32| (v.clamp(-8_192.0, 8_192.0) * scale) as i32;
        Node {
            x: pixel.map_or(0, |p| fixed(p.x)),
            y: pixel.map_or(0, |p| fixed(p.y)),
            lead: lead(if ahead < within { ahead } else { within }),
            usable: pixel.is_some(),
        }
    }
}

/// Draws what one camera sees into the ring: gray levels 1 to 255; cells that it does not see, or where safety
/// gear is, are left as they are.
///
/// The camera nearest to a bearing by its axis has it; `rig` must therefore hold those that are in use.
#[inline(always)]
pub(super) fn draw(
    cells: &mut [u8],
    resolution: Resolution,
    rig: &Rig,
    camera: usize,
    level: Level,
    (image, red): (&GrayImage<'_>, Red<'_>),
) {
    let Some(projector) = Projector::new(rig, camera, level) else { return };
    let grid = SIDE as i32 / resolution.per_degree() as i32;
    let angle = |from: i32, node: usize| {
        libm::sincosf((from - node as i32 * grid) as f32 * (core::f32::consts::PI / 180.0))
    };
    let elevations: [_; GRID_ROWS] = core::array::from_fn(|row| angle(TOP_DEG, row));
    let rows = resolution.rows().div_ceil(SIDE);
    let nodes = |column: usize| {
        let azimuth = angle(180, column);
        let mut nodes = [Node::default(); GRID_ROWS];
        for (node, elevation) in nodes.iter_mut().zip(elevations).take(rows + 1) {
            *node = projector.node(azimuth, elevation);
        }
        nodes
    };
    let mut left = nodes(0);
    for column in 0..resolution.columns() / SIDE {
        let right = nodes(column + 1);
        let pairs = left.windows(2).zip(right.windows(2)).take(rows).enumerate();
        for (row, (left, right)) in pairs {
            let (&[a, c], &[b, d]) = (left, right) else { continue };
            let corners = [a, b, c, d];
            if corners.iter().all(|n| n.usable) && corners.iter().any(|n| n.lead > 0) {
                draw_patch(cells, resolution, (column, row), &corners, image, red);
            }
        }
        left = right;
    }
}

/// Draws the cells between four nodes, `SIDE` a side: upper left, upper right, lower left, lower right.
///
/// A column at a time, in arrays: positions and levels then come in vectors, and only the pixels one by one.
#[inline(always)]
fn draw_patch(
    cells: &mut [u8],
    resolution: Resolution,
    (column, row): (usize, usize),
    [a, b, c, d]: &[Node; 4],
    image: &GrayImage<'_>,
    red: Red<'_>,
) {
    // Cell centres lie at odd halves of cells, so weights are of `2 SIDE`, a power of two.
    let bits = SIDE.trailing_zeros() + 1;
    let twice = 2 * SIDE as i32;
    let top = row * SIDE;
    let height = SIDE.min(resolution.rows().saturating_sub(top));
    // Red is looked for in every other cell of every other column, and taken to be around it.
    let mut hidden = [false; SIDE];
    for u in 0..SIDE {
        let wx = 2 * u as i32 + 1;
        let blend = |left: i32, right: i32| left * (twice - wx) + right * wx;
        let down = |upper: i32, lower: i32| {
            let mut places = [0; SIDE];
            for (v, place) in places.iter_mut().enumerate() {
                let wy = 2 * v as i32 + 1;
                *place = (upper * (twice - wy) + lower * wy) >> (2 * bits);
            }
            places
        };
        let x = down(blend(a.x, b.x), blend(c.x, d.x));
        let y = down(blend(a.y, b.y), blend(c.y, d.y));
        let lead = down(blend(a.lead, b.lead), blend(c.lead, d.lead));
        let [mut upper_left, mut upper_right, mut lower_left, mut lower_right] = [[0; SIDE]; 4];
        let mut seen = [0; SIDE];
        for v in 0..height {
            if v % 2 == 0 && u % 2 == 0 {
                hidden[v] = red.at(x[v], y[v]);
            }
            if lead[v] > 0
                && !hidden[v & !1]
                && let Some(four) = around(image, x[v], y[v])
            {
                [upper_left[v], upper_right[v], lower_left[v], lower_right[v]] = four;
                seen[v] = u8::MAX;
            }
        }
        let mut levels = [0; SIDE];
        for (v, level) in levels.iter_mut().enumerate() {
            let four = [upper_left[v], upper_right[v], lower_left[v], lower_right[v]];
            *level = between(four, x[v], y[v]) & seen[v];
        }
        let start = (column * SIDE + u) * resolution.rows() + top;
        let cells = cells.get_mut(start..start + height).unwrap_or(&mut []);
        for ((cell, level), lead) in cells.iter_mut().zip(levels).zip(lead) {
            *cell = if lead > 0 { level } else { *cell };
        }
    }
}

/// The gray level at a position, 1 to 255; 0 within a pixel of the image's border, outside it, or on red.
#[inline(always)]
pub(crate) fn look(image: &GrayImage<'_>, red: Red<'_>, x: i32, y: i32) -> u8 {
    let four = around(image, x, y).filter(|_| !red.at(x, y));
    four.map_or(0, |four| between(four, x, y))
}

/// The four pixels around a position; `None` within a pixel of the image's border or outside it.
#[inline(always)]
fn around(image: &GrayImage<'_>, x: i32, y: i32) -> Option<[u8; 4]> {
    let (column, row) = (x >> SUBPIXEL, y >> SUBPIXEL);
    let width = image.width() as usize;
    if column < 1 || row < 1 || column + 2 >= width as i32 || row + 2 >= image.height() as i32 {
        return None;
    }
    let start = row as usize * width + column as usize;
    match image.pixels().get(start..start + width + 2) {
        Some([a, b, .., c, d]) => Some([*a, *b, *c, *d]),
        _ => None,
    }
}

/// The gray level at a position between four pixels, 1 to 255.
#[inline(always)]
fn between(four: [u8; 4], x: i32, y: i32) -> u8 {
    let [a, b, c, d] = four.map(i32::from);
    let (wx, wy) = (x & 0xff, y & 0xff);
    let top = (a << 8) + (b - a) * wx;
    let bottom = (c << 8) + (d - c) * wx;
    let gray = ((top << 8) + (bottom - top) * wy + (1 << 15)) >> 16;
    gray.clamp(1, 255) as u8
}
