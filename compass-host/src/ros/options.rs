//! What a node is told.

use crate::up::Mount;
use compass_core::{HeightPrior, PosePrior};

/// What a node is told.
#[derive(Debug, Clone)]
pub struct Options {
    /// Name of the node.
    pub name: String,
    /// Its namespace, `/` or `/a/b`.
    pub namespace: String,
    /// Number of the DDS domain.
    pub domain: u16,
    /// Topics of cam0 and cam1; those that end in `/compressed` have `CompressedImage`, others `Image`.
    pub topics: [Option<String>; 2],
    /// Topic of the odometry.
    pub odometry: Option<String>,
    /// Name of the map's axes.
    pub map_frame: String,
    /// Largest difference of stamps in a pair, nanoseconds.
    pub pair_within_ns: u64,
    /// Whether the first sure pose is said on `/initialpose`.
    pub initial_pose: bool,
    /// Probability from which a pose is said.
    pub min_probability: f64,
    /// Which side of cam0's image is up.
    pub mount: Mount,
    /// What is known of the heights.
    pub heights: HeightPrior,
    /// What is known of the pose.
    pub place: PosePrior,
}
