//! The locators and searches of one thread.

use super::error::Result;
use super::evidence_file::Evidence;
use super::job::Job;
use super::oracle;
use super::paper::Paper;
use super::record::{Found, PAPER, Record};
use crate::clock::Clock;
use crate::dataset::recording::{Shot, Source};
use crate::dual_image::{self, Halves};
use crate::frame::Frame;
use crate::locator::{Locator, NoPlan, SeeError, see};
use crate::site;
use crate::up::{UpFrom, UpSources};
use crate::up_by_plan::{Tried, best};
use compass_core::base::confidence::Confidence;
use compass_core::base::ladder::NOMINAL_HEIGHT_M;
use compass_core::base::num::{BINS, Nats};
use compass_core::base::scan::Scan;
use compass_core::vision::boundary::RangeLikelihoods;
use compass_core::vision::visual_scan;
use compass_core::{HeightPrior, Settings};
use std::collections::BTreeMap;

/// The evidence of a frame with an up vector in cam0.
#[derive(Debug)]
struct Look {
    evidence: Evidence,
    up: [f32; 3],
}

/// The frames of an instant.
struct Instant {
    /// Index of the locator for their sizes.
    locator: usize,
    frames: [Option<Frame>; 2],
    /// How both lenses lay in one image, if they did.
    halves: Option<Halves>,
}

/// Sizes of the frames of the two cameras.
type Sizes = [Option<(u32, u32)>; 2];

/// Locators with all their memory, reused from frame to frame.
pub struct Worker<'a> {
    job: &'a Job<'a>,
    /// Observes: one locator for each combination of frame sizes that occurred.
    locators: Vec<(Sizes, Locator<'static>)>,
    /// Searches the evidence.
    search: Locator<'a>,
    paper: Paper,
}

impl std::fmt::Debug for Worker<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Worker").field("job", &self.job).finish_non_exhaustive()
    }
}

impl<'a> Worker<'a> {
    /// Allocates the buffers for the whole job.
    ///
    /// # Errors
    /// [`NoPlan`] if a floor has no plan to refine poses on.
    pub fn new(job: &'a Job<'a>) -> Result<Self, NoPlan> {
        let search = Locator::without_rig(job.floors, Settings::FULL)?;
        Ok(Self { job, locators: Vec::new(), search, paper: Paper::default() })
    }

    /// Localizes a frame by every method and stores its evidence. Images that cannot be read are the frame's problem.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn record(&mut self, shot: &Shot) -> Result<Record> {
        let mut clock = Clock::start();
        let read = self.read(shot);
        clock.stage("read");
        let mut record = Record {
            timestamp_ns: shot.timestamp_ns,
            fingerprint: String::new(),
            problem: None,
            is_unreadable: false,
            halves: None,
            up: None,
            up_from: UpFrom::Image,
            height: 0,
            ceiling: 0,
            height_m: self.job.heights.camera_m().unwrap_or(NOMINAL_HEIGHT_M),
            single: Vec::new(),
            rival: None,
            covariance: None,
            oracle: Vec::new(),
            evidence: None,
            paper: [None; PAPER.len()],
            milliseconds: BTreeMap::new(),
        };
        let up =
            UpSources { from: UpFrom::Both, mount: self.job.mount, imu: self.job.gravity(shot.timestamp_ns) };
        match read {
            Ok(Instant { locator, frames, halves }) => {
                record.halves = halves.map(|halves| halves.note().to_owned());
                let frames = frames.each_ref().map(Option::as_ref);
                match self.see(locator, frames, &up, &mut clock) {
                    Ok((looks, up_from)) => {
                        record.up_from = up_from;
                        self.search(looks, &mut record, &mut clock)?;
                    }
                    Err(problem) => record.problem = Some(problem.to_string()),
                }
            }
            Err(problem) => (record.problem, record.is_unreadable) = (Some(problem), true),
        }
        self.oracle(&mut record, &mut clock);
        record.milliseconds = clock.stages().iter().map(|(stage, ms)| ((*stage).to_owned(), *ms)).collect();
        Ok(record)
    }

    /// The frames of an instant, or what is wrong with them.
    fn read(&mut self, shot: &Shot) -> Result<Instant, String> {
        let read = |camera: usize| shot.images[camera].as_ref().map(Source::read).transpose();
        let frames = [read(0).map_err(|e| e.to_string())?, read(1).map_err(|e| e.to_string())?];
        let (frames, halves) = dual_image::split(self.job.calibration, frames);
        let sizes = frames.each_ref().map(|frame| frame.as_ref().map(|f| (f.width(), f.height())));
        let known = self.locators.iter().position(|(known, _)| *known == sizes);
        let locator = match known {
            Some(known) => known,
            None => {
                let rig = self.job.calibration.rig(sizes).map_err(|error| {
                    let names: Vec<_> = shot.images.iter().flatten().map(Source::name).collect();
                    format!("{}: {error}", names.join(", "))
                })?;
                self.locators.push((sizes, Locator::without_site(rig, Settings::FULL)));
                self.locators.len() - 1
            }
        };
        Ok(Instant { locator, frames, halves })
    }

    /// The evidence of the frames with each up vector that may be right, and the source of those; or why there is none.
    fn see(
        &mut self,
        locator: usize,
        frames: [Option<&Frame>; 2],
        up: &UpSources,
        clock: &mut Clock,
    ) -> Result<(Vec<Look>, UpFrom), SeeError> {
        let locator = &mut self.locators[locator].1;
        let mut observe = || {
            let mut segmented = locator.segment(frames)?;
            let (candidates, from) = up.candidates(&mut segmented)?;
            let looks = candidates.iter().filter_map(|up| {
                let levelled = segmented.by_ref().level(up).ok()?;
                let up = levelled.frame().up();
                let evidence = Evidence::of(&mut see(levelled));
                Some(Look { evidence, up: [up.x, up.y, up.z] })
            });
            let looks: Vec<Look> = looks.collect();
            if looks.is_empty() { Err(SeeError::Up) } else { Ok((looks, from)) }
        };
        let seen = observe();
        clock.extend(locator.watch().milliseconds());
        seen
    }

    /// The pose search, in which the plan decides which way is up, and the paper's matching.
    fn search(&mut self, looks: Vec<Look>, record: &mut Record, clock: &mut Clock) -> Result<()> {
        let known = self.job.heights;
        let tried = looks.into_iter().map(|look| {
            let fix = self.search.recall(&look.evidence.boundaries(), &look.evidence.windows()).locate(known);
            Tried { with: look, fix }
        });
        let Some((Look { evidence, up, .. }, fix)) = best(tried.collect()) else { return Ok(()) };
        clock.stage("locate");
        record.up = Some(up);
        record.rival = fix.rival().map(Nats::to_bits);
        record.covariance = fix.covariance().map(|covariance| covariance.rows());
        record.height_m = fix.camera_height_m();
        // A score of 0 carries no information.
        record.single = fix.poses().iter().map(Found::from).filter(|found| found.score > 0).collect();
        [record.height, record.ceiling] = fix.heights().to_rungs();
        record.evidence = Some(evidence.write(&self.job.evidence_file(record.timestamp_ns))?);
        clock.stage("write");
        let windows = evidence.windows();
        let mut seen = self.search.recall(&evidence.boundaries(), &windows);
        let mut ranges = Box::new(RangeLikelihoods::EMPTY);
        seen.range_likelihoods(HeightPrior::both(fix.heights()), &mut ranges);
        let (scan, confidence) = visual_scan::scan(&ranges, record.height, &windows);
        record.paper = self.paper(&scan, &confidence);
        clock.stage("paper");
        Ok(())
    }

    /// The best candidate by the cosine of descriptors in each way, on layer 0 of each floor.
    fn paper(&mut self, scan: &Scan, confidence: &Confidence) -> [Option<Found>; PAPER.len()] {
        let mut best: [Option<Found>; PAPER.len()] = [None; PAPER.len()];
        for (number, layer) in (0..).zip(self.search.layers()).filter(|(_, layer)| layer.number == 0) {
            for (best, found) in best.iter_mut().zip(self.paper.best(&layer.map, scan, confidence)) {
                let Some(found) = found else { continue };
                let Some(at) = layer.map.position(found.candidate as usize) else { continue };
                let score = found.peak.score_bits;
                if best.is_none_or(|best| score > best.score) {
                    let (x, y, heading) = (at.x.to_bits(), at.y.to_bits(), found.heading().to_bits());
                    *best = Some(Found { layer: number, x, y, heading, score });
                }
            }
        }
        best
    }

    /// The search on evidence computed from the plan at the true pose, if that is known and free.
    fn oracle(&mut self, record: &mut Record, clock: &mut Clock) {
        let Some(truth) = self.job.truth.at(record.timestamp_ns) else { return };
        clock.restart();
        let plan = self.job.floors.get(self.job.floor).and_then(|floor| floor.floor?.plan(0));
        let at = site::point(truth.position.x, truth.position.y);
        let mut scan = Scan { steps: [0; BINS], ..Scan::OPEN };
        if let Some((plan, at)) = plan.zip(at)
            && plan.scan(at, site::turn(truth.heading_deg()), &mut scan).is_ok()
        {
            let perfect = oracle::perfect(&scan);
            let mut seen = self.search.recall(&perfect.boundaries(), &perfect.windows());
            record.oracle = Found::all(seen.locate(HeightPrior::camera(NOMINAL_HEIGHT_M)).poses());
        }
        clock.stage("oracle");
    }
}
