//! The node of ROS 2: frames on topics become poses on topics. Without a ROS installation: DDS is that of `RustDDS`.
//!
//! One thread hears messages, pairs frames and remembers odometry; one localizes the newest pair. Frames that come faster than they are
//! answered are dropped and counted.

pub mod answer;
mod error;
pub mod messages;
mod node;
mod options;
mod outputs;
pub mod pairing;
mod worker;

pub use error::NodeError;
pub use node::run;
pub use options::Options;
