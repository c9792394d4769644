//! Where the cameras are.

use super::heights::{HeightPrior, Heights};
use super::{Answer, FloorLayer, ScoredPose};
use crate::base::num::Nats;
use crate::base::pose::Pose;

/// An answer that leads by as much needs no second search, with another ceiling.
pub const SURE: Nats = Nats::lit("150");

/// Log odds against an answer whose margin is 0, and what they lose per unit of ln(1 + margin in nats).
const CERTAINTY: [f32; 2] = [14.02, 3.26];

/// Where the cameras are: the likeliest pose, its alternatives, and the heights that were found with it.
#[derive(Debug, Clone)]
pub struct Fix<'a> {
    answer: Answer,
    heights: Heights,
    known: HeightPrior,
    /// The layer that the likeliest pose was found on.
    layer: Option<Place<'a>>,
}

/// A floor and which of its layers.
#[derive(Debug, Clone, Copy)]
struct Place<'a> {
    floor: u8,
    name: &'a str,
    number: u8,
}

impl<'a> Fix<'a> {
    pub(super) fn new(
        answer: Answer,
        heights: Heights,
        known: HeightPrior,
        layers: &[FloorLayer<'a>],
    ) -> Self {
        let layer = answer.best().and_then(|best| layers.get(usize::from(best.layer)));
        let layer = layer.map(|layer| Place { floor: layer.floor, name: layer.name, number: layer.number });
        Self { answer, heights, known, layer }
    }

    /// No pose.
    pub(crate) fn nothing(known: HeightPrior) -> Self {
        let camera = known.camera_rungs().unwrap_or(0);
        Self { answer: Answer::nothing(), heights: Heights { camera, ceiling: 0 }, known, layer: None }
    }

    /// The likeliest pose of camera 0; `None` if there is no candidate, or nothing was seen.
    #[must_use]
    pub fn pose(&self) -> Option<Pose> {
        let (best, layer) = (self.best()?, self.layer?);
        Some(Pose { floor: layer.floor, at: best.at, heading: best.heading })
    }

    /// Name of its floor.
    #[must_use]
    pub fn floor_name(&self) -> Option<&'a str> {
        Some(self.layer?.name)
    }

    /// Which layer of its floor fits best: 0 the plan as drawn, 1 its structure alone.
    #[must_use]
    pub fn layer_number(&self) -> Option<u8> {
        Some(self.layer?.number)
    }

    /// How likely the pose is within 1 m of the true one, 0 to 1: from its margin over the best pose elsewhere.
    ///
    /// Logistic in the logarithm of the margin, fitted to 249 frame pairs of two storeys, 240 of them simulated
    /// (`docs/design.md`). The score itself says little: bins next to each other err together.
    #[must_use]
    pub fn probability(&self) -> f32 {
        if self.best().is_none_or(|best| best.score <= Nats::ZERO) {
            return 0.0;
        }
        let margin = self.margin().max(Nats::ZERO).to_num::<f32>();
        1.0 / (1.0 + libm::expf(CERTAINTY[0] - CERTAINTY[1] * libm::log1pf(margin)))
    }

    /// By how much the best score exceeds the best one elsewhere; the best score itself when there is no
    /// other.
    #[must_use]
    pub fn margin(&self) -> Nats {
        self.answer.margin()
    }

    /// Whether the pose leads by so much that no other height of the ceiling was tried.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.margin() >= SURE
    }

    /// Height of the camera above the floor, metres: that known before, or that found, to 3 %.
    #[must_use]
    pub fn camera_height_m(&self) -> f32 {
        self.known.camera_m().unwrap_or_else(|| self.heights.camera_m())
    }

    /// Height of the ceiling above the floor, metres, to 3 % of the part above the camera.
    #[must_use]
    pub fn ceiling_height_m(&self) -> f32 {
        self.heights.ceiling_m()
    }

    /// Both heights as the search counts them.
    #[must_use]
    pub const fn heights(&self) -> Heights {
        self.heights
    }

    /// The likeliest pose with its score.
    #[must_use]
    pub fn best(&self) -> Option<&ScoredPose> {
        self.answer.best()
    }

    /// The likeliest pose and its alternatives, best first: on other floors, or at least 1 m or 20 degrees apart.
    #[must_use]
    pub fn poses(&self) -> &[ScoredPose] {
        self.answer.modes()
    }

    /// The score of the likeliest pose; below all others without one.
    pub(super) fn score(&self) -> Nats {
        self.answer.score()
    }
}
