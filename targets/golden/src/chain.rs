//! What a firmware does with packed frames: pose and track, step by step.

use crate::Eyes;
use compass_board::{Error, Frame, Locator};
use compass_core::vision::attitude::UpHint;
use compass_core::base::ladder::height_rungs;
use compass_core::pose::{ScoredPose, FloorLayer};
use compass_core::pose::locate::{Effort, Fix, HeightPrior};
use compass_core::vision::shot::Shot;
use compass_core::pose::track::{Estimate, Track};
use compass_core::vision::sample::ExclusionMask;
use core::fmt;

/// Below an even chance the answer is "I don't know".
const LEAST_PROBABILITY: f32 = 0.5;

/// How a target runs a step: a board counts it.
pub trait Meter {
    /// Runs it.
    fn step<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T;
}

/// All that is kept from frame to frame, and the memory of the steps.
#[derive(Debug)]
pub struct Chain {
    eyes: Eyes,
    track: Track,
    last_ns: Option<i64>,
}

impl Chain {
    /// For a static; it takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self { eyes: Locator::new([0; crate::eyes::SCRATCH]), track: Track::new(), last_ns: None }
    }

    /// The pose of what the cameras took, and where the track has come to.
    ///
    /// # Errors
    /// [`Error`].
    pub fn run(
        &mut self,
        layers: &[FloorLayer<'_>],
        shot: &Shot<'_>,
        meter: &mut impl Meter,
    ) -> Result<Found, Error> {
        let header = shot.header();
        let rig = &header.rig;
        let frames = shot.images().map(|image| image.map(|(gray, red)| Frame { gray, red: ExclusionMask::Mask(red) }));
        let eyes = &mut self.eyes;
        for ((camera, frame), name) in frames.iter().enumerate().zip(["segments", "segments_back"]) {
            if let Some(frame) = frame {
                meter.step(name, || eyes.detect(rig, camera, frame))?;
            }
        }
        meter.step("attitude", || eyes.level(rig, UpHint::Up(header.up)))?;
        meter.step("windows", || eyes.look(rig, &frames))?;
        meter.step("ranges", || eyes.survey(rig, &frames))?;
        let room = HeightPrior { height: header.height_m.map(height_rungs), ceiling: None };
        let fix = meter.step("locate", || eyes.locate(layers, room, Effort::on_board(&room)))?;
        let passed_ns = self.last_ns.map_or(0, |last| header.time_ns.saturating_sub(last));
        let seconds = passed_ns as f32 * 1e-9;
        let track = &mut self.track;
        let estimate = meter.step("track", || eyes.track(track, layers, &fix, seconds, None))?;
        self.last_ns = Some(header.time_ns);
        Ok(Found { fix, estimate, height_m: header.height_m })
    }
}

impl Default for Chain {
    fn default() -> Self {
        Self::new()
    }
}

/// What was found; displayed, it is lines of names and values, and the bits of the pose.
#[derive(Debug, Clone)]
pub struct Found {
    fix: Fix,
    estimate: Option<Estimate>,
    height_m: Option<f32>,
}

impl Found {
    /// Whether the pose is more likely right than not.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.fix.probability() >= LEAST_PROBABILITY
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fix.answer.best() {
            Some(best) => {
                let height = self.height_m.unwrap_or_else(|| self.fix.height_m());
                let margin = self.fix.answer.margin().to_num::<f32>();
                let probability = self.fix.probability();
                write!(f, "pose {} layer {} camera {height:.2} m", Pose(best), best.layer)?;
                writeln!(f, " margin {margin:.1} nats probability {probability:.2}")?;
                writeln!(f, "bits {}", Bits(best))?;
            }
            None => f.write_str("pose none\n")?,
        }
        match &self.estimate {
            Some(Estimate { mode, probability, spread_m }) => {
                write!(f, "track {} probability {probability:.2} spread {spread_m:.2} m", Pose(mode))
            }
            None => f.write_str("track none"),
        }
    }
}

struct Pose<'a>(&'a ScoredPose);

impl fmt::Display for Pose<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ScoredPose { at, heading, .. } = self.0;
        let degrees = heading.to_microdegrees() as f32 * 1e-6;
        write!(f, "x {:.3} y {:.3} heading {degrees:.2}", at.x, at.y)
    }
}

struct Bits<'a>(&'a ScoredPose);

impl fmt::Display for Bits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ScoredPose { at, heading, score, .. } = self.0;
        let score = score.to_bits();
        write!(f, "{:016x} {:016x} {:08x} {score}", at.x.to_bits(), at.y.to_bits(), heading.to_bits())
    }
}
