//! One step along an edge.

use super::cell::strength;
use crate::base::num::index_of;

/// A pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Position {
    pub(super) x: i32,
    pub(super) y: i32,
}

impl Position {
    #[inline(always)]
    pub(super) const fn packed(self) -> u32 {
        self.y.cast_unsigned() << 16 | self.x.cast_unsigned()
    }

    #[inline(always)]
    pub(super) const fn unpacked(packed: u32) -> Self {
        Self { x: (packed & 0xffff).cast_signed(), y: (packed >> 16).cast_signed() }
    }
}

/// Cells of the whole image; cells outside are read as 0, which ends a walk.
#[derive(Debug)]
pub(super) struct Cells<'a> {
    pub(super) cells: &'a mut [u16],
    pub(super) width: i32,
    pub(super) height: i32,
}

impl Cells<'_> {
    #[inline(always)]
    pub(super) fn index(&self, p: Position) -> usize {
        index_of(p.y * self.width + p.x)
    }

    #[inline(always)]
    pub(super) fn get(&self, p: Position) -> u16 {
        self.at(self.index(p))
    }

    #[inline(always)]
    fn at(&self, index: usize) -> u16 {
        self.cells.get(index).copied().unwrap_or(0)
    }

    #[inline(always)]
    pub(super) fn label(&mut self, p: Position, label: u16) {
        let index = self.index(p);
        if let Some(cell) = self.cells.get_mut(index) {
            *cell = super::cell::labelled(*cell, label);
        }
    }

    pub(super) fn contains(&self, p: Position) -> bool {
        (0..self.width).contains(&p.x) && (0..self.height).contains(&p.y)
    }
}

/// Position of a walk and its last step (each component -1, 0 or 1).
#[derive(Debug, Clone, Copy)]
pub(super) struct Walker {
    pub(super) at: Position,
    pub(super) dx: i32,
    pub(super) dy: i32,
}

impl Walker {
    /// Steps to the strongest neighbour ahead, along an edge that is `vertical` here; returns its cell.
    #[inline(always)]
    pub(super) fn advance(&mut self, cells: &Cells<'_>, vertical: bool) -> u16 {
        let here = cells.index(self.at);
        if vertical { self.advance_rows(cells, here) } else { self.advance_columns(cells, here) }
    }

    #[inline(always)]
    fn advance_columns(&mut self, cells: &Cells<'_>, here: usize) -> u16 {
        let width = index_of(cells.width);
        if self.dx != 0 {
            let ahead = here.wrapping_add_signed(self.dx as isize);
            let all =
                [cells.at(ahead.wrapping_sub(width)), cells.at(ahead), cells.at(ahead.wrapping_add(width))];
            self.dy = sideways(all);
        } else {
            // The last step was along y: turn, keeping the sign of dy.
            let ahead = here.wrapping_add_signed((self.dy * cells.width) as isize);
            let (left, right) = (cells.at(ahead.wrapping_sub(1)), cells.at(ahead.wrapping_add(1)));
            self.dx = if strength(left) > strength(right) { -1 } else { 1 };
        }
        self.step(cells)
    }

    #[inline(always)]
    fn advance_rows(&mut self, cells: &Cells<'_>, here: usize) -> u16 {
        let width = index_of(cells.width);
        if self.dy != 0 {
            let ahead = here.wrapping_add_signed((self.dy * cells.width) as isize);
            let all = [cells.at(ahead.wrapping_sub(1)), cells.at(ahead), cells.at(ahead.wrapping_add(1))];
            self.dx = sideways(all);
        } else {
            let ahead = here.wrapping_add_signed(self.dx as isize);
            let (up, down) = (cells.at(ahead.wrapping_sub(width)), cells.at(ahead.wrapping_add(width)));
            self.dy = if strength(up) > strength(down) { -1 } else { 1 };
        }
        self.step(cells)
    }

    #[inline(always)]
    fn step(&mut self, cells: &Cells<'_>) -> u16 {
        self.at = Position { x: self.at.x + self.dx, y: self.at.y + self.dy };
        cells.get(self.at)
    }

    /// The unit step along an edge, with the signs of the last step.
    pub(super) const fn onward(&self, vertical: bool) -> (i8, i8) {
        let (dx, dy) = (if self.dx > 0 { 1 } else { -1 }, if self.dy > 0 { 1 } else { -1 });
        if vertical { (0, dy) } else { (dx, 0) }
    }
}

/// Offset, -1, 0 or 1, of the strongest of three cells; an outer one must exceed both others.
#[inline(always)]
fn sideways([one, straight, other]: [u16; 3]) -> i32 {
    let [one, straight, other] = [strength(one), strength(straight), strength(other)];
    i32::from(other > straight && other > one) - i32::from(one > straight && one > other)
}
