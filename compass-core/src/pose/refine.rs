//! From a candidate to where between the candidates the likelihood is highest.
//!
//! A pattern search: of the neighbours of the best position so far the best is taken, until none is better; then the
//! pattern shrinks to half. While it is wide, [parallax](View) tells which neighbour is likeliest, and rays are cast from
//! that one alone. The rays are laid over the table at some whole degrees around the heading; when the pattern is narrow,
//! parts of a degree are tried as well.
//!
//! A sixth or a quarter of the 360 rays do for most of the way, since neighbouring bins see the same wall.

use super::evidence::EvidenceTable;
use super::parallax::View;
use super::search::FloorLayer;
use crate::base::num::{BINS, CastNats, Metres, Nats, Point, Turn};
use crate::base::pose::ScoredPose;
use crate::map::plan::Plan;
use core::cmp::Reverse;

/// The pattern ends below this, 0.02 m.
const FINEST: Metres = Metres::from_bits((1 << 32) / 50);
/// Patterns from here on are wide, 0.1 m.
const WIDE: Metres = Metres::from_bits((1 << 32) / 10);
/// Patterns below this are polished, 0.05 m.
const POLISHED: Metres = Metres::from_bits((1 << 32) / 20);
/// Headings a cast is laid at, one degree apart, while the pattern is wide and when it is narrow.
const WIDE_HEADINGS: usize = 9;
const NARROW_HEADINGS: usize = 3;
/// Every how many-th ray is cast while the pattern is wide, unless otherwise told, while it is narrow, and for the last step.
const WIDE_STRIDE: usize = 4;
const NARROW_STRIDE: usize = 4;
const LAST_STRIDE: usize = 1;

/// Widths of the pattern.
const LEVELS: usize = 6;
/// Moves at one width.
const MOVES: usize = 4;
/// No more casts than this are made, with all rays or some of them: eight where the parts begin and end, and per move five
/// neighbours and two headings; parts share widths.
pub const MAX_CASTS: usize = 8 + 3 * LEVELS * MOVES * (5 + TURNS.len());

/// The neighbours of a position along x and y, and diagonally.
const ALONG: [[Way; 2]; 2] = [[[1, 0], [-1, 0]], [[0, 1], [0, -1]]];
const DIAGONAL: [Way; 4] = [[1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Headings beside a narrow pattern's, by units that shrink with it.
const TURNS: [i32; 2] = [1, -1];

/// A place, a heading, and the score of the rays cast from there, as one of 360 bins.
#[derive(Debug, Clone, Copy)]
struct Cast {
    at: Point,
    heading: Turn,
    score: CastNats,
}

impl Cast {
    fn mode(self, layer: u8) -> ScoredPose {
        let Self { at, heading, score } = self;
        ScoredPose { layer, at, heading, score: Nats::from_bits((score.to_bits() + (1 << 7)) >> 8) }
    }
}

/// Climbs from a mode to a top of the likelihood near it, off the grid: [`refine_coarse`], [`refine_fine`], then [`refine_final`].
///
/// The result's score is that of all 360 rays in the table [between rungs](EvidenceTable::at), and no less than what the mode has
/// by the same measure. A position outside the plan or occupied is never taken; a mode that begins at one is returned as it
/// is.
///
/// # Cost
/// At most [`MAX_CASTS`] casts. On an office floor with candidates 0.5 m apart it takes as long as some 30
/// casts of 360 rays.
#[must_use]
pub fn refine(table: &EvidenceTable, layer: &FloorLayer<'_>, mode: ScoredPose) -> ScoredPose {
    let whole = Climb::<1> { table, plan: layer.plan, stride: 1 };
    let Some(start) = whole.cast(mode.at, mode.heading) else { return mode };
    let end =
        refine_final(table, layer, refine_fine(table, layer, refine_coarse(table, layer, mode, WIDE_STRIDE)));
    let start = start.mode(mode.layer);
    if end.score > start.score { end } else { start }
}

/// The first part of [`refine`](refine()): the wide patterns, to a decimetre or less, by every `stride`-th ray: every fourth or
/// fewer. The score is that of those.
#[must_use]
pub fn refine_coarse(
    table: &EvidenceTable,
    layer: &FloorLayer<'_>,
    mode: ScoredPose,
    stride: usize,
) -> ScoredPose {
    let stride = stride.max(WIDE_STRIDE);
    let climb = Climb::<WIDE_HEADINGS> { table, plan: layer.plan, stride };
    let Some((start, mut view)) = climb.cast_view(mode.at, mode.heading) else { return mode };
    let wide = |step| step >= WIDE / 2;
    climb_through(start, layer, wide, |pose, _, step| climb.glance(&mut view, pose, step)).mode(mode.layer)
}

/// The second part of [`refine`](refine()): the narrow patterns, from where an [`refine_coarse`] ended, to some centimetres.
#[must_use]
pub fn refine_fine(table: &EvidenceTable, layer: &FloorLayer<'_>, mode: ScoredPose) -> ScoredPose {
    climb_narrow(table, layer, mode, NARROW_STRIDE, |step| step < WIDE)
}

/// The last part of [`refine`](refine()): the narrowest patterns anew, with all rays.
#[must_use]
pub fn refine_final(table: &EvidenceTable, layer: &FloorLayer<'_>, mode: ScoredPose) -> ScoredPose {
    climb_narrow(table, layer, mode, LAST_STRIDE, |step| step < POLISHED)
}

/// Climbs through the narrow widths of the pattern that are asked for. What the end is worth all rays say: some may have
/// led astray.
fn climb_narrow(
    table: &EvidenceTable,
    layer: &FloorLayer<'_>,
    mode: ScoredPose,
    stride: usize,
    wanted: impl Fn(Metres) -> bool,
) -> ScoredPose {
    let climb = Climb::<NARROW_HEADINGS> { table, plan: layer.plan, stride };
    let whole = Climb { stride: 1, ..climb };
    let Some(start) = whole.cast(mode.at, mode.heading) else { return mode };
    let first = if stride > 1 { climb.cast(start.at, start.heading) } else { Some(start) };
    let Some(first) = first else { return mode };
    let end = climb_through(first, layer, wanted, |pose, came, step| climb.neighbour(pose, came, step));
    let end = if stride > 1 { whole.cast(end.at, end.heading) } else { Some(end) };
    end.filter(|end| end.score > start.score).unwrap_or(start).mode(mode.layer)
}

/// Climbs through those widths of the pattern that are asked for, at each while a `neighbour` is better.
fn climb_through(
    mut pose: Cast,
    layer: &FloorLayer<'_>,
    wanted: impl Fn(Metres) -> bool,
    mut neighbour: impl FnMut(&Cast, Option<Way>, Metres) -> Option<Move>,
) -> Cast {
    let spacing = Metres::from_bits((i64::from(layer.map.header().spacing_mm) << 32) / 1000);
    // Three quarters reach the middle between candidates and a little beyond.
    let mut step = spacing / 4 * 3;
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

/// Steps along x and y.
type Way = [i8; 2];
/// A cast and the way that led to it.
type Move = (Cast, Way);

fn score((pose, _): &Move) -> CastNats {
    pose.score
}

/// Whether a neighbour was looked at from the former position, which was left in this direction: after a turn of the
/// heading all were.
fn is_known(came: Option<Way>, way: Way) -> bool {
    came.is_some_and(|came| came == [0; 2] || came.iter().zip(way).any(|(came, way)| came * way < 0))
}

/// Climbing with every `stride`-th ray, laid at so many headings.
#[derive(Debug, Clone, Copy)]
struct Climb<'a, const HEADINGS: usize> {
    table: &'a EvidenceTable,
    plan: Plan<'a>,
    stride: usize,
}

impl<const HEADINGS: usize> Climb<'_, HEADINGS> {
    /// The best place beside this one or heading beside its own, if it is better than this; `came` is the way that led
    /// here.
    fn neighbour(&self, pose: &Cast, came: Option<Way>, step: Metres) -> Option<Move> {
        let look = |way: Way| Some((self.cast(beside(pose.at, way, step), pose.heading)?, way));
        let [x, y] = ALONG.map(|ways| {
            let unknown = ways.into_iter().filter(|way| !is_known(came, *way));
            unknown.filter_map(look).max_by_key(score)
        });
        // Of the diagonal neighbours only the one between the better two of the others.
        let diagonal = match (x, y) {
            (Some((a, [dx, _])), Some((b, [_, dy]))) if a.score.max(b.score) > pose.score => look([dx, dy]),
            _ => None,
        };
        // 8 degrees per metre: what moves a wall 7 m off as far as the step does.
        let unit = (step.to_bits() / 360 * 8) as u32;
        let turned = TURNS.into_iter().filter_map(|units| {
            let heading = pose.heading + Turn::from_bits(unit.wrapping_mul(units.cast_unsigned()));
            Some((self.cast(pose.at, heading)?, [0; 2]))
        });
        let found = [x, y, diagonal].into_iter().flatten().chain(turned).max_by_key(score);
        found.filter(|(there, _)| there.score > pose.score)
    }

    /// The place that seems best from here, if it is better.
    fn glance(&self, view: &mut View, pose: &Cast, step: Metres) -> Option<Move> {
        let seems = |way: &Way| {
            let scores = view.scores::<HEADINGS>(self.table, aside(*way, step));
            (best(beside(pose.at, *way, step), pose.heading, scores), *way)
        };
        let is_better = |there: &Cast| there.score > pose.score;
        let ways = ALONG.as_flattened().iter().chain(&DIAGONAL);
        let (nearby, way) = ways.map(seems).max_by_key(score).filter(|(there, _)| is_better(there))?;
        let (there, from_there) =
            self.cast_view(nearby.at, nearby.heading).filter(|(there, _)| is_better(there))?;
        *view = from_there;
        Some((there, way))
    }

    /// Casts rays: the best heading around one, and what is seen with it. `None` outside the plan or in a wall.
    fn cast_view(&self, at: Point, heading: Turn) -> Option<(Cast, View)> {
        let mut view = View::cast(&self.plan, at, heading, self.stride).ok()?;
        let pose = best(at, heading, view.scores::<HEADINGS>(self.table, [Metres::ZERO; 2]));
        view.turn(pose.heading);
        Some((pose, view))
    }

    /// The same without keeping what is seen.
    fn cast(&self, at: Point, heading: Turn) -> Option<Cast> {
        let mut scores = [0; HEADINGS];
        let rays = self.plan.rays(at, heading, self.stride).ok()?;
        for (bin, (steps, hit)) in (0..BINS).step_by(self.stride.max(1)).zip(rays) {
            self.table.between(steps, hit).add_around(bin, &mut scores);
        }
        Some(best(at, heading, scores.map(|score| score * self.stride as i32)))
    }
}

/// The best of some headings, whole degrees around one, by the bits of [`CastNats`]; of equal ones the nearest to it.
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
