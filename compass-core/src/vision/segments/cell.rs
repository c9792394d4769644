//! One `u16` per pixel: gradient magnitude, edge axis and label.
//!
//! Bits 14 to 4 hold the thresholded magnitude |dx| + |dy| (at most 2040), bit 3 whether the edge is
//! vertical, bits 2 to 0 the label. Bit 15 stays clear, so that cells compare as `i16` too.

/// Bits below the magnitude.
pub(super) const MAGNITUDE_SHIFT: u32 = 4;
/// Set where |dx| >= |dy|: the edge runs vertically.
pub(super) const VERTICAL: u16 = 1 << 3;
const MAGNITUDE: u16 = 0x7ff0;
const LABEL: u16 = 0x7;

/// Nothing is known of the pixel.
pub(super) const NONE: u16 = 0;
/// Drawing started here, or the pixel lay off the line.
pub(super) const OUTLIER: u16 = 1;
/// Drawn while no line was known. This label and those above it end a walk.
pub(super) const EDGE: u16 = 2;
/// Lies on a line.
pub(super) const INLIER: u16 = 3;
/// First half of a jump.
pub(super) const JUNCTION: u16 = 4;

/// The magnitude, still shifted: only good for comparing.
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
