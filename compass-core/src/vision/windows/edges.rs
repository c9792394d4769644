//! Edges: near-vertical segments in the level frame, grouped by azimuth.

use super::tuning::{
    EDGE_DEG, GAP_DEG, HIGHEST_DEG, LEAN, LEAN_DEG, LOWEST_DEG, MOST_LEAN, SEGMENT_DEG, SPAN_DEG,
};
use crate::base::num::truncate_to_i32;
use crate::vision::camera::{Bearing, Pixel, View};
use crate::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use crate::vision::panorama::{Resolution, TOP_DEG};
use crate::vision::projector::RIM_COS;
use crate::vision::segments::Segment;
use bytemuck::{Pod, Zeroable};
use heapless::Vec;

/// Units of position per cell.
pub(super) const FINE: i32 = 16;
/// Capacity of the list of edges.
pub(super) const MAX_EDGES: usize = 192;

/// A near-vertical segment in the panorama; positions and length in 1/16 cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct VerticalSegment {
    x: i32,
    top: i32,
    bottom: i32,
    length: i32,
}

impl VerticalSegment {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self { x: 0, top: 0, bottom: 0, length: 0 };
}

/// A vertical line in the panorama that may bound a window; positions in 1/16 cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    pub(super) x: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
    /// Whether it is the end of the view: such an edge has all rows, and no two of them make a box.
    pub(super) rim: bool,
}

impl Edge {
    /// Its column, in cells.
    #[must_use]
    pub fn column(&self) -> f32 {
        self.x as f32 / FINE as f32
    }

    /// First and last row, in cells, downwards.
    #[must_use]
    pub fn rows(&self) -> [f32; 2] {
        [self.top, self.bottom].map(|row| row as f32 / FINE as f32)
    }
}

/// An image segment in the panorama; `None` if it is not near-vertical, too short, or on floor or ceiling.
pub(super) fn vertical_segment(
    segment: &Segment,
    view: &View,
    level: &LevelFrame,
    resolution: Resolution,
) -> Option<VerticalSegment> {
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
    let fine = (FINE * resolution.per_degree_i32()) as f32;
    let cells = |degrees: f32| truncate_to_i32(libm::floorf(degrees * fine + 0.5));
    Some(VerticalSegment {
        x: cells(180.0 - wrapped(a0 + turn * 0.5)),
        top: cells(TOP_DEG as f32 - high),
        bottom: cells(TOP_DEG as f32 - low),
        length: cells(length),
    })
}

/// The angle in degrees, wrapped to -180 to 180.
fn wrapped(angle: f32) -> f32 {
    if angle > 180.0 {
        angle - 360.0
    } else if angle < -180.0 {
        angle + 360.0
    } else {
        angle
    }
}

/// Groups vertical segments into edges, sorted by column; false if there are more than [`MAX_EDGES`].
#[expect(clippy::cast_possible_truncation, reason = "a weighted mean of `i32` values lies between them")]
pub(super) fn gather(
    segments: &mut [VerticalSegment],
    resolution: Resolution,
    edges: &mut Vec<Edge, MAX_EDGES>,
) -> bool {
    sort_by_column(segments);
    let fine = |degrees: f32| truncate_to_i32(degrees * (FINE * resolution.per_degree_i32()) as f32);
    let (gap, span, least) = (fine(GAP_DEG), fine(SPAN_DEG), fine(EDGE_DEG));
    let mut rest: &[VerticalSegment] = segments;
    while let Some(first) = rest.first() {
        let mut last = first.x;
        let joins = |u: &&VerticalSegment| {
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

/// Insertion sort: lists are short, nearly sorted from the second camera on, and it has no panic path.
fn sort_by_column(segments: &mut [VerticalSegment]) {
    for end in 1..segments.len() {
        let mut at = end;
        while at > 0 {
            let (Some(before), Some(here)) = (segments.get(at - 1).copied(), segments.get(at).copied())
            else {
                break;
            };
            // All fields break ties, so that the order does not depend on that of the cameras.
            let key = |u: &VerticalSegment| (u.x, u.top, u.bottom, u.length);
            if key(&before) <= key(&here) {
                break;
            }
            segments.swap(at - 1, at);
            at -= 1;
        }
    }
}
