//! Windows in camera frames.
//!
//! [`level`] works in the level frame and needs an up vector; it is the default.

pub mod level;
