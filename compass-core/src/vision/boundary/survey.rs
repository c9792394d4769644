//! What is seen of floor and ceiling, before it is decided how high the ceiling is.

use super::evidence::{self, RangeLikelihoods};
use super::{CELLS, RUNGS};
use crate::base::ladder::height_m;
use crate::base::num::{BINS, Nats};
use core::cmp::Reverse;
use heapless::Vec;

/// Most heights of the ceiling that are worth a look.
pub const MAX_CEILINGS: usize = 4;

/// Evidence of edges of the floor and of the ceiling, in every direction.
///
/// Sills, lintels and beams make a ceiling of their own, at another height: which one is true the plan may tell, so that
/// there are several [`ceilings`](Self::ceilings), and [`ranges`](Self::ranges) for each.
#[derive(Debug, Clone, Copy)]
pub struct BoundaryEvidence<'a> {
    cells: &'a [u8],
    known: [bool; BINS],
}

impl<'a> BoundaryEvidence<'a> {
    /// One that was kept: its [`cells`](Self::cells) and what was [`known`](Self::known). `None` if the cells are not
    /// [`CELLS`] bytes.
    #[must_use]
    pub fn new(cells: &'a [u8], known: [bool; BINS]) -> Option<Self> {
        (cells.len() == CELLS).then_some(Self { cells, known })
    }

    /// Of [`CELLS`] bytes.
    pub(super) const fn of(cells: &'a [u8], known: [bool; BINS]) -> Self {
        Self { cells, known }
    }

    /// Evidence, the bits of [`SupportNats`](crate::base::num::SupportNats), by surface (floor, ceiling), rung and bin:
    /// [`CELLS`] bytes.
    #[must_use]
    pub const fn cells(&self) -> &'a [u8] {
        self.cells
    }

    /// Bins of which enough floor or ceiling was seen.
    #[must_use]
    pub const fn known(&self) -> &[bool; BINS] {
        &self.known
    }

    /// Heights that the ceiling may have, the likeliest first: those at which more directions see both boundaries at one
    /// range than at the heights beside. In rungs that it lies higher above the camera than the floor below; a known
    /// height of the camera, in [rungs](crate::base::ladder::height_rungs), bounds the room.
    ///
    /// # Cost
    /// A pass over a third of the cells for each height that the ceiling may have: 45.
    #[must_use]
    pub fn ceilings(&self, height: Option<i8>) -> Vec<i8, MAX_CEILINGS> {
        let [least, most] = height.map_or(evidence::CEILINGS, |rungs| evidence::ceilings(height_m(rungs)));
        let (floor, ceiling) = self.surfaces();
        let mut peaks: Vec<(Nats, i8), MAX_CEILINGS> = Vec::new();
        let mut former = Nats::MIN;
        let mut here = evidence::agreement(floor, ceiling, least);
        for offset in least..=most {
            let next =
                if offset < most { evidence::agreement(floor, ceiling, offset + 1) } else { Nats::MIN };
            if here > former && here >= next {
                insert(&mut peaks, (here, offset));
            }
            (former, here) = (here, next);
        }
        let mut offsets = Vec::new();
        for (_, offset) in peaks {
            // As many places as peaks.
            let _ = offsets.push(offset);
        }
        offsets
    }

    /// The likelihoods of ranges if the ceiling is at one of those heights.
    pub fn ranges(&self, ceiling: i8, ranges: &mut RangeLikelihoods) {
        let (floor, above) = self.surfaces();
        ranges.known = self.known.map(u8::from);
        ranges.ceiling = ceiling.clamp(evidence::CEILINGS[0], evidence::CEILINGS[1]);
        evidence::fill(ranges, floor, above);
    }

    /// The likelihoods of ranges with the likeliest ceiling.
    pub fn likeliest(&self, height: Option<i8>, ranges: &mut RangeLikelihoods) {
        self.ranges(self.ceilings(height).first().copied().unwrap_or(0), ranges);
    }

    fn surfaces(&self) -> (&'a [u8], &'a [u8]) {
        self.cells.split_at_checked(RUNGS * BINS).unwrap_or_default()
    }
}

/// Keeps the highest; of equal ones the lower ceiling, which comes first.
fn insert(peaks: &mut Vec<(Nats, i8), MAX_CEILINGS>, mut new: (Nats, i8)) {
    let order = |(agreement, offset): (Nats, i8)| (agreement, Reverse(offset));
    for peak in peaks.iter_mut() {
        // From the first that is lower on, each gives way to the one before it.
        if order(new) > order(*peak) {
            core::mem::swap(peak, &mut new);
        }
    }
    // Where all places are taken the lowest is left over.
    let _ = peaks.push(new);
}
