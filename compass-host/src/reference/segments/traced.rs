//! A segment in progress, and the step of a walk along its edge.

use super::gradient::{Axis, Field, Pixel};
use super::line::{Fit, Line};
use std::ops::Range;

/// The end of a segment that a walk extends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The first pixel.
    Tail,
    /// The last pixel.
    Head,
}

/// A segment during and after drawing.
#[derive(Debug, Clone)]
pub(super) struct Traced {
    pub(super) fit: Fit,
    pub(super) line: Line,
    /// Outermost pixels of the tail and the head.
    pub(super) ends: [Pixel; 2],
    /// The pixels just inside them: one step at each end can be undone.
    pub(super) inner: [Pixel; 2],
    /// An end that needs a new inlier before it may be extended again.
    pub(super) extended: [bool; 2],
    pub(super) tail_grew: bool,
    /// Its pixels in the drawing's list.
    pub(super) pixels: Range<usize>,
}

impl Traced {
    /// Fits the line to the sums; a degenerate fit keeps the previous line.
    fn refit(&mut self) {
        self.line = self.fit.line(self.ends[0], self.ends[1]).unwrap_or(self.line);
    }

    pub(super) fn grow(&mut self, pixel: Pixel, end: End) {
        let e = end as usize;
        self.fit.add(pixel);
        (self.inner[e], self.ends[e]) = (self.ends[e], pixel);
        self.tail_grew |= end == End::Tail;
        self.refit();
    }

    pub(super) fn undo(&mut self, end: End) -> Pixel {
        let e = end as usize;
        let undone = self.ends[e];
        self.fit.remove(undone);
        self.ends[e] = self.inner[e];
        self.refit();
        undone
    }
}

/// The next pixel along an edge; `None` at the image border.
///
/// An edge crossing the axis is entered diagonally: this is how a walk turns where the axis changes.
pub(super) fn step(field: &Field, at: Pixel, previous: Pixel, axis: Axis) -> Option<Pixel> {
    let arrived_along = at[axis.main()] != previous[axis.main()];
    let (m, c) = if arrived_along { (axis.main(), axis.cross()) } else { (axis.cross(), axis.main()) };
    let mut next = at;
    next[m] += (at[m] - previous[m]).signum();
    let size = field.size();
    if !(0..size[m]).contains(&next[m]) || at[c] < 1 || at[c] > size[c] - 2 {
        return None;
    }
    let side = |offset: i32| {
        let mut pixel = next;
        pixel[c] += offset;
        (field.magnitude(pixel), pixel)
    };
    let (below, straight, above) = (side(-1), side(0), side(1));
    Some(match arrived_along {
        true if below.0 > straight.0.max(above.0) => below.1,
        true if above.0 > straight.0.max(below.0) => above.1,
        true => straight.1,
        false if below.0 > above.0 => below.1,
        false => above.1,
    })
}
