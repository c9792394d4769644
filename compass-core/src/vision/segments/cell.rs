//! One `u16` per pixel: gradient magnitude, edge axis and label.
//!
//! Bits 14 to 4 hold the thresholded magnitude |dx| + |dy| (at most 2040), bit 3 is set for a vertical edge,
//! bits 2 to 0 hold the label. Bit 15 is clear, so that cells compare as `i16` too.

/// Bits below the magnitude.
pub(super) const MAGNITUDE_SHIFT: u32 = 4;
/// Set where |dx| >= |dy|: the edge runs vertically.
pub(super) const VERTICAL: u16 = 1 << 3;
const MAGNITUDE: u16 = 0x7ff0;
const LABEL: u16 = 0x7;

/// Not visited.
pub(super) const NONE: u16 = 0;
/// Start of a drawing, or off the line.
pub(super) const OUTLIER: u16 = 1;
/// Visited before a line was fitted. This label and those above it end a walk.
pub(super) const EDGE: u16 = 2;
/// On a line.
pub(super) const INLIER: u16 = 3;
/// First half of a jump.
pub(super) const JUNCTION: u16 = 4;

/// The magnitude, still shifted: for comparisons only.
#[inline(always)]
pub(super) const fn strength(cell: u16) -> u16 {
    cell & MAGNITUDE
}

#[inline(always)]
pub(super) const fn is_vertical(cell: u16) -> bool {
    cell & VERTICAL != 0
}

#[inline(always)]
pub(super) const fn label(cell: u16) -> u16 {
    cell & LABEL
}

#[inline(always)]
pub(super) const fn labelled(cell: u16, label: u16) -> u16 {
    cell & !LABEL | label
}
