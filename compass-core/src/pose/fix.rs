//! The result of a localization: pose, probability, heights, alternatives.

use super::heights::{HeightPrior, Heights};
use super::{Alternatives, Covariance, FloorLayer, PosePrior, ScoredPose};
use crate::base::num::Nats;
use crate::base::pose::{MAX_ALTERNATIVES, Pose};

/// Probability from which a pose is [sure](Fix::is_sure).
pub const SURE: f32 = 0.9;

/// Log odds that a pose is right: constant, and factor of the lead in nats. See [`Fix::probability`].
const LOG_ODDS: [f32; 2] = [-4.13, 0.0464];

/// The likeliest pose, its alternatives, and the heights of camera and ceiling estimated with it.
///
/// # Formats
/// Positions in metres in the coordinates of the floor, headings counter-clockwise from +x, scores and margins in 1/16 nat,
/// heights in metres. An example is in the documentation of the [crate].
#[derive(Debug, Clone)]
pub struct Fix<'a> {
    answer: Answer,
    known: HeightPrior,
    within: PosePrior,
    /// Floor and layer of the likeliest pose.
    layer: Option<Place<'a>>,
    /// Score of the best pose under another assumption, if one was tried.
    rival: Option<Nats>,
}

/// What a search found.
#[derive(Debug, Clone)]
pub(super) struct Answer {
    pub(super) alternatives: Alternatives,
    /// Of each of them.
    pub(super) covariances: heapless::Vec<Covariance, MAX_ALTERNATIVES>,
    pub(super) heights: Heights,
    /// What the score of the likeliest pose gains if floor and ceiling exchange their weights.
    pub(super) exchange: Nats,
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
        layers: &[FloorLayer<'a>],
        answer: Answer,
        known: HeightPrior,
        within: PosePrior,
    ) -> Self {
        let layer = answer.alternatives.best().and_then(|best| layers.get(usize::from(best.layer)));
        let layer = layer.map(|layer| Place { floor: layer.floor, name: layer.name, number: layer.number });
        Self { answer, known, within, layer, rival: None }
    }

    /// No pose.
    pub(crate) fn nothing(known: HeightPrior, within: PosePrior) -> Self {
        let camera = known.camera_rungs().unwrap_or(0);
        let answer = Answer {
            alternatives: Alternatives::nothing(),
            covariances: heapless::Vec::new(),
            heights: Heights { camera, ceiling: 0 },
            exchange: Nats::ZERO,
        };
        Self { answer, known, within, layer: None, rival: None }
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
    /// A logistic function of the lead over the second best explanation of the images: the [margin](Self::margin), and at
    /// most the score, because the explanation "not in this plan" scores 0. Fitted to frames of known pose, on their own plan
    /// and on those of other buildings (`docs/design.md`, "Probability").
    #[must_use]
    pub fn probability(&self) -> f32 {
        self.best().map_or(0.0, |best| probability_of(best.score, self.margin()))
    }

    /// Difference of the best and the second best score among poses that are separated; the best score itself without
    /// a second one. A [rival](Self::with_rival) is one of them; of a better one the margin is 0.
    #[must_use]
    pub fn margin(&self) -> Nats {
        let margin = self.answer.alternatives.margin();
        let lead = self.best().zip(self.rival).map(|(best, rival)| best.score.saturating_sub(rival));
        lead.map_or(margin, |lead| margin.min(lead).max(Nats::ZERO))
    }

    /// The same with a rival: the best score elsewhere under another assumption of the same frames, such as another up
    /// vector. It is no pose of this result, but [`margin`](Self::margin) and [`probability`](Self::probability) count it.
    #[must_use]
    pub fn with_rival(self, score: Nats) -> Self {
        Self { rival: Some(self.rival.map_or(score, |rival| rival.max(score))), ..self }
    }

    /// Score of the best [rival](Self::with_rival).
    #[must_use]
    pub const fn rival(&self) -> Option<Nats> {
        self.rival
    }

    /// Score of the likeliest pose with the weights of floor and ceiling exchanged, by which opposite up vectors of the same
    /// frames are compared. `None` without a pose.
    ///
    /// The score counts the ceiling half, because it is the fainter of the two. With the wrong one of two up vectors the true
    /// ceiling passes for the floor, is counted whole, and would win by that.
    #[must_use]
    pub fn exchanged_score(&self) -> Option<Nats> {
        Some(self.best()?.score.saturating_add(self.answer.exchange))
    }

    /// Whether the [probability](Self::probability) reaches [`SURE`].
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.probability() >= SURE
    }

    /// Height of the camera above the floor, metres: the prior if it is known, else the estimate, quantized to 3 %.
    #[must_use]
    pub fn camera_height_m(&self) -> f32 {
        self.known.camera_m().unwrap_or_else(|| self.answer.heights.camera_m())
    }

    /// Height of the ceiling above the floor, metres. Its part above the camera is quantized to 3 %.
    #[must_use]
    pub fn ceiling_height_m(&self) -> f32 {
        self.answer.heights.ceiling_m()
    }

    /// Both heights in the rungs of the search.
    #[must_use]
    pub const fn heights(&self) -> Heights {
        self.answer.heights
    }

    /// The likeliest pose with its score.
    #[must_use]
    pub fn best(&self) -> Option<&ScoredPose> {
        self.answer.alternatives.best()
    }

    /// Covariance of the error of the likeliest pose, if it is right: of x, y and heading.
    #[must_use]
    pub fn covariance(&self) -> Option<Covariance> {
        self.covariances().first().copied()
    }

    /// Covariances of the [poses](Self::poses), one of each.
    #[must_use]
    pub fn covariances(&self) -> &[Covariance] {
        &self.answer.covariances
    }

    /// What was known of the pose: it restricted the search.
    #[must_use]
    pub const fn prior(&self) -> &PosePrior {
        &self.within
    }

    /// The likeliest pose and its alternatives, by descending score. Any two are on different floors, or at least 1 m or
    /// 20 degrees apart.
    #[must_use]
    pub fn poses(&self) -> &[ScoredPose] {
        self.answer.alternatives.poses()
    }
}

/// [`Fix::probability`] of a score and a margin.
#[must_use]
pub fn probability_of(score: Nats, margin: Nats) -> f32 {
    if score <= Nats::ZERO {
        return 0.0;
    }
    let lead = margin.clamp(Nats::ZERO, score).to_num::<f32>();
    let odds = LOG_ODDS[0] + LOG_ODDS[1] * lead;
    1.0 / (1.0 + libm::expf(-odds))
}
