//! Evidence of the boundaries of floor and ceiling, and the vote for the height of the ceiling.

use super::ranges::{self, RangeLikelihoods};
use super::tuning::CEILINGS;
use super::{CELLS, RUNGS};
use crate::base::ladder::height_m;
use crate::base::num::{BINS, Nats};
use core::cmp::Reverse;
use heapless::Vec;

/// Largest number of ceiling heights that [`BoundaryEvidence::ceilings`] returns.
pub const MAX_CEILINGS: usize = 4;

/// Evidence of boundaries of the floor and of the ceiling, per direction and rung.
///
/// Sills, lintels and beams also vote for a ceiling, at another height; only the plan can decide between them. Therefore
/// there are several [`ceilings`](Self::ceilings), each with its own [`ranges`](Self::ranges).
#[derive(Debug, Clone, Copy)]
pub struct BoundaryEvidence<'a> {
    cells: &'a [u8],
    known: [bool; BINS],
}

impl<'a> BoundaryEvidence<'a> {
    /// Restores evidence from its [`cells`](Self::cells) and [`known`](Self::known) bins. `None` if `cells` does not have
    /// [`CELLS`] bytes.
    #[must_use]
    pub fn new(cells: &'a [u8], known: [bool; BINS]) -> Option<Self> {
        (cells.len() == CELLS).then_some(Self { cells, known })
    }

    /// Makes evidence of [`CELLS`] bytes.
    pub(super) const fn of(cells: &'a [u8], known: [bool; BINS]) -> Self {
        Self { cells, known }
    }

    /// Evidence by surface (floor, ceiling), rung and bin: [`CELLS`] bytes, the bits of
    /// [`SupportNats`](crate::base::num::SupportNats).
    #[must_use]
    pub const fn cells(&self) -> &'a [u8] {
        self.cells
    }

    /// Bins in which a third of the rungs of floor or ceiling was seen.
    #[must_use]
    pub const fn known(&self) -> &[bool; BINS] {
        &self.known
    }

    /// Candidate heights of the ceiling, the most likely first: local maxima of the directions' vote for both boundaries at
    /// one range. A height is the shift in rungs of the ceiling's height above the camera against the camera height.
    /// `height`, a known camera height in [rungs](crate::base::ladder::height_rungs), restricts them to ceilings 2.0 to 4.5
    /// m above the floor.
    ///
    /// # Cost
    /// A pass over a third of the cells for each of at most 45 heights.
    #[must_use]
    pub fn ceilings(&self, height: Option<i8>) -> Vec<i8, MAX_CEILINGS> {
        let [least, most] = height.map_or(CEILINGS, |rungs| ranges::ceiling_bounds(height_m(rungs)));
        let (floor, ceiling) = self.surfaces();
        let mut peaks: Vec<(Nats, i8), MAX_CEILINGS> = Vec::new();
        let mut former = Nats::MIN;
        let mut here = ranges::agreement(floor, ceiling, least);
        for offset in least..=most {
            let next = if offset < most { ranges::agreement(floor, ceiling, offset + 1) } else { Nats::MIN };
            if here > former && here >= next {
                insert(&mut peaks, (here, offset));
            }
            (former, here) = (here, next);
        }
        let mut offsets = Vec::new();
        for (_, offset) in peaks {
            // Both lists have the same capacity.
            let _ = offsets.push(offset);
        }
        offsets
    }

    /// Computes the log-likelihood ratios of ranges for a ceiling height, clamped to -16 to 28 rungs.
    pub fn ranges(&self, ceiling: i8, ranges: &mut RangeLikelihoods) {
        let (floor, above) = self.surfaces();
        ranges.known = self.known.map(u8::from);
        ranges.ceiling = ceiling.clamp(CEILINGS[0], CEILINGS[1]);
        ranges::fill(ranges, floor, above);
    }

    /// Computes the log-likelihood ratios of ranges for the most likely ceiling, by [`ceilings`](Self::ceilings).
    pub fn likeliest(&self, height: Option<i8>, ranges: &mut RangeLikelihoods) {
        self.ranges(self.ceilings(height).first().copied().unwrap_or(0), ranges);
    }

    fn surfaces(&self) -> (&'a [u8], &'a [u8]) {
        self.cells.split_at_checked(RUNGS * BINS).unwrap_or_default()
    }
}

/// Inserts a peak in descending order, ties by ascending height; a full list drops the last.
fn insert(peaks: &mut Vec<(Nats, i8), MAX_CEILINGS>, mut new: (Nats, i8)) {
    let order = |(agreement, offset): (Nats, i8)| (agreement, Reverse(offset));
    for peak in peaks.iter_mut() {
        // From the first lower peak on, each moves down one place.
        if order(new) > order(*peak) {
            core::mem::swap(peak, &mut new);
        }
    }
    // If the list is full, `new` is now the lowest peak, and is dropped.
    let _ = peaks.push(new);
}
