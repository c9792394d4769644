//! The best poses that lie apart.

use super::search::{FloorLayer, pose_of};
use crate::base::num::Nats;
use crate::base::order;
use crate::base::pose::{MAX_ALTERNATIVES, ScoredPose, Separation};

/// What was found, best first.
#[derive(Debug, Clone)]
pub struct Answer {
    modes: heapless::Vec<ScoredPose, MAX_ALTERNATIVES>,
}

impl Answer {
    /// No pose.
    pub(crate) const fn nothing() -> Self {
        Self { modes: heapless::Vec::new() }
    }

    /// The best pose and its alternatives: on other floors, or at least 1 m or 20 degrees apart.
    #[must_use]
    pub fn modes(&self) -> &[ScoredPose] {
        &self.modes
    }

    /// The best pose.
    #[must_use]
    pub fn best(&self) -> Option<&ScoredPose> {
        self.modes.first()
    }

    /// The best score; below all others without a pose.
    pub(crate) fn score(&self) -> Nats {
        self.best().map_or(Nats::MIN, |mode| mode.score)
    }

    /// By how much the best score exceeds the best one elsewhere; the best score itself, which is relative to "nothing
    /// known", when there is no other.
    #[must_use]
    pub fn margin(&self) -> Nats {
        let score = |at: usize| self.modes.get(at).map_or(Nats::ZERO, |mode| mode.score);
        score(0).saturating_sub(score(1))
    }
}

/// Sorts [refined](super::refine()) modes and keeps the best that lie apart. The same pose on two layers of one floor
/// counts once, by its better layer; modes of layers that do not exist do not count.
#[must_use]
pub fn answer(layers: &[FloorLayer<'_>], modes: &mut [ScoredPose]) -> Answer {
    order::sort_by_key(modes, ScoredPose::order);
    let mut kept: heapless::Vec<ScoredPose, MAX_ALTERNATIVES> = heapless::Vec::new();
    for mode in modes.iter().filter(|mode| mode.score > Nats::MIN) {
        let Some(pose) = pose_of(layers, mode) else { continue };
        let is_near = |other: &ScoredPose| {
            pose_of(layers, other).is_some_and(|other| Separation::ALTERNATIVES.joins(&pose, &other))
        };
        if !kept.iter().any(is_near) && kept.push(*mode).is_err() {
            break;
        }
    }
    Answer { modes: kept }
}
