//! Evidence of the boundaries of floor and ceiling.

use super::cells::{CELLS, RUNGS};
use super::ranges::{self, RangeLikelihoods};
use super::tuning::CEILINGS;
use crate::base::ladder::height_m;
use crate::base::num::{BINS, CellNats, Nats};

/// Log-likelihood ratios of a boundary of the floor and of the ceiling, per direction and rung of log range.
///
/// Floor and ceiling are independent sources, each in units of its own height: the camera's above the floor, the ceiling's
/// above the camera. Their sum for two heights is [`RangeLikelihoods`].
///
/// # Formats
/// Cells in [`CellNats`]: -0.7 to 4.3 nats, and 0 in a bin of which too little was seen. Rung k lies at a log range of `ln(0.4 /
/// 1.5) + 0.0608 (k - 9)` in units of the height.
#[derive(Debug, Clone, Copy)]
pub struct BoundaryEvidence<'a> {
    cells: &'a [CellNats],
}

impl<'a> BoundaryEvidence<'a> {
    /// Restores evidence from its [`cells`](Self::cells). `None` if there are not [`CELLS`].
    ///
    /// ```
    /// use compass_core::base::num::CellNats;
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
    ///
    /// assert!(BoundaryEvidence::new(&[CellNats::ZERO; CELLS]).is_some());
    /// assert!(BoundaryEvidence::new(&[CellNats::ZERO; 9]).is_none());
    /// ```
    #[must_use]
    pub fn new(cells: &'a [CellNats]) -> Option<Self> {
        (cells.len() == CELLS).then_some(Self { cells })
    }

    /// Makes evidence of [`CELLS`] values.
    pub(super) const fn of(cells: &'a [CellNats]) -> Self {
        Self { cells }
    }

    /// Log-likelihood ratios by surface (floor, ceiling), rung and bin: [`CELLS`] values.
    #[must_use]
    pub const fn cells(&self) -> &'a [CellNats] {
        self.cells
    }

    /// Bins in which a third of floor or ceiling was seen.
    #[must_use]
    pub fn known(&self) -> [bool; BINS] {
        let mut known = [false; BINS];
        for row in self.cells.chunks_exact(BINS) {
            known.iter_mut().zip(row).for_each(|(known, cell)| *known |= *cell != CellNats::ZERO);
        }
        known
    }

    /// Computes the log-likelihood ratios of ranges for a height of the ceiling: its shift in rungs above the camera against
    /// the camera height, clamped to -20 to 28 rungs.
    ///
    /// # Formats
    /// Sums of the floor's ratio and half of the ceiling's, in [`CellNats`].
    ///
    /// # Accuracy
    /// [`EVIDENCE_ERROR`](super::EVIDENCE_ERROR), which `compass compare` checks against `f64`.
    ///
    /// # Cost
    /// A pass over the cells.
    ///
    /// ```
    /// use compass_core::base::num::CellNats;
    /// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RUNGS, RangeLikelihoods};
    ///
    /// // Floor at rung 30, ceiling at rung 25, in all directions.
    /// let mut cells = vec![-CellNats::ONE / 2; CELLS];
    /// cells[30 * 360..31 * 360].fill(CellNats::ONE * 3);
    /// cells[(RUNGS + 25) * 360..(RUNGS + 26) * 360].fill(CellNats::ONE * 2);
    /// let evidence = BoundaryEvidence::new(&cells).unwrap();
    /// let mut ranges = RangeLikelihoods::EMPTY;
    /// evidence.ranges(5, &mut ranges);
    /// // Rung 30 is rung 21 of the range ladder for the nominal camera height: 1.43 m.
    /// let found = ranges.range(0, 0).unwrap();
    /// assert!((found.metres - 1.43).abs() < 0.02, "{found:?}");
    /// ```
    pub fn ranges(&self, ceiling: i8, ranges: &mut RangeLikelihoods) {
        ranges.known = self.known().map(u8::from);
        ranges.ceiling = ceiling.clamp(CEILINGS[0], CEILINGS[1]);
        ranges::fill(ranges, self);
    }

    /// A guess of the ceiling without a plan: the height at which both boundaries agree best on the ranges. `height`, a known
    /// camera height in [rungs](crate::base::ladder::height_rungs), restricts it to ceilings 2.0 to 4.5 m above the floor.
    ///
    /// # Formats
    /// The shift in rungs of the ceiling's height above the camera against the camera height; 0 if nothing was seen.
    ///
    /// # Cost
    /// A pass over a third of the cells for each of at most 49 heights.
    #[must_use]
    pub fn guess_ceiling(&self, height: Option<i8>) -> i8 {
        let [least, most] = height.map_or(CEILINGS, |rungs| ranges::ceiling_bounds(height_m(rungs)));
        let agreement = |ceiling: &i8| (ranges::agreement(self, *ceiling), -i16::from(*ceiling).abs());
        let best = (least..=most).max_by_key(agreement).unwrap_or(0);
        if ranges::agreement(self, best) > Nats::ZERO { best } else { 0 }
    }

    /// Computes the log-likelihood ratios of ranges for a [guess](Self::guess_ceiling) of the ceiling.
    pub fn likeliest(&self, height: Option<i8>, ranges: &mut RangeLikelihoods) {
        self.ranges(self.guess_ceiling(height), ranges);
    }

    /// The cells of a rung of a surface: 0 floor, 1 ceiling. Zeros outside.
    #[inline]
    pub(crate) fn rung(&self, surface: usize, rung: Option<usize>) -> &'a [CellNats; BINS] {
        const NOTHING: [CellNats; BINS] = [CellNats::ZERO; BINS];
        rung.and_then(|rung| self.cells.as_chunks::<BINS>().0.get(surface * RUNGS + rung)).unwrap_or(&NOTHING)
    }
}
