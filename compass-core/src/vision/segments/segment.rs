//! A line segment of an image.

use bytemuck::{Pod, Zeroable};

/// A line segment, in pixels; pixel centres are at integers, x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct Segment {
    /// x of the first end.
    pub x1: f32,
    /// y of the first end.
    pub y1: f32,
    /// x of the second end.
    pub x2: f32,
    /// y of the second end.
    pub y2: f32,
    /// Number of pixels whose gradient points across the segment; without validation, number of pixels.
    pub score: u32,
}

impl Segment {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self { x1: 0.0, y1: 0.0, x2: 0.0, y2: 0.0, score: 0 };
}
