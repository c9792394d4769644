//! Multi-hypothesis tracking: a recursive Bayesian filter over poses, causal and in fixed memory.
//!
//! The belief is a bank of hypotheses: poses with probabilities. For each frame,
//!
//! 1. every hypothesis is predicted, by odometry if available, and [refined](refine()) in the new evidence;
//! 2. the poses found in the frame by itself are added, and hypotheses close to each other are merged;
//! 3. the prior of a pose is the sum over the former bank of weight times transition density, plus a constant for
//!    transitions that no motion model explains: a wrong former estimate, or a robot that was carried;
//! 4. the prior is multiplied by the tempered likelihood of the frame.
//!
//! Errors of neighbouring bins are correlated, so that the likelihood is raised to the power of 1/16: in single frames a
//! wrong pose can exceed the true one by 50 nats, which become 3.
//!
//! # Thresholds
//! | constant | value | effect |
//! |---|---|---|
//! | `JUMP` | -9 nat | transition density without a motion: after a jump, about three frames outweigh the past |
//! | `LOSS` | 4 nat | largest loss of a pose against the best one of a frame |
//! | `NEGLIGIBLE` | 10 nat | hypotheses this far below the best are dropped |
//! | `FASTEST` | 2.5 m/s | largest speed of the constant-velocity model |
//! | `ODOMETRY_*` | | standard deviations of the transition with odometry |
//! | `FREE_*` | | standard deviations of the transition without odometry: those of a walking person |
//!
//! `docs/design.md`, "A sequence", gives the reasons.

use crate::base::num::{LogWeight, Metres, Nats, Point, ToFloat as _, Turn};
use crate::base::order;
use crate::base::pose::{ScoredPose, Separation};
use crate::base::scan::Hit;
use crate::pose::evidence::EvidenceTable;
use crate::pose::refine::refine;
use crate::pose::search::FloorLayer;
use core::f32::consts::PI;
use heapless::Vec;

/// Capacity of the bank.
pub const MAX_HYPOTHESES: usize = 64;

/// Bits of 1 nat as a [`LogWeight`].
const NAT: f32 = LogWeight::ONE.to_bits() as f32;
/// Transition density, relative to the maximum of the motion model, of a jump to any pose.
const JUMP: LogWeight = LogWeight::lit("-9");
/// Largest loss of a hypothesis against the best one in a frame.
const LOSS: LogWeight = LogWeight::lit("4");
/// Hypotheses this far below the best are dropped. A true one among them would return by [`JUMP`].
const NEGLIGIBLE: LogWeight = LogWeight::lit("10");

/// Largest speed of the constant-velocity model, metres per second: that of a walking person.
const FASTEST: f32 = 2.5;

/// Standard deviation of a position predicted by odometry: metres, metres per metre of motion, metres per second.
const ODOMETRY_METRES: [f32; 3] = [0.15, 0.1, 0.03];
/// Standard deviation of a heading predicted by odometry: radians, radians per radian of turn, radians per second.
const ODOMETRY_RADIANS: [f32; 3] = [0.05, 0.1, 0.01];
/// Standard deviation of a position without odometry: metres, metres per second.
const FREE_METRES: [f32; 2] = [0.25, 1.2];
/// Standard deviation of a heading without odometry: radians, radians per second.
const FREE_RADIANS: [f32; 2] = [0.15, 1.0];
/// Longest time between frames that widens the transition, seconds.
const LONGEST_SECONDS: f32 = 60.0;

/// Odometry between two frames, in the level frame of the first one: forward is the heading of camera 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Forward displacement, metres.
    pub forward_m: f32,
    /// Displacement to the left, metres.
    pub left_m: f32,
    /// Change of heading, radians, counter-clockwise.
    pub turn: f32,
}

/// The input of [`Track::step`]: one frame.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// Evidence of the frame.
    pub table: &'a EvidenceTable,
    /// Refined poses that were found in this frame by itself.
    pub poses: &'a [ScoredPose],
    /// Time since the former frame, seconds; 0 for the first frame.
    pub seconds: f32,
    /// Odometry since the former frame, if available.
    pub motion: Option<Motion>,
}

/// The likeliest hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// The pose, with its score in the last frame.
    pub pose: ScoredPose,
    /// Probability of the hypothesis, 0 to 1.
    pub probability: f32,
    /// Root mean square distance of the hypotheses on the same floor from the pose, metres.
    pub spread_m: f32,
}

/// A pose with its probability and velocity.
#[derive(Debug, Clone, Copy)]
struct Hypothesis {
    pose: ScoredPose,
    /// Logarithm of the probability.
    weight: LogWeight,
    /// Velocity along x and y, metres per second, and of the heading, radians per second, from the last two frames.
    rate: [f32; 3],
}

/// Standard deviations of the transition.
#[derive(Debug, Clone, Copy)]
struct Widths {
    metres: f32,
    radians: f32,
}

/// The belief: at most [`MAX_HYPOTHESES`] poses with probabilities, in less than 8 KiB (test
/// `a_bank_is_bounded_and_repeatable`).
#[derive(Debug, Clone, Default)]
pub struct Track {
    hypotheses: Vec<Hypothesis, MAX_HYPOTHESES>,
    /// Bank of the former frame, used within [`Track::step`] alone.
    former: Vec<Hypothesis, MAX_HYPOTHESES>,
}

impl Track {
    /// A track without hypotheses.
    #[must_use]
    pub const fn new() -> Self {
        Self { hypotheses: Vec::new(), former: Vec::new() }
    }

    /// Updates the belief by a frame and returns the likeliest hypothesis; `None` while there is none.
    ///
    /// `layers` must be the same in each call. Values of `observation` that are not finite count as 0.
    ///
    /// # Accuracy
    /// Within 0.75 m and 15 degrees of the true pose while three consecutive frames give wrong poses alone, 50 nats above
    /// it (test `three_wrong_frames_do_not_mislead_the_track`).
    ///
    /// # Cost
    /// Per hypothesis one [refinement](refine()), without odometry up to two: at most twice [`MAX_HYPOTHESES`]. Few
    /// hypotheses remain once the belief has converged. Each new pose is compared with the whole bank. Cortex-M7: `track`
    /// in `targets/budget.txt`.
    ///
    /// ```
    /// # use compass_core::Site;
    /// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
    /// # let site = Site::new(&bytes)?;
    /// # let floor = site.floor(0).unwrap();
    /// # use compass_core::pose::{EvidenceTable, FloorLayer, plane_of};
    /// # use compass_core::{Nats, Scan, ScoredPose, Turn};
    /// # let map = *floor.map();
    /// # let layer = FloorLayer { map, number: 0, plan: floor.plan(0).unwrap(), floor: 0, name: floor.name() };
    /// # let mut scan = Scan::OPEN;
    /// # map.get(7).unwrap().scan(&mut scan);
    /// # let mut table = Box::new(EvidenceTable::EMPTY);
    /// # for (bin, (steps, hit)) in scan.steps.iter().zip(scan.hit).enumerate() {
    /// #     table.set(plane_of(*steps, hit), bin, Nats::ONE);
    /// # }
    /// use compass_core::Track;
    /// use compass_core::pose::track::Observation;
    ///
    /// // One frame: evidence of the scan of candidate 7, and its pose.
    /// let found = ScoredPose { layer: 0, at: map.position(7).unwrap(), heading: Turn::ZERO, score: Nats::ONE };
    /// let observation = Observation { table: &table, poses: &[found], seconds: 0.0, motion: None };
    /// let mut track = Track::new();
    /// let estimate = track.step(&[layer], &observation).unwrap();
    /// assert_eq!(estimate.pose, found);
    /// assert!(estimate.probability > 0.99);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn step(&mut self, layers: &[FloorLayer<'_>], observation: &Observation<'_>) -> Option<Estimate> {
        core::mem::swap(&mut self.hypotheses, &mut self.former);
        self.hypotheses.clear();
        let past = Past { layers, observation, bank: &self.former };
        for pose in observation.poses {
            insert(&mut self.hypotheses, layers, past.with_prior(*pose));
        }
        for pose in self.former.iter().flat_map(|hypothesis| past.predict(hypothesis)) {
            if let Some(layer) = layers.get(usize::from(pose.layer))
                && layer.plan.hit_at(pose.at) == Some(Hit::Open)
            {
                insert(&mut self.hypotheses, layers, past.with_prior(refine(observation.table, layer, pose)));
            }
        }
        self.update();
        self.estimate(layers)
    }

    /// The likeliest hypothesis; `None` while there is none.
    #[must_use]
    pub fn estimate(&self, layers: &[FloorLayer<'_>]) -> Option<Estimate> {
        let best = self.hypotheses.first()?;
        let floor = floor(layers, &best.pose);
        let (mut mass, mut moment) = (0.0, 0.0);
        for hypothesis in self.hypotheses.iter().filter(|h| self::floor(layers, &h.pose) == floor) {
            let [dx, dy] = between(best.pose.at, hypothesis.pose.at);
            let probability = exp(hypothesis.weight);
            mass += probability;
            moment += probability * (dx * dx + dy * dy);
        }
        let spread_m = libm::sqrtf(moment / mass);
        Some(Estimate { pose: best.pose, probability: exp(best.weight), spread_m })
    }

    /// All hypotheses and their probabilities, by descending probability.
    pub fn hypotheses(&self) -> impl ExactSizeIterator<Item = (ScoredPose, f32)> {
        self.hypotheses.iter().map(|hypothesis| (hypothesis.pose, exp(hypothesis.weight)))
    }

    /// Multiplies priors by likelihoods, sorts, drops negligible hypotheses and normalizes.
    fn update(&mut self) {
        let Some(best) = self.hypotheses.iter().map(|h| h.pose.score).max() else { return };
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight -= tempered(best.saturating_sub(hypothesis.pose.score)).min(LOSS);
        }
        order::sort_by_key(&mut self.hypotheses, |h| (core::cmp::Reverse(h.weight), h.pose.order()));
        let Some(top) = self.hypotheses.first().map(|h| h.weight) else { return };
        let kept = self.hypotheses.iter().take_while(|h| top - h.weight <= NEGLIGIBLE).count();
        self.hypotheses.truncate(kept);
        let sum: f32 = self.hypotheses.iter().map(|h| exp(h.weight - top)).sum();
        let whole = top + log(sum);
        self.hypotheses.iter_mut().for_each(|h| h.weight -= whole);
    }
}

/// The belief before a frame, and the frame: the prediction step.
#[derive(Clone, Copy)]
struct Past<'a> {
    layers: &'a [FloorLayer<'a>],
    observation: &'a Observation<'a>,
    bank: &'a [Hypothesis],
}

impl Past<'_> {
    /// Predicted poses of a hypothesis: by odometry, else by a standstill and by constant velocity.
    fn predict(&self, hypothesis: &Hypothesis) -> impl Iterator<Item = ScoredPose> + use<> {
        let Hypothesis { pose, rate, .. } = *hypothesis;
        let moved = |[x, y]: [f32; 2], turn: f32| {
            let [x, y] = [x, y].map(metres);
            let at = Point::new(pose.at.x.saturating_add(x), pose.at.y.saturating_add(y));
            ScoredPose { at, heading: pose.heading + turn_of(turn), ..pose }
        };
        let [first, second] = match self.observation.motion {
            Some(Motion { forward_m, left_m, turn }) => {
                let (cos, sin) = pose.heading.cos_sin();
                let (cos, sin): (f32, f32) = (cos.to_num(), sin.to_num());
                let step = [forward_m * cos - left_m * sin, forward_m * sin + left_m * cos];
                [Some(moved(step, turn)), None]
            }
            None if rate == [0.0; 3] => [Some(pose), None],
            None => {
                let [x, y, turn] = rate.map(|rate| rate * self.observation.seconds);
                [Some(pose), Some(moved([x, y], turn))]
            }
        };
        first.into_iter().chain(second)
    }

    /// A pose with its prior, and the velocity of the likeliest transition to it.
    fn with_prior(&self, pose: ScoredPose) -> Hypothesis {
        if self.bank.is_empty() {
            return Hypothesis { pose, weight: LogWeight::ZERO, rate: [0.0; 3] };
        }
        let widths = self.widths();
        let (mut sum, mut origin) = (exp(JUMP), (exp(JUMP), None));
        for hypothesis in self.bank {
            if floor(self.layers, &hypothesis.pose) != floor(self.layers, &pose) {
                continue;
            }
            let transition =
                self.predict(hypothesis).map(|predicted| widths.log_density(&predicted, &pose)).max();
            let share = exp(hypothesis.weight.saturating_add(transition.unwrap_or(LogWeight::MIN)));
            sum += share;
            if share > origin.0 {
                origin = (share, Some(hypothesis));
            }
        }
        let rate = origin.1.map_or([0.0; 3], |from| self.rate(from, &pose));
        Hypothesis { pose, weight: log(sum), rate }
    }

    /// Standard deviations of the transition. They increase with time and, with odometry, with the motion.
    fn widths(&self) -> Widths {
        let seconds = finite(self.observation.seconds).clamp(0.0, LONGEST_SECONDS);
        match self.observation.motion {
            Some(Motion { forward_m, left_m, turn }) => {
                let distance = libm::sqrtf(forward_m * forward_m + left_m * left_m);
                let [metres, per_metre, metres_per_second] = ODOMETRY_METRES;
                let [radians, per_radian, radians_per_second] = ODOMETRY_RADIANS;
                Widths {
                    metres: metres + per_metre * finite(distance) + metres_per_second * seconds,
                    radians: radians + per_radian * libm::fabsf(finite(turn)) + radians_per_second * seconds,
                }
            }
            None => {
                let ([metres, metres_per_second], [radians, radians_per_second]) =
                    (FREE_METRES, FREE_RADIANS);
                Widths {
                    metres: metres + metres_per_second * seconds,
                    radians: radians + radians_per_second * seconds,
                }
            }
        }
    }

    /// Velocity of a transition, metres and radians per second; 0 above [`FASTEST`].
    fn rate(&self, from: &Hypothesis, to: &ScoredPose) -> [f32; 3] {
        let [dx, dy] = between(from.pose.at, to.at);
        let seconds = self.observation.seconds;
        let limit = FASTEST * seconds;
        let walks = seconds > 0.0 && dx * dx + dy * dy <= limit * limit;
        if walks { [dx, dy, turned(from.pose.heading, to.heading)].map(|d| d / seconds) } else { [0.0; 3] }
    }
}

impl Widths {
    /// Logarithm of the Gaussian density of a transition, relative to its maximum at the predicted pose.
    #[expect(clippy::cast_possible_truncation, reason = "conversions from float saturate")]
    fn log_density(&self, predicted: &ScoredPose, pose: &ScoredPose) -> LogWeight {
        let [dx, dy] = between(predicted.at, pose.at);
        let turn = turned(predicted.heading, pose.heading) / self.radians;
        let square = (dx * dx + dy * dy) / (self.metres * self.metres) + turn * turn;
        // The conversion saturates.
        -LogWeight::from_bits((square * (NAT / 2.0)) as i32)
    }
}

/// Inserts a hypothesis into a bank. One of two within [`Separation::HYPOTHESES`] remains, the better one; a full bank
/// replaces its worst.
fn insert(bank: &mut Vec<Hypothesis, MAX_HYPOTHESES>, layers: &[FloorLayer<'_>], new: Hypothesis) {
    // 64 bits: neither weights nor scores are bounded.
    let posterior =
        |h: &Hypothesis| i64::from(h.weight.to_bits()) + i64::from(tempered(h.pose.score).to_bits());
    let is_same = |old: &Hypothesis| {
        floor(layers, &old.pose) == floor(layers, &new.pose)
            && Separation::HYPOTHESES.is_near(old.pose.place(), new.pose.place())
    };
    let same = bank.iter().position(is_same);
    let slot = match same {
        None if bank.len() < MAX_HYPOTHESES => {
            let _ = bank.push(new);
            return;
        }
        None => bank.iter_mut().min_by_key(|old| posterior(old)),
        Some(at) => bank.get_mut(at),
    };
    if let Some(old) = slot
        && posterior(&new) > posterior(old)
    {
        *old = new;
    }
}

fn floor(layers: &[FloorLayer<'_>], pose: &ScoredPose) -> Option<u8> {
    layers.get(usize::from(pose.layer)).map(|layer| layer.floor)
}

/// Displacement from one point to another, metres.
fn between(from: Point, to: Point) -> [f32; 2] {
    [to.x.saturating_sub(from.x), to.y.saturating_sub(from.y)].map(|d| d.to_num())
}

/// Angle from one direction to another, radians, -pi to pi.
fn turned(from: Turn, to: Turn) -> f32 {
    (to - from).to_bits().cast_signed() as f32 * (PI / 2_147_483_648.0)
}

/// Conversion from radians.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "conversions from float saturate"
)]
fn turn_of(radians: f32) -> Turn {
    let turns = finite(radians) / (2.0 * PI);
    let rest = turns - libm::floorf(turns);
    // The conversion saturates just below the whole turn.
    Turn::from_bits((rest * 4_294_967_296.0) as u32)
}

/// Conversion from metres, saturated.
#[expect(clippy::cast_possible_truncation, reason = "conversions from float saturate")]
fn metres(length: f32) -> Metres {
    // Rounded to the nearest like the conversions of `fixed`, which panic on NaN.
    Metres::from_bits(libm::rintf(finite(length) * 4_294_967_296.0) as i64)
}

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// The likelihood to the power of 1/16: the same bits as 1/16 nat of a score and as 1/256 nat of a weight.
const fn tempered(score: Nats) -> LogWeight {
    LogWeight::from_bits(score.to_bits())
}

/// The probability of a log weight.
fn exp(weight: LogWeight) -> f32 {
    libm::expf(weight.to_float())
}

/// The log weight of a probability.
#[expect(clippy::cast_possible_truncation, reason = "conversions from float saturate")]
fn log(probability: f32) -> LogWeight {
    LogWeight::from_bits(libm::roundf(NAT * libm::logf(probability)) as i32)
}

#[cfg(test)]
mod tests;
