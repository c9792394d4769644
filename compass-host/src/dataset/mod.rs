//! Recordings and what belongs to them.

pub mod imu;
pub mod tum;
