//! Evidence of the boundaries of floor and ceiling, and the vote for the height of the ceiling.

use super::cells::{CELLS, RUNGS};
use super::ranges::{self, RangeLikelihoods};
use super::tuning::CEILINGS;
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
    ///
    /// ```
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
    ///
    /// assert!(BoundaryEvidence::new(&[0; CELLS], [true; 360]).is_some());
    /// assert!(BoundaryEvidence::new(&[0; 9], [true; 360]).is_none());
    /// ```
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
    /// # Formats
    /// Sums of 120 bins in [`Nats`]; heights -16 to 28 rungs.
    ///
    /// # Cost
    /// A pass over a third of the cells for each of at most 45 heights.
    ///
    /// ```
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS};
    ///
    /// // Floor at rung 30, ceiling at rung 25, in all directions.
    /// let mut cells = vec![0; CELLS];
    /// cells[30 * 360..31 * 360].fill(60);
    /// cells[(RUNGS + 25) * 360..(RUNGS + 26) * 360].fill(50);
    /// let evidence = BoundaryEvidence::new(&cells, [true; 360]).unwrap();
    /// assert_eq!(evidence.ceilings(None).first(), Some(&5));
    /// ```
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
    ///
    /// # Formats
    /// Evidence in 1/16 nat, softmax in 1/65536, log-likelihood ratios in [`CellNats`](crate::base::num::CellNats): -1.25 to
    /// 4 nats.
    ///
    /// # Accuracy
    /// [`EVIDENCE_ERROR`](super::EVIDENCE_ERROR), which `compass compare` checks against `f64`.
    ///
    /// # Cost
    /// Three passes over the cells.
    ///
    /// # References
    /// D. L. `McFadden`, "Conditional Logit Analysis of Qualitative Choice Behavior", 1974.
    ///
    /// ```
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS, RangeLikelihoods};
    ///
    /// // Floor at rung 30, ceiling at rung 25, in all directions.
    /// let mut cells = vec![0; CELLS];
    /// cells[30 * 360..31 * 360].fill(60);
    /// cells[(RUNGS + 25) * 360..(RUNGS + 26) * 360].fill(50);
    /// let evidence = BoundaryEvidence::new(&cells, [true; 360]).unwrap();
    /// let mut ranges = RangeLikelihoods::EMPTY;
    /// evidence.ranges(5, &mut ranges);
    /// // Rung 30 is rung 21 of the range ladder for the nominal camera height: 1.43 m.
    /// let found = ranges.range(0, 0).unwrap();
    /// assert!((found.metres - 1.43).abs() < 0.02 && found.confidence > 0.8, "{found:?}");
    /// ```
    pub fn ranges(&self, ceiling: i8, ranges: &mut RangeLikelihoods) {
        let (floor, above) = self.surfaces();
        ranges.known = self.known.map(u8::from);
        ranges.ceiling = ceiling.clamp(CEILINGS[0], CEILINGS[1]);
        ranges::fill(ranges, floor, above);
    }

    /// Computes the log-likelihood ratios of ranges for the most likely ceiling, by [`ceilings`](Self::ceilings).
    ///
    /// ```
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS, RangeLikelihoods};
    ///
    /// // Floor at rung 30, ceiling at rung 25, in all directions.
    /// let mut cells = vec![0; CELLS];
    /// cells[30 * 360..31 * 360].fill(60);
    /// cells[(RUNGS + 25) * 360..(RUNGS + 26) * 360].fill(50);
    /// let evidence = BoundaryEvidence::new(&cells, [true; 360]).unwrap();
    /// let mut ranges = RangeLikelihoods::EMPTY;
    /// evidence.likeliest(None, &mut ranges);
    /// assert!((ranges.ceiling_ratio() - 1.355).abs() < 1e-3);
    /// ```
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
