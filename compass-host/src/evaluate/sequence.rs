//! The track of a recording, and trajectories to write.

use super::error::Result;
use super::evidence_file::Evidence;
use super::job::Job;
use super::record::{Found, Record};
use super::row::Judge;
use crate::dataset::trajectory::Trajectory;
use crate::dataset::tum::Pose;
use crate::locator::Locator;
use crate::progress::Progress;
use crate::wall_check::Walls;
use compass_core::pose::ScoredPose;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::heights::HeightMemory;
use compass_core::pose::locate::SURE_NATS;
use compass_core::pose::track::{Estimate, Frame, Track};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::time::Instant;

/// What a sequence came to.
#[derive(Debug)]
pub struct Followed {
    /// After each record; `None` before anything was seen.
    pub estimates: Vec<Option<Estimate>>,
    /// Mean time of a step, milliseconds.
    pub milliseconds: f64,
    /// What was seen of the walls of the floor that the truth lies on, where the track was sure.
    pub walls: Walls,
}

/// From this probability on the track is sure.
pub const SURE: f32 = 0.9;

/// Follows the records in the order of time, with the evidence that was kept of them. Where nothing was seen the
/// estimate goes on by odometry, or stays.
///
/// Whoever carries the cameras keeps their height, and a floor its ceiling: a frame that is not sure and found other
/// heights than the sure ones before it is searched anew with [theirs](HeightMemory), and the answer that leads by more counts.
///
/// # Errors
/// Names a file of evidence that cannot be read.
pub fn follow(
    job: &Job<'_>,
    records: &[Record],
    locator: &mut Locator<'_>,
    odometry: Option<&Trajectory>,
    progress: &dyn Progress,
) -> Result<Followed> {
    let mut track = Track::new();
    let (mut before, mut usual): (Option<u64>, HeightMemory) = (None, HeightMemory::new());
    let (nothing, mut walls) = (Box::new(EvidenceTable::EMPTY), Walls::default());
    let plan = job.floors.get(job.floor).and_then(|floor| floor.floor?.plan(0));
    let (mut estimates, mut seconds, mut steps) = (Vec::with_capacity(records.len()), 0.0, 0);
    let steps_done = progress.begin(records.len(), "following");
    for record in records {
        steps_done.step();
        let seconds_since = before.map_or(0.0, |before| (record.timestamp_ns - before) as f32 / 1e9);
        let motion = before.zip(odometry).and_then(|(before, way)| way.motion(before, record.timestamp_ns));
        if record.problem.is_some() {
            if motion.is_some() {
                let frame = Frame { table: &nothing, modes: &[], seconds: seconds_since, motion };
                estimates.push(track.step(locator.layers(), &frame));
                before = Some(record.timestamp_ns);
            } else {
                estimates.push(track.estimate(locator.layers()));
            }
            continue;
        }
        let evidence = Evidence::read(&job.evidence_file(record.timestamp_ns))?;
        let started = Instant::now();
        let modes = explain(record, &evidence, &mut usual, locator);
        let frame = Frame { table: locator.table(), modes: &modes, seconds: seconds_since, motion };
        let estimate = track.step(locator.layers(), &frame);
        seconds += started.elapsed().as_secs_f64();
        let judge = Judge { layers: locator.layers(), floor: job.floor };
        let on_floor = |mode: &ScoredPose| judge.is_on_floor(&Found::from(mode));
        if let Some((plan, sure)) = plan.zip(estimate.filter(|e| e.probability >= SURE && on_floor(&e.mode)))
        {
            walls.add(&plan, &sure.mode, locator.table());
        }
        estimates.push(estimate);
        steps += 1;
        before = Some(record.timestamp_ns);
    }
    Ok(Followed { estimates, milliseconds: 1e3 * seconds / f64::from(steps.max(1)), walls })
}

/// The poses that explain a frame with the usual heights; the locator's table has its evidence.
fn explain(
    record: &Record,
    evidence: &Evidence,
    usual: &mut HeightMemory,
    locator: &mut Locator<'_>,
) -> Vec<ScoredPose> {
    let is_sure = record.margin() >= f64::from(SURE_NATS);
    if is_sure {
        usual.learn(record.height, record.ceiling);
    }
    let (survey, sighting) = (evidence.survey(), evidence.sighting());
    if !is_sure && !usual.is_like(record.height, record.ceiling) {
        let fix = locator.locate(&survey, usual.room(), &sighting);
        if fix.answer.margin().to_num::<f64>() > record.margin() {
            locator.weigh(&survey, [fix.height, fix.ceiling], &sighting);
            return fix.answer.modes().to_vec();
        }
    }
    locator.weigh(&survey, [record.height, record.ceiling], &sighting);
    record.single.iter().map(ScoredPose::from).collect()
}

/// A pose of cam0 with all its axes: z is its height above the floor, and the frame tells which way is up.
#[must_use]
pub fn pose(record: &Record, found: &Found) -> Pose {
    let [x, y] = found.position();
    let up = record.up.map_or(-Vector3::y(), |up| Vector3::from(up).cast::<f64>());
    let heading = found.heading_deg().to_radians();
    let (sin, cos) = (libm::sin(heading), libm::cos(heading));
    // Level axes in the camera and in the map: forward, left, up.
    let forward = (Vector3::z() - up * up.z).normalize();
    let camera = Matrix3::from_columns(&[forward, up.cross(&forward), up]);
    let map = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let rotation = Rotation3::from_matrix_unchecked(map * camera.transpose());
    Pose {
        timestamp_ns: record.timestamp_ns,
        position: Vector3::new(x, y, f64::from(record.height_m)),
        rotation: UnitQuaternion::from_rotation_matrix(&rotation),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::{point, turn};
    use compass_core::base::num::Nats;

    #[test]
    fn a_pose_has_its_heading_and_its_up() {
        let truth = Pose::looking(7, [3.0, -2.0, 1.4], 130.0, 20.0, 175.0);
        let mode = ScoredPose {
            layer: 0,
            at: point(3.0, -2.0).unwrap(),
            heading: turn(truth.heading_deg()),
            score: Nats::DELTA,
        };
        let up: [f32; 3] = truth.up_in_camera().cast::<f32>().into();
        let record = Record {
            timestamp_ns: 7,
            fingerprint: String::new(),
            problem: None,
            up: Some(up),
            up_from: crate::up::UpFrom::Image,
            height_m: 1.4,
            height: -1,
            ceiling: 0,
            single: Vec::new(),
            oracle: Vec::new(),
            paper: [None; crate::evaluate::PAPER.len()],
            milliseconds: std::collections::BTreeMap::new(),
        };
        let back = pose(&record, &Found::from(&mode));
        assert!((back.position - truth.position).amax() < 1e-6);
        assert!(back.rotation.angle_to(&truth.rotation) < 1e-5, "{back:?}");
    }
}
