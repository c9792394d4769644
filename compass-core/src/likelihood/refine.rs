//! From a candidate to where between the candidates the likelihood is highest.
//!
//! A pattern search: of the eight neighbours of the best position so far the best is taken, until none
//! is better; then the pattern shrinks to half. Each cast is laid over the table at some whole degrees
//! around the heading. When the pattern is narrow, of the diagonal neighbours only the one between the better two of the
//! others is looked at, and parts of a degree are tried as well.
//!
//! A quarter of the [`Rays`] do for most of the way, since neighbouring bins see the same wall.

use super::search::{Mode, Sheet};
use super::table::Table;
use crate::num::{BINS, Metres, Point, Turn};
use crate::plan::Plan;
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

/// Widths of the pattern.
const LEVELS: usize = 6;
/// Moves at one width.
const MOVES: usize = 4;
/// No more casts than this are made, with all rays or some of them: eight where the parts begin and end, and per move eight
/// neighbours and two headings; two parts share widths.
pub const MAX_CASTS: usize = 8 + 2 * LEVELS * MOVES * (4 + DIAGONAL.len() + TURNS.len());

/// The neighbours of a position along x and y, and diagonally.
const ALONG: [[[i8; 2]; 2]; 2] = [[[1, 0], [-1, 0]], [[0, 1], [0, -1]]];
const DIAGONAL: [[i8; 2]; 4] = [[1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Headings beside a narrow pattern's, by units that shrink with it.
const TURNS: [i32; 2] = [1, -1];

/// How many rays are cast on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rays {
    /// A quarter, and all for the last step.
    #[default]
    Many,
    /// About half as many: for a board.
    Few,
}

impl Rays {
    /// Every how many-th is cast while the pattern is wide.
    const fn wide(self) -> usize {
        match self {
            Self::Many => 4,
            Self::Few => 8,
        }
    }

    /// Every how many-th while it is narrow.
    const fn narrow(self) -> usize {
        match self {
            Self::Many | Self::Few => 4,
        }
    }

    /// Every how many-th for the last step.
    const fn last(self) -> usize {
        match self {
            Self::Many => 1,
            Self::Few => 2,
        }
    }
}

/// A pose and its score in 1/4096 nat of 360 bins.
#[derive(Debug, Clone, Copy)]
struct Pose {
    at: Point,
    heading: Turn,
    score: i32,
}

/// Climbs from a mode to a top of the likelihood near it, off the grid: [`approach`], [`settle`], then [`polish`].
///
/// The result's score is that of all 360 rays in the table [between rungs](Table::at), and no less than what the mode has
/// by the same measure. A position outside the plan or occupied is never taken; a mode that begins at one is returned as it
/// is.
///
/// # Cost
/// At most [`MAX_CASTS`] casts. On an office floor with candidates 0.5 m apart it takes as long as some 30
/// casts of 360 rays.
#[must_use]
pub fn refine(table: &Table, sheet: &Sheet<'_>, mode: Mode, rays: Rays) -> Mode {
    let whole = Climb { table, plan: sheet.plan, stride: 1 };
    let Some(start) = whole.best::<1>(mode.at, mode.heading) else { return mode };
    let near = approach(table, sheet, mode, rays);
    let end = polish(table, sheet, settle(table, sheet, near, rays), rays);
    let start = start.mode(mode.sheet);
    if end.score > start.score { end } else { start }
}

/// The first part of [`refine`](refine()): the wide patterns, to a decimetre or so. The score is that of some rays.
#[must_use]
pub fn approach(table: &Table, sheet: &Sheet<'_>, mode: Mode, rays: Rays) -> Mode {
    let climb = Climb { table, plan: sheet.plan, stride: rays.wide() };
    let Some(start) = climb.best::<WIDE_HEADINGS>(mode.at, mode.heading) else { return mode };
    climb.through::<WIDE_HEADINGS>(start, sheet, |step| step >= WIDE).mode(mode.sheet)
}

/// The second part of [`refine`](refine()): the narrow patterns, from where an [`approach`] ended, to some centimetres.
#[must_use]
pub fn settle(table: &Table, sheet: &Sheet<'_>, mode: Mode, rays: Rays) -> Mode {
    let climb = Climb { table, plan: sheet.plan, stride: rays.narrow() };
    climb_narrow(&climb, sheet, mode, |step| step < WIDE)
}

/// The last part of [`refine`](refine()): the narrowest patterns anew, with all rays or half of them.
#[must_use]
pub fn polish(table: &Table, sheet: &Sheet<'_>, mode: Mode, rays: Rays) -> Mode {
    let climb = Climb { table, plan: sheet.plan, stride: rays.last() };
    climb_narrow(&climb, sheet, mode, |step| step < POLISHED)
}

/// Climbs through the narrow widths of the pattern that are asked for. What the end is worth all rays say: some may have
/// led astray.
fn climb_narrow(climb: &Climb<'_>, sheet: &Sheet<'_>, mode: Mode, wanted: impl Fn(Metres) -> bool) -> Mode {
    let whole = Climb { stride: 1, ..*climb };
    let Some(start) = whole.best::<1>(mode.at, mode.heading) else { return mode };
    let Some(pose) = climb.best::<NARROW_HEADINGS>(mode.at, mode.heading) else { return mode };
    let pose = climb.through::<NARROW_HEADINGS>(pose, sheet, wanted);
    let end = whole.best::<NARROW_HEADINGS>(pose.at, pose.heading).filter(|end| end.score > start.score);
    end.unwrap_or(start).mode(mode.sheet)
}

/// A pose and the way that led to it, in steps.
type Move = (Pose, [i8; 2]);

fn score((pose, _): &Move) -> i32 {
    pose.score
}

#[derive(Debug, Clone, Copy)]
struct Climb<'a> {
    table: &'a Table,
    plan: Plan<'a>,
    /// Every how many-th ray is cast.
    stride: usize,
}

impl Pose {
    fn mode(self, sheet: u8) -> Mode {
        let Self { at, heading, score } = self;
        Mode { sheet, at, heading, score: (score + (1 << 7)) >> 8 }
    }
}

impl Climb<'_> {
    /// Climbs through those widths of the pattern that are asked for.
    fn through<const HEADINGS: usize>(
        &self,
        mut pose: Pose,
        sheet: &Sheet<'_>,
        wanted: impl Fn(Metres) -> bool,
    ) -> Pose {
        let spacing = Metres::from_bits((i64::from(sheet.map.header().spacing_mm) << 32) / 1000);
        // Three quarters reach the middle between candidates and a little beyond.
        let mut step = spacing / 4 * 3;
        for _ in 0..LEVELS {
            if wanted(step) {
                pose = self.climb::<HEADINGS>(pose, step);
            }
            step /= 2;
            if step < FINEST {
                break;
            }
        }
        pose
    }

    /// Moves while a neighbour is better.
    fn climb<const HEADINGS: usize>(&self, mut pose: Pose, step: Metres) -> Pose {
        let mut came = None;
        for _ in 0..MOVES {
            let Some((next, toward)) = self.neighbour::<HEADINGS>(&pose, came, step) else { break };
            (pose, came) = (next, Some(toward));
        }
        pose
    }

    /// The best of the poses around one and the way to it, if it is better; `came` is the way that led here.
    fn neighbour<const HEADINGS: usize>(
        &self,
        pose: &Pose,
        came: Option<[i8; 2]>,
        step: Metres,
    ) -> Option<Move> {
        let wide = step >= WIDE;
        let look = |way: [i8; 2]| {
            let there = self.best::<HEADINGS>(beside(pose.at, way, step), pose.heading)?;
            Some((there, way))
        };
        let best = |ways: &[[i8; 2]]| {
            ways.iter()
                .filter(|way| !is_known(came, **way, wide))
                .filter_map(|way| look(*way))
                .max_by_key(score)
        };
        let [x, y] = ALONG.map(|ways| best(&ways));
        let diagonal = match (x, y) {
            _ if wide => best(&DIAGONAL),
            (Some((a, [dx, _])), Some((b, [_, dy]))) if a.score.max(b.score) > pose.score => look([dx, dy]),
            _ => None,
        };
        let turned = self.turned(pose, step).map(|there| (there, [0; 2]));
        let found = [x, y, diagonal, turned].into_iter().flatten().max_by_key(score);
        found.filter(|(there, _)| there.score > pose.score)
    }

    /// The best of some headings beside a pose; none while the pattern is wide.
    fn turned(&self, pose: &Pose, step: Metres) -> Option<Pose> {
        if step >= WIDE {
            return None;
        }
        // 8 degrees per metre: what moves a wall 7 m off as far as the step does.
        let unit = (step.to_bits() / 360 * 8) as u32;
        TURNS
            .into_iter()
            .map(|units| pose.heading + Turn::from_bits(unit.wrapping_mul(units.cast_unsigned())))
            .filter_map(|heading| self.best::<1>(pose.at, heading))
            .max_by_key(|there| there.score)
    }

    /// The best of some headings, whole degrees around one; of equal ones the nearest to it.
    fn best<const HEADINGS: usize>(&self, at: Point, heading: Turn) -> Option<Pose> {
        let scores: [i32; HEADINGS] = self.scores(at, heading)?;
        let middle = (HEADINGS / 2) as i64;
        let (degrees, score) =
            (-middle..).zip(scores).max_by_key(|&(degrees, score)| (score, Reverse(degrees.abs())))?;
        Some(Pose { at, heading: heading + Turn::from_ratio(degrees, BINS as u32), score })
    }

    /// Scores at some headings, whole degrees around one; `None` outside the plan or in a wall.
    fn scores<const HEADINGS: usize>(&self, at: Point, heading: Turn) -> Option<[i32; HEADINGS]> {
        let mut scores = [0; HEADINGS];
        let rays = self.plan.rays(at, heading, self.stride).ok()?;
        for (bin, (steps, hit)) in (0..BINS).step_by(self.stride.max(1)).zip(rays) {
            let between = self.table.between(steps, hit);
            // The more the robot looks to the left, the farther right it sees the ray.
            let mut from = (bin + HEADINGS / 2) % BINS;
            for score in &mut scores {
                *score += between.at(from);
                from = from.checked_sub(1).unwrap_or(BINS - 1);
            }
        }
        Some(scores.map(|score| score * self.stride as i32))
    }
}

/// Whether a neighbour was looked at from the former position, which was left in this direction; of a narrow pattern only
/// that position itself was for sure.
fn is_known(came: Option<[i8; 2]>, way: [i8; 2], wide: bool) -> bool {
    let Some(came) = came else { return false };
    let mut axes = came.iter().zip(way);
    came == [0; 2]
        || if wide {
            axes.all(|(came, way)| (came + way).abs() <= 1)
        } else {
            axes.any(|(came, way)| came * way < 0)
        }
}

fn beside(at: Point, offset: [i8; 2], step: Metres) -> Point {
    let [x, y] = offset.map(|steps| step.saturating_mul_int(i64::from(steps)));
    Point::new(at.x.saturating_add(x), at.y.saturating_add(y))
}
