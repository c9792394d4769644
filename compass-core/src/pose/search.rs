//! Exhaustive search over candidates and headings, with non-maximum suppression.

use super::rows::Rows;
use crate::base::num::{BINS, Nats, Point, Turn};
use crate::base::order;
use crate::base::pose::{Pose, ScoredPose, Separation};
use crate::map::plan::Plan;
use crate::map::site_map::{PACKED_SCAN_BYTES, SiteMap};
use bytemuck::{Pod, Zeroable};
use core::cmp::Reverse;

/// Smallest angle between the two headings kept per candidate, degrees.
const SECOND_DEGREES: usize = Separation::ALTERNATIVES.turn.to_bin();
/// Margin added to a [rough score](Rows::rough_top) before a candidate is rejected by it. With 30 nats no pose was lost on
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
    layer: u32,
}

impl PoolEntry {
    /// A place-holder of zero bytes.
    pub const EMPTY: Self = Self { score: Nats::ZERO, heading: 0, cell: [0; 2], layer: 0 };

    /// The pose; `None` if the layer does not exist.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "the search numbers at most 256 layers")]
    pub fn pose(&self, layers: &[FloorLayer<'_>]) -> Option<ScoredPose> {
        let at = self.position(layers)?;
        Some(ScoredPose { layer: self.layer as u8, at, heading: self.heading(), score: self.score })
    }

    fn position(&self, layers: &[FloorLayer<'_>]) -> Option<Point> {
        let [column, row] = self.cell;
        Some(layers.get(self.layer as usize)?.map.header().grid.cell_centre(column, row))
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

/// Scores the candidates of all layers at N headings, and keeps the best poses that are separated.
///
/// Each candidate contributes its best heading, and the best one at least 20 degrees from that. `pool` keeps the entries
/// of highest score; then non-maximum suppression drops those within 0.75 m and 15 degrees of a better one on the same
/// layer. Returns the number of poses at the front of `pool`, by descending score.
///
/// `among` selects candidates by layer and number: `|_, _| true` for all. Only the first 256 layers are searched.
///
/// A candidate is rejected early if its [rough score](Rows::rough_top) is more than 30 nats below the worst entry of a
/// full pool. The rough score is an estimate, not a bound: a pose that belongs into the pool can be lost, though hardly
/// the best one.
///
/// # Formats
/// Headings are the multiples of 360 / N degrees. Scores are in 1/16 nat, scaled to 360 bins.
///
/// # Cost
/// Per candidate N / 2 additions for each of N / 6 to N / 2 rough rays. Per candidate that is not rejected, 2 N additions
/// for each run of equal planes: at most N runs; about 107 at N = 360 and 61 at N = 90 on an office floor. The suppression
/// is quadratic in the size of the pool.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// # use compass_core::pose::{EvidenceTable, FloorLayer, PoolEntry, Rows, plane_of, refine, search, select_alternatives};
/// # use compass_core::{Nats, Scan, ScoredPose, Turn};
/// # let map = *floor.map();
/// # let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
/// # let mut scan = Scan::OPEN;
/// # map.get(7).unwrap().scan(&mut scan);
/// # let mut table = Box::new(EvidenceTable::EMPTY);
/// # for (bin, (steps, hit)) in scan.steps.iter().zip(scan.hit).enumerate() {
/// #     table.set(plane_of(*steps, hit), bin, Nats::ONE);
/// # }
/// // `table` is evidence of the scan of candidate 7, at heading 0.
/// let mut rows = Box::new(Rows::<90>::BLANK);
/// rows.set(&table);
/// let mut pool = [PoolEntry::EMPTY; 64];
/// let count = search(&rows, &[layer], |_, _| true, &mut pool);
/// assert!(count > 1);
/// let best = pool[0].pose(&[layer]).unwrap();
/// assert_eq!((Some(best.at), best.heading), (map.position(7), Turn::ZERO));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[inline]
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 360 headings")]
pub fn search<const N: usize>(
    rows: &Rows<N>,
    layers: &[FloorLayer<'_>],
    among: impl Fn(u8, usize) -> bool,
    pool: &mut [PoolEntry],
) -> usize {
    let mut pool = Pool { slots: pool, used: 0 };
    let mut scores = [0; N];
    for (number, layer) in (0..=u8::MAX).zip(layers) {
        for candidate in (0..layer.map.len()).filter(|&candidate| among(number, candidate)) {
            let Some(packed) = layer.packed(candidate) else { continue };
            let rough = rows.rough_top(packed);
            if !pool.is_worth(Rows::<N>::of_360(rough).saturating_add(SLACK)) {
                continue;
            }
            rows.scores(&Rows::planes_of_packed(packed), &mut scores);
            if pool.is_worth(Rows::<N>::of_360(top(&scores)))
                && let Some(record) = layer.map.get(candidate)
            {
                for (heading, score) in peaks(&scores) {
                    let heading = Turn::from_ratio(heading as i64, N as u32).to_bits();
                    let (cell, layer) = (record.cell(), number.into());
                    pool.insert(PoolEntry { score: Rows::<N>::of_360(score), heading, cell, layer });
                }
            }
        }
    }
    pool.suppress_near(layers)
}

fn top(scores: &[i16]) -> i16 {
    scores.iter().fold(i16::MIN, |top, &score| top.max(score))
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
