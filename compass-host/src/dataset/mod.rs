//! Recordings and what belongs to them.

pub mod tum;
