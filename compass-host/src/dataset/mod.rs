//! Recordings, their trajectories and their IMU readings.

#[cfg(feature = "bag")]
pub(crate) mod bag;
mod error;
mod euroc;
pub mod faults;
pub mod imu;
mod pairs;
pub mod recording;
pub mod table;
mod topics;
pub mod trajectory;
pub mod tum;
