//! Exhaustive search over candidates and headings, with non-maximum suppression.

use super::evidence::HitEvidence;
use super::heights::HeightGrid;
use super::prior::PosePrior;
use super::rows::{Rows, Source};
use crate::base::num::{BINS, Metres, Nats, Point, Turn};
use crate::base::order;
use crate::base::pose::{Pose, ScoredPose, Separation};
use crate::map::plan::Plan;
use crate::map::site_map::{PACKED_SCAN_BYTES, SiteMap};
use crate::vision::boundary::BoundaryEvidence;
use bytemuck::{Pod, Zeroable};
use core::cmp::Reverse;

/// Smallest angle between the two headings kept per candidate, degrees.
const SECOND_DEGREES: usize = Separation::ALTERNATIVES.turn.to_bin();
/// Margin added to a rough score before a candidate is rejected by it. With 30 nats no pose was lost on
/// 129 frame pairs (`docs/design.md`).
const SLACK: Nats = Nats::lit("30");

/// One layer of one floor: its candidates and the plan that they were cast from.
#[derive(Debug, Clone, Copy)]
pub struct FloorLayer<'a> {
    /// Site map of the floor.
    pub map: SiteMap<'a>,
    /// Number of the layer: 0 plan, 1 structure.
    pub number: u8,
    /// Packed plan of the layer.
    pub plan: Plan<'a>,
    /// Number of the floor in the site. Layers of one floor share its coordinates.
    pub floor: u8,
    /// Name of the floor.
    pub name: &'a str,
}

impl<'a> FloorLayer<'a> {
    /// The scan of a candidate as it is stored.
    fn packed(&self, candidate: usize) -> Option<&'a [u8; PACKED_SCAN_BYTES]> {
        self.map.get(candidate)?.layer(usize::from(self.number))?.packed()
    }

    /// Distance between candidates.
    pub(super) fn spacing(&self) -> Metres {
        Metres::from_bits((i64::from(self.map.header().spacing_mm) << 32) / 1000)
    }

    /// Whether a candidate is where the pose is known to be, or its spacing beyond.
    fn is_near(&self, candidate: usize, within: &PosePrior) -> bool {
        within.place().is_none()
            || self.map.position(candidate).is_some_and(|at| within.has_place_within(at, self.spacing()))
    }
}

/// A scored pose without its layer and score; `None` if its layer does not exist.
pub(super) fn pose_of(layers: &[FloorLayer<'_>], scored: &ScoredPose) -> Option<Pose> {
    let floor = layers.get(usize::from(scored.layer))?.floor;
    Some(Pose { floor, at: scored.at, heading: scored.heading })
}

/// Largest useful size of a pool.
pub const MAX_POOL: usize = 4096;

/// A candidate at a heading with its score: an entry of the pool of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct PoolEntry {
    score: Nats,
    heading: u32,
    /// Plan cell: column from the west, row from the south.
    cell: [u16; 2],
    layer: u8,
    /// Height of the camera above the floor and of the ceiling above the camera, rungs.
    heights: [i8; 2],
    padding: u8,
}

impl PoolEntry {
    /// A place-holder of zero bytes.
    pub const EMPTY: Self =
        Self { score: Nats::ZERO, heading: 0, cell: [0; 2], layer: 0, heights: [0; 2], padding: 0 };

    /// The pose; `None` if the layer does not exist.
    #[must_use]
    pub fn pose(&self, layers: &[FloorLayer<'_>]) -> Option<ScoredPose> {
        let at = self.position(layers)?;
        Some(ScoredPose { layer: self.layer, at, heading: self.heading(), score: self.score })
    }

    /// Height of the camera above the floor and of the ceiling above the camera, rungs, that the pose has its score at.
    pub(super) const fn heights(&self) -> [i8; 2] {
        self.heights
    }

    fn position(&self, layers: &[FloorLayer<'_>]) -> Option<Point> {
        let [column, row] = self.cell;
        Some(layers.get(usize::from(self.layer))?.map.header().grid.cell_centre(column, row))
    }

    const fn heading(&self) -> Turn {
        Turn::from_bits(self.heading)
    }

    /// The order of [`ScoredPose::order`]: positions increase with columns and rows.
    fn order(&self) -> impl Ord + use<> {
        let [column, row] = self.cell;
        (Reverse(self.score), self.layer, row, column, self.heading)
    }
}

/// What a search is for: the evidence of the images and the heights to try.
#[derive(Debug, Clone, Copy)]
pub struct Query<'a> {
    /// Boundaries of floor and ceiling.
    pub boundaries: BoundaryEvidence<'a>,
    /// Window or wall.
    pub hits: &'a HitEvidence,
    /// Heights of camera and ceiling.
    pub heights: &'a HeightGrid,
    /// Where the pose is known to be.
    pub within: &'a PosePrior,
}

/// Scores the candidates of all layers at N headings and all heights, and keeps the best poses that are separated.
///
/// Each candidate contributes its best heading, and the best one at least 20 degrees from that. `pool` keeps the entries
/// of highest score; then non-maximum suppression drops those within 0.75 m and 15 degrees of a better one on the same
/// layer. Returns the number of poses at the front of `pool`, by descending score.
///
/// `within` restricts the search: to candidates at most their spacing, and headings at most 360 / N degrees beyond what it
/// says, from which refinement may reach it. Only the first 256 layers are searched.
///
/// A candidate is rejected early if its rough score is more than 30 nats below the worst entry of a full pool. The rough
/// score is an estimate, not a bound: a pose that belongs into the pool can be lost, though hardly the best one.
///
/// # Formats
/// Headings are the multiples of 360 / N degrees. Scores are in 1/16 nat, scaled to 360 bins. The score at a heading is that
/// of the best heights of the grid: the sum of floor, ceiling and hit type.
///
/// # Cost
/// Per candidate and height N / 2 additions for each of N / 6 to N / 2 rough rays. Per candidate that is not rejected, and
/// height, 2 N additions for each run of equal rays: at most N runs; about 107 at N = 360 and 61 at N = 90 on an office floor.
/// The suppression is quadratic in the size of the pool.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// use compass_core::base::num::{BINS, CellNats, Turn};
/// use compass_core::pose::heights::{HeightGrid, HeightPrior};
/// use compass_core::pose::{FloorLayer, HitEvidence, PoolEntry, PosePrior, Rows, search};
/// use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
///
/// # let map = *floor.map();
/// # let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
/// // The floor's boundary as a camera 1.5 m above it sees it from candidate 7, at heading 0.
/// let mut scan = compass_core::Scan::OPEN;
/// map.get(7).unwrap().scan(&mut scan);
/// let mut cells = vec![CellNats::ZERO; CELLS];
/// for (bin, steps) in scan.steps.iter().enumerate().filter(|(_, steps)| **steps < 1500) {
///     let rung = 9.0 + (f32::from(*steps) * 0.02 / 0.4).ln() / 0.0608;
///     cells[rung.round() as usize * BINS + bin] = CellNats::ONE;
/// }
/// let evidence = BoundaryEvidence::new(&cells).unwrap();
/// let hits = HitEvidence { wall: [CellNats::ZERO; BINS], window: [CellNats::ZERO; BINS] };
/// let mut rows = Box::new(Rows::<90>::BLANK);
/// rows.set(&evidence, &hits, 0.5);
///
/// let mut pool = [PoolEntry::EMPTY; 64];
/// let heights = HeightGrid::coarse(&HeightPrior::camera(1.5));
/// let count = search(&rows, &heights, &[layer], &PosePrior::UNKNOWN, &mut pool);
/// assert!(count > 1);
/// let best = pool[0].pose(&[layer]).unwrap();
/// assert_eq!((Some(best.at), best.heading), (map.position(7), Turn::ZERO));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[inline]
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 360 headings")]
pub fn search<const N: usize>(
    rows: &Rows<N>,
    heights: &HeightGrid,
    layers: &[FloorLayer<'_>],
    within: &PosePrior,
    pool: &mut [PoolEntry],
) -> usize {
    let mut pool = Pool { slots: pool, used: 0 };
    let mut scores = Scores::<N>::NONE;
    for (number, layer) in (0..=u8::MAX).zip(layers).filter(|(_, layer)| within.has_floor(layer.floor)) {
        for candidate in (0..layer.map.len()).filter(|&candidate| layer.is_near(candidate, within)) {
            let Some(packed) = layer.packed(candidate) else { continue };
            let rays = Rows::<N>::rough_rays(packed);
            scores.fill(heights, N / 2, |source, out| rows.rough_scores(&rays, source, out));
            scores.keep(|top| pool.is_worth(Rows::<N>::of_360(top).saturating_add(SLACK)));
            if !scores.is_kept() {
                continue;
            }
            let runs = Rows::<N>::runs_of(packed);
            scores.fill(heights, N, |source, out| rows.scores(&runs, source, out));
            scores.keep_headings(within);
            if pool.is_worth(Rows::<N>::of_360(scores.top(N)))
                && let Some(record) = layer.map.get(candidate)
            {
                for (heading, score) in peaks(&scores.best) {
                    let heights = scores.heights(heights, heading);
                    let heading = Turn::from_ratio(heading as i64, N as u32).to_bits();
                    let (cell, layer, score) = (record.cell(), number, Rows::<N>::of_360(score));
                    pool.insert(PoolEntry { score, heading, cell, layer, heights, padding: 0 });
                }
            }
        }
    }
    pool.suppress_near(layers)
}

/// Scores of a candidate at N headings by each source and height.
struct Scores<const N: usize> {
    cameras: [[i16; N]; HeightGrid::CAMERAS],
    ceilings: [[i16; N]; HeightGrid::CEILINGS],
    /// The largest sum at each camera height; [`i16::MIN`] for one that is left out.
    tops: [i16; HeightGrid::CAMERAS],
    /// The sum at the best heights.
    best: [i16; N],
}

impl<const N: usize> Scores<N> {
    const NONE: Self = Self {
        cameras: [[0; N]; HeightGrid::CAMERAS],
        ceilings: [[0; N]; HeightGrid::CEILINGS],
        tops: [0; HeightGrid::CAMERAS],
        best: [0; N],
    };

    /// Scores the first `headings` by each source, and their sums at the best heights: of all camera heights if `headings` is
    /// a part of N, else of those that are [kept](Self::keep).
    #[inline]
    fn fill(&mut self, grid: &HeightGrid, headings: usize, score: impl Fn(Source, &mut [i16; N])) {
        if headings < N {
            let cameras = grid.cameras().len();
            self.tops = core::array::from_fn(|camera| if camera < cameras { 0 } else { i16::MIN });
        }
        let kept = |camera: &usize| self.tops.get(*camera).is_some_and(|top| *top > i16::MIN);
        let rooms = (0..grid.cameras().len()).filter(kept).map(|camera| grid.rooms(camera));
        let rooms = rooms.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0);
        // A rough score takes every second ceiling.
        let step = if headings < N && grid.has_many_ceilings() { 2 } else { 1 };
        let ceilings = self.ceilings.iter_mut().zip(grid.ceilings()).enumerate();
        for (_, (scores, height)) in
            ceilings.take(rooms.end).skip(rooms.start).filter(|(number, _)| number % step == 0)
        {
            score(Source::Ceiling(*height), scores);
        }
        let mut hits = [0; N];
        score(Source::HitType, &mut hits);
        self.best = [i16::MIN; N];
        let cameras = self.cameras.iter_mut().zip(&mut self.tops).zip(grid.cameras()).enumerate();
        for (camera, ((floor, top), height)) in cameras {
            if *top == i16::MIN {
                continue;
            }
            score(Source::Floor(*height), floor);
            let mut above = [i16::MIN; N];
            let rooms = grid.rooms(camera);
            let first = rooms.start.next_multiple_of(step);
            for ceiling in self.ceilings.iter().take(rooms.end).skip(first).step_by(step) {
                for (above, ceiling) in above.iter_mut().zip(ceiling).take(headings) {
                    *above = (*above).max(*ceiling);
                }
            }
            let prior = Rows::<N>::from_360(grid.camera_prior(camera));
            let mut most = i16::MIN;
            let sums = self.best.iter_mut().zip(floor.iter()).zip(&above).zip(&hits).take(headings);
            for (((best, floor), above), hits) in sums {
                let sum = floor.saturating_add(*above).saturating_add(*hits).saturating_add(prior);
                *best = (*best).max(sum);
                most = most.max(sum);
            }
            *top = most;
        }
    }

    /// Leaves out the camera heights whose largest sum is not worth it.
    fn keep(&mut self, is_worth: impl Fn(i16) -> bool) {
        for top in &mut self.tops {
            *top = if is_worth(*top) { *top } else { i16::MIN };
        }
    }

    /// Leaves out the headings that are known to be wrong by more than a step.
    #[expect(clippy::cast_possible_truncation, reason = "at most 360 headings")]
    fn keep_headings(&mut self, within: &PosePrior) {
        if within.heading().is_none() {
            return;
        }
        for (heading, best) in (0..).zip(&mut self.best) {
            if !within.has_heading_within(Turn::from_ratio(heading, N as u32), Turn::from_ratio(1, N as u32))
            {
                *best = i16::MIN;
            }
        }
    }

    fn is_kept(&self) -> bool {
        self.tops.iter().any(|top| *top > i16::MIN)
    }

    fn top(&self, headings: usize) -> i16 {
        self.best.iter().take(headings).fold(i16::MIN, |top, &score| top.max(score))
    }

    /// The heights that a heading has its score at.
    fn heights(&self, grid: &HeightGrid, heading: usize) -> [i8; 2] {
        let at = |scores: &[i16; N]| scores.get(heading).copied().unwrap_or(i16::MIN);
        let mut best = (i16::MIN, [0; 2]);
        let cameras = self.cameras.iter().zip(&self.tops).zip(grid.cameras()).enumerate();
        for (camera, ((floor, top), height)) in cameras {
            if *top == i16::MIN {
                continue;
            }
            let floor = at(floor).saturating_add(Rows::<N>::from_360(grid.camera_prior(camera)));
            let rooms = grid.rooms(camera);
            let ceilings = self.ceilings.iter().zip(grid.ceilings()).skip(rooms.start).take(rooms.len());
            for (above, ceiling) in ceilings {
                let sum = floor.saturating_add(at(above));
                if sum > best.0 {
                    best = (sum, [*height, *ceiling]);
                }
            }
        }
        best.1
    }
}
/// The best heading and the best one at least [`SECOND_DEGREES`] from it, with their scores; of equal ones the first.
fn peaks<const N: usize>(scores: &[i16; N]) -> impl Iterator<Item = (usize, i16)> {
    let first = best(scores.iter().copied().enumerate());
    let is_far = move |heading: usize| {
        let turn = heading.abs_diff(first.0);
        turn.min(N.saturating_sub(turn)) * BINS >= SECOND_DEGREES * N
    };
    let second = best(scores.iter().copied().enumerate().filter(|&(heading, _)| is_far(heading)));
    [first, second].into_iter().filter(|peak| peak.1 > i16::MIN)
}

fn best(scores: impl Iterator<Item = (usize, i16)>) -> (usize, i16) {
    scores.fold((0, i16::MIN), |best, here| if here.1 > best.1 { here } else { best })
}

/// The best entries so far; when full, a heap with the worst entry first.
struct Pool<'a> {
    slots: &'a mut [PoolEntry],
    used: usize,
}

impl Pool<'_> {
    /// Whether an entry of this score could be kept.
    fn is_worth(&self, score: Nats) -> bool {
        self.used < self.slots.len() || self.slots.first().is_some_and(|worst| score >= worst.score)
    }

    fn insert(&mut self, entry: PoolEntry) {
        if let Some(slot) = self.slots.get_mut(self.used) {
            *slot = entry;
            self.used += 1;
            if self.used == self.slots.len() {
                order::heapify(self.slots, &PoolEntry::order);
            }
        } else if let Some(worst) = self.slots.first_mut()
            && entry.order() < worst.order()
        {
            *worst = entry;
            order::sink(self.slots, 0, &PoolEntry::order);
        }
    }

    /// Non-maximum suppression: moves the remaining entries to the front, best first, and returns their number.
    fn suppress_near(self, layers: &[FloorLayer<'_>]) -> usize {
        let entries = self.slots.get_mut(..self.used).unwrap_or_default();
        order::sort_by_key(entries, PoolEntry::order);
        let mut kept = 0;
        for next in 0..entries.len() {
            let (Some(before), Some(entry)) = (entries.get(..kept), entries.get(next)) else { break };
            let at = entry.position(layers);
            let is_near = |other: &PoolEntry| {
                other.layer == entry.layer
                    && Separation::FOUND.is_turn_near(entry.heading(), other.heading())
                    && at
                        .zip(other.position(layers))
                        .is_some_and(|(a, b)| Separation::FOUND.is_place_near(a, b))
            };
            if !before.iter().any(is_near) {
                order::swap(entries, kept, next);
                kept += 1;
            }
        }
        kept
    }
}
