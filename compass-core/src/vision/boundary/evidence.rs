//! Evidence of the boundaries of floor and ceiling.

use super::cells::{CELLS, RUNGS};
#[cfg(doc)]
use super::ranges::RangeLikelihoods;
use crate::base::num::{BINS, CellNats};

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

    /// The cells of a rung of a surface: 0 floor, 1 ceiling. Zeros outside.
    #[inline]
    pub(crate) fn rung(&self, surface: usize, rung: Option<usize>) -> &'a [CellNats; BINS] {
        const NOTHING: [CellNats; BINS] = [CellNats::ZERO; BINS];
        rung.and_then(|rung| self.cells.as_chunks::<BINS>().0.get(surface * RUNGS + rung)).unwrap_or(&NOTHING)
    }
}
