//! From a candidate to where between the candidates the likelihood is highest.
//!
//! A pattern search: of the eight neighbours of the best position so far the best is taken, until none
//! is better; then the pattern shrinks to half. Each cast is laid over the table at some whole degrees
//! around the heading. When the pattern is narrow, parts of a degree are tried as well.

use super::search::{Mode, Sheet};
use super::table::Table;
use crate::num::{BINS, Metres, Point, Turn};
use crate::plan::Plan;
use core::cmp::Reverse;

/// The pattern ends below this, 0.02 m.
const FINEST: Metres = Metres::from_bits((1 << 32) / 50);
/// Patterns from here on are wide, 0.1 m: a third of the rays do.
const WIDE: Metres = Metres::from_bits((1 << 32) / 10);
const WIDE_STRIDE: usize = 3;
/// Headings a cast is laid at, one degree apart, while the pattern is wide and when it is narrow.
const WIDE_HEADINGS: usize = 9;
const NARROW_HEADINGS: usize = 3;

/// Widths of the pattern.
const LEVELS: usize = 6;
/// Moves at one width.
const MOVES: usize = 4;
/// No more casts than this are made, with all rays or a third of them: one each to begin and to end
/// of both parts, and at each width the position anew and per move eight neighbours and two headings.
pub const MAX_CASTS: usize = 4 + LEVELS * (1 + MOVES * (STAR.len() + TURNS.len()));

/// The neighbours of a position.
const STAR: [[i8; 2]; 8] = [[1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Headings beside a narrow pattern's, by units that shrink with it.
const TURNS: [i32; 2] = [1, -1];

/// A pose and its score in 1/4096 nat of 360 bins.
#[derive(Debug, Clone, Copy)]
struct Pose {
    at: Point,
    heading: Turn,
    score: i32,
}

/// Climbs from a mode to a top of the likelihood near it, off the grid: [`approach`], then [`settle`].
///
/// The result's score is that of all 360 rays in the table [between rungs](Table::at), and no less than
/// what the mode has by the same measure. A position outside the plan or occupied is never taken; a
/// mode that begins at one is returned as it is.
///
/// # Cost
/// At most [`MAX_CASTS`] casts. On an office floor with candidates 0.5 m apart it takes as long as some 30
/// casts of 360 rays.
#[must_use]
pub fn refine(table: &Table, sheet: &Sheet<'_>, mode: Mode) -> Mode {
    settle(table, sheet, approach(table, sheet, mode))
}

/// The first part of [`refine`](refine()): the wide patterns, with a third of the rays; to a decimetre or so.
#[must_use]
pub fn approach(table: &Table, sheet: &Sheet<'_>, mode: Mode) -> Mode {
    let climb = Climb { table, plan: sheet.plan, stride: WIDE_STRIDE };
    climb_through(table, sheet, mode, |pose, step| match step < WIDE {
        true => pose,
        false => climb.climb::<WIDE_HEADINGS>(pose, step),
    })
}

/// The second part of [`refine`](refine()): the narrow patterns, from where an [`approach`] ended.
#[must_use]
pub fn settle(table: &Table, sheet: &Sheet<'_>, mode: Mode) -> Mode {
    let climb = Climb { table, plan: sheet.plan, stride: 1 };
    climb_through(table, sheet, mode, |pose, step| match step < WIDE {
        true => climb.climb::<NARROW_HEADINGS>(pose, step),
        false => pose,
    })
}

/// Climbs through the widths of the pattern. What the end is worth all rays say: a third may have led astray.
fn climb_through(table: &Table, sheet: &Sheet<'_>, mode: Mode, climb: impl Fn(Pose, Metres) -> Pose) -> Mode {
    let whole = Climb { table, plan: sheet.plan, stride: 1 };
    let Some(start) = whole.best::<1>(mode.at, mode.heading) else { return mode };
    let spacing = Metres::from_bits((i64::from(sheet.map.header().spacing_mm) << 32) / 1000);
    // Three quarters reach the middle between candidates and a little beyond.
    let mut step = spacing / 4 * 3;
    let mut pose = start;
    for _ in 0..LEVELS {
        pose = climb(pose, step);
        step /= 2;
        if step < FINEST {
            break;
        }
    }
    let end = whole.best::<NARROW_HEADINGS>(pose.at, pose.heading).filter(|end| end.score > start.score);
    let Pose { at, heading, score } = end.unwrap_or(start);
    Mode { at, heading, score: (score + (1 << 7)) >> 8, ..mode }
}

#[derive(Debug, Clone, Copy)]
struct Climb<'a> {
    table: &'a Table,
    plan: Plan<'a>,
    /// Every how many-th ray is cast.
    stride: usize,
}

impl Climb<'_> {
    /// Moves while a neighbour is better.
    fn climb<const HEADINGS: usize>(&self, pose: Pose, step: Metres) -> Pose {
        let Some(mut pose) = self.best::<HEADINGS>(pose.at, pose.heading) else { return pose };
        let mut came = None;
        for _ in 0..MOVES {
            let (mut next, mut toward) = (pose, [0; 2]);
            for offset in STAR.into_iter().filter(|&offset| !is_known(came, offset)) {
                if let Some(there) = self.best::<HEADINGS>(beside(pose.at, offset, step), pose.heading)
                    && there.score > next.score
                {
                    (next, toward) = (there, offset);
                }
            }
            if let Some(there) = self.turned(&pose, step)
                && there.score > next.score
            {
                (next, toward) = (there, [0; 2]);
            }
            if next.score <= pose.score {
                break;
            }
            (pose, came) = (next, Some(toward));
        }
        pose
    }

    /// The best of some headings beside a pose; none while the pattern is wide.
    fn turned(&self, pose: &Pose, step: Metres) -> Option<Pose> {
        if self.stride > 1 {
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

/// Whether a neighbour was one of the former position, which was left in this direction.
fn is_known(came: Option<[i8; 2]>, offset: [i8; 2]) -> bool {
    came.is_some_and(|came| came.iter().zip(offset).all(|(came, offset)| (came + offset).abs() <= 1))
}

fn beside(at: Point, offset: [i8; 2], step: Metres) -> Point {
    let [x, y] = offset.map(|steps| step.saturating_mul_int(i64::from(steps)));
    Point::new(at.x.saturating_add(x), at.y.saturating_add(y))
}
