//! Window openings in a camera image, from its line segments.
//!
//! [`paper`] is the finder of the paper, on the image as it is: the baseline.

pub mod paper;
