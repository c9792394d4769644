//! Recordings and what belongs to them.

pub mod euroc;
pub mod imu;
pub mod lines;
pub mod trajectory;
pub mod tum;
