//! The track of a recording, and the trajectories to write.

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
use compass_core::base::num::Nats;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::heights::{HeightMemory, Heights};
use compass_core::pose::track::{Estimate, Observation, Track};
use compass_core::pose::{SURE as SURE_FRAME, ScoredPose};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::time::Instant;

/// The result of tracking a sequence.
#[derive(Debug)]
pub struct Followed {
    /// The estimate after each record; `None` before the first evidence.
    pub estimates: Vec<Option<Estimate>>,
    /// Mean time of a step, milliseconds.
    pub milliseconds: f64,
    /// The observed state of the walls of the ground-truth floor, from frames at which the track was certain.
    pub walls: Walls,
}

/// The track counts as certain from this probability on.
pub const SURE: f32 = 0.9;

/// Tracks the records in order of time, with their stored evidence. A frame without evidence moves the estimate by
/// odometry, or leaves it.
///
/// The carrier keeps the camera height, and a floor its ceiling height: a frame that is uncertain and found other
/// heights than the certain ones before it is searched again with [the remembered heights](HeightMemory), and the
/// result with the larger lead counts.
///
/// # Errors
/// Names an evidence file that cannot be read.
pub fn follow(
    job: &Job<'_>,
    records: &[Record],
    locator: &mut Locator<'_>,
    odometry: Option<&Trajectory>,
    progress: &dyn Progress,
) -> Result<Followed> {
    let mut track = Track::new();
    let (mut before, mut memory): (Option<u64>, HeightMemory) = (None, HeightMemory::new());
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
                let nothing = Observation { table: &nothing, poses: &[], seconds: seconds_since, motion };
                estimates.push(track.step(locator.layers(), &nothing));
                before = Some(record.timestamp_ns);
            } else {
                estimates.push(track.estimate(locator.layers()));
            }
            continue;
        }
        let evidence = Evidence::read(&job.evidence_file(record.timestamp_ns))?;
        let started = Instant::now();
        let (poses, heights) = explain(record, &evidence, &mut memory, locator);
        let mut seen = locator.recall(&evidence.boundaries(), &evidence.windows());
        let estimate = seen.with_evidence(heights, |table, layers| {
            let observation = Observation { table, poses: &poses, seconds: seconds_since, motion };
            let estimate = track.step(layers, &observation);
            seconds += started.elapsed().as_secs_f64();
            let judge = Judge { layers, floor: job.floor };
            let on_floor = |pose: &ScoredPose| judge.is_on_floor(&Found::from(pose));
            let sure = estimate.filter(|e| e.probability >= SURE && on_floor(&e.pose));
            if let Some((plan, sure)) = plan.zip(sure) {
                walls.add(&plan, &sure.pose, table);
            }
            estimate
        });
        let estimate = estimate.flatten();
        estimates.push(estimate);
        steps += 1;
        before = Some(record.timestamp_ns);
    }
    Ok(Followed { estimates, milliseconds: 1e3 * seconds / f64::from(steps.max(1)), walls })
}

/// The poses that explain a frame, searched with the remembered heights where that gives the larger lead; and the
/// heights.
fn explain(
    record: &Record,
    evidence: &Evidence,
    memory: &mut HeightMemory,
    locator: &mut Locator<'_>,
) -> (Vec<ScoredPose>, Heights) {
    let heights = Heights::from_rungs([record.height, record.ceiling]);
    let margin = Nats::from_num(record.margin());
    if record.probability() >= SURE_FRAME {
        memory.learn(heights);
    } else if !memory.is_like(heights) {
        let fix = locator.recall(&evidence.boundaries(), &evidence.windows()).locate(memory.prior());
        if fix.margin() > margin {
            return (fix.poses().to_vec(), fix.heights());
        }
    }
    (record.single.iter().map(ScoredPose::from).collect(), heights)
}

/// The full orientation of a pose of cam0: z is its height above the floor, and roll and pitch come from the frame's
/// up vector.
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
        let scored = ScoredPose {
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
            is_unreadable: false,
            halves: None,
            up: Some(up),
            up_from: crate::up::UpFrom::Image,
            height_m: 1.4,
            height: -1,
            ceiling: 0,
            single: Vec::new(),
            rival: None,
            covariance: None,
            oracle: Vec::new(),
            evidence: None,
            paper: [None; crate::evaluate::PAPER.len()],
            milliseconds: std::collections::BTreeMap::new(),
        };
        let back = pose(&record, &Found::from(&scored));
        assert!((back.position - truth.position).amax() < 1e-6);
        assert!(back.rotation.angle_to(&truth.rotation) < 1e-5, "{back:?}");
    }
}
