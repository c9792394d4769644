//! Normalization of edges within the frame, and their support by neighbours.
//!
//! Boundaries are continuous: along a wall the rung changes by about one per degree at most. The evidence of a cell is a
//! weighted sum of its edge and of the strongest edges within reach in the three bins on either side.

use super::cells::RUNGS;
use super::tuning::{LEAST_SCALE, PERCENT, REACH, WEIGHTS};
#[cfg(doc)]
use crate::base::num::SupportNats;
use crate::base::num::{BINS, EdgeNats, saturate_to_u32, truncate_to_u8};

/// Bits of a normalized edge of 1 nat.
const EDGE_NAT: f32 = EdgeNats::ONE.to_bits() as f32;

/// Whether a third of the rungs of a bin is known, of the floor or of the ceiling.
pub(super) fn known(edges: &[u8]) -> [bool; BINS] {
    let mut counts = [[0_u8; 2]; BINS];
    for (surface, edges) in edges.chunks_exact(RUNGS * BINS).enumerate() {
        for row in edges.chunks_exact(BINS) {
            for (count, edge) in counts.iter_mut().zip(row) {
                if let Some(count) = count.get_mut(surface) {
                    *count += u8::from(*edge > 0);
                }
            }
        }
    }
    counts.map(|of| of.iter().any(|count| 3 * usize::from(*count) >= RUNGS))
}

/// Replaces edges by `ln(1 + 2 edge / scale)` in the bits of [`EdgeNats`]; unknown cells become 0.
#[expect(clippy::indexing_slicing, reason = "bytes index 256 entries")]
pub(super) fn normalize(edges: &mut [u8]) {
    let mut counts = [0_u32; 256];
    edges.iter().for_each(|edge| counts[usize::from(*edge)] += 1);
    counts[0] = 0;
    let wanted = counts.iter().sum::<u32>() / 100 * PERCENT;
    let mut below = 0;
    let reached = counts.iter().position(|count| {
        below += count;
        below > wanted
    });
    let scale = saturate_to_u32(reached.unwrap_or(0)).saturating_sub(1).max(LEAST_SCALE) as f32;
    let logs: [u8; 256] = core::array::from_fn(|edge| {
        let strength = edge.saturating_sub(1) as f32;
        truncate_to_u8(libm::log1pf(2.0 * strength / scale) * EDGE_NAT)
    });
    edges.iter_mut().for_each(|edge| *edge = logs[usize::from(*edge)]);
}

/// Computes the evidence of each cell, saturated, in the bits of [`SupportNats`], from normalized edges.
pub(super) fn gather(edges: &[u8], support: &mut [u8]) {
    let surfaces = edges.chunks_exact(RUNGS * BINS).zip(support.chunks_exact_mut(RUNGS * BINS));
    for ((edges, support), [own, others]) in surfaces.zip(WEIGHTS) {
        for (rung, out) in support.chunks_exact_mut(BINS).enumerate() {
            let mut sums = [0_u16; BINS];
            let mut strongest = PaddedBins { cells: [0; BINS + 2 * REACH] };
            for reach in 0..=REACH {
                for row in [rung.checked_sub(reach), rung.checked_add(reach)].into_iter().flatten() {
                    strongest.raise(edges.get(row * BINS..(row + 1) * BINS).unwrap_or(&[]));
                }
                if reach > 0 {
                    strongest.add_neighbours(&mut sums, reach);
                }
            }
            let here = edges.get(rung * BINS..).unwrap_or(&[]);
            for ((out, sum), edge) in out.iter_mut().zip(&sums).zip(here) {
                *out = ((u32::from(*edge) * own + u32::from(*sum) * others) >> 8).min(255) as u8;
            }
        }
    }
}

/// One value per bin, padded on both sides by the values of the bins around the circle.
struct PaddedBins {
    cells: [u8; BINS + 2 * REACH],
}

impl PaddedBins {
    /// Takes the maximum of each value and that of a row.
    fn raise(&mut self, row: &[u8]) {
        let bins = self.cells.iter_mut().skip(REACH);
        bins.zip(row).for_each(|(most, edge)| *most = (*most).max(*edge));
    }

    /// Adds to `sums` the values `distance` bins to either side; `distance` is at most [`REACH`].
    fn add_neighbours(&mut self, sums: &mut [u16; BINS], distance: usize) {
        self.cells.copy_within(REACH..2 * REACH, BINS + REACH);
        self.cells.copy_within(BINS..BINS + REACH, 0);
        let from = |start: usize| self.cells.get(start..start + BINS).unwrap_or(&[]);
        let (right, left) = (from(REACH - distance.min(REACH)), from(REACH + distance.min(REACH)));
        for ((sum, right), left) in sums.iter_mut().zip(right).zip(left) {
            *sum += u16::from(*right) + u16::from(*left);
        }
    }
}
