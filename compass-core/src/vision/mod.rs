//! What the cameras see: each stage takes borrowed images and gives plain results.

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
