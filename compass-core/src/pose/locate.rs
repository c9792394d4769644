//! Localization of one frame: search over heights, candidates and headings, refinement, selection of alternatives.

use super::evidence::{EvidenceTable, weigh};
use super::heights::{HeightPrior, Heights};
use super::{
    Alternatives, Fix, FloorLayer, Headings, PoolEntry, ScoredPose, refine_coarse, refine_final, refine_fine,
    select_alternatives,
};
use crate::base::order;
use crate::base::pose::Separation;
use crate::vision::boundary::{BoundaryEvidence, MAX_CEILINGS, RangeLikelihoods};
use crate::vision::windows::WindowEvidence;
use core::ops::RangeInclusive;
use heapless::Vec;

/// Largest number of poses that are refined.
pub const MAX_REFINED: usize = 48;

/// Stride in rungs (6.3 %) over camera heights that are not known.
const COARSE_HEIGHT_STRIDE: usize = 2;
/// The same for the second search of [`Effort::finer_heights`].
const FINE_HEIGHT_STRIDE: usize = 1;

/// Memory lent to the search. Its former contents do not matter.
#[derive(Debug)]
pub struct Work<'a> {
    /// Likelihoods of ranges.
    pub ranges: &'a mut RangeLikelihoods,
    /// Evidence.
    pub table: &'a mut EvidenceTable,
    /// Headings of the search. 90 suffice, since refinement closes the gaps; 40 are nearly as good for a known camera
    /// height.
    pub headings: Headings,
    /// Rows of the search: [`Headings::words`].
    pub rows: &'a mut [u32],
    /// Pool of the search: 64 to [`MAX_POOL`](super::MAX_POOL) entries.
    pub pool: &'a mut [PoolEntry],
    /// Bounds of the work.
    pub effort: Effort,
}

/// Bounds of the work of [`locate`].
///
/// Success rates of the presets on 129 frame pairs: `docs/design.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Effort {
    /// Number of poses that pass [`refine_coarse`], 8 to [`MAX_REFINED`]: with fewer the second best, which makes a
    /// probability honest, may be missing.
    pub refined_poses: usize,
    /// Number of those that pass [`refine_fine`] as well, at least 1. The others remain accurate to 0.1 m or 0.2 m.
    pub refined_fully: usize,
    /// Number of ceiling heights that are tried until the result is [sure](Fix::is_sure), 1 to [`MAX_CEILINGS`].
    pub ceilings: usize,
    /// Azimuth stride of the rays in [`refine_coarse`], degrees, 4 to 36.
    pub rays: usize,
    /// Whether a result that is not sure is followed by a second search, over twice as many camera heights. Without effect
    /// for a known camera height.
    pub finer_heights: bool,
}

impl Effort {
    /// Preset of a desktop computer.
    pub const FULL: Self =
        Self { refined_poses: 36, refined_fully: 8, ceilings: MAX_CEILINGS, rays: 4, finer_heights: true };
    /// Half to two thirds of the work of [`Effort::FULL`], with nearly the same success rate.
    pub const SOME: Self =
        Self { refined_poses: 24, refined_fully: 8, ceilings: 3, rays: 6, finer_heights: false };
    /// A third of the work of [`Effort::FULL`] or less, with nearly the same success rate for a known camera height.
    pub const LITTLE: Self =
        Self { refined_poses: 8, refined_fully: 3, ceilings: 1, rays: 6, finer_heights: false };
}

/// A pose and the camera height that it was found with, in rungs.
type Found = (ScoredPose, i8);

/// Finds the maximum-likelihood pose over all layers. Heights that are not known are searched.
///
/// A wrong ceiling height scales the observed room, which then fits badly in many places instead of well in one. Of the
/// likeliest ceiling heights, the one whose best pose has the largest [margin](Fix::margin) is therefore chosen; scores
/// at different heights are not comparable. The final pose is refined at the two neighbouring camera heights as well.
///
/// # Formats
/// `layers` of the site in any order; [`ScoredPose::layer`] of the result is an index into them. Scores are in 1/16 nat
/// relative to a table of zeros.
///
/// # Cost
/// Per ceiling height one [`search`](super::search()) per camera height, and refinement of [`Effort::refined_poses`] poses.
/// An unknown camera height takes about 7 searches, and 14 more if the result is not sure and
/// [`Effort::finer_heights`] is set. Cortex-M7, with [`Effort::LITTLE`] and 40 headings: `locate` in `targets/budget.txt`.
///
/// # References
/// The paper matches descriptors; maximum likelihood under evidence is described in `docs/design.md`.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// # let map = *floor.map();
/// use compass_core::HeightPrior;
/// use compass_core::base::num::LogOdds;
/// use compass_core::base::confidence::Confidence;
/// use compass_core::pose::locate::{Effort, Work, locate};
/// use compass_core::pose::{EvidenceTable, FloorLayer, Headings, PoolEntry};
/// use compass_core::vision::boundary::{BoundaryEvidence, CELLS, RangeLikelihoods};
/// use compass_core::vision::windows::WindowEvidence;
///
/// // Hit types alone: no boundary was seen, and windows where the plan has them at candidate 7.
/// let cells = vec![0; CELLS];
/// let boundaries = BoundaryEvidence::new(&cells, [false; 360]).unwrap();
/// let mut scan = compass_core::Scan::OPEN;
/// map.get(7).unwrap().scan(&mut scan);
/// let mut windows = WindowEvidence::NOTHING;
/// windows.confidence = Confidence::CERTAIN;
/// windows.evidence = scan.hit.map(|hit| LogOdds::from_num(if hit == compass_core::Hit::Window { 4 } else { -4 }));
///
/// let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
/// let headings = Headings::N40;
/// let mut work = Work {
///     ranges: &mut Box::new(RangeLikelihoods::EMPTY),
///     table: &mut Box::new(EvidenceTable::EMPTY),
///     headings,
///     rows: &mut vec![0; headings.words()],
///     pool: &mut [PoolEntry::EMPTY; 64],
///     effort: Effort::LITTLE,
/// };
/// let fix = locate(&boundaries, HeightPrior::camera(1.5), &windows, &[layer], &mut work);
/// assert_eq!(fix.floor_name(), Some(floor.name()));
/// assert_eq!(fix.camera_height_m(), 1.5);
/// assert!(fix.margin() < fix.best().unwrap().score, "windows alone leave alternatives");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn locate<'a>(
    boundaries: &BoundaryEvidence<'_>,
    known: HeightPrior,
    windows: &WindowEvidence,
    layers: &[FloorLayer<'a>],
    work: &mut Work<'_>,
) -> Fix<'a> {
    let camera = known.camera_rungs();
    let ceilings =
        known.ceiling_rungs().map_or_else(|| boundaries.ceilings(camera), |ceiling| Vec::from([ceiling]));
    let fix =
        |(alternatives, camera), ceiling| Fix::new(alternatives, Heights { camera, ceiling }, known, layers);
    let mut best = fix((Alternatives::nothing(), camera.unwrap_or(0)), 0);
    for (tried, &ceiling) in ceilings.iter().take(work.effort.ceilings.max(1)).enumerate() {
        boundaries.ranges(ceiling, work.ranges);
        let found = search_ceiling(camera, COARSE_HEIGHT_STRIDE, windows, layers, work);
        if tried == 0 || found.0.margin() > best.margin() {
            best = fix(found, ceiling);
        }
        if best.is_sure() {
            return best;
        }
    }
    if camera.is_none() && work.effort.finer_heights {
        let ceiling = best.heights().ceiling;
        boundaries.ranges(ceiling, work.ranges);
        let found = search_ceiling(None, FINE_HEIGHT_STRIDE, windows, layers, work);
        // Scores are comparable: the ceiling height is the same.
        if found.0.score() > best.score() {
            best = fix(found, ceiling);
        }
    }
    best
}

/// Finds the maximum-likelihood poses for a given table of evidence: search and refinement.
#[cfg(any(test, feature = "introspect"))]
pub(crate) fn explain(
    table: &EvidenceTable,
    layers: &[FloorLayer<'_>],
    (headings, rows, pool): (Headings, &mut [u32], &mut [PoolEntry]),
    effort: Effort,
) -> Alternatives {
    let count = headings.search(table, rows, layers, pool);
    let mut poses: Vec<ScoredPose, MAX_REFINED> = Vec::new();
    for pose in pool.iter().take(count.min(effort.refined_poses)).filter_map(|entry| entry.pose(layers)) {
        if let Some(layer) = layers.get(usize::from(pose.layer)) {
            // Full after [`MAX_REFINED`] poses: the pool is sorted, so that the best are kept.
            let _ = poses.push(super::refine(table, layer, pose));
        }
    }
    select_alternatives(layers, &mut poses)
}

/// Finds the maximum-likelihood poses for one ceiling height, and their camera height: the given one, or the best of every
/// `step`-th rung.
fn search_ceiling(
    height: Option<i8>,
    step: usize,
    windows: &WindowEvidence,
    layers: &[FloorLayer<'_>],
    work: &mut Work<'_>,
) -> (Alternatives, i8) {
    let Work { ranges, table, headings, rows, pool, effort } = work;
    let heights = height.map_or_else(|| ranges.heights(), |known| known..=known);
    let mut evidence = Evidence { ranges, windows, table, height: None };
    let wanted = effort.refined_poses.clamp(1, MAX_REFINED);
    let mut found: Vec<Found, MAX_REFINED> = Vec::new();
    for height in heights.clone().step_by(step.max(1)) {
        let count = headings.search(evidence.at(height), rows, layers, pool);
        let poses = pool.iter().take(count.min(wanted)).filter_map(|entry| entry.pose(layers));
        poses.for_each(|pose| insert_if_better(&mut found, wanted, (pose, height)));
    }
    evidence.refine(&heights, layers, &mut found, |table, layer, pose| {
        refine_coarse(table, layer, pose, effort.rays)
    });
    order::sort_by_key(&mut found, |(pose, height)| (pose.order(), *height));
    let fully = found.len().min(effort.refined_fully.max(1));
    evidence.refine(&heights, layers, found.get_mut(..fully).unwrap_or_default(), refine_fine);
    // Never full: the capacity is that of `found` and one more.
    let mut refined: Vec<ScoredPose, { MAX_REFINED + 1 }> = Vec::new();
    for (pose, _) in &found {
        let _ = refined.push(*pose);
    }
    let Some(best) = found.into_iter().max_by_key(|(pose, _)| pose.score) else {
        return (Alternatives::nothing(), height.unwrap_or(0));
    };
    let best = evidence.refine_final(&heights, layers, best);
    let _ = refined.push(best.0);
    (select_alternatives(layers, &mut refined), best.1)
}

/// Ranges and hit types of a frame, combined into a table for one camera height at a time.
struct Evidence<'a> {
    ranges: &'a RangeLikelihoods,
    windows: &'a WindowEvidence,
    table: &'a mut EvidenceTable,
    /// Camera height of the table, rungs.
    height: Option<i8>,
}

impl Evidence<'_> {
    /// The evidence for a camera height in rungs.
    fn at(&mut self, height: i8) -> &EvidenceTable {
        if self.height != Some(height) {
            weigh(self.ranges, height, self.windows, self.table);
            self.height = Some(height);
        }
        self.table
    }

    /// Refines poses, grouped by camera height so that each table is filled once.
    fn refine(
        &mut self,
        heights: &RangeInclusive<i8>,
        layers: &[FloorLayer<'_>],
        found: &mut [Found],
        refine: impl Fn(&EvidenceTable, &FloorLayer<'_>, ScoredPose) -> ScoredPose,
    ) {
        for at in heights.clone() {
            for (pose, _) in found.iter_mut().filter(|(_, height)| *height == at) {
                if let Some(layer) = layers.get(usize::from(pose.layer)) {
                    *pose = refine(self.at(at), layer, *pose);
                }
            }
        }
    }

    /// Refines the best pose at the neighbouring camera heights too, then by [`refine_final`] at the best of them.
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

/// Inserts a pose into a sorted list of at most `wanted`, unless a better pose within [`Separation::FOUND`] is in it.
fn insert_if_better(found: &mut Vec<Found, MAX_REFINED>, wanted: usize, new: Found) {
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
