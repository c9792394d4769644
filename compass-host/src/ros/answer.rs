//! Answers as messages.

use super::messages::{
    DiagnosticArray, DiagnosticStatus, Header, KeyValue, Point, Pose, PoseArray, PoseWithCovariance,
    PoseWithCovarianceStamped, Quaternion, Time, TransformStamped, Transforms,
};
use compass_core::base::num::Turn;
use compass_core::{Covariance, ScoredPose};
use std::f64::consts::TAU;

/// Radians of a heading, counter-clockwise from +x.
fn radians(heading: Turn) -> f64 {
    f64::from(heading.to_bits()) / 4_294_967_296.0 * TAU
}

/// A pose on the floor: of cam0, its height left at 0.
fn pose(scored: &ScoredPose) -> Pose {
    let position = Point { x: scored.at.x.to_num(), y: scored.at.y.to_num(), z: 0.0 };
    Pose { position, orientation: Quaternion::about_up(radians(scored.heading)) }
}

/// The pose with the covariance of x, y and the turn about the vertical axis; that of the others is 0.
#[must_use]
pub fn pose_message(
    header: Header,
    scored: &ScoredPose,
    covariance: &Covariance,
) -> PoseWithCovarianceStamped {
    let axes = [0, 1, 5];
    let mut all = [[0.0; 6]; 6];
    for (row, values) in axes.into_iter().zip(covariance.rows()) {
        for (column, value) in axes.into_iter().zip(values) {
            all[row][column] = f64::from(value);
        }
    }
    PoseWithCovarianceStamped { header, pose: PoseWithCovariance { pose: pose(scored), covariance: all } }
}

/// All likely poses, best first.
#[must_use]
pub fn candidates_message(header: Header, poses: &[ScoredPose]) -> PoseArray {
    PoseArray { header, poses: poses.iter().map(pose).collect() }
}

/// Where the axes of odometry are in the map, if the robot is at a pose of the map and at `odometry` of its own axes.
#[must_use]
pub fn map_to_odom(header: Header, odometry_frame: &str, scored: &ScoredPose, odometry: &Pose) -> Transforms {
    let turn = radians(scored.heading) - odometry.orientation.yaw();
    let (sin, cos) = turn.sin_cos();
    let at = pose(scored).position;
    let Point { x, y, .. } = odometry.position;
    let translation = Point { x: at.x - (cos * x - sin * y), y: at.y - (sin * x + cos * y), z: 0.0 };
    let rotation = Quaternion::about_up(turn);
    Transforms {
        transforms: vec![TransformStamped {
            header,
            child_frame_id: odometry_frame.to_owned(),
            translation,
            rotation,
        }],
    }
}

/// How a diagnosis reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// A pose is said.
    Good = 0,
    /// No pose is sure.
    Warning = 1,
    /// Frames cannot be used.
    Error = 2,
    /// No frames come.
    Stale = 3,
}

/// The state of the node.
#[must_use]
pub fn diagnosis(
    stamp: Time,
    name: &str,
    level: Level,
    message: &str,
    values: impl IntoIterator<Item = (&'static str, String)>,
) -> DiagnosticArray {
    let values = values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect();
    DiagnosticArray {
        header: Header { stamp, frame_id: String::new() },
        status: vec![DiagnosticStatus {
            level: level as u8,
            name: format!("{name}: localization"),
            message: message.to_owned(),
            hardware_id: String::new(),
            values,
        }],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::{point, turn};
    use compass_core::Nats;

    #[test]
    fn odometry_is_placed_in_the_map() {
        let scored =
            ScoredPose { layer: 0, at: point(5.0, -2.0).unwrap(), heading: turn(100.0), score: Nats::ONE };
        let robot =
            Pose { position: Point { x: 1.0, y: 2.0, z: 0.0 }, orientation: Quaternion::about_up(0.3) };
        let message = map_to_odom(Header::default(), "odom", &scored, &robot);
        let TransformStamped { translation, rotation, child_frame_id, .. } = &message.transforms[0];
        assert_eq!(child_frame_id, "odom");
        let (sin, cos) = rotation.yaw().sin_cos();
        let x = translation.x + cos * 1.0 - sin * 2.0;
        let y = translation.y + sin * 1.0 + cos * 2.0;
        assert!((x - 5.0).abs() < 1e-6 && (y + 2.0).abs() < 1e-6, "{x}, {y}");
        assert!((rotation.yaw() + 0.3 - 100f64.to_radians()).abs() < 1e-6);
    }

    #[test]
    fn the_covariance_has_its_places() {
        let scored =
            ScoredPose { layer: 0, at: point(1.0, 2.0).unwrap(), heading: turn(90.0), score: Nats::ONE };
        let message = pose_message(Header::default(), &scored, &Covariance::UNKNOWN);
        let all = message.pose.covariance;
        assert_eq!([all[0][0], all[1][1]], [0.25; 2]);
        assert!(all[5][5] > 0.03 && all[2][2] == 0.0 && all[0][5] == 0.0);
        assert!((message.pose.pose.orientation.yaw() - 90f64.to_radians()).abs() < 1e-6);
    }
}
