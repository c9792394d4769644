//! Refinement of a pose: pattern search for the maximum of the score between the candidates.
//!
//! The search moves to the best neighbour of the current position until none is better, then halves the step. At wide
//! steps, [parallax](View) predicts the scores of the neighbours, and rays are cast from the best one alone; at narrow
//! steps, rays are cast from all neighbours. Each cast is scored at several headings in steps of 1 degree; at small steps,
//! fractions of a degree are tried as well. Most moves use every fourth or sixth ray, because neighbouring rays meet the
//! same wall.
//!
//! # Thresholds
//! | constant | value | effect |
//! |---|---|---|
//! | `FINEST` | 0.02 m | smallest step: one march step |
//! | `WIDE` | 0.1 m | [`refine_coarse`] takes steps from half of it on, [`refine_fine`] steps below it |
//! | `FINAL` | 0.05 m | [`refine_final`] takes steps below it |
//! | `WIDE_HEADINGS`, `NARROW_HEADINGS` | 9, 3 | headings per cast at wide and at narrow steps |
//! | `WIDE_STRIDE`, `NARROW_STRIDE`, `FINAL_STRIDE` | 4, 4, 1 | azimuth stride of the rays, degrees |
//! | `LEVELS` | 6 | number of steps, each half the one before |
//! | `MOVES` | 4 | largest number of moves per step |
//!
//! They trade time for the number of poses found: `docs/design.md`, "Likelihood of a pose".

use super::evidence::EvidenceTable;
use super::parallax::View;
use super::search::FloorLayer;
use crate::base::num::{BINS, CastNats, Metres, Nats, Point, Turn};
use crate::base::pose::ScoredPose;
use crate::map::plan::Plan;
use core::cmp::Reverse;

/// Smallest step of the pattern: 0.02 m.
const FINEST: Metres = Metres::from_bits((1 << 32) / 50);
/// Border of wide and narrow steps: 0.1 m. Steps from half of it to it are taken by both.
const WIDE: Metres = Metres::from_bits((1 << 32) / 10);
/// Upper limit of the steps of the final pattern: 0.05 m.
const FINAL: Metres = Metres::from_bits((1 << 32) / 20);
/// Headings per cast of the wide pattern, 1 degree apart.
const WIDE_HEADINGS: usize = 9;
/// Headings per cast of the narrow and the final pattern, 1 degree apart.
const NARROW_HEADINGS: usize = 3;
/// Smallest azimuth stride of the rays of the wide pattern, degrees.
const WIDE_STRIDE: usize = 4;
/// Azimuth stride of the rays of the narrow pattern, degrees.
const NARROW_STRIDE: usize = 4;
/// Azimuth stride of the rays of the final pattern, degrees.
const FINAL_STRIDE: usize = 1;

/// Number of steps of the pattern, each half the one before.
const LEVELS: usize = 6;
/// Largest number of moves per step.
const MOVES: usize = 4;
/// Upper bound of the casts of [`refine`](refine()), of all rays or a part of them: eight at the begin and end of its
/// parts, and seven per move (five positions, two headings), at most 6 steps in each of three parts.
pub const MAX_CASTS: usize = 8 + 3 * LEVELS * MOVES * (5 + TURNS.len());

/// The neighbours of a position along x and along y.
const ALONG: [[Way; 2]; 2] = [[[1, 0], [-1, 0]], [[0, 1], [0, -1]]];
/// The diagonal neighbours of a position.
const DIAGONAL: [Way; 4] = [[1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Heading changes of the narrow pattern, in units proportional to the step.
const TURNS: [i32; 2] = [1, -1];

/// A position, a heading, and the score of the rays cast from there, scaled to 360 bins.
#[derive(Debug, Clone, Copy)]
struct Cast {
    at: Point,
    heading: Turn,
    score: CastNats,
}

impl Cast {
    fn scored(self, layer: u8) -> ScoredPose {
        let Self { at, heading, score } = self;
        ScoredPose { layer, at, heading, score: Nats::from_bits((score.to_bits() + (1 << 7)) >> 8) }
    }
}

/// Moves a pose to a local maximum of the score: [`refine_coarse`], [`refine_fine`], then [`refine_final`].
///
/// The score of the result is the sum of the [interpolated](EvidenceTable::at) values of all 360 rays, and never below
/// that of the start. The result is never outside the plan or in an occupied cell; a pose that starts there is returned
/// unchanged.
///
/// # Formats
/// The smallest step is 0.02 m in position and 0.16 degrees in heading; the score is rounded to 1/16 nat.
///
/// # Accuracy
/// Within 0.05 m and 0.5 degrees of the true pose, with a third of the directions unknown and a tenth wrong (test
/// `a_pose_off_the_grid_is_found`).
///
/// # Cost
/// At most [`MAX_CASTS`] casts. On an office floor with candidates 0.5 m apart, the time of about 30 casts of 360 rays.
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
/// let start = ScoredPose { layer: 0, at: map.position(7).unwrap(), heading: Turn::from_degrees(2), score: Nats::ZERO };
/// let refined = refine(&table, &layer, start);
/// assert!(refined.score > Nats::ZERO);
/// assert!(refined.heading.distance(Turn::ZERO) < Turn::from_degrees(1));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[must_use]
pub fn refine(table: &EvidenceTable, layer: &FloorLayer<'_>, pose: ScoredPose) -> ScoredPose {
    let whole = Climb::<1> { table, plan: layer.plan, stride: 1 };
    let Some(start) = whole.cast(pose.at, pose.heading) else { return pose };
    let end =
        refine_final(table, layer, refine_fine(table, layer, refine_coarse(table, layer, pose, WIDE_STRIDE)));
    let start = start.scored(pose.layer);
    if end.score > start.score { end } else { start }
}

/// The first part of [`refine`](refine()): steps from 0.05 m on, to an accuracy of about 0.1 m.
///
/// `stride` is the azimuth stride of the rays in degrees, clamped to 4 to 360. The score is that of these rays, scaled to 360.
#[must_use]
pub fn refine_coarse(
    table: &EvidenceTable,
    layer: &FloorLayer<'_>,
    pose: ScoredPose,
    stride: usize,
) -> ScoredPose {
    let stride = stride.clamp(WIDE_STRIDE, BINS);
    let climb = Climb::<WIDE_HEADINGS> { table, plan: layer.plan, stride };
    let Some((start, mut view)) = climb.cast_view(pose.at, pose.heading) else { return pose };
    let wide = |step| step >= WIDE / 2;
    climb_through(start, layer, wide, |pose, _, step| climb.predicted_neighbour(&mut view, pose, step))
        .scored(pose.layer)
}

/// The second part of [`refine`](refine()): steps below 0.1 m, from the result of [`refine_coarse`].
#[must_use]
pub fn refine_fine(table: &EvidenceTable, layer: &FloorLayer<'_>, pose: ScoredPose) -> ScoredPose {
    climb_narrow(table, layer, pose, NARROW_STRIDE, |step| step < WIDE)
}

/// The last part of [`refine`](refine()): steps below 0.05 m again, with all rays.
#[must_use]
pub fn refine_final(table: &EvidenceTable, layer: &FloorLayer<'_>, pose: ScoredPose) -> ScoredPose {
    climb_narrow(table, layer, pose, FINAL_STRIDE, |step| step < FINAL)
}

/// Pattern search over the steps for which `wanted` holds. All rays score the start and the end, and the better one is the
/// result: a part of the rays can mislead.
fn climb_narrow(
    table: &EvidenceTable,
    layer: &FloorLayer<'_>,
    pose: ScoredPose,
    stride: usize,
    wanted: impl Fn(Metres) -> bool,
) -> ScoredPose {
    let climb = Climb::<NARROW_HEADINGS> { table, plan: layer.plan, stride };
    let whole = Climb { stride: 1, ..climb };
    let Some(start) = whole.cast(pose.at, pose.heading) else { return pose };
    let first = if stride > 1 { climb.cast(start.at, start.heading) } else { Some(start) };
    let Some(first) = first else { return pose };
    let end = climb_through(first, layer, wanted, |pose, came, step| climb.neighbour(pose, came, step));
    let end = if stride > 1 { whole.cast(end.at, end.heading) } else { Some(end) };
    end.filter(|end| end.score > start.score).unwrap_or(start).scored(pose.layer)
}

/// Pattern search over the steps for which `wanted` holds; `neighbour` gives the best neighbour if it is better.
fn climb_through(
    mut pose: Cast,
    layer: &FloorLayer<'_>,
    wanted: impl Fn(Metres) -> bool,
    mut neighbour: impl FnMut(&Cast, Option<Way>, Metres) -> Option<Move>,
) -> Cast {
    // Three quarters of the spacing: beyond the middle between two candidates.
    let mut step = layer.spacing() / 4 * 3;
    for _ in 0..LEVELS {
        if wanted(step) {
            let mut came = None;
            for _ in 0..MOVES {
                let Some((there, way)) = neighbour(&pose, came, step) else { break };
                (pose, came) = (there, Some(way));
            }
        }
        step /= 2;
        if step < FINEST {
            break;
        }
    }
    pose
}

/// A direction: -1, 0 or 1 step along x and along y.
type Way = [i8; 2];
/// A cast and the direction from the former position to it.
type Move = (Cast, Way);

fn score((pose, _): &Move) -> CastNats {
    pose.score
}

/// Whether a neighbour was scored at the former position, `came` being the direction of the last move. After a change of
/// heading alone, all were.
fn is_known(came: Option<Way>, way: Way) -> bool {
    came.is_some_and(|came| came == [0; 2] || came.iter().zip(way).any(|(came, way)| came * way < 0))
}

/// The objective of the pattern search: every `stride`-th ray, scored at `HEADINGS` headings.
#[derive(Debug, Clone, Copy)]
struct Climb<'a, const HEADINGS: usize> {
    table: &'a EvidenceTable,
    plan: Plan<'a>,
    stride: usize,
}

impl<const HEADINGS: usize> Climb<'_, HEADINGS> {
    /// The best neighbour in position or heading by casts, if it is better than `pose`; `came` is the direction of the last
    /// move.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "headings wrap, like all turns"
    )]
    fn neighbour(&self, pose: &Cast, came: Option<Way>, step: Metres) -> Option<Move> {
        let cast = |way: Way| Some((self.cast(beside(pose.at, way, step), pose.heading)?, way));
        let [x, y] = ALONG.map(|ways| {
            let unknown = ways.into_iter().filter(|way| !is_known(came, *way));
            unknown.filter_map(cast).max_by_key(score)
        });
        // One diagonal neighbour: that between the better neighbour along x and the better one along y.
        let diagonal = match (x, y) {
            (Some((a, [dx, _])), Some((b, [_, dy]))) if a.score.max(b.score) > pose.score => cast([dx, dy]),
            _ => None,
        };
        // 8 degrees per metre: a wall at 7 m is displaced as far as by the step.
        let unit = (step.to_bits() / 360 * 8) as u32;
        let turned = TURNS.into_iter().filter_map(|units| {
            let heading = pose.heading + Turn::from_bits(unit.wrapping_mul(units.cast_unsigned()));
            Some((self.cast(pose.at, heading)?, [0; 2]))
        });
        let found = [x, y, diagonal].into_iter().flatten().chain(turned).max_by_key(score);
        found.filter(|(there, _)| there.score > pose.score)
    }

    /// The best neighbour by parallax, cast from there, if it is better than `pose`.
    fn predicted_neighbour(&self, view: &mut View, pose: &Cast, step: Metres) -> Option<Move> {
        let predict = |way: &Way| {
            let scores = view.scores::<HEADINGS>(self.table, aside(*way, step));
            (best(beside(pose.at, *way, step), pose.heading, scores), *way)
        };
        let is_better = |there: &Cast| there.score > pose.score;
        let ways = ALONG.as_flattened().iter().chain(&DIAGONAL);
        let (nearby, way) = ways.map(predict).max_by_key(score).filter(|(there, _)| is_better(there))?;
        let (there, from_there) =
            self.cast_view(nearby.at, nearby.heading).filter(|(there, _)| is_better(there))?;
        *view = from_there;
        Some((there, way))
    }

    /// Casts rays: the best heading and the end points. `None` outside the plan or in an occupied cell.
    fn cast_view(&self, at: Point, heading: Turn) -> Option<(Cast, View)> {
        let mut view = View::cast(&self.plan, at, heading, self.stride).ok()?;
        let pose = best(at, heading, view.scores::<HEADINGS>(self.table, [Metres::ZERO; 2]));
        view.turn(pose.heading);
        Some((pose, view))
    }

    /// [`Climb::cast_view`] without the end points.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "strides are at most 360"
    )]
    fn cast(&self, at: Point, heading: Turn) -> Option<Cast> {
        let mut scores = [0; HEADINGS];
        let rays = self.plan.rays(at, heading, self.stride).ok()?;
        for (bin, (steps, hit)) in (0..BINS).step_by(self.stride.max(1)).zip(rays) {
            self.table.between(steps, hit).add_around(bin, &mut scores);
        }
        Some(best(at, heading, scores.map(|score| score * self.stride as i32)))
    }
}

/// The best of `HEADINGS` headings, centred on one and 1 degree apart; of equal ones the nearest to the centre. Scores are
/// the bits of [`CastNats`].
#[expect(clippy::cast_possible_wrap, reason = "at most 9 headings")]
fn best<const HEADINGS: usize>(at: Point, heading: Turn, scores: [i32; HEADINGS]) -> Cast {
    let middle = (HEADINGS / 2) as i64;
    let top = (-middle..).zip(scores).max_by_key(|&(degrees, score)| (score, Reverse(degrees.abs())));
    let (degrees, score) = top.unwrap_or((0, i32::MIN));
    Cast { at, heading: heading + Turn::from_degrees(degrees), score: CastNats::from_bits(score) }
}

fn aside(way: Way, step: Metres) -> [Metres; 2] {
    way.map(|steps| step.saturating_mul_int(i64::from(steps)))
}

fn beside(at: Point, way: Way, step: Metres) -> Point {
    let [x, y] = aside(way, step);
    Point::new(at.x.saturating_add(x), at.y.saturating_add(y))
}
