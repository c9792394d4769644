//! A line under construction, and the trail of its pixels.

use super::line::Line;
use super::walk::Position;

/// A line under construction. The head is the end at which the first window ended, the tail the other one.
#[derive(Debug)]
pub(super) struct Growth {
    pub(super) line: Line,
    /// The last pixel and the one before it.
    pub(super) head: [Position; 2],
    /// The first pixel and the one after it.
    pub(super) tail: [Position; 2],
    pub(super) head_extended: bool,
    pub(super) tail_extended: bool,
    /// Sign of the step along the main axis from tail to head.
    pub(super) forward: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Head,
    Tail,
}

impl Growth {
    pub(super) fn end_mut(&mut self, end: End) -> (&mut [Position; 2], &mut bool) {
        match end {
            End::Head => (&mut self.head, &mut self.head_extended),
            End::Tail => (&mut self.tail, &mut self.tail_extended),
        }
    }

    #[inline(always)]
    pub(super) fn accept(&mut self, end: End, p: Position) {
        self.line.add(p);
        let (pixels, extended) = self.end_mut(end);
        *pixels = [p, pixels[0]];
        *extended = false;
    }

    /// The unit step away from the line along the main axis at an end.
    pub(super) fn outwards(&self, end: End) -> (i32, i32) {
        let sense = if end == End::Head { self.forward } else { -self.forward };
        let (steep, slope) = (self.line.steep, self.line.slope);
        // Refits may rotate a line near 45 degrees to the other main axis.
        let (steep, sense) =
            if slope.abs() > 1 << 16 { (!steep, sense * slope.signum()) } else { (steep, sense) };
        if steep { (0, sense) } else { (sense, 0) }
    }
}

/// The pixels of one branch, in drawing order.
#[derive(Debug)]
pub(super) struct Trail<'a> {
    pub(super) pixels: &'a mut [u32],
    pub(super) len: usize,
}

impl<'a> Trail<'a> {
    pub(super) fn new(pixels: &'a mut [u32]) -> Self {
        Self { pixels, len: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, p: Position) -> bool {
        let Some(slot) = self.pixels.get_mut(self.len) else { return false };
        *slot = p.packed();
        self.len += 1;
        true
    }

    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Position {
        Position::unpacked(self.pixels.get(i).copied().unwrap_or(0))
    }

    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = Position> + '_ {
        self.pixels.get(..self.len).unwrap_or(&[]).iter().map(|p| Position::unpacked(*p))
    }

    /// Drops all but the last `keep` pixels.
    pub(super) fn keep_last(&mut self, keep: usize) {
        let pixels = self.pixels.get_mut(..self.len).unwrap_or_default();
        let start = pixels.len().saturating_sub(keep);
        pixels.copy_within(start.., 0);
        self.len -= start;
    }
}
