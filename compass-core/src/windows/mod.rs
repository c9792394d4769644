//! Window openings in camera frames, from their line segments.
//!
//! [`level`] works on both cameras' panorama in the level frame, and needs an up vector: the default.
//! [`paper`] is the finder of the paper, on one image as it is: the baseline.

pub mod level;
pub mod paper;
