//! Localization of one frame: search over heights, candidates and headings, refinement, selection of alternatives.

use super::evidence::{EvidenceTable, HitEvidence, weigh};
use super::fix::Answer;
use super::heights::{HeightGrid, HeightPrior, Heights};
use super::search::pose_of;
use super::{
    Covariance, Fix, FloorLayer, Headings, PoolEntry, PosePrior, Query, ScoredPose, refine_coarse,
    refine_final, refine_fine, select_alternatives, upright,
};
use crate::base::ladder::{FRACTION_BITS, position_of};
use crate::base::num::{BINS, CellNats, Metres, Nats, Turn};
use crate::base::order;
use crate::base::pose::{MAX_ALTERNATIVES, Separation};
use crate::base::scan::{Hit, Scan};
use crate::vision::boundary::{BoundaryEvidence, CEILING_SHIFT, rung_of};
use crate::vision::windows::WindowEvidence;
use core::cmp::Reverse;
use heapless::Vec;

/// Largest number of poses that are refined.
pub const MAX_REFINED: usize = 48;
/// Azimuth stride of the rays that choose heights, degrees.
const HEIGHT_STRIDE: u8 = 4;

/// How far outside a [`PosePrior`] a pose may be that is refined no further than roughly: a fine refinement may end inside.
const ROUGH: Separation = Separation { distance: Metres::lit("0.25"), turn: Turn::from_degrees(5) };

/// Memory lent to the search. Its former contents do not matter.
#[derive(Debug)]
pub struct Work<'a> {
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
    /// Azimuth stride of the rays in [`refine_coarse`], degrees, 4 to 36.
    pub rays: usize,
}

impl Effort {
    /// Preset of a desktop computer.
    pub const FULL: Self = Self { refined_poses: 36, refined_fully: 8, rays: 4 };
    /// Half to two thirds of the work of [`Effort::FULL`], with nearly the same success rate.
    pub const SOME: Self = Self { refined_poses: 24, refined_fully: 8, rays: 6 };
    /// A third of the work of [`Effort::FULL`] or less, with nearly the same success rate for a known camera height.
    pub const LITTLE: Self = Self { refined_poses: 8, refined_fully: 3, rays: 6 };
}

/// A pose, and the heights that it has its score at: of the camera above the floor and of the ceiling above the camera,
/// rungs.
type Found = (ScoredPose, [i8; 2]);

/// Finds the maximum-likelihood pose over all layers. Heights that are not known are searched.
///
/// Floor, ceiling and hit type are independent sources. The heights of camera and ceiling that explain a pose best are part
/// of it: no height is decided before the plan is asked.
///
/// # Formats
/// `layers` of the site in any order; [`ScoredPose::layer`] of the result is an index into them. Scores are in 1/16 nat
/// relative to a table of zeros.
///
/// # Cost
/// One [`search`](super::search()), and refinement of [`Effort::refined_poses`] poses, each with a [table](EvidenceTable) for
/// its heights. Cortex-M7, with [`Effort::LITTLE`] and 40 headings: `locate` in `targets/budget.txt`.
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
/// use compass_core::{HeightPrior, Nats, PosePrior};
/// use compass_core::base::num::LogOdds;
/// use compass_core::base::confidence::Confidence;
/// use compass_core::pose::locate::{Effort, Work, locate};
/// use compass_core::pose::{EvidenceTable, FloorLayer, Headings, PoolEntry};
/// use compass_core::base::num::CellNats;
/// use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
/// use compass_core::vision::windows::WindowEvidence;
///
/// // Hit types alone: no boundary was seen, and windows where the plan has them at candidate 7.
/// let cells = vec![CellNats::ZERO; CELLS];
/// let boundaries = BoundaryEvidence::new(&cells).unwrap();
/// let mut scan = compass_core::Scan::OPEN;
/// map.get(7).unwrap().scan(&mut scan);
/// let mut windows = WindowEvidence::NOTHING;
/// windows.confidence = Confidence::CERTAIN;
/// windows.evidence = scan.hit.map(|hit| LogOdds::from_num(if hit == compass_core::Hit::Window { 4 } else { -4 }));
///
/// let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
/// let headings = Headings::N40;
/// let mut work = Work {
///     table: &mut Box::new(EvidenceTable::EMPTY),
///     headings,
///     rows: &mut vec![0; headings.words()],
///     pool: &mut [PoolEntry::EMPTY; 64],
///     effort: Effort::LITTLE,
/// };
/// let (height, within) = (HeightPrior::camera(1.5), PosePrior::UNKNOWN);
/// let fix = locate(&boundaries, height, &within, &windows, &[layer], &mut work);
/// assert_eq!(fix.floor_name(), Some(floor.name()));
/// assert_eq!(fix.camera_height_m(), 1.5);
/// let score = fix.best().unwrap().score;
/// assert!(fix.margin() < score, "windows alone leave alternatives");
/// // The same score elsewhere, for another up vector, leaves no margin; a low one changes nothing.
/// assert_eq!(fix.clone().with_rival(score).margin(), Nats::ZERO);
/// assert_eq!(fix.clone().with_rival(Nats::ZERO).margin(), fix.margin());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub fn locate<'a>(
    boundaries: &BoundaryEvidence<'_>,
    known: HeightPrior,
    within: &PosePrior,
    windows: &WindowEvidence,
    layers: &[FloorLayer<'a>],
    work: &mut Work<'_>,
) -> Fix<'a> {
    let hits = HitEvidence::new(windows);
    let heights = HeightGrid::coarse(&known);
    let query = Query { boundaries: *boundaries, hits: &hits, heights: &heights, within };
    let count = work.headings.search(&query, work.rows, layers, work.pool);
    let wanted = work.effort.refined_poses.clamp(1, MAX_REFINED);
    let mut found: Vec<Found, MAX_REFINED> = Vec::new();
    for entry in work.pool.iter().take(count.min(wanted)) {
        if let Some(pose) = entry.pose(layers) {
            // Never full: at most as many were taken.
            let _ = found.push((pose, entry.heights()));
        }
    }
    let mut evidence = Evidence {
        boundaries,
        hits: &hits,
        grid: HeightGrid::fine(&known),
        table: work.table,
        heights: None,
    };
    evidence.refine_found(layers, &mut found, within, &windows.upright_edges, &work.effort);
    let mut refined: Vec<ScoredPose, MAX_REFINED> = Vec::new();
    for (pose, _) in &found {
        let _ = refined.push(*pose);
    }
    let alternatives = select_alternatives(layers, &mut refined);
    let best = found.first().map_or([known.camera_rungs().unwrap_or(0); 2], |(_, heights)| *heights);
    let mut chosen: Vec<Found, MAX_ALTERNATIVES> = Vec::new();
    for pose in alternatives.poses() {
        let heights = found.iter().find(|(found, _)| found == pose).map_or(best, |(_, heights)| *heights);
        let _ = chosen.push((*pose, heights));
    }
    let covariances = evidence.covariances(layers, &mut chosen);
    let exchange = alternatives.best().map_or(Nats::ZERO, |first| evidence.exchange(layers, first, best));
    let [camera, above] = best;
    let heights = Heights { camera, ceiling: above.saturating_sub(camera) };
    Fix::new(layers, Answer { alternatives, covariances, heights, exchange }, known, *within)
}

/// The range rung nearest to a range in steps.
fn rung_at(steps: u16) -> i32 {
    (i32::from(position_of(steps)) + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS
}

/// Log-likelihood ratio of the upright edges at a pose; 0 outside the plan.
fn upright_score(layers: &[FloorLayer<'_>], pose: &ScoredPose, classes: &[u8; BINS]) -> Nats {
    let mut scan = Scan::OPEN;
    let layer = layers.get(usize::from(pose.layer));
    let is_free = layer.is_some_and(|layer| layer.plan.scan(pose.at, pose.heading, &mut scan).is_ok());
    if is_free { upright::score(&scan, classes) } else { Nats::ZERO }
}

/// Evidence of a frame, combined into a table for one pair of heights at a time.
struct Evidence<'a> {
    boundaries: &'a BoundaryEvidence<'a>,
    hits: &'a HitEvidence,
    grid: HeightGrid,
    table: &'a mut EvidenceTable,
    /// Heights of the table: of the camera above the floor and of the ceiling above the camera, rungs.
    heights: Option<[i8; 2]>,
}

impl Evidence<'_> {
    /// The evidence for two heights.
    // Once in code memory, of which boards have little.
    #[inline(never)]
    fn at(&mut self, [camera, above]: [i8; 2]) -> &EvidenceTable {
        if self.heights != Some([camera, above]) {
            weigh(self.boundaries, [camera, above], self.hits, self.table);
            self.heights = Some([camera, above]);
        }
        self.table
    }

    /// Refines the poses that the search found and chooses their heights; sorts them by score, and leaves out those that end
    /// where the pose is known not to be.
    fn refine_found(
        &mut self,
        layers: &[FloorLayer<'_>],
        found: &mut Vec<Found, MAX_REFINED>,
        within: &PosePrior,
        upright_edges: &[u8; BINS],
        effort: &Effort,
    ) {
        // A pose refined at wrong heights is a wrong pose, and its heights are wrong with it: twice.
        for _ in 0..2 {
            self.refine(layers, found, |table, layer, pose| refine_coarse(table, layer, pose, effort.rays));
            self.choose_heights(layers, found);
        }
        found.retain(|(pose, _)| pose_of(layers, pose).is_some_and(|pose| within.has_within(&pose, &ROUGH)));
        let grid = self.grid.clone();
        order::sort_by_key(found, |(pose, heights)| {
            (Reverse(pose.score.saturating_add(grid.prior(*heights))), pose.order(), *heights)
        });
        let fully = found.len().min(effort.refined_fully.max(1));
        let best = found.get_mut(..fully).unwrap_or_default();
        self.refine(layers, best, refine_fine);
        self.choose_heights(layers, best);
        self.refine(layers, best, refine_fine);
        let others = |(pose, heights): &Found| {
            grid.prior(*heights).saturating_add(upright_score(layers, pose, upright_edges))
        };
        // The best pose by all that is seen, refined to the end without the upright edges.
        let whole = |found: &Found| found.0.score.saturating_add(others(found));
        let first = found.iter().enumerate().max_by_key(|(at, found)| (whole(found), Reverse(*at)));
        if let Some(best) = first.map(|(at, _)| at).and_then(|at| found.get_mut(at)) {
            self.refine(layers, core::slice::from_mut(best), refine_final);
        }
        for found in found.iter_mut() {
            found.0.score = whole(found);
        }
        found.retain(|(pose, _)| pose_of(layers, pose).is_some_and(|pose| within.has(&pose)));
        order::sort_by_key(found, |(pose, heights)| (pose.order(), *heights));
    }

    /// Refines poses at their heights.
    fn refine(
        &mut self,
        layers: &[FloorLayer<'_>],
        found: &mut [Found],
        refine: impl Fn(&EvidenceTable, &FloorLayer<'_>, ScoredPose) -> ScoredPose,
    ) {
        self.visit(layers, found, |table, layer, _, pose| *pose = refine(table, layer, *pose));
    }

    /// The covariance of each pose.
    fn covariances(
        &mut self,
        layers: &[FloorLayer<'_>],
        found: &mut [Found],
    ) -> Vec<Covariance, MAX_ALTERNATIVES> {
        let mut all = Vec::new();
        let _ = all.resize(found.len().min(MAX_ALTERNATIVES), Covariance::UNKNOWN);
        self.visit(layers, found, |table, layer, number, pose| {
            if let Some(covariance) = all.get_mut(number) {
                *covariance = Covariance::new(table, layer, pose);
            }
        });
        all
    }

    /// Visits poses with the evidence for their heights, those of equal heights one after the other so that each table is
    /// filled once.
    fn visit(
        &mut self,
        layers: &[FloorLayer<'_>],
        found: &mut [Found],
        mut visit: impl FnMut(&EvidenceTable, &FloorLayer<'_>, usize, &mut ScoredPose),
    ) {
        for first in 0..found.len() {
            let Some((_, heights)) = found.get(first).copied() else { return };
            let before = found.get(..first).unwrap_or_default();
            if before.iter().any(|(_, others)| *others == heights) {
                continue;
            }
            let poses = found.iter_mut().enumerate().skip(first);
            for (number, (pose, _)) in poses.filter(|(_, (_, others))| *others == heights) {
                if let Some(layer) = layers.get(usize::from(pose.layer)) {
                    visit(self.at(heights), layer, number, pose);
                }
            }
        }
    }

    /// What the score of a pose gains if floor and ceiling exchange their weights: half of what the ceiling counts more than
    /// the floor.
    fn exchange(&self, layers: &[FloorLayer<'_>], pose: &ScoredPose, [camera, above]: [i8; 2]) -> Nats {
        let Some(layer) = layers.get(usize::from(pose.layer)) else { return Nats::ZERO };
        let Ok(rays) = layer.plan.rays(pose.at, pose.heading, 1) else { return Nats::ZERO };
        let mut gain = 0;
        for (bin, (steps, _)) in (0..BINS).zip(rays).filter(|(_, (_, hit))| *hit != Hit::Open) {
            let rung = rung_at(steps);
            let [floor, ceiling] = [(0, camera), (1, above)].map(|(surface, height)| {
                let cells = self.boundaries.rung(surface, rung_of(rung, height.into()));
                cells.get(bin).map_or(0, |cell| i32::from(cell.to_bits()))
            });
            gain += ceiling - floor;
        }
        Nats::from_bits(gain / 2)
    }

    /// Gives each pose the heights that explain it best, and its score there.
    fn choose_heights(&self, layers: &[FloorLayer<'_>], found: &mut [Found]) {
        for (pose, heights) in found {
            let Some(layer) = layers.get(usize::from(pose.layer)) else { continue };
            if let Some((score, best)) = self.best_heights(layer, pose) {
                (pose.score, *heights) = (score, best);
            }
        }
    }

    /// The heights that explain a pose best, and the score there, of every fourth ray and scaled to 360.
    fn best_heights(&self, layer: &FloorLayer<'_>, pose: &ScoredPose) -> Option<(Nats, [i8; 2])> {
        let mut floors = [0_i32; HeightGrid::CAMERAS];
        let mut ceilings = [0_i32; HeightGrid::CEILINGS];
        let mut hits = 0;
        let rays = layer.plan.rays(pose.at, pose.heading, HEIGHT_STRIDE.into()).ok()?;
        for (bin, (steps, hit)) in (0..BINS).step_by(HEIGHT_STRIDE.into()).zip(rays) {
            let types = match hit {
                Hit::Open => continue,
                Hit::Wall => &self.hits.wall,
                Hit::Window => &self.hits.window,
            };
            let bits = |cells: &[CellNats; BINS]| cells.get(bin).map_or(0, |cell| i32::from(cell.to_bits()));
            hits += bits(types);
            let rung = rung_at(steps);
            for (sum, height) in floors.iter_mut().zip(self.grid.cameras()) {
                *sum += bits(self.boundaries.rung(0, rung_of(rung, (*height).into())));
            }
            for (sum, height) in ceilings.iter_mut().zip(self.grid.ceilings()) {
                *sum += bits(self.boundaries.rung(1, rung_of(rung, (*height).into()))) >> CEILING_SHIFT;
            }
        }
        let best =
            floors.iter().zip(self.grid.cameras()).enumerate().flat_map(|(number, (floor, camera))| {
                let rooms = self.grid.rooms(number);
                let ceilings = ceilings.iter().zip(self.grid.ceilings()).take(rooms.end).skip(rooms.start);
                ceilings.map(|(ceiling, above)| {
                    let heights = [*camera, *above];
                    let prior = self.grid.prior(heights).to_bits() / i32::from(HEIGHT_STRIDE);
                    (*floor + *ceiling, prior, heights)
                })
            });
        let (score, _, heights) =
            best.max_by_key(|(score, prior, heights)| (*score + prior, Reverse(*heights)))?;
        // Without the prior, like the scores of refinement.
        Some((Nats::from_bits((score + hits) * i32::from(HEIGHT_STRIDE)), heights))
    }
}
