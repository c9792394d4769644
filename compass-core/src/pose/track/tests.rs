use super::*;
use crate::base::scan::Scan;
use crate::pose::tests::{Building, evidence, point};
use std::boxed::Box;
use std::vec::Vec;

const ONWARDS: Motion = Motion { forward_m: 0.2, left_m: 0.0, turn: 0.0 };

fn pose(x: f64, y: f64, degrees: i64, score: i32) -> ScoredPose {
    ScoredPose {
        layer: 0,
        at: point(x, y),
        heading: Turn::from_ratio(degrees, 360),
        score: Nats::from_bits(score),
    }
}

/// Noisy evidence at a pose, and the pose refined in it.
fn seen(building: &Building, x: f64, y: f64, degrees: i64, seed: u32) -> (Box<EvidenceTable>, ScoredPose) {
    let layer = building.layer();
    let mut scan = Scan::OPEN;
    layer.plan.scan(point(x, y), Turn::from_ratio(degrees, 360), &mut scan).unwrap();
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let table = evidence(&scan, &mut random);
    let found = refine(&table, &layer, pose(x, y, degrees, 0));
    (table, found)
}

fn is_at(estimate: Option<Estimate>, pose: &ScoredPose) -> bool {
    let separation = Separation { distance: Metres::from_bits(3 << 30), turn: Turn::from_ratio(15, 360) };
    estimate.is_some_and(|e| separation.is_near(e.pose.place(), pose.place()))
}

/// A frame 0.5 s after the former one.
fn frame<'a>(table: &'a EvidenceTable, poses: &'a [ScoredPose], motion: Option<Motion>) -> Observation<'a> {
    Observation { table, poses, seconds: 0.5, motion }
}

#[test]
fn odometry_distinguishes_two_equal_poses() {
    let building = Building::new();
    let layers = [building.layer()];
    let mut track = Track::new();
    let first = [pose(1.5, 1.5, 0, 900), pose(9.0, 4.0, 90, 900)];
    let start = track.step(&layers, &frame(&EvidenceTable::EMPTY, &first, None)).unwrap();
    assert!((start.probability - 0.5).abs() < 0.01 && start.spread_m > 4.0, "{start:?}");
    // The first pose moved as the odometry says, the second sideways.
    let second = [pose(8.0, 4.0, 90, 900), pose(2.5, 1.5, 0, 900)];
    let motion = Some(Motion { forward_m: 1.0, ..Motion::default() });
    let end = track.step(&layers, &frame(&EvidenceTable::EMPTY, &second, motion));
    assert!(is_at(end, &second[1]), "{end:?}");
    assert!(end.unwrap().probability > 0.95 && end.unwrap().spread_m < 1.5, "{end:?}");
}

#[test]
fn three_wrong_frames_do_not_mislead_the_track() {
    let building = Building::new();
    let layers = [building.layer()];
    for motion in [None, Some(ONWARDS)] {
        let mut track = Track::new();
        for n in 0..8_u32 {
            let x = 6.0 + 0.2 * f64::from(n);
            let (table, truth) = seen(&building, x, 1.2, 0, n);
            // Frames 3 to 5 give one wrong pose each, at different positions, 50 nats above the true one.
            let wrong = pose(1.5 + f64::from(n % 3), 2.0, 120 * i64::from(n), truth.score.to_bits() + 800);
            let found = [if (3..6).contains(&n) { wrong } else { truth }];
            let estimate = track.step(&layers, &frame(&table, &found, motion));
            assert!(is_at(estimate, &pose(x, 1.2, 0, 0)), "frame {n}, {motion:?}: {estimate:?}");
        }
    }
}

#[test]
fn a_jump_is_followed() {
    let building = Building::new();
    let layers = [building.layer()];
    let mut track = Track::new();
    for n in 0..10_u32 {
        let x = 6.0 + 0.2 * f64::from(n);
        let (table, found) = seen(&building, x, 1.2, 0, n);
        track.step(&layers, &frame(&table, &[found], Some(ONWARDS)));
    }
    let estimates: Vec<_> = (0..3)
        .map(|n| {
            let (table, found) = seen(&building, 1.5 + 0.2 * f64::from(n), 5.0, 0, n);
            track.step(&layers, &frame(&table, &[found], Some(ONWARDS)))
        })
        .collect();
    assert!(is_at(estimates[2], &pose(1.9, 5.0, 0, 0)), "{estimates:?}");
}

#[test]
fn a_bank_is_bounded_and_repeatable() {
    let building = Building::new();
    let layers = [building.layer()];
    let run = || {
        let mut track = Track::new();
        for n in 0..3_u32 {
            let (table, _) = seen(&building, 6.0, 1.2, 0, n);
            let grid =
                (0..300).map(|k| pose(0.5 + 0.5 * f64::from(k % 20), 0.5 + 0.5 * f64::from(k / 20), 0, k));
            let poses: Vec<_> = grid.collect();
            track.step(&layers, &frame(&table, &poses, None));
        }
        track.hypotheses().collect::<Vec<_>>()
    };
    let hypotheses = run();
    assert!(hypotheses.len() <= MAX_HYPOTHESES);
    let whole: f32 = hypotheses.iter().map(|h| h.1).sum();
    assert!((whole - 1.0).abs() < 0.1, "{whole}");
    assert_eq!(hypotheses, run());
    assert!(size_of::<Track>() < 8192, "{}", size_of::<Track>());
}

#[test]
fn values_that_are_not_finite_do_not_panic() {
    let building = Building::new();
    let layers = [building.layer()];
    let mut track = Track::new();
    assert_eq!(track.step(&layers, &frame(&EvidenceTable::EMPTY, &[], None)), None);
    let poses = [
        pose(1.5, 1.5, 0, i32::MAX),
        pose(3.0, 1.5, 0, i32::MIN),
        ScoredPose { layer: 9, ..pose(0.0, 0.0, 0, 0) },
        ScoredPose { at: Point::new(Metres::MAX, Metres::MIN), ..pose(0.0, 0.0, 0, 0) },
    ];
    for value in [f32::NAN, f32::INFINITY, f32::MIN, 1e30, -1.0] {
        let motion = Motion { forward_m: value, left_m: value, turn: value };
        for motion in [Some(motion), None] {
            let frame = Observation { table: &EvidenceTable::EMPTY, poses: &poses, seconds: value, motion };
            assert!(track.step(&layers, &frame).is_some_and(|e| e.probability > 0.0));
        }
    }
    assert_eq!(turn_of(-PI / 2.0).distance(Turn::from_ratio(-90, 360)).to_microdegrees() / 100, 0);
}
