//! A topic of a bag.

use super::kind::Kind;

/// A topic of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    pub(super) name: String,
    /// Its type as written, such as `sensor_msgs/msg/Image`.
    pub(super) written_kind: String,
    /// How its messages are serialized, such as `cdr`.
    pub(super) format: String,
    /// Number of messages, as far as it is known.
    pub(super) count: usize,
}

impl Topic {
    pub(super) fn kind(&self) -> Kind {
        Kind::of(&self.written_kind)
    }
}

/// All topics with their types, for messages.
pub(super) fn list(topics: &[Topic]) -> String {
    let texts: Vec<_> =
        topics.iter().map(|topic| format!("{} ({})", topic.name, topic.written_kind)).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}
