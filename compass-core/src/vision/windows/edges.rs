//! Edges: near-vertical segments in the level frame, gathered where they continue each other.

use crate::vision::camera::{Bearing, Pixel, View};
use crate::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use crate::vision::panorama::{Resolution, TOP_DEG};
use crate::vision::projector::RIM_COS;
use crate::vision::segments::Segment;
use bytemuck::{Pod, Zeroable};
use heapless::Vec;

/// Fraction of a cell that positions count in.
pub(super) const FINE: i32 = 16;
/// A segment may lean this much: its azimuth range per elevation range (tangent of 3 degrees) ...
const LEAN: f32 = 0.052_407_78;
/// ... or by so many degrees, if short ...
const LEAN_DEG: f32 = 0.3;
/// ... but never more than this (12 degrees).
const MOST_LEAN: f32 = 0.21;
/// Shorter segments are no edges, degrees.
const SEGMENT_DEG: f32 = 1.5;
/// Segments that begin above this elevation or end below [`LOWEST_DEG`] belong to ceiling or floor.
const HIGHEST_DEG: f32 = 12.0;
const LOWEST_DEG: f32 = -8.0;
/// Segments this near to the last of an edge, and this near to its first, join it; degrees.
const GAP_DEG: f32 = 0.5;
const SPAN_DEG: f32 = 1.0;
/// An edge is at least so long, all its segments together, degrees.
const EDGE_DEG: f32 = 1.5;
/// Most edges.
pub(super) const MAX_EDGES: usize = 192;

/// A near-vertical segment on the ring; positions and lengths in 1/16 cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Upright {
    x: i32,
    top: i32,
    bottom: i32,
    length: i32,
}

impl Upright {
    /// For buffers.
    pub const EMPTY: Self = Self { x: 0, top: 0, bottom: 0, length: 0 };
}

/// A vertical line on the ring that may border a window; positions in 1/16 cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    pub(super) x: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
    /// Where the view ends: it has all heights, and no two of these make a window.
    pub(super) rim: bool,
}

impl Edge {
    /// Its column.
    #[must_use]
    pub fn column(&self) -> f32 {
        self.x as f32 / FINE as f32
    }

    /// The rows it begins and ends at, downwards.
    #[must_use]
    pub fn rows(&self) -> [f32; 2] {
        [self.top, self.bottom].map(|row| row as f32 / FINE as f32)
    }
}

/// An image segment as an upright, if it is one.
pub(super) fn upright(
    segment: &Segment,
    view: &View,
    level: &LevelFrame,
    resolution: Resolution,
) -> Option<Upright> {
    let degrees = 180.0 / core::f32::consts::PI;
    let end = |x, y| -> Option<(f32, f32)> {
        let bearing = view.camera.unproject(Pixel { x, y }).filter(|b| b.z > RIM_COS)?;
        let point: Bearing = view.rotation * bearing * NOMINAL_RANGE_M + view.position;
        let (azimuth, elevation) = level.direction(&(point / libm::sqrtf(point.dot(&point))));
        Some((azimuth * degrees, elevation * degrees))
    };
    let ((a0, e0), (a1, e1)) = (end(segment.x1, segment.y1)?, end(segment.x2, segment.y2)?);
    let turn = wrapped(a1 - a0);
    let middle = (e0 + e1) * (0.5 / degrees);
    let (across, along) = (turn.abs() * libm::cosf(middle), (e1 - e0).abs());
    let length = libm::sqrtf(across * across + along * along);
    let vertical = (across < LEAN * along || across < LEAN_DEG) && across < MOST_LEAN * along;
    let (low, high) = (e0.min(e1), e0.max(e1));
    if !vertical || length <= SEGMENT_DEG || low >= HIGHEST_DEG || high <= LOWEST_DEG {
        return None;
    }
    let fine = (FINE * resolution.per_degree() as i32) as f32;
    let cells = |degrees: f32| libm::floorf(degrees * fine + 0.5) as i32;
    Some(Upright {
        x: cells(180.0 - wrapped(a0 + turn * 0.5)),
        top: cells(TOP_DEG as f32 - high),
        bottom: cells(TOP_DEG as f32 - low),
        length: cells(length),
    })
}

/// The angle in degrees, brought to -180 to 180.
fn wrapped(angle: f32) -> f32 {
    if angle > 180.0 {
        angle - 360.0
    } else if angle < -180.0 {
        angle + 360.0
    } else {
        angle
    }
}

/// Gathers uprights into edges, sorted by column; false if there were too many edges.
pub(super) fn gather(
    uprights: &mut [Upright],
    resolution: Resolution,
    edges: &mut Vec<Edge, MAX_EDGES>,
) -> bool {
    sort_by_column(uprights);
    let fine = |degrees: f32| (degrees * (FINE * resolution.per_degree() as i32) as f32) as i32;
    let (gap, span, least) = (fine(GAP_DEG), fine(SPAN_DEG), fine(EDGE_DEG));
    let mut rest: &[Upright] = uprights;
    while let Some(first) = rest.first() {
        let mut last = first.x;
        let joins = |u: &&Upright| {
            let joined = u.x - last <= gap && u.x - first.x <= span;
            last = u.x;
            joined
        };
        let n = rest.iter().take_while(joins).count().max(1);
        let (group, others) = rest.split_at_checked(n).unwrap_or((rest, &[]));
        rest = others;
        let length: i32 = group.iter().map(|u| u.length).sum();
        if length < least {
            continue;
        }
        let weighted: i64 = group.iter().map(|u| i64::from(u.x) * i64::from(u.length)).sum();
        let edge = Edge {
            x: (weighted / i64::from(length.max(1))) as i32,
            top: group.iter().map(|u| u.top).min().unwrap_or(0),
            bottom: group.iter().map(|u| u.bottom).max().unwrap_or(0),
            rim: false,
        };
        if edges.push(edge).is_err() {
            return false;
        }
    }
    true
}

/// Insertion sort: lists are short, nearly sorted from the second camera on, and nothing can panic.
fn sort_by_column(uprights: &mut [Upright]) {
    for end in 1..uprights.len() {
        let mut at = end;
        while at > 0 {
            let (Some(before), Some(here)) = (uprights.get(at - 1).copied(), uprights.get(at).copied())
            else {
                break;
            };
            // Ties by all fields: the order must not depend on which camera came first.
            let key = |u: &Upright| (u.x, u.top, u.bottom, u.length);
            if key(&before) <= key(&here) {
                break;
            }
            uprights.swap(at - 1, at);
            at -= 1;
        }
    }
}
