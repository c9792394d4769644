//! The results of one frame, as a line of JSON.

use crate::up::UpFrom;
use compass_core::base::num::{Metres, Nats, Point, Turn};
use compass_core::descriptor::similarity::{Similarity, Weights};
use compass_core::pose::{ScoredPose, probability_of};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Variants of the paper's matching: name, similarity and channel weights.
pub const PAPER: [(&str, Similarity, Weights); 4] = [
    ("paper, plain", Similarity::Plain, Weights::EQUAL),
    ("paper, centred", Similarity::Centred, Weights::EQUAL),
    ("paper, hit type", Similarity::Centred, Weights::HIT_TYPE),
    ("paper, range", Similarity::Centred, Weights::RANGE),
];

/// A pose, exact to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Found {
    /// Index of the layer.
    pub layer: u8,
    /// Bits of [`Metres`].
    pub x: i64,
    /// Bits of [`Metres`].
    pub y: i64,
    /// Bits of [`Turn`].
    pub heading: u32,
    /// Bits of [`Nats`]; of a cosine, its own bits.
    pub score: i32,
}

/// The results of one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The time of the frame.
    pub timestamp_ns: u64,
    /// Fingerprint of the inputs, hexadecimal.
    pub fingerprint: String,
    /// Why the frame gave no evidence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// Whether the problem is that an image cannot be read or does not fit the calibration.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_unreadable: bool,
    /// How both lenses lay in one image, if they did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub halves: Option<String>,
    /// The up vector in cam0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f32; 3]>,
    /// The source of the up vector.
    #[serde(default)]
    pub up_from: UpFrom,
    /// Height of cam0 above the floor in metres: given or estimated.
    pub height_m: f32,
    /// The same height in rungs.
    pub height: i8,
    /// Rungs by which the ceiling is higher above the camera than the floor is below it.
    pub ceiling: i8,
    /// The single frame's best pose and its alternatives.
    pub single: Vec<Found>,
    /// Covariance of x, y and heading of the best pose, if it is right: m2, m rad, rad2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f32; 3]; 3]>,
    /// Bits of the best score elsewhere with another up vector, if several were tried.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rival: Option<i32>,
    /// The poses of the same search on evidence computed from the plan at the true pose.
    pub oracle: Vec<Found>,
    /// The best match by the paper's cosine, in each of the [`PAPER`] ways.
    pub paper: [Option<Found>; PAPER.len()],
    /// [`Fingerprint`](super::Fingerprint) of the file with its evidence, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<String>,
    /// Milliseconds by stage.
    pub milliseconds: BTreeMap<String, f64>,
}

impl From<&ScoredPose> for Found {
    fn from(scored: &ScoredPose) -> Self {
        let ScoredPose { layer, at, heading, score } = *scored;
        Self {
            layer,
            x: at.x.to_bits(),
            y: at.y.to_bits(),
            heading: heading.to_bits(),
            score: score.to_bits(),
        }
    }
}

impl From<&Found> for ScoredPose {
    fn from(found: &Found) -> Self {
        let at = Point::new(Metres::from_bits(found.x), Metres::from_bits(found.y));
        let (heading, score) = (Turn::from_bits(found.heading), Nats::from_bits(found.score));
        Self { layer: found.layer, at, heading, score }
    }
}

impl Found {
    /// All poses of a result.
    #[must_use]
    pub fn all(poses: &[ScoredPose]) -> Vec<Self> {
        poses.iter().map(Self::from).collect()
    }

    /// Position in metres.
    #[must_use]
    pub fn position(&self) -> [f64; 2] {
        [self.x, self.y].map(|bits| Metres::from_bits(bits).to_num())
    }

    /// Heading in degrees, -180 to 180.
    #[must_use]
    pub fn heading_deg(&self) -> f64 {
        f64::from(Turn::from_bits(self.heading).to_bits().cast_signed()) * (180.0 / 2_147_483_648.0)
    }
}

impl Record {
    /// Lead of the best pose over the best one elsewhere, nats.
    #[must_use]
    pub fn margin(&self) -> f64 {
        let [best, second] = [0, 1].map(|at| self.score(at));
        let rival = self.rival.map_or(Nats::MIN, Nats::from_bits);
        best.saturating_sub(second).min(best.saturating_sub(rival).max(Nats::ZERO)).to_num()
    }

    /// Score of the best pose or of an alternative; 0 without it.
    fn score(&self, at: usize) -> Nats {
        self.single.get(at).map_or(Nats::ZERO, |found| Nats::from_bits(found.score))
    }

    /// The [margin](Self::margin), at most the score: "not in this plan" scores 0. Nats.
    #[must_use]
    pub fn lead(&self) -> f64 {
        self.margin().clamp(0.0, self.score(0).to_num::<f64>().max(0.0))
    }

    /// Estimated probability that the best pose is right.
    #[must_use]
    pub fn probability(&self) -> f32 {
        probability_of(self.score(0), Nats::from_num(self.margin()))
    }
}
