//! Drawing: follows edges and grows straight segments while walking.

use super::gradient::{Axis, Field, Pixel};
use super::jump;
use super::line::{Fit, mean_square};
use super::options::Options;
use super::traced::{End, Traced, step};

/// State of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Label {
    /// Not visited, or released.
    None,
    /// Drawn, but on no line yet.
    Edge,
    /// Start of a drawing.
    Anchor,
    /// On a segment.
    Inlier,
    /// Visited, but off the segment that was growing.
    Outlier,
    /// In a gap that a segment bridges.
    Junction,
}

/// A pending walk.
#[derive(Debug)]
struct Branch {
    start: Pixel,
    direction: Pixel,
    end: End,
    /// Pixels that count as already walked.
    seeds: Vec<Pixel>,
}

/// The outcome of a walk.
#[derive(Debug)]
struct Walk {
    at: Pixel,
    previous: Pixel,
    /// Edge axis at the last pixel from which it continued: the pixel that ended the walk has no influence.
    axis: Axis,
    /// It ran into an earlier drawing.
    hit: bool,
    outliers: Vec<Pixel>,
    end: End,
}

/// The state of the whole drawing.
#[derive(Debug)]
pub(super) struct Drawing<'a> {
    field: &'a Field,
    options: &'a Options,
    labels: Vec<Label>,
    pub(super) pixels: Vec<Pixel>,
    pub(super) segments: Vec<Traced>,
    branches: Vec<Branch>,
    /// The segment that is growing.
    current: Option<Traced>,
    window_start: usize,
}

impl<'a> Drawing<'a> {
    /// Draws from every anchor in turn.
    pub(super) fn new(field: &'a Field, options: &'a Options) -> Self {
        let [width, height] = field.size();
        let labels = vec![Label::None; width as usize * height as usize];
        let (pixels, segments, branches) = (Vec::new(), Vec::new(), Vec::new());
        let mut drawing =
            Self { field, options, labels, pixels, segments, branches, current: None, window_start: 0 };
        for anchor in field.anchors(options) {
            if drawing.label(anchor) == Label::None {
                drawing.draw_from(anchor);
            }
        }
        drawing
    }

    /// State of a pixel; `None` outside the image.
    pub(super) fn label(&self, pixel: Pixel) -> Label {
        self.field.index(pixel).map_or(Label::None, |i| self.labels[i])
    }

    fn set(&mut self, pixel: Pixel, label: Label) {
        if let Some(i) = self.field.index(pixel) {
            self.labels[i] = label;
        }
    }

    fn draw_from(&mut self, anchor: Pixel) {
        let (start, axis) = (self.pixels.len(), self.field.axis(anchor));
        self.set(anchor, Label::Anchor);
        self.draw_tree(anchor, axis.unit(true), vec![anchor]);
        let seeds = self.seeds_back(anchor, start);
        self.draw_tree(anchor, axis.unit(false), seeds);
    }

    /// The start of the way back from an anchor: the first pixels of the way out, farthest first.
    ///
    /// They end at the first one that a segment owns, so a segment close to the anchor leaves none.
    fn seeds_back(&self, anchor: Pixel, start: usize) -> Vec<Pixel> {
        if self.label(anchor) == Label::Inlier {
            return Vec::new();
        }
        let most = self.options.minimum_length.saturating_sub(1);
        let owned = |p: &Pixel| matches!(self.label(*p), Label::Inlier | Label::Junction);
        let out = self.pixels.get(start..).unwrap_or_default();
        out.iter().take(most).rev().copied().take_while(|p| !owned(p)).collect()
    }

    fn draw_tree(&mut self, anchor: Pixel, direction: Pixel, seeds: Vec<Pixel>) {
        self.branches.push(Branch { start: anchor, direction, end: End::Head, seeds });
        while let Some(branch) = self.branches.pop() {
            let walk = self.walk(branch);
            if let Some(segment) = self.current.take() {
                self.after_walk(segment, walk, anchor);
            }
            // Every iteration lengthens the list, so this bound ends any cycle of mutual releases.
            if self.pixels.len() / 16 > self.labels.len() {
                self.branches.clear();
            }
        }
        self.finish();
    }

    fn finish(&mut self) {
        if let Some(mut segment) = self.current.take() {
            segment.pixels.end = self.pixels.len();
            self.segments.push(segment);
        }
    }

    fn walk(&mut self, branch: Branch) -> Walk {
        let Branch { start, direction, end, seeds } = branch;
        if self.current.is_none() {
            self.window_start = self.pixels.len();
        }
        self.pixels.extend(seeds);
        let previous = [start[0] - direction[0], start[1] - direction[1]];
        let axis = Axis::of_extent(f64::from(direction[0]), f64::from(direction[1]));
        let mut walk = Walk { at: start, previous, axis, hit: false, outliers: Vec::new(), end };
        while walk.outliers.len() <= self.options.outlier_limit {
            let Some(next) = step(self.field, walk.at, walk.previous, walk.axis) else { break };
            (walk.previous, walk.at) = (walk.at, next);
            if self.field.magnitude(next) == 0 {
                break;
            }
            walk.hit = matches!(self.label(next), Label::Edge | Label::Inlier | Label::Junction);
            if walk.hit {
                break;
            }
            walk.axis = self.field.axis(next);
            self.visit(&mut walk);
        }
        walk
    }

    fn visit(&mut self, walk: &mut Walk) {
        let pixel = walk.at;
        let Some(segment) = &mut self.current else {
            self.pixels.push(pixel);
            self.set(pixel, Label::Edge);
            self.find_line();
            return;
        };
        if segment.line.distance(pixel) < self.options.inlier_distance {
            segment.grow(pixel, walk.end);
            segment.extended[walk.end as usize] = false;
            self.pixels.push(pixel);
            self.set(pixel, Label::Inlier);
            walk.outliers.clear();
        } else {
            self.set(pixel, Label::Outlier);
            walk.outliers.push(pixel);
        }
    }

    /// Fits the window once it is full, and slides it on while it is not straight.
    fn find_line(&mut self) {
        let length = self.options.minimum_length.max(2);
        if self.pixels.len() != self.window_start.saturating_add(length) {
            return;
        }
        let window = &self.pixels[self.window_start..];
        let (tail, head) = (window[0], window[length - 1]);
        let fit = Fit::new(window);
        let straight = fit.line(tail, head).filter(|line| mean_square(line, window) < self.options.fit_error);
        let Some(line) = straight else {
            self.window_start += self.options.window_slide.clamp(1, length);
            return;
        };
        let inner = [window[1], window[length - 2]];
        let pixels = self.window_start..self.pixels.len();
        for i in pixels.clone() {
            self.set(self.pixels[i], Label::Inlier);
        }
        let extended = [false; 2];
        self.current =
            Some(Traced { fit, line, ends: [tail, head], inner, extended, tail_grew: false, pixels });
    }

    /// Decides where drawing continues after a walk that left a segment.
    fn after_walk(&mut self, mut segment: Traced, mut walk: Walk, anchor: Pixel) {
        const TAIL: usize = End::Tail as usize;
        const HEAD: usize = End::Head as usize;
        self.undo_last(&mut segment, &mut walk, anchor);
        let many = walk.outliers.len() > self.options.outlier_limit;
        if many {
            self.redraw_later(&walk);
        }
        // The head jumps only from curves and drawn edges; the tail, below, from anywhere.
        if (many || walk.hit) && !segment.extended[HEAD] && self.jump(&mut segment, End::Head) {
            self.current = Some(segment);
            return;
        }
        segment.extended[HEAD] = true;
        let tail_free = !segment.extended[TAIL];
        let back = tail_free && segment.ends[TAIL] == anchor;
        if back {
            segment.extended[TAIL] = true;
            self.branch(&segment, anchor, End::Tail);
        }
        let goes_on = back || (tail_free && self.jump(&mut segment, End::Tail));
        self.current = Some(segment);
        if !goes_on {
            self.finish();
        }
    }

    /// Continues from a pixel along the line's main axis, away from the segment's other end.
    fn branch(&mut self, segment: &Traced, start: Pixel, end: End) {
        let heading = jump::heading(&segment.line, end);
        // The axis of the current line: near 45 degrees the fit may still have the other one.
        let axis = Axis::of_extent(heading[0], heading[1]);
        let direction = axis.unit(heading[axis.main()] > 0.0);
        self.branches.push(Branch { start, direction, end, seeds: Vec::new() });
    }

    /// Removes the last pixel when outliers followed it: it often belongs to the curve that they begin.
    ///
    /// It then leads their list, so three outliers before a dead end count as four.
    fn undo_last(&mut self, segment: &mut Traced, walk: &mut Walk, anchor: Pixel) {
        if walk.outliers.is_empty() || !(walk.end == End::Head || segment.tail_grew) {
            return;
        }
        let undone = segment.undo(walk.end);
        self.pixels.pop();
        self.set(undone, Label::None);
        walk.outliers.insert(0, undone);
        let tail = End::Tail as usize;
        segment.extended[tail] |= walk.end == End::Tail && segment.ends[tail] == anchor;
    }

    /// Releases outliers, to search for another line in them once the present segment is finished.
    fn redraw_later(&mut self, walk: &Walk) {
        for &pixel in &walk.outliers {
            self.set(pixel, Label::None);
        }
        let main = walk.axis.main();
        let direction = walk.axis.unit(walk.at[main] > walk.previous[main]);
        // The last pixel of the list, not of the growing end: after a walk at the tail that found nothing this is the
        // head, far away, and the window slides over it.
        let seeds = self.pixels.last().into_iter().chain(&walk.outliers).copied().collect();
        self.branches.push(Branch { start: walk.at, direction, end: End::Head, seeds });
    }

    /// Bridges a gap at one end, if the edge continues behind it.
    fn jump(&mut self, segment: &mut Traced, end: End) -> bool {
        let Some(bridge) = jump::bridge(self.field, self.options, segment, end) else { return false };
        for (i, &pixel) in bridge.iter().enumerate() {
            if segment.line.distance(pixel) >= self.options.inlier_distance {
                self.set(pixel, Label::Outlier);
                continue;
            }
            segment.grow(pixel, end);
            self.pixels.push(pixel);
            self.set(pixel, if i < bridge.len() / 2 { Label::Junction } else { Label::Inlier });
        }
        segment.extended[end as usize] = true;
        if let Some(&start) = bridge.last() {
            self.branch(segment, start, end);
        }
        true
    }
}
