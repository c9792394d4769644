//! The messages of ROS 2 that the node takes and gives, with their fields in the order of their definitions.

use serde::{Deserialize, Serialize};

/// `builtin_interfaces/msg/Time`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Time {
    /// Seconds.
    pub sec: i32,
    /// Nanoseconds beyond.
    pub nanosec: u32,
}

impl Time {
    /// Nanoseconds since the epoch; `None` before it, or if the part below a second is not below it.
    #[must_use]
    pub fn nanoseconds(self) -> Option<u64> {
        let seconds = u64::try_from(self.sec).ok()?;
        (self.nanosec < 1_000_000_000).then(|| seconds * 1_000_000_000 + u64::from(self.nanosec))
    }
}

/// `std_msgs/msg/Header`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When.
    pub stamp: Time,
    /// In which axes.
    pub frame_id: String,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When it was taken.
    pub header: Header,
    /// How it is compressed.
    pub format: String,
    /// The file.
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/Image`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// When it was taken.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// How bytes are pixels.
    pub encoding: String,
    /// Whether samples of 16 bits have their high byte first.
    pub is_bigendian: u8,
    /// Bytes of a row.
    pub step: u32,
    /// Rows of bytes.
    pub data: Vec<u8>,
}

/// `geometry_msgs/msg/Point` and `Vector3`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Metres.
    pub z: f64,
}

/// `geometry_msgs/msg/Quaternion`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
    /// Scalar.
    pub w: f64,
}

impl Quaternion {
    /// A turn about the vertical axis, radians counter-clockwise.
    #[must_use]
    pub fn about_up(radians: f64) -> Self {
        let half = radians / 2.0;
        Self { x: 0.0, y: 0.0, z: half.sin(), w: half.cos() }
    }

    /// The turn about the vertical axis, radians counter-clockwise.
    #[must_use]
    pub fn yaw(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
    }
}

/// `geometry_msgs/msg/Pose`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where.
    pub position: Point,
    /// Which way round.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/PoseWithCovariance`: of x, y, z and the turns about them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/msg/PoseWithCovarianceStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    /// When and in which axes.
    pub header: Header,
    /// The pose.
    pub pose: PoseWithCovariance,
}

/// `geometry_msgs/msg/PoseArray`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseArray {
    /// When and in which axes.
    pub header: Header,
    /// The poses.
    pub poses: Vec<Pose>,
}

/// `geometry_msgs/msg/TwistWithCovariance`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// Metres per second.
    pub linear: Point,
    /// Radians per second.
    pub angular: Point,
    /// Row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `nav_msgs/msg/Odometry`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// When and in which axes.
    pub header: Header,
    /// Whose pose it is.
    pub child_frame_id: String,
    /// The pose.
    pub pose: PoseWithCovariance,
    /// Its rate.
    pub twist: TwistWithCovariance,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent.
    pub header: Header,
    /// The child.
    pub child_frame_id: String,
    /// Where the child is in the parent.
    pub translation: Point,
    /// Which way round.
    pub rotation: Quaternion,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Transforms {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

/// `diagnostic_msgs/msg/KeyValue`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// What.
    pub key: String,
    /// How much.
    pub value: String,
}

/// `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// 0 good, 1 warning, 2 error, 3 stale.
    pub level: u8,
    /// Of what.
    pub name: String,
    /// In words.
    pub message: String,
    /// Of which device.
    pub hardware_id: String,
    /// Numbers.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/msg/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// The states.
    pub status: Vec<DiagnosticStatus>,
}

/// The request of `std_srvs/srv/Trigger`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// CDR has no empty structs.
    pub structure_needs_at_least_one_member: u8,
}

/// The response of `std_srvs/srv/Trigger`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: bool,
    /// In words.
    pub message: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_turns_convert() {
        assert_eq!(Time { sec: 2, nanosec: 5 }.nanoseconds(), Some(2_000_000_005));
        assert_eq!(Time { sec: -1, nanosec: 0 }.nanoseconds(), None);
        assert_eq!(Time { sec: 1, nanosec: 1_000_000_000 }.nanoseconds(), None);
        for yaw in [-3.0, -0.5, 0.0, 1.0, 3.1] {
            assert!((Quaternion::about_up(yaw).yaw() - yaw).abs() < 1e-12);
        }
    }
}
