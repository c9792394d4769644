//! Computer vision: from frames to segments, up vector, windows, and boundaries of floor and ceiling. Each stage takes
//! borrowed images and buffers and returns plain values.

pub mod attitude;
pub mod boundary;
pub mod camera;
pub mod lens_field;
pub mod level_frame;
pub mod panorama;
pub(crate) mod projector;
pub mod sample;
pub mod segments;
pub mod shot;
pub mod visual_scan;
pub mod windows;
