//! Where a sequence of frames leads: a causal belief over poses, in fixed memory.
//!
//! The belief is a bank of poses with probabilities. Each frame,
//!
//! 1. every hypothesis is moved on, by odometry where there is some, and [refined](refine()) in the new evidence,
//! 2. the poses found in the frame by itself join in, and what lies close together becomes one,
//! 3. a pose's probability before looking is the sum over the former bank of how likely each leads there, and a share
//!    for what no motion explains: that the former answer was wrong, or that the robot was carried off,
//! 4. it is multiplied by the likelihood of what was seen.
//!
//! Neighbouring bins see the same wall and err together, so that a likelihood counts only to the power of 1/16: wrong
//! poses lead right ones by up to 50 nats in single frames, which is then 3. One frame can take no more than a bounded
//! factor from any pose.

use crate::base::num::{LogWeight, Metres, Nats, Point, ToFloat as _, Turn};
use crate::base::order;
use crate::base::pose::{ScoredPose, Separation};
use crate::base::scan::Hit;
use crate::pose::evidence::EvidenceTable;
use crate::pose::refine::refine;
use crate::pose::search::FloorLayer;
use core::f32::consts::PI;
use heapless::Vec;

/// Most hypotheses.
pub const MAX_HYPOTHESES: usize = 64;

/// Bits of a logarithm of 1 nat.
const NAT: f32 = LogWeight::ONE.to_bits() as f32;
/// The share of what no motion explains, for each pose.
const JUMP: LogWeight = LogWeight::lit("-9");
/// No pose loses more than this against the best of a frame.
const LOSS: LogWeight = LogWeight::lit("4");
/// Hypotheses this far below the best are dropped: were they right, the share for jumps would bring them back.
const NEGLIGIBLE: LogWeight = LogWeight::lit("10");

/// Faster than this nobody walks, metres per second.
const FASTEST: f32 = 2.5;

/// How the robot moved between two frames, in the level axes it had at the first: forward is where cam0 looked.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Metres.
    pub forward_m: f32,
    /// Metres.
    pub left_m: f32,
    /// Radians, counter-clockwise.
    pub turn: f32,
}

/// What a frame brings.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// What was seen.
    pub table: &'a EvidenceTable,
    /// The poses that explain it best by themselves, refined.
    pub poses: &'a [ScoredPose],
    /// Seconds since the frame before; 0 for the first.
    pub seconds: f32,
    /// The motion since then, if it was measured.
    pub motion: Option<Motion>,
}

/// What is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// The likeliest pose, with its score in the last frame.
    pub mode: ScoredPose,
    /// Its probability among the hypotheses.
    pub probability: f32,
    /// Root mean square distance of the hypotheses on its floor from it, metres.
    pub spread_m: f32,
}

/// A pose and what is known of it.
#[derive(Debug, Clone, Copy)]
struct Hypothesis {
    mode: ScoredPose,
    /// Logarithm of its probability.
    weight: LogWeight,
    /// Metres and radians per second, as the last two frames have it.
    rate: [f32; 3],
}

/// How far a motion may lead astray: standard deviations in metres and radians.
#[derive(Debug, Clone, Copy)]
struct Widths {
    metres: f32,
    radians: f32,
}

/// The belief: less than 8 KiB.
#[derive(Debug, Clone, Default)]
pub struct Track {
    hypotheses: Vec<Hypothesis, MAX_HYPOTHESES>,
    /// Of the frame before: only used while a frame is worked on.
    former: Vec<Hypothesis, MAX_HYPOTHESES>,
}

impl Track {
    /// Nothing is known.
    #[must_use]
    pub const fn new() -> Self {
        Self { hypotheses: Vec::new(), former: Vec::new() }
    }

    /// Takes in a frame; the layers must be the same each time. `None` while there is no hypothesis.
    ///
    /// # Cost
    /// A [refinement](refine()) of each hypothesis, of which there are few once the belief has settled; without
    /// odometry two: at most twice [`MAX_HYPOTHESES`]. What is offered is compared with all that are there.
    pub fn step(&mut self, layers: &[FloorLayer<'_>], observation: &Observation<'_>) -> Option<Estimate> {
        core::mem::swap(&mut self.hypotheses, &mut self.former);
        self.hypotheses.clear();
        let past = Past { layers, observation, bank: &self.former };
        for mode in observation.poses {
            offer(&mut self.hypotheses, layers, past.reach(*mode));
        }
        for mode in self.former.iter().flat_map(|hypothesis| past.ahead(hypothesis)) {
            if let Some(layer) = layers.get(usize::from(mode.layer))
                && layer.plan.hit_at(mode.at) == Some(Hit::Open)
            {
                offer(&mut self.hypotheses, layers, past.reach(refine(observation.table, layer, mode)));
            }
        }
        self.weigh();
        self.estimate(layers)
    }

    /// The likeliest pose; `None` while there is no hypothesis.
    #[must_use]
    pub fn estimate(&self, layers: &[FloorLayer<'_>]) -> Option<Estimate> {
        let best = self.hypotheses.first()?;
        let floor = floor(layers, &best.mode);
        let (mut mass, mut moment) = (0.0, 0.0);
        for hypothesis in self.hypotheses.iter().filter(|h| self::floor(layers, &h.mode) == floor) {
            let [dx, dy] = between(best.mode.at, hypothesis.mode.at);
            let probability = exp(hypothesis.weight);
            mass += probability;
            moment += probability * (dx * dx + dy * dy);
        }
        let spread_m = libm::sqrtf(moment / mass);
        Some(Estimate { mode: best.mode, probability: exp(best.weight), spread_m })
    }

    /// All poses that are believed possible and their probabilities, the likeliest first.
    pub fn hypotheses(&self) -> impl ExactSizeIterator<Item = (ScoredPose, f32)> {
        self.hypotheses.iter().map(|hypothesis| (hypothesis.mode, exp(hypothesis.weight)))
    }

    /// From probabilities before looking to those after, sorted; negligible ones are dropped.
    fn weigh(&mut self) {
        let Some(best) = self.hypotheses.iter().map(|h| h.mode.score).max() else { return };
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight -= tempered(best.saturating_sub(hypothesis.mode.score)).min(LOSS);
        }
        order::sort_by_key(&mut self.hypotheses, |h| (core::cmp::Reverse(h.weight), h.mode.order()));
        let Some(top) = self.hypotheses.first().map(|h| h.weight) else { return };
        let kept = self.hypotheses.iter().take_while(|h| top - h.weight <= NEGLIGIBLE).count();
        self.hypotheses.truncate(kept);
        let sum: f32 = self.hypotheses.iter().map(|h| exp(h.weight - top)).sum();
        let whole = top + log(sum);
        self.hypotheses.iter_mut().for_each(|h| h.weight -= whole);
    }
}

/// The belief before a frame, and the frame.
#[derive(Clone, Copy)]
struct Past<'a> {
    layers: &'a [FloorLayer<'a>],
    observation: &'a Observation<'a>,
    bank: &'a [Hypothesis],
}

impl Past<'_> {
    /// Where a hypothesis leads: where odometry says, else to stay and to go on as before.
    fn ahead(&self, hypothesis: &Hypothesis) -> impl Iterator<Item = ScoredPose> + use<> {
        let Hypothesis { mode, rate, .. } = *hypothesis;
        let moved = |[x, y]: [f32; 2], turn: f32| {
            let [x, y] = [x, y].map(metres);
            let at = Point::new(mode.at.x.saturating_add(x), mode.at.y.saturating_add(y));
            ScoredPose { at, heading: mode.heading + turn_of(turn), ..mode }
        };
        let [first, second] = match self.observation.motion {
            Some(Motion { forward_m, left_m, turn }) => {
                let (cos, sin) = mode.heading.cos_sin();
                let (cos, sin): (f32, f32) = (cos.to_num(), sin.to_num());
                let step = [forward_m * cos - left_m * sin, forward_m * sin + left_m * cos];
                [Some(moved(step, turn)), None]
            }
            None if rate == [0.0; 3] => [Some(mode), None],
            None => {
                let [x, y, turn] = rate.map(|rate| rate * self.observation.seconds);
                [Some(mode), Some(moved([x, y], turn))]
            }
        };
        first.into_iter().chain(second)
    }

    /// A pose with its probability before looking, and the motion that leads there most likely.
    fn reach(&self, mode: ScoredPose) -> Hypothesis {
        if self.bank.is_empty() {
            return Hypothesis { mode, weight: LogWeight::ZERO, rate: [0.0; 3] };
        }
        let widths = self.widths();
        let (mut sum, mut origin) = (exp(JUMP), (exp(JUMP), None));
        for hypothesis in self.bank {
            if floor(self.layers, &hypothesis.mode) != floor(self.layers, &mode) {
                continue;
            }
            let passage = self.ahead(hypothesis).map(|ahead| widths.passage(&ahead, &mode)).max();
            let share = exp(hypothesis.weight.saturating_add(passage.unwrap_or(LogWeight::MIN)));
            sum += share;
            if share > origin.0 {
                origin = (share, Some(hypothesis));
            }
        }
        let rate = origin.1.map_or([0.0; 3], |from| self.rate(from, &mode));
        Hypothesis { mode, weight: log(sum), rate }
    }

    /// Widths grow with time, and with odometry much less, with the motion it tells.
    fn widths(&self) -> Widths {
        let seconds = finite(self.observation.seconds).clamp(0.0, 60.0);
        match self.observation.motion {
            Some(Motion { forward_m, left_m, turn }) => {
                let way = libm::sqrtf(forward_m * forward_m + left_m * left_m);
                Widths {
                    metres: 0.15 + 0.1 * finite(way) + 0.03 * seconds,
                    radians: 0.05 + 0.1 * libm::fabsf(finite(turn)) + 0.01 * seconds,
                }
            }
            None => Widths { metres: 0.25 + 1.2 * seconds, radians: 0.15 + 1.0 * seconds },
        }
    }

    /// Metres and radians per second from one pose to another; 0 for what nobody walks.
    fn rate(&self, from: &Hypothesis, to: &ScoredPose) -> [f32; 3] {
        let [dx, dy] = between(from.mode.at, to.at);
        let seconds = self.observation.seconds;
        let limit = FASTEST * seconds;
        let walks = seconds > 0.0 && dx * dx + dy * dy <= limit * limit;
        if walks { [dx, dy, turned(from.mode.heading, to.heading)].map(|d| d / seconds) } else { [0.0; 3] }
    }
}

impl Widths {
    /// Logarithm of how likely a motion to one pose ended at another, 0 where it is the same.
    fn passage(&self, ahead: &ScoredPose, mode: &ScoredPose) -> LogWeight {
        let [dx, dy] = between(ahead.at, mode.at);
        let turn = turned(ahead.heading, mode.heading) / self.radians;
        let square = (dx * dx + dy * dy) / (self.metres * self.metres) + turn * turn;
        // The conversion saturates.
        -LogWeight::from_bits((square * (NAT / 2.0)) as i32)
    }
}

/// Adds a pose to a bank. What lies close together is one, the better of both; of a full bank the worst gives way.
fn offer(bank: &mut Vec<Hypothesis, MAX_HYPOTHESES>, layers: &[FloorLayer<'_>], new: Hypothesis) {
    // Of 64 bits: neither a weight nor a score is bounded.
    let worth = |h: &Hypothesis| i64::from(h.weight.to_bits()) + i64::from(tempered(h.mode.score).to_bits());
    let is_same = |old: &Hypothesis| {
        floor(layers, &old.mode) == floor(layers, &new.mode)
            && Separation::HYPOTHESES.is_near(old.mode.place(), new.mode.place())
    };
    let same = bank.iter().position(is_same);
    let slot = match same {
        None if bank.len() < MAX_HYPOTHESES => {
            let _ = bank.push(new);
            return;
        }
        None => bank.iter_mut().min_by_key(|old| worth(old)),
        Some(at) => bank.get_mut(at),
    };
    if let Some(old) = slot
        && worth(&new) > worth(old)
    {
        *old = new;
    }
}

fn floor(layers: &[FloorLayer<'_>], mode: &ScoredPose) -> Option<u8> {
    layers.get(usize::from(mode.layer)).map(|layer| layer.floor)
}

/// Metres from one point to another.
fn between(from: Point, to: Point) -> [f32; 2] {
    [to.x.saturating_sub(from.x), to.y.saturating_sub(from.y)].map(|d| d.to_num())
}

/// Radians from one direction to another, -pi to pi.
fn turned(from: Turn, to: Turn) -> f32 {
    (to - from).to_bits().cast_signed() as f32 * (PI / 2_147_483_648.0)
}

/// The angle of some radians.
fn turn_of(radians: f32) -> Turn {
    let turns = finite(radians) / (2.0 * PI);
    let rest = turns - libm::floorf(turns);
    // The conversion saturates just below the whole turn.
    Turn::from_bits((rest * 4_294_967_296.0) as u32)
}

/// A length in fixed point, saturated.
fn metres(length: f32) -> Metres {
    // To the nearest, as conversions of `fixed`, which panic where a length is not a number.
    Metres::from_bits(libm::rintf(finite(length) * 4_294_967_296.0) as i64)
}

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// A likelihood to the power of 1/16: 1/16 nat of a score are 1/256 nat of a weight.
const fn tempered(score: Nats) -> LogWeight {
    LogWeight::from_bits(score.to_bits())
}

/// A probability of its logarithm.
fn exp(weight: LogWeight) -> f32 {
    libm::expf(weight.to_float())
}

/// The logarithm of a probability.
fn log(probability: f32) -> LogWeight {
    LogWeight::from_bits(libm::roundf(NAT * libm::logf(probability)) as i32)
}

#[cfg(test)]
mod tests;
