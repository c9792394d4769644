//! Trajectories with interpolation between their poses.

use super::faults::Faults;
use super::tum::{self, Pose, TumError};
use crate::site::wrapped;
use compass_core::pose::track::Motion;
use std::path::Path;

/// Poses up to this far apart are interpolated, nanoseconds.
const GAP_NS: u64 = 1_000_000_000;
/// Sparser trajectories are interpolated over gaps of up to this many of their usual spacings, ...
const SPACINGS: u64 = 2;
/// ... and up to this far, nanoseconds: nobody walks straight for longer.
const LONGEST_GAP_NS: u64 = 5_000_000_000;
/// Outside an interpolated interval, the nearest pose is used up to this far, nanoseconds.
const NEAR_NS: u64 = 20_000_000;

/// Poses in order of time, without duplicate times.
#[derive(Debug, Clone)]
pub struct Trajectory {
    poses: Vec<Pose>,
    /// Poses up to this far apart are interpolated, nanoseconds.
    gap_ns: u64,
    faults: Faults,
}

impl Trajectory {
    /// Reads TUM lines, in any order; lines that are no pose are left out, and of two poses at one time the first is kept.
    ///
    /// # Errors
    /// [`TumError`]: a file that cannot be read or has no pose.
    pub fn read(path: &Path) -> Result<Self, TumError> {
        let (poses, faults) = tum::read_tolerant(path)?;
        Ok(Self { faults, ..Self::new(poses) })
    }

    fn new(mut poses: Vec<Pose>) -> Self {
        poses.sort_by_key(|pose| pose.timestamp_ns);
        poses.dedup_by_key(|pose| pose.timestamp_ns);
        let mut spacings: Vec<_> =
            poses.windows(2).map(|pair| pair[1].timestamp_ns - pair[0].timestamp_ns).collect();
        spacings.sort_unstable();
        let usual = spacings.get(spacings.len() / 2).copied().unwrap_or_default();
        let gap_ns = usual.saturating_mul(SPACINGS).clamp(GAP_NS, LONGEST_GAP_NS);
        Self { poses, gap_ns, faults: Faults::default() }
    }

    /// The lines that were left out.
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// First and last time, nanoseconds.
    #[must_use]
    pub fn span(&self) -> Option<[u64; 2]> {
        Some([self.poses.first()?.timestamp_ns, self.poses.last()?.timestamp_ns])
    }

    /// The pose at a time, interpolated between poses at most a second apart, or twice their usual spacing if that is
    /// more, up to 5 s; else the nearest within 20 ms.
    #[must_use]
    pub fn at(&self, timestamp_ns: u64) -> Option<Pose> {
        let next = self.poses.partition_point(|pose| pose.timestamp_ns < timestamp_ns);
        let after = self.poses.get(next);
        let before = next.checked_sub(1).and_then(|at| self.poses.get(at));
        if let (Some(before), Some(after)) = (before, after)
            && after.timestamp_ns - before.timestamp_ns <= self.gap_ns
        {
            return Some(between(before, after, timestamp_ns));
        }
        let nearest = before.into_iter().chain(after).min_by_key(|p| p.timestamp_ns.abs_diff(timestamp_ns));
        nearest.filter(|p| p.timestamp_ns.abs_diff(timestamp_ns) <= NEAR_NS).copied()
    }

    /// The motion of cam0 from one time to another, provided that the trajectory's z points up.
    #[must_use]
    pub fn motion(&self, from_ns: u64, to_ns: u64) -> Option<Motion> {
        let (from, to) = (self.at(from_ns)?, self.at(to_ns)?);
        let way = to.position - from.position;
        let heading = from.heading_deg().to_radians();
        let (sin, cos) = (libm::sin(heading), libm::cos(heading));
        let turn = wrapped(to.heading_deg() - from.heading_deg());
        Some(Motion {
            forward_m: (way.x * cos + way.y * sin) as f32,
            left_m: (way.y * cos - way.x * sin) as f32,
            turn: turn.to_radians() as f32,
        })
    }
}

fn between(before: &Pose, after: &Pose, timestamp_ns: u64) -> Pose {
    let whole = (after.timestamp_ns - before.timestamp_ns) as f64;
    let share = (timestamp_ns - before.timestamp_ns) as f64 / whole;
    // Half a turn apart the shortest path is undefined.
    let nearest = if share < 0.5 { before } else { after };
    let rotation = before.rotation.try_slerp(&after.rotation, share, 1e-9).unwrap_or(nearest.rotation);
    Pose { timestamp_ns, position: before.position.lerp(&after.position, share), rotation }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory() -> Trajectory {
        let pose = |time, x, heading| Pose::looking(time, [x, 2.0, 1.5], heading, 10.0, 180.0);
        let poses = vec![
            pose(500_000_000, 0.0, 170.0),
            pose(1_000_000_000, 1.0, 170.0),
            pose(1_500_000_000, 2.0, -170.0),
        ];
        Trajectory::new([poses, vec![pose(9_000_000_000, 5.0, 0.0)]].concat())
    }

    #[test]
    fn poses_are_interpolated_but_not_across_gaps() {
        let trajectory = trajectory();
        let middle = trajectory.at(1_250_000_000).unwrap();
        assert!((middle.position.x - 1.5).abs() < 1e-9);
        assert!((middle.heading_deg().abs() - 180.0).abs() < 0.1, "{}", middle.heading_deg());
        assert_eq!(trajectory.at(1_500_000_000).unwrap().position.x, 2.0);
        assert_eq!(trajectory.at(1_510_000_000).unwrap().position.x, 2.0);
        for none in [0, 2_000_000_000, 8_900_000_000, 9_100_000_000] {
            assert!(trajectory.at(none).is_none(), "{none}");
        }
    }

    #[test]
    fn sparse_poses_are_interpolated() {
        let every = |spacing: u64| {
            let pose = |at: u64| Pose::looking(at * spacing, [at as f64, 0.0, 1.5], 0.0, 0.0, 0.0);
            // One pose is missing.
            Trajectory::new([0, 1, 2, 4, 5].map(pose).to_vec())
        };
        let two = every(2_000_000_000);
        assert_eq!(two.at(3_000_000_000).unwrap().position.x, 1.5);
        assert_eq!(two.at(6_000_000_000).unwrap().position.x, 3.0);
        assert!(every(4_000_000_000).at(12_000_000_000).is_none(), "8 s are too long");
        assert!(every(6_000_000_000).at(3_000_000_000).is_none());
    }

    #[test]
    fn motion_is_in_the_axes_of_the_first_pose() {
        let motion = trajectory().motion(1_000_000_000, 1_500_000_000).unwrap();
        assert!((motion.forward_m + 170f32.to_radians().cos().abs()).abs() < 1e-6, "{motion:?}");
        assert!((motion.left_m + 170f32.to_radians().sin()).abs() < 1e-6, "{motion:?}");
        assert!((motion.turn - 20f32.to_radians()).abs() < 1e-6, "{motion:?}");
        assert!(trajectory().motion(1_000_000_000, 5_000_000_000).is_none());
    }
}
