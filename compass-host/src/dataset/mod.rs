//! Recordings, their trajectories and their IMU readings.

#[cfg(feature = "bag")]
mod bag;
mod error;
mod euroc;
pub mod imu;
pub mod lines;
mod pairs;
pub mod recording;
mod topics;
pub mod trajectory;
pub mod tum;
