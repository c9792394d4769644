//! Edge drawing: walks from each anchor along its edge, fits lines on the way and extends them at both ends.

use super::cell::{self, EDGE, INLIER, JUNCTION, NONE, OUTLIER, is_vertical, label, strength};
use super::growth::{End, Growth, Trail};
use super::jump::{self, Jump};
use super::line::{Line, WINDOW, Window};
use super::parameters::Parameters;
use super::segment::Segment;
use super::validate;
use super::walk::{Cells, Position, Walker};
use crate::base::num::{saturate_to_u16, saturate_to_u32};
use heapless::Vec;

/// A walk ends after more consecutive pixels off the line than this.
const MAX_OUTLIERS: usize = 3;
/// Capacity of the stack of branches; further ones are dropped and the result is flagged truncated.
const MAX_BRANCHES: usize = 128;
/// Pixels of an anchor's first branch that seed the opposite one.
const BACK_SEEDS: usize = WINDOW - 1;
/// Largest distance between a segment's ends and its last pixels: twice the inlier tolerance, because later fits move the
/// line.
const STRAY_PX: f32 = 3.0;
/// Stride of the sliding window, pixels.
const SLIDE: usize = 2;

/// Consecutive pixels off the line: at most one former inlier and four new ones.
type Outliers = Vec<Position, { MAX_OUTLIERS + 2 }>;

/// A position from which to search a new line. Positions are packed to keep the stack small.
#[derive(Debug)]
struct Branch {
    at: u32,
    direction: (i8, i8),
    /// The last pixel of the line that ended, and the outliers after it.
    seeds: Vec<u32, { MAX_OUTLIERS + 3 }, u8>,
}

/// End of a walk along a line.
struct Stop {
    /// Whether the walk met a pixel drawn before.
    hit: bool,
    outliers: Outliers,
    walker: Walker,
    /// Whether the edge is vertical at the last pixel.
    vertical: bool,
}

/// State of drawing.
#[derive(Debug)]
pub(super) struct Drawing<'a, 'out> {
    pub(super) cells: Cells<'a>,
    pub(super) smoothed: &'a [u8],
    pub(super) trail: Trail<'a>,
    pub(super) found: &'out mut [Segment],
    pub(super) count: usize,
    pub(super) truncated: bool,
    /// Remaining step budget: bounds the work for any image.
    pub(super) steps_left: u32,
    pub(super) parameters: Parameters,
    anchor: Position,
    branches: Vec<Branch, MAX_BRANCHES>,
}

impl<'a, 'out> Drawing<'a, 'out> {
    pub(super) fn new(
        cells: Cells<'a>,
        smoothed: &'a [u8],
        trail: &'a mut [u32],
        found: &'out mut [Segment],
        parameters: Parameters,
    ) -> Self {
        let steps_left = saturate_to_u32(cells.cells.len()).saturating_mul(16);
        Self {
            cells,
            smoothed,
            trail: Trail::new(trail),
            found,
            count: 0,
            truncated: false,
            steps_left,
            parameters,
            anchor: Position::default(),
            branches: Vec::new(),
        }
    }

    /// Draws from a pixel that is not yet visited; false once the segment list or the step budget is exhausted.
    pub(super) fn draw_from(&mut self, p: Position) -> bool {
        let cell = self.cells.get(p);
        if label(cell) == NONE {
            self.both_ways(p, is_vertical(cell));
            self.truncated |= self.steps_left == 0 || self.count == self.found.len();
        }
        self.steps_left > 0 && self.count < self.found.len()
    }

    fn both_ways(&mut self, anchor: Position, vertical: bool) {
        self.anchor = anchor;
        self.cells.label(anchor, OUTLIER);
        let (dx, dy) = if vertical { (0, 1) } else { (1, 0) };
        self.trail.len = 0;
        self.trail.push(anchor);
        let first = self.tree(Walker { at: anchor, dx, dy });
        self.trail.len = 0;
        if label(self.cells.get(anchor)) != INLIER {
            for p in first.into_iter().rev().map(Position::unpacked) {
                if label(self.cells.get(p)) >= INLIER {
                    break;
                }
                self.trail.push(p);
            }
        }
        self.tree(Walker { at: anchor, dx: -dx, dy: -dy });
    }

    /// Draws a branch, seeded by the trail, and all branches that follow from it; returns the first pixels of the first one.
    fn tree(&mut self, root: Walker) -> Vec<u32, BACK_SEEDS> {
        self.branch(root);
        let first = self.trail.iter().take(self.parameters.window() - 1).map(Position::packed).collect();
        while let Some(branch) = self.branches.pop() {
            self.trail.len = 0;
            for seed in &branch.seeds {
                self.trail.push(Position::unpacked(*seed));
            }
            let (dx, dy) = branch.direction;
            self.branch(Walker { at: Position::unpacked(branch.at), dx: i32::from(dx), dy: i32::from(dy) });
        }
        first
    }

    fn branch(&mut self, mut walker: Walker) {
        if let Some(growth) = self.search(&mut walker) {
            self.grow(growth, walker);
        }
    }

    /// Walks until the pixels of the sliding window lie on a line.
    fn search(&mut self, walker: &mut Walker) -> Option<Growth> {
        let mut window = Window::default();
        let mut start = 0;
        self.trail.iter().for_each(|p| window.add(p));
        let mut vertical = walker.dy != 0;
        let length = self.parameters.window();
        // Seeds never fill a window, so that the first test comes after at least one step.
        while self.steps_left > 0 {
            self.steps_left -= 1;
            let cell = walker.advance(&self.cells, vertical);
            if strength(cell) == 0 || label(cell) >= EDGE {
                return None;
            }
            vertical = is_vertical(cell);
            if self.trail.len == self.trail.pixels.len() {
                self.trail.keep_last(length - 1);
                start = 0;
                window = Window::default();
                self.trail.iter().for_each(|p| window.add(p));
            }
            self.trail.push(walker.at);
            self.cells.label(walker.at, EDGE);
            window.add(walker.at);
            if self.trail.len - start == length {
                let (first, last) = (self.trail.get(start), walker.at);
                let steep = (last.x - first.x).abs() < (last.y - first.y).abs();
                if window.is_line(length, steep) {
                    return Some(self.found_line(start, steep));
                }
                for i in start..start + SLIDE {
                    window.remove(self.trail.get(i));
                }
                start += SLIDE;
            }
        }
        None
    }

    /// Fits the first line, to the window that starts at `start`.
    fn found_line(&mut self, start: usize, steep: bool) -> Growth {
        self.trail.keep_last(self.trail.len - start);
        let last = self.trail.len - 1;
        let line = Line::through(self.trail.iter(), self.trail.get(0), steep);
        for i in 0..=last {
            let p = self.trail.get(i);
            self.cells.label(p, INLIER);
        }
        let (first, end) = (self.trail.get(0), self.trail.get(last));
        let forward = if steep { (end.y - first.y).signum() } else { (end.x - first.x).signum() };
        Growth {
            line,
            head: [end, self.trail.get(last - 1)],
            tail: [first, self.trail.get(1)],
            head_extended: false,
            tail_extended: false,
            forward,
        }
    }

    /// Extends a line at both ends as far as possible, then emits it.
    fn grow(&mut self, mut growth: Growth, walker: Walker) {
        let mut end = End::Head;
        let mut tail_grown = false;
        let mut start = (walker, is_vertical(self.cells.get(walker.at)));
        loop {
            let mut stop = self.follow(&mut growth, end, start);
            if !stop.outliers.is_empty() && (end == End::Head || tail_grown) {
                self.take_back(&mut growth, end, &mut stop.outliers);
            }
            tail_grown |= end == End::Tail;
            let left_line = stop.outliers.len() > MAX_OUTLIERS;
            if left_line {
                self.continue_later(&stop);
            }
            growth.line.fit();
            if (left_line || stop.hit)
                && !growth.head_extended
                && let Some(jump) = self.jump(&growth, End::Head)
            {
                start = self.cross(&mut growth, End::Head, &jump);
                end = End::Head;
                continue;
            }
            growth.head_extended = true;
            end = End::Tail;
            if growth.tail_extended || self.steps_left == 0 {
                break;
            }
            if growth.tail[0] == self.anchor {
                growth.tail_extended = true;
                let (dx, dy) = growth.outwards(End::Tail);
                start = (Walker { at: self.anchor, dx, dy }, dy != 0);
            } else if let Some(jump) = self.jump(&growth, End::Tail) {
                start = self.cross(&mut growth, End::Tail, &jump);
            } else {
                break;
            }
        }
        self.emit(&growth);
    }

    /// Walks along a line until it ends.
    fn follow(&mut self, growth: &mut Growth, end: End, (mut walker, axis): (Walker, bool)) -> Stop {
        let mut outliers = Outliers::new();
        let mut hit = false;
        let mut vertical = axis;
        while outliers.len() <= MAX_OUTLIERS && self.steps_left > 0 {
            self.steps_left -= 1;
            let cell = walker.advance(&self.cells, vertical);
            if strength(cell) == 0 {
                break;
            }
            if label(cell) >= EDGE {
                hit = true;
                break;
            }
            vertical = is_vertical(cell);
            let p = walker.at;
            if growth.line.takes(p) {
                growth.accept(end, p);
                self.cells.label(p, INLIER);
                outliers.clear();
                if !self.trail.push(p) {
                    self.truncated = true;
                    break;
                }
            } else {
                self.cells.label(p, OUTLIER);
                let _ = outliers.push(p);
            }
        }
        Stop { hit, outliers, walker, vertical }
    }

    /// Removes the last inlier from the line: it was the first pixel to deviate.
    fn take_back(&mut self, growth: &mut Growth, end: End, outliers: &mut Outliers) {
        let anchor = self.anchor;
        let (pixels, _) = growth.end_mut(end);
        let [last, before] = *pixels;
        *pixels = [before, before];
        growth.line.remove(last);
        self.cells.label(last, NONE);
        self.trail.len = self.trail.len.saturating_sub(1);
        let _ = outliers.insert(0, last);
        if end == End::Tail && before == anchor {
            growth.tail_extended = true;
        }
    }

    /// Clears the labels of the outliers and pushes a branch that searches a new line through them after this one.
    fn continue_later(&mut self, stop: &Stop) {
        let mut seeds: Vec<_, _, u8> = self.trail.iter().last().map(Position::packed).into_iter().collect();
        for p in &stop.outliers {
            self.cells.label(*p, NONE);
            let _ = seeds.push(p.packed());
        }
        let at = stop.walker.at.packed();
        let direction = stop.walker.onward(stop.vertical);
        self.truncated |= self.branches.push(Branch { at, direction, seeds }).is_err();
    }

    fn jump(&self, growth: &Growth, end: End) -> Option<Jump> {
        if !self.parameters.jump {
            return None;
        }
        jump::find(&self.cells, self.smoothed, growth, end)
    }

    /// Adds the pixels of a jump to the line; returns the walker beyond the gap and whether its first step is along y.
    fn cross(&mut self, growth: &mut Growth, end: End, jump: &Jump) -> (Walker, bool) {
        let half = jump.pixels.len() / 2;
        for (i, p) in jump.pixels.iter().enumerate() {
            if growth.line.takes(*p) {
                growth.accept(end, *p);
                self.cells.label(*p, if i < half { JUNCTION } else { INLIER });
                self.truncated |= !self.trail.push(*p);
            } else {
                self.cells.label(*p, OUTLIER);
            }
        }
        let (_, extended) = growth.end_mut(end);
        *extended = true;
        let (dx, dy) = growth.outwards(end);
        (Walker { at: jump.pixels.last().copied().unwrap_or_default(), dx, dy }, dy != 0)
    }

    fn emit(&mut self, growth: &Growth) {
        let score = if self.parameters.validate {
            match validate::score(&self.cells, self.smoothed, growth, &self.trail) {
                Some(score) => score,
                None => return,
            }
        } else {
            saturate_to_u16(growth.line.len())
        };
        let ([x1, y1], [x2, y2]) = (growth.line.foot(growth.tail[0]), growth.line.foot(growth.head[0]));
        // Drop a line that has rotated away from its first or last pixels.
        let strays = |[x, y]: [f32; 2], p: Position| {
            let (dx, dy) = (x - p.x as f32, y - p.y as f32);
            // NaN counts as too far.
            (dx * dx + dy * dy).partial_cmp(&(STRAY_PX * STRAY_PX)).is_none_or(core::cmp::Ordering::is_gt)
        };
        if strays([x1, y1], growth.tail[0]) || strays([x2, y2], growth.head[0]) {
            return;
        }
        match self.found.get_mut(self.count) {
            Some(slot) => {
                *slot = Segment { x1, y1, x2, y2, score: score.into() };
                self.count += 1;
            }
            None => self.truncated = true,
        }
    }
}

const _: () =
    assert!(cell::JUNCTION > cell::INLIER && cell::INLIER > cell::EDGE && cell::EDGE > cell::OUTLIER);
