//! From what is seen to a pose: search over heights of ceiling and camera, candidates and headings, refinement, answer.

use super::evidence::weigh;
use super::{
    Answer, EvidenceTable, FloorLayer, Rows, ScoredPose, answer, refine_coarse, refine_final, refine_fine,
    search,
};
use crate::base::ladder::height_m;
use crate::base::num::Nats;
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
/// An answer that leads by so many nats needs no second look, with another ceiling.
pub const SURE_NATS: i32 = 150;

/// Log odds against an answer whose margin is 0, and what they lose per unit of ln(1 + margin in nats).
const CERTAINTY: [f32; 2] = [14.02, 3.26];

/// What is known of the room and of how the cameras are carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeightPrior {
    /// Height of the camera above the floor, in [rungs](crate::base::ladder::height_rungs).
    pub height: Option<i8>,
    /// By how many rungs the ceiling is higher above the camera than the floor below it.
    pub ceiling: Option<i8>,
}

/// Memory lent for the search; what it holds before does not matter. The search tries N headings: 90 do, and nearly as
/// well 40 where the camera's height is told; the rest is refinement.
#[derive(Debug)]
pub struct Work<'a, const N: usize> {
    /// For the likelihoods of ranges.
    pub ranges: &'a mut RangeLikelihoods,
    /// For the evidence.
    pub table: &'a mut EvidenceTable,
    /// For the search.
    pub rows: &'a mut Rows<N>,
    /// 64 to 512 places.
    pub pool: &'a mut [ScoredPose],
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

    /// What pays on a microcontroller: little where the camera's height is told. Where it is not, so little work finds too
    /// few.
    #[must_use]
    pub const fn on_board(room: &HeightPrior) -> Self {
        if room.height.is_some() { Self::LITTLE } else { Self::SOME }
    }
}

/// Where the cameras are.
#[derive(Debug, Clone)]
pub struct Fix {
    /// The best pose and its alternatives, refined.
    pub answer: Answer,
    /// The camera's height in [rungs](crate::base::ladder::height_rungs): that given, or that found.
    pub height: i8,
    /// By how many rungs the ceiling is higher above the camera than the floor below it: that given, or that found.
    pub ceiling: i8,
}

impl Fix {
    /// The camera's height above the floor, metres, to half a rung: 3 %.
    #[must_use]
    pub fn height_m(&self) -> f32 {
        height_m(self.height)
    }

    /// How likely the best pose is within 1 m of the true one, 0 to 1: from its margin over the best pose elsewhere.
    ///
    /// Logistic in the logarithm of the margin, fitted to 249 frame pairs of two storeys, 240 of them simulated
    /// (`docs/design.md`). The score itself says little: bins next to each other err together.
    #[must_use]
    pub fn probability(&self) -> f32 {
        if self.answer.best().is_none_or(|best| best.score <= Nats::ZERO) {
            return 0.0;
        }
        let margin = self.answer.margin().max(Nats::ZERO).to_num::<f32>();
        1.0 / (1.0 + libm::expf(CERTAINTY[0] - CERTAINTY[1] * libm::log1pf(margin)))
    }

    /// Whether the answer leads by so much that no other height of the ceiling was tried.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.answer.margin() >= Nats::from_num(SURE_NATS)
    }
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
#[inline]
pub fn locate<const N: usize>(
    survey: &BoundaryEvidence<'_>,
    room: HeightPrior,
    sighting: &WindowEvidence,
    layers: &[FloorLayer<'_>],
    work: &mut Work<'_, N>,
) -> Fix {
    let ceilings = room.ceiling.map_or_else(|| survey.ceilings(room.height), |known| Vec::from([known]));
    let [coarse, fine] = HEIGHT_STEPS;
    let mut best = Fix { answer: Answer::nothing(), height: room.height.unwrap_or(0), ceiling: 0 };
    for (tried, &ceiling) in ceilings.iter().take(work.effort.ceilings.max(1)).enumerate() {
        survey.ranges(ceiling, work.ranges);
        let (answer, height) = search_ceiling(room.height, coarse, sighting, layers, work);
        if tried == 0 || answer.margin() > best.answer.margin() {
            best = Fix { answer, height, ceiling };
        }
        if best.is_sure() {
            return best;
        }
    }
    if room.height.is_none() && work.effort.again {
        survey.ranges(best.ceiling, work.ranges);
        let (answer, height) = search_ceiling(None, fine, sighting, layers, work);
        // With the same ceiling scores compare.
        if answer.score() > best.answer.score() {
            best = Fix { answer, height, ..best };
        }
    }
    best
}

/// The poses that explain best what was seen, with one ceiling, and the height of the camera, of which every `step`-th is
/// tried.
fn search_ceiling<const N: usize>(
    height: Option<i8>,
    step: usize,
    sighting: &WindowEvidence,
    layers: &[FloorLayer<'_>],
    work: &mut Work<'_, N>,
) -> (Answer, i8) {
    let Work { ranges, table, rows, pool, effort } = work;
    let heights = height.map_or_else(|| ranges.heights(), |known| known..=known);
    let mut evidence = Evidence { ranges, sighting, table, height: None };
    let wanted = effort.modes.clamp(1, MAX_MODES);
    let mut found: Vec<Found, MAX_MODES> = Vec::new();
    for height in heights.clone().step_by(step.max(1)) {
        rows.set(evidence.at(height));
        let count = search(rows, layers, |_, _| true, pool);
        pool.iter()
            .take(count.min(wanted))
            .for_each(|mode| insert_if_better(&mut found, wanted, (*mode, height)));
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
