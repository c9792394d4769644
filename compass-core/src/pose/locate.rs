//! From what is seen to a pose: search over heights of ceiling and camera, candidates and headings, refinement, answer.

use super::evidence::{EvidenceTable, weigh};
use super::heights::{HeightPrior, Heights};
use super::{
    Answer, Fix, FloorLayer, Headings, PoolEntry, ScoredPose, answer, refine, refine_coarse, refine_final,
    refine_fine,
};
use crate::base::order;
use crate::base::pose::Separation;
use crate::vision::boundary::{BoundaryEvidence, MAX_CEILINGS, RangeLikelihoods};
use crate::vision::windows::WindowEvidence;
use core::ops::RangeInclusive;
use heapless::Vec;

/// Most modes that are refined.
pub const MAX_MODES: usize = 48;

/// Where the camera's height is not known, every second rung of it is tried, 13 %, and all where the answer is not sure.
const HEIGHT_STEPS: [usize; 2] = [2, 1];
/// Memory lent for the search; what it holds before does not matter.
#[derive(Debug)]
pub struct Work<'a> {
    /// For the likelihoods of ranges.
    pub ranges: &'a mut RangeLikelihoods,
    /// For the evidence.
    pub table: &'a mut EvidenceTable,
    /// Headings that the search tries: 90 do, and nearly as well 40 where the camera's height is known; the rest is
    /// refinement.
    pub headings: Headings,
    /// [`Headings::words`] for the search.
    pub rows: &'a mut [u32],
    /// 64 to [`MAX_POOL`](super::MAX_POOL) places.
    pub pool: &'a mut [PoolEntry],
    /// How much work may be done.
    pub effort: Effort,
}

/// How much work the search may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Effort {
    /// How many modes to refine, 1 to [`MAX_MODES`].
    pub modes: usize,
    /// How many of them to the end: the others are alternatives to a decimetre or two.
    pub settled: usize,
    /// How many heights of the ceiling to try until an answer is sure, 1 to [`MAX_CEILINGS`].
    pub ceilings: usize,
    /// Every how many-th ray is cast while modes [refine_coarse] their tops, at least 4.
    pub rays: usize,
    /// Whether an answer that is not sure is sought once more, with twice as many heights of a camera whose height is not
    /// known.
    pub again: bool,
}

impl Effort {
    /// What pays on a computer.
    pub const FULL: Self = Self { modes: 36, settled: 8, ceilings: MAX_CEILINGS, rays: 4, again: true };
    /// A half to two thirds of the work, and nearly as good.
    pub const SOME: Self = Self { modes: 24, settled: 8, ceilings: 3, rays: 6, again: false };
    /// A third of it or less, and nearly as good where the camera's height is told.
    pub const LITTLE: Self = Self { modes: 8, settled: 3, ceilings: 1, rays: 6, again: false };
}

/// A mode and the height of the camera that it was found with.
type Found = (ScoredPose, i8);

/// Finds the pose that explains best what was seen, on all layers. Heights that are not known are searched for.
///
/// Which ceiling is the true one the plan tells: with a wrong one the room has the wrong size, and fits badly in many
/// places rather than well in one. Of the likeliest ones that counts whose best pose leads by the most.
///
/// # Cost
/// For each ceiling tried one [`search`] per height, and refinement of as many modes as [`Effort::modes`] says. Where the
/// height is not known, a room of usual height allows about 7, the best pose is tried with the two next to its own
/// as well, and an answer that is not sure takes 14 more searches if [`Effort::again`].
pub fn locate<'a>(
    survey: &BoundaryEvidence<'_>,
    known: HeightPrior,
    sighting: &WindowEvidence,
    layers: &[FloorLayer<'a>],
    work: &mut Work<'_>,
) -> Fix<'a> {
    let camera = known.camera_rungs();
    let ceilings =
        known.ceiling_rungs().map_or_else(|| survey.ceilings(camera), |ceiling| Vec::from([ceiling]));
    let [coarse, fine] = HEIGHT_STEPS;
    let fix = |(answer, camera), ceiling| Fix::new(answer, Heights { camera, ceiling }, known, layers);
    let mut best = fix((Answer::nothing(), camera.unwrap_or(0)), 0);
    for (tried, &ceiling) in ceilings.iter().take(work.effort.ceilings.max(1)).enumerate() {
        survey.ranges(ceiling, work.ranges);
        let found = search_ceiling(camera, coarse, sighting, layers, work);
        if tried == 0 || found.0.margin() > best.margin() {
            best = fix(found, ceiling);
        }
        if best.is_sure() {
            return best;
        }
    }
    if camera.is_none() && work.effort.again {
        let ceiling = best.heights().ceiling;
        survey.ranges(ceiling, work.ranges);
        let found = search_ceiling(None, fine, sighting, layers, work);
        // With the same ceiling scores compare.
        if found.0.score() > best.score() {
            best = fix(found, ceiling);
        }
    }
    best
}

/// The poses that explain some evidence best, by a search at these headings in this memory, refined.
pub(crate) fn explain(
    table: &EvidenceTable,
    layers: &[FloorLayer<'_>],
    (headings, rows, pool): (Headings, &mut [u32], &mut [PoolEntry]),
    effort: Effort,
) -> Answer {
    let count = headings.search(table, rows, layers, pool);
    let mut poses: Vec<ScoredPose, MAX_MODES> = Vec::new();
    for pose in pool.iter().take(count.min(effort.modes)).filter_map(|entry| entry.pose(layers)) {
        if let Some(layer) = layers.get(usize::from(pose.layer)) {
            // Of more than there is room for the first count.
            let _ = poses.push(refine(table, layer, pose));
        }
    }
    answer(layers, &mut poses)
}

/// The poses that explain best what was seen, with one ceiling, and the height of the camera, of which every `step`-th is
/// tried.
fn search_ceiling(
    height: Option<i8>,
    step: usize,
    sighting: &WindowEvidence,
    layers: &[FloorLayer<'_>],
    work: &mut Work<'_>,
) -> (Answer, i8) {
    let Work { ranges, table, headings, rows, pool, effort } = work;
    let heights = height.map_or_else(|| ranges.heights(), |known| known..=known);
    let mut evidence = Evidence { ranges, sighting, table, height: None };
    let wanted = effort.modes.clamp(1, MAX_MODES);
    let mut found: Vec<Found, MAX_MODES> = Vec::new();
    for height in heights.clone().step_by(step.max(1)) {
        let count = headings.search(evidence.at(height), rows, layers, pool);
        let poses = pool.iter().take(count.min(wanted)).filter_map(|entry| entry.pose(layers));
        poses.for_each(|mode| insert_if_better(&mut found, wanted, (mode, height)));
    }
    evidence.refine(&heights, layers, &mut found, |table, layer, mode| {
        refine_coarse(table, layer, mode, effort.rays)
    });
    order::sort_by_key(&mut found, |(mode, height)| (mode.order(), *height));
    let settled = found.len().min(effort.settled.max(1));
    evidence.refine(&heights, layers, found.get_mut(..settled).unwrap_or_default(), refine_fine);
    // Never full: it has one place more.
    let mut modes: Vec<ScoredPose, { MAX_MODES + 1 }> = Vec::new();
    for (mode, _) in &found {
        let _ = modes.push(*mode);
    }
    let Some(best) = found.into_iter().max_by_key(|(mode, _)| mode.score) else {
        return (Answer::nothing(), height.unwrap_or(0));
    };
    let best = evidence.refine_final(&heights, layers, best);
    let _ = modes.push(best.0);
    (answer(layers, &mut modes), best.1)
}

/// What was seen, as evidence for one height of the camera at a time.
struct Evidence<'a> {
    ranges: &'a RangeLikelihoods,
    sighting: &'a WindowEvidence,
    table: &'a mut EvidenceTable,
    /// The height that the table is for.
    height: Option<i8>,
}

impl Evidence<'_> {
    /// The evidence for a height.
    fn at(&mut self, height: i8) -> &EvidenceTable {
        if self.height != Some(height) {
            weigh(self.ranges, height, self.sighting, self.table);
            self.height = Some(height);
        }
        self.table
    }

    /// Refines modes, height by height.
    fn refine(
        &mut self,
        heights: &RangeInclusive<i8>,
        layers: &[FloorLayer<'_>],
        found: &mut [Found],
        refine: impl Fn(&EvidenceTable, &FloorLayer<'_>, ScoredPose) -> ScoredPose,
    ) {
        for at in heights.clone() {
            for (mode, _) in found.iter_mut().filter(|(_, height)| *height == at) {
                if let Some(layer) = layers.get(usize::from(mode.layer)) {
                    *mode = refine(self.at(at), layer, *mode);
                }
            }
        }
    }

    /// The best mode polished, and tried with the heights next to its own, where they may be.
    fn refine_final(
        &mut self,
        heights: &RangeInclusive<i8>,
        layers: &[FloorLayer<'_>],
        (best, height): Found,
    ) -> Found {
        let Some(layer) = layers.get(usize::from(best.layer)) else { return (best, height) };
        let beside = [height.saturating_sub(1), height.saturating_add(1)];
        let tried = beside.into_iter().filter(|height| heights.contains(height));
        let tried = tried.map(|height| (refine_fine(self.at(height), layer, best), height));
        let (best, height) =
            tried.fold((best, height), |best, other| if other.0.score > best.0.score { other } else { best });
        (refine_final(self.at(height), layer, best), height)
    }
}

/// Adds a mode unless as many better ones are there, or a better one at the same pose.
fn insert_if_better(found: &mut Vec<Found, MAX_MODES>, wanted: usize, new: Found) {
    let same = |other: &ScoredPose| Separation::FOUND.joins_on_layer(&new.0, other);
    if let Some(at) = found.iter().position(|(other, _)| same(other)) {
        if found.get(at).is_some_and(|(other, _)| other.score >= new.0.score) {
            return;
        }
        found.remove(at);
    }
    let at = found.iter().position(|(other, _)| new.0.score > other.score).unwrap_or(found.len());
    if at < wanted {
        found.truncate(wanted - 1);
        let _ = found.insert(at.min(found.len()), new);
    }
}
