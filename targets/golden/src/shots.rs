//! Localizes packed frames: pose and track, as lines for comparison between targets.

use crate::WORDS;
use compass_core::base::num::Metres;
use compass_core::locator::{Error, Frame, Locator, Settings, Trace};
use compass_core::map::site::Site;
use compass_core::pose::heights::HeightPrior;
use compass_core::pose::track::{Estimate, Track};
use compass_core::pose::{Fix, ScoredPose};
use compass_core::vision::attitude::UpHint;
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::shot::Shot;
use core::fmt;

/// Below this probability the answer is "I don't know".
const LEAST_PROBABILITY: f32 = 0.5;

/// The state kept from frame to frame, and the memory of the stages.
#[derive(Debug)]
pub struct Shots {
    words: [u32; WORDS],
    track: Track,
    last_ns: Option<i64>,
}

impl Shots {
    /// For use in a static; it takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self { words: [0; WORDS], track: Track::new(), last_ns: None }
    }

    /// The pose of a pair of frames, and the updated track.
    ///
    /// # Errors
    /// [`Error`].
    pub fn locate<'a>(
        &mut self,
        site: &Site<'a>,
        shot: &Shot<'_>,
        trace: &mut impl Trace,
    ) -> Result<Located<'a>, Error> {
        let header = shot.header();
        let mut locator =
            Locator::<_, _, 16>::traced(header.rig, Settings::BOARD, &mut self.words[..], trace)?;
        locator.add_site(site)?;
        let frames = shot
            .images()
            .map(|image| image.map(|(gray, red)| Frame { gray, excluded: ExclusionMask::Mask(red) }));
        let heights = header.height_m.map_or(HeightPrior::UNKNOWN, HeightPrior::camera);
        let mut seen = locator.segment(&frames)?.level_near(UpHint::Up(header.up))?.see();
        let fix = seen.locate(heights);
        let passed_ns = self.last_ns.map_or(0, |last| header.time_ns.saturating_sub(last));
        let estimate = seen.track(&mut self.track, &fix, passed_ns as f32 * 1e-9, None);
        self.last_ns = Some(header.time_ns);
        Ok(Located { fix, estimate })
    }
}

impl Default for Shots {
    fn default() -> Self {
        Self::new()
    }
}

/// The result; it displays as lines of names and values, and the bits of the pose.
#[derive(Debug, Clone)]
pub struct Located<'a> {
    fix: Fix<'a>,
    estimate: Option<Estimate>,
}

impl Located<'_> {
    /// Whether the pose is more likely right than wrong.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.fix.probability() >= LEAST_PROBABILITY
    }
}

impl fmt::Display for Located<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { fix, estimate } = self;
        match fix.best() {
            Some(best) => {
                let (height, margin) = (fix.camera_height_m(), fix.margin().to_num::<f32>());
                write!(f, "pose {} layer {} camera {height:.2} m", Pose(best), best.layer)?;
                writeln!(f, " margin {margin:.1} nats probability {:.2}", fix.probability())?;
                writeln!(f, "bits {}", Bits(best))?;
            }
            None => f.write_str("pose none\n")?,
        }
        match estimate {
            Some(Estimate { pose, probability, spread_m }) => {
                write!(f, "track {} probability {probability:.2} spread {spread_m:.2} m", Pose(pose))
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
        let [x, y] = [at.x, at.y].map(Metres::to_bits);
        write!(f, "{x:016x} {y:016x} {:08x} {}", heading.to_bits(), score.to_bits())
    }
}
