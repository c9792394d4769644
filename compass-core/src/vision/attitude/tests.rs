use super::*;
use crate::vision::camera::{Bearing, Camera, Equidistant, Intrinsics, Rig, View};
use crate::vision::level_frame::LevelFrame;
use crate::vision::segments::Segment;
use proptest::prelude::*;
use std::vec::Vec;

fn rig() -> Rig {
    let camera = Camera::Equidistant(
        Equidistant::new(Intrinsics { fx: 400.0, fy: 400.0, cx: 640.0, cy: 620.0 }).unwrap(),
    );
    let view = View::new(camera, 1280, 1240);
    Rig::back_to_back(view, view).unwrap()
}

/// A synthetic scene: arcs of vertical lines, of horizontal ones along two axes turned by `axis_deg`, and random ones.
fn scene(up: Bearing, axis_deg: f32, jitter: f32) -> Vec<Arc> {
    let level = LevelFrame::new(&up).unwrap();
    let rig = rig();
    let mut state = 7_u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let mut arcs = Vec::new();
    let mut add = |a: Bearing, b: Bearing, random: &mut dyn FnMut() -> f32| {
        for (number, view) in rig.views() {
            let [p, q] = [a, b].map(|b| view.camera.project(&view.rotation.tr_mul(&b)));
            if let (Some(p), Some(q)) = (p, q) {
                let mut off = || jitter * random();
                let s =
                    Segment { x1: p.x + off(), y1: p.y + off(), x2: q.x + off(), y2: q.y + off(), score: 9 };
                arcs.extend(Arc::new(&s, view, number as u32));
            }
        }
    };
    for k in 0..40 {
        let azimuth = k as f32 * 0.157;
        add(level.bearing(azimuth, -0.2), level.bearing(azimuth, 0.15 + 0.1 * random()), &mut random);
        let (turn, side) =
            (axis_deg.to_radians() + (k % 2) as f32 * core::f32::consts::FRAC_PI_2, random() * 4.0);
        let point = |along: f32| {
            let (x, y) = (along * turn.cos() - side * turn.sin(), along * turn.sin() + side * turn.cos());
            level.bearing(y.atan2(x), (1.2 / x.hypot(y)).atan() * if k % 3 == 0 { 1.0 } else { -1.0 })
        };
        add(point(1.0), point(2.0), &mut random);
        let (a, e) = (random() * 6.0, random());
        add(level.bearing(a, e), level.bearing(a + random() * 0.4, e + random() * 0.4), &mut random);
    }
    arcs
}

fn between(a: &Bearing, b: &Bearing) -> f32 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

proptest! {
    #[test]
    fn finds_up_at_any_tilt_to_45_degrees(tilt in 0.0_f32..45.0, way in 0.0_f32..6.3, upside_down: bool, axis in 0.0_f32..90.0) {
        let mount = if upside_down { Bearing::new(0.0, 1.0, 0.0) } else { Bearing::new(0.0, -1.0, 0.0) };
        let lean = Bearing::new(way.cos(), 0.0, way.sin()) * tilt.to_radians().sin();
        let up = mount * tilt.to_radians().cos() + lean;
        let arcs = scene(up, axis, 0.6);
        let found = vertical(&arcs, UpHint::Up(mount), &Parameters::default()).unwrap();
        prop_assert!(between(&found.up, &up) < 0.3, "{:?} {:?}", found, up);
        prop_assert!(found.inliers.iter().sum::<u16>() >= 30);
        let axes = building_axes(&arcs, &LevelFrame::new(&found.up).unwrap()).unwrap();
        let off = (axes.azimuth_deg - axis + 45.0).rem_euclid(90.0) - 45.0;
        prop_assert!(off.abs() < 1.0, "{:?} {}", axes, axis);
    }
}

#[test]
fn other_verticals_follow_the_vertical_and_keep_their_distance() {
    let lean =
        |degrees: f32| Bearing::new(degrees.to_radians().sin(), -degrees.to_radians().cos(), 0.1).normalize();
    let ups = [lean(5.0), lean(-40.0)];
    let arcs: Vec<_> = ups.into_iter().flat_map(|up| scene(up, 30.0, 0.6)).collect();
    let axis = UpHint::Axis(Bearing::new(0.0, -1.0, 0.0));
    let found = verticals(&arcs, axis, &Parameters::default());
    assert_eq!(found.first().copied(), vertical(&arcs, axis, &Parameters::default()));
    assert_eq!(found.len(), MOST_VERTICALS, "{found:?}");
    for (k, one) in found.iter().enumerate() {
        assert!(one.inliers.iter().sum::<u16>() >= LEAST_INLIERS && one.runner_up > 0.0, "{one:?}");
        for other in &found[..k] {
            let apart = between(&one.up, &other.up);
            assert!((30.0..=150.0).contains(&apart), "{apart} degrees: {one:?} {other:?}");
        }
    }
    let rank = |one: &Vertical| one.support * axis.prior(&one.up);
    assert!(found.is_sorted_by(|a, b| rank(a) >= rank(b)), "{found:?}");
    // The third is a level axis.
    assert!(found.iter().zip(&ups).all(|(found, up)| between(&found.up, up) < 1.0), "{found:?}");
    assert!(verticals(&[], axis, &Parameters::default()).is_empty());
}

#[test]
fn a_known_mounting_excludes_verticals_far_from_it() {
    let mount = Bearing::new(0.0, -1.0, 0.0);
    let arcs = scene(mount, 30.0, 0.6);
    let found = verticals(&arcs, UpHint::Up(mount), &Parameters::default());
    assert_eq!(found.len(), 1, "the building's other axes are level: {found:?}");
    // What leans by 40 degrees may be the vertical as well.
    let leaning = Bearing::new(40.0_f32.to_radians().sin(), -(40.0_f32.to_radians().cos()), 0.0);
    let both: Vec<_> = arcs.into_iter().chain(scene(leaning, 10.0, 0.6)).collect();
    let found = verticals(&both, UpHint::Up(mount), &Parameters::default());
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(between(&found[0].up, &mount) < 1.0 && between(&found[1].up, &leaning) < 1.0, "{found:?}");
}

#[test]
fn roll_and_pitch_follow_their_convention() {
    let with =
        |up: Bearing| Vertical { up, inliers: [0; 2], support: 0.0, runner_up: 0.0, residual_deg: 0.0 };
    let level = with(Bearing::new(0.0, -1.0, 0.0));
    assert_eq!((level.roll_deg(), level.pitch_deg()), (0.0, 0.0));
    let turned = with(Bearing::new(1.0, 0.0, 0.0));
    assert!((turned.roll_deg() - 90.0).abs() < 1e-3);
    let raised = with(Bearing::new(0.0, -0.8, 0.6));
    assert!((raised.pitch_deg() - 36.87).abs() < 0.01, "a camera that looks up sees the zenith ahead");
}

#[test]
fn too_few_arcs_give_none() {
    let hint = UpHint::Up(Bearing::new(0.0, -1.0, 0.0));
    assert_eq!(vertical(&[], hint, &Parameters::default()), None);
    let arcs: Vec<_> = scene(Bearing::new(0.0, -1.0, 0.0), 0.0, 0.0).into_iter().take(12).collect();
    assert_eq!(vertical(&arcs, hint, &Parameters::default()), None);
    assert_eq!(building_axes(&[], &LevelFrame::new(&Bearing::new(0.0, -1.0, 0.0)).unwrap()), None);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let arcs = scene(Bearing::new(0.1, -0.9, 0.3), 20.0, 1.0);
    let find = |seed| {
        vertical(
            &arcs,
            UpHint::Axis(Bearing::new(0.0, 1.0, 0.0)),
            &Parameters { seed, ..Parameters::default() },
        )
    };
    assert_eq!(find(3), find(3));
    assert!(find(3).unwrap().up.y > 0.0, "the answer has the sign of the axis");
}
