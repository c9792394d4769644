//! From the sample's frames to a pose and a track, by the core's pipeline: the checksum of each stage's result.

use crate::{Inputs, Report, WORDS, checksum, frames, prior};
use compass_core::base::num::Metres;
use compass_core::locator::{Locator, Picture, Stage, Trace};
use compass_core::pose::track::{Estimate, Motion, Track};
use compass_core::pose::{Fix, ScoredPose};
use compass_core::vision::attitude::Vertical;
use compass_core::vision::boundary::BoundaryEvidence;
use compass_core::vision::segments::Segment;
use compass_core::vision::windows::{Window, WindowEvidence};

/// A locator of one layer.
pub(crate) type SampleLocator<'a, 'm, T> = Locator<'a, &'m mut [u32], T, 1>;

/// Bytes of RAM on the way from frames to a pose, beside the stack.
pub const POSE_RAM: usize = size_of::<[u32; WORDS]>();

/// The stages of the pipeline.
pub const POSE_STAGES: [&str; 6] = ["segments", "segments_back", "attitude", "windows", "ranges", "locate"];

/// The state and memory of the pipeline.
#[derive(Debug)]
pub(crate) struct Memory {
    words: [u32; WORDS],
    track: Track,
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Self { words: [0; WORDS], track: Track::new() }
    }
}

/// Locates the frames, and adds them twice to a track: a fifth of a second and a few centimetres apart by odometry.
#[inline(never)]
pub(crate) fn run(inputs: &Inputs<'_>, memory: &mut Memory, report: &mut impl Report) {
    let mut locator = inputs.locator(&mut memory.words, Checks { report, tracked: 0 });
    let prior = prior();
    let segmented = locator.segment(&frames()).expect("the frames are those of the rig");
    let mut seen = segmented.level_near(prior.up).expect("there are upright lines").see();
    let fix = seen.locate(prior.heights);
    let track = &mut memory.track;
    *track = Track::new();
    let moved = Motion { forward_m: 0.03, left_m: -0.01, turn: 0.02 };
    let _ = seen.track(track, &fix, 0.0, None);
    let _estimate = seen.track(track, &fix, 0.2, Some(moved));
}

/// Reports stages with the checksums of their results.
#[derive(Debug)]
struct Checks<'r, R> {
    report: &'r mut R,
    /// Number of frames added to the track.
    tracked: usize,
}

impl<R: Report> Checks<'_, R> {
    const fn name(&self, stage: Stage) -> &'static str {
        match stage {
            Stage::Up => "attitude",
            Stage::Track if self.tracked == 0 => "track_first",
            _ => stage.name(),
        }
    }
}

impl<R: Report> Trace for Checks<'_, R> {
    fn begin(&mut self, stage: Stage) {
        self.report.begin(self.name(stage));
    }

    #[inline(never)]
    fn end(&mut self, stage: Stage, picture: Picture<'_>) {
        let name = self.name(stage);
        self.report.end(name);
        self.report.check(name, sum(picture));
        self.tracked += usize::from(stage == Stage::Track);
    }
}

/// The checksum of every bit of a stage's result.
#[inline(never)]
fn sum(picture: Picture<'_>) -> u32 {
    match picture {
        Picture::Segments(segments) => checksum(segment_words(segments)),
        Picture::Up(vertical) => checksum(up_words(vertical)),
        Picture::Windows { windows, evidence, .. } => checksum(window_words(windows, evidence)),
        Picture::Boundaries(evidence) => checksum(boundary_words(evidence)),
        Picture::Fix(fix) => checksum(fix_words(fix)),
        Picture::Estimate(estimate) => checksum(estimate_words(estimate)),
        _ => 0,
    }
}

fn segment_words(segments: &[Segment]) -> impl Iterator<Item = u32> + '_ {
    segments.iter().flat_map(|s| [s.x1.to_bits(), s.y1.to_bits(), s.x2.to_bits(), s.y2.to_bits(), s.score])
}

/// The up vector and its inliers.
fn up_words(vertical: Option<&Vertical>) -> impl Iterator<Item = u32> + '_ {
    vertical.into_iter().flat_map(|v| {
        let [front, back] = v.inliers.map(u32::from);
        [v.up.x.to_bits(), v.up.y.to_bits(), v.up.z.to_bits(), front, back]
    })
}

/// The windows, and the evidence of each bin.
fn window_words<'a>(windows: &'a [Window], evidence: &'a WindowEvidence) -> impl Iterator<Item = u32> + 'a {
    let windows = windows.iter().flat_map(|w| {
        let [[left, right], [top, bottom]] = [w.columns, w.rows].map(|pair| pair.map(u32::from));
        [left, right, top, bottom, w.score.to_bits() as u32, w.camera.into()]
    });
    let bins = evidence.hit.iter().zip(evidence.confidence.sixteenths()).zip(&evidence.evidence);
    let bins = bins.flat_map(|((hit, confidence), evidence)| {
        [*hit as u32, u32::from(*confidence), evidence.to_bits() as u32]
    });
    windows.chain(bins).chain(evidence.upright_edges.iter().copied().map(u32::from))
}

fn boundary_words<'a>(evidence: &'a BoundaryEvidence<'_>) -> impl Iterator<Item = u32> + 'a {
    evidence.cells().iter().map(|cell| cell.to_bits() as u32)
}

/// All poses with their scores, their covariances, and the heights.
fn fix_words<'a>(fix: &'a Fix<'_>) -> impl Iterator<Item = u32> + 'a {
    let heights = fix.heights().to_rungs().map(|rungs| rungs as u32);
    let covariances = fix.covariances().iter().flat_map(|covariance| covariance.rows());
    let covariances = covariances.flatten().map(f32::to_bits);
    fix.poses().iter().flat_map(pose_words).chain(covariances).chain(heights)
}

/// The likeliest pose, its probability and the spread.
fn estimate_words(estimate: Option<&Estimate>) -> impl Iterator<Item = u32> + '_ {
    estimate.into_iter().flat_map(|estimate| {
        let numbers = [estimate.probability, estimate.spread_m].map(f32::to_bits);
        pose_words(&estimate.pose).into_iter().chain(numbers)
    })
}

fn pose_words(pose: &ScoredPose) -> [u32; 6] {
    let [x, y] = [pose.at.x, pose.at.y].map(Metres::to_bits);
    [
        x as u32,
        (x >> 32) as u32,
        y as u32,
        (y >> 32) as u32,
        pose.heading.to_bits(),
        pose.score.to_bits() as u32,
    ]
}
