//! The result of a localization: pose, probability, heights, alternatives.

use super::heights::{HeightPrior, Heights};
use super::{Alternatives, FloorLayer, ScoredPose};
use crate::base::num::Nats;
use crate::base::pose::Pose;

/// Margin from which a pose is accepted without a search at further ceiling heights.
pub const SURE: Nats = Nats::lit("150");

/// Log odds that a pose of margin 0 is wrong. Fitted together with [`LOG_ODDS_SLOPE`]: see [`Fix::probability`].
const LOG_ODDS_WRONG: f32 = 14.02;
/// Decrease of these log odds per unit of ln(1 + margin in nats).
const LOG_ODDS_SLOPE: f32 = 3.26;

/// The likeliest pose, its alternatives, and the heights of camera and ceiling estimated with it.
///
/// # Formats
/// Positions in metres in the coordinates of the floor, headings counter-clockwise from +x, scores and margins in 1/16 nat,
/// heights in metres. An example is in the documentation of the [crate].
#[derive(Debug, Clone)]
pub struct Fix<'a> {
    alternatives: Alternatives,
    heights: Heights,
    known: HeightPrior,
    /// Floor and layer of the likeliest pose.
    layer: Option<Place<'a>>,
}

/// A floor and one of its layers.
#[derive(Debug, Clone, Copy)]
struct Place<'a> {
    floor: u8,
    name: &'a str,
    number: u8,
}

impl<'a> Fix<'a> {
    pub(super) fn new(
        alternatives: Alternatives,
        heights: Heights,
        known: HeightPrior,
        layers: &[FloorLayer<'a>],
    ) -> Self {
        let layer = alternatives.best().and_then(|best| layers.get(usize::from(best.layer)));
        let layer = layer.map(|layer| Place { floor: layer.floor, name: layer.name, number: layer.number });
        Self { alternatives, heights, known, layer }
    }

    /// No pose.
    pub(crate) fn nothing(known: HeightPrior) -> Self {
        let camera = known.camera_rungs().unwrap_or(0);
        Self {
            alternatives: Alternatives::nothing(),
            heights: Heights { camera, ceiling: 0 },
            known,
            layer: None,
        }
    }

    /// The likeliest pose of camera 0; `None` if the site has no candidate or the images gave no evidence.
    #[must_use]
    pub fn pose(&self) -> Option<Pose> {
        let (best, layer) = (self.best()?, self.layer?);
        Some(Pose { floor: layer.floor, at: best.at, heading: best.heading })
    }

    /// Name of the floor of the likeliest pose.
    #[must_use]
    pub fn floor_name(&self) -> Option<&'a str> {
        Some(self.layer?.name)
    }

    /// Number of the floor layer that the likeliest pose was found on: 0 plan, 1 structure.
    #[must_use]
    pub fn layer_number(&self) -> Option<u8> {
        Some(self.layer?.number)
    }

    /// Estimated probability, 0 to 1, that the pose is within 1 m of the true one.
    ///
    /// A logistic function of ln(1 + [margin](Self::margin)), fitted to 249 frame pairs of two storeys, 240 of them
    /// simulated (`docs/design.md`). The score itself is a poor predictor, because the errors of neighbouring bins are
    /// correlated. 0 for a score of 0 or less.
    #[must_use]
    pub fn probability(&self) -> f32 {
        if self.best().is_none_or(|best| best.score <= Nats::ZERO) {
            return 0.0;
        }
        let margin = self.margin().max(Nats::ZERO).to_num::<f32>();
        1.0 / (1.0 + libm::expf(LOG_ODDS_WRONG - LOG_ODDS_SLOPE * libm::log1pf(margin)))
    }

    /// Difference of the best and the second best score among poses that are separated; the best score itself without
    /// a second one.
    #[must_use]
    pub fn margin(&self) -> Nats {
        self.alternatives.margin()
    }

    /// Whether the margin reaches [`SURE`]: [`locate`](super::locate::locate()) then tries no further ceiling height.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.margin() >= SURE
    }

    /// Height of the camera above the floor, metres: the prior if it is known, else the estimate, quantized to 3 %.
    #[must_use]
    pub fn camera_height_m(&self) -> f32 {
        self.known.camera_m().unwrap_or_else(|| self.heights.camera_m())
    }

    /// Height of the ceiling above the floor, metres. Its part above the camera is quantized to 3 %.
    #[must_use]
    pub fn ceiling_height_m(&self) -> f32 {
        self.heights.ceiling_m()
    }

    /// Both heights in the rungs of the search.
    #[must_use]
    pub const fn heights(&self) -> Heights {
        self.heights
    }

    /// The likeliest pose with its score.
    #[must_use]
    pub fn best(&self) -> Option<&ScoredPose> {
        self.alternatives.best()
    }

    /// The likeliest pose and its alternatives, by descending score. Any two are on different floors, or at least 1 m or
    /// 20 degrees apart.
    #[must_use]
    pub fn poses(&self) -> &[ScoredPose] {
        self.alternatives.poses()
    }

    /// The score of the likeliest pose; [`Nats::MIN`] without one.
    pub(super) fn score(&self) -> Nats {
        self.alternatives.score()
    }
}
