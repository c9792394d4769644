//! Recordings and what belongs to them.

pub mod euroc;
pub mod trajectory;
pub mod tum;
