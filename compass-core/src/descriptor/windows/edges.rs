//! Step 2: upright segments of the band, clustered to edges.

use super::parameters::Parameters;
use crate::base::order;
use crate::vision::segments::Segment;

/// Largest coordinate of a segment that is considered, px.
const FARTHEST: f32 = 65_534.0;

/// An upright edge: a cluster of segments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Edge {
    /// Mean column, weighted by length, in 1/16 px; pixel centres are at integers.
    pub x: u32,
    /// First row.
    pub y0: u16,
    /// One past the last row.
    pub y1: u16,
    /// Sum of the lengths of the segments, 1/16 px.
    pub length: u32,
}

impl Edge {
    /// The edge of a segment; `None` if it is not upright or too short.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "coordinates are 0 to 2^20 in 1/16 px, rows below 2^16"
    )]
    pub(super) fn upright(segment: &Segment, parameters: &Parameters) -> Option<Self> {
        let ends = [segment.x1, segment.y1, segment.x2, segment.y2];
        if !ends.iter().all(|v| (-0.5..=FARTHEST).contains(v)) {
            return None;
        }
        // 1/16 px, so at most 2^20.
        let [x1, y1, x2, y2] = ends.map(|v| (v * 16.0).max(0.0) as u32);
        let (dx, dy) = (u64::from(x1.abs_diff(x2)), u64::from(y1.abs_diff(y2)));
        let length = (dx * dx + dy * dy).isqrt() as u32;
        let steep = 1024 * dy > u64::from(parameters.slope) * dx;
        if !steep || length < 16 * u32::from(parameters.min_length) {
            return None;
        }
        let row = |y: u32| ((y + 8) / 16) as u16;
        Some(Self { x: x1.midpoint(x2), y0: row(y1.min(y2)), y1: row(y1.max(y2)) + 1, length })
    }

    /// Number of rows.
    pub(super) fn height(&self) -> u16 {
        self.y1.saturating_sub(self.y0)
    }

    /// Rows in common with another edge: the first, and one past the last.
    pub(super) fn shared(&self, other: &Self) -> Option<(u16, u16)> {
        let (y0, y1) = (self.y0.max(other.y0), self.y1.min(other.y1));
        (y0 < y1).then_some((y0, y1))
    }

    /// Adds a segment to the cluster.
    #[expect(clippy::cast_possible_truncation, reason = "a mean of 32-bit columns, and a saturated length")]
    fn merge(&mut self, other: &Self) {
        let weigh = |edge: &Self| u64::from(edge.x) * u64::from(edge.length);
        let total = u64::from(self.length) + u64::from(other.length);
        self.x = ((weigh(self) + weigh(other)) / total.max(1)) as u32;
        (self.y0, self.y1) = (self.y0.min(other.y0), self.y1.max(other.y1));
        self.length = total.min(u64::from(u32::MAX)) as u32;
    }
}

/// Writes the edges from left to right; returns their number, and whether the buffer was too small.
///
/// A segment belongs to the band if its middle does. It belongs to an edge if their distance along x is at most the gap and
/// they share rows.
pub(super) fn cluster(
    segments: &[Segment],
    band: (u16, u16),
    parameters: &Parameters,
    edges: &mut [Edge],
) -> (usize, bool) {
    let within = |edge: &Edge| (band.0..band.1).contains(&edge.y0.midpoint(edge.y1));
    let mut upright = segments.iter().filter_map(|s| Edge::upright(s, parameters)).filter(within);
    let mut taken = 0;
    for (slot, edge) in edges.iter_mut().zip(&mut upright) {
        *slot = edge;
        taken += 1;
    }
    let truncated = upright.next().is_some();
    let by_place = |edge: &Edge| (edge.x, edge.y0, edge.y1, edge.length);
    order::sort_by_key(edges.get_mut(..taken).unwrap_or_default(), by_place);

    let gap = 16 * u32::from(parameters.gap);
    let mut count = 0;
    for next in 0..taken {
        let Some((clusters, rest)) = edges.split_at_mut_checked(count) else { break };
        let Some(&edge) = rest.get(next - count) else { break };
        let near = |c: &&mut Edge| c.x.abs_diff(edge.x) <= gap && c.shared(&edge).is_some();
        if let Some(cluster) = clusters.iter_mut().rev().find(near) {
            cluster.merge(&edge);
        } else if let Some(slot) = rest.first_mut() {
            *slot = edge;
            count += 1;
        }
    }
    order::sort_by_key(edges.get_mut(..count).unwrap_or_default(), by_place);
    (count, truncated)
}
