//! Where answers go.

use super::error::{NodeError, failed};
use super::messages::{DiagnosticArray, PoseArray, PoseWithCovarianceStamped, Transforms};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{MessageTypeName, Name, Node, Publisher, QosProfile};

/// Where answers go.
pub(super) struct Outputs {
    pose: Publisher<PoseWithCovarianceStamped>,
    initial: Publisher<PoseWithCovarianceStamped>,
    candidates: Publisher<PoseArray>,
    transforms: Publisher<Transforms>,
    diagnostics: Publisher<DiagnosticArray>,
}

impl std::fmt::Debug for Outputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Outputs").finish_non_exhaustive()
    }
}

impl Outputs {
    // A message that nobody takes is lost, as any in ROS: there is nothing to be done about it here.
    pub(super) fn pose(&self, message: PoseWithCovarianceStamped) {
        let _ = self.pose.publish(message);
    }

    pub(super) fn initial_pose(&self, message: PoseWithCovarianceStamped) {
        let _ = self.initial.publish(message);
    }

    pub(super) fn candidates(&self, message: PoseArray) {
        let _ = self.candidates.publish(message);
    }

    pub(super) fn transform(&self, message: Transforms) {
        let _ = self.transforms.publish(message);
    }

    pub(super) fn diagnosis(&self, message: DiagnosticArray) {
        let _ = self.diagnostics.publish(message);
    }
}

fn publisher<M: serde::Serialize>(
    node: &mut Node,
    name: &str,
    kind: (&str, &str),
    qos: &QosProfile,
) -> Result<Publisher<M>, NodeError> {
    let of = || Some(node.create_topic(&Name::parse(name).ok()?, MessageTypeName::new(kind.0, kind.1), qos));
    let topic = of()
        .ok_or_else(|| failed(name, "no name of a topic"))?
        .map_err(|error| failed(name, format!("{error:?}")))?;
    node.create_publisher(&topic, None).map_err(|error| failed(name, format!("{error:?}")))
}

/// The topics of the answers, of a node.
pub(super) fn outputs(node: &mut Node) -> Result<Outputs, NodeError> {
    let reliable = QosProfile::publisher_default()
        .reliability_reliable(WhenFull::DEFAULT)
        .history(History::KeepLast { depth: 10 });
    // Who comes later hears it too, as navigation expects of an initial pose.
    let kept = reliable.clone().durability(Durability::TransientLocal);
    let own = |topic: &str| format!("{}/{topic}", node.fully_qualified_name());
    let (pose, candidates) = (own("pose"), own("candidates"));
    Ok(Outputs {
        pose: publisher(node, &pose, ("geometry_msgs", "PoseWithCovarianceStamped"), &reliable)?,
        initial: publisher(node, "/initialpose", ("geometry_msgs", "PoseWithCovarianceStamped"), &kept)?,
        candidates: publisher(node, &candidates, ("geometry_msgs", "PoseArray"), &reliable)?,
        transforms: publisher(node, "/tf", ("tf2_msgs", "TFMessage"), &reliable)?,
        diagnostics: publisher(node, "/diagnostics", ("diagnostic_msgs", "DiagnosticArray"), &reliable)?,
    })
}
