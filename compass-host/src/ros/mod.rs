//! The node of ROS 2: frames on topics become poses on topics. Without a ROS installation: DDS is that of `RustDDS`.
//!
//! One thread hears messages, pairs frames and remembers odometry; one localizes the newest pair. Frames that come faster than they are
//! answered are dropped and counted.

pub mod answer;
pub mod messages;
mod node;
mod options;
pub mod pairing;
mod worker;

pub use node::{NodeError, run};
pub use options::Options;
