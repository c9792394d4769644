//! What exists for pictures, comparisons and evaluation: the feature `introspect`.

use super::Locator;
use super::stages::{Levelled, Seen, arcs, collect_arcs};
use super::trace::Trace;
use crate::pose::heights::HeightPrior;
use crate::vision::attitude::{self, Arc, Axes};
use crate::vision::boundary::{BoundaryEvidence, RangeLikelihoods};
use crate::vision::windows::WindowEvidence;

impl<M: AsRef<[u32]> + AsMut<[u32]>, T: Trace, const LAYERS: usize> Locator<'_, M, T, LAYERS> {
    /// The stage after all that was seen, from evidence that was kept of it. Windows themselves are not kept.
    pub fn recall<'l>(
        &'l mut self,
        boundaries: &BoundaryEvidence<'_>,
        windows: &WindowEvidence,
    ) -> Seen<'l, Self> {
        self.found.windows = WindowEvidence { count: 0, ..windows.clone() };
        if let Some(search) = self.memory_map().search(self.memory.as_mut()) {
            search.evidence.iter_mut().zip(boundaries.cells()).for_each(|(cell, kept)| *cell = *kept);
        }
        Seen { locator: self }
    }
}

impl<'a, M, T, const LAYERS: usize> Levelled<'_, '_, Locator<'a, M, T, LAYERS>>
where
    M: AsRef<[u32]> + AsMut<[u32]>,
    T: Trace,
{
    /// The building's axes.
    #[must_use]
    pub fn axes(&mut self) -> Option<Axes> {
        let frame = self.frame;
        attitude::building_axes(self.arcs(), &frame)
    }

    /// The segments of all cameras as arcs of great circles.
    #[must_use]
    pub fn arcs(&mut self) -> &[Arc] {
        self.locator.found.arcs = collect_arcs(self.locator);
        arcs(self.locator)
    }
}

impl<'a, M, T, const LAYERS: usize> Seen<'_, Locator<'a, M, T, LAYERS>>
where
    M: AsRef<[u32]> + AsMut<[u32]>,
    T: Trace,
{
    /// The likelihoods of ranges, with a guess of the ceiling unless it is known.
    pub fn range_likelihoods(&mut self, known: HeightPrior, ranges: &mut RangeLikelihoods) {
        *ranges = RangeLikelihoods::EMPTY;
        if let Some(boundaries) = self.boundaries() {
            match known.ceiling_rungs() {
                Some(ceiling) => boundaries.ranges(ceiling, ranges),
                None => boundaries.likeliest(known.camera_rungs(), ranges),
            }
        }
    }
}
