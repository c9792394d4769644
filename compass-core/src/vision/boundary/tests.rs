use super::*;
use crate::base::ladder::{HEIGHTS_M, NOMINAL_HEIGHT_M, height_m, height_rungs};
use crate::vision::camera::{Camera, Equidistant, Intrinsics, Pixel, View};
use crate::vision::level_frame::LevelFrame;
use nalgebra::Vector3;
use std::vec::Vec;
use std::{boxed::Box, vec};

const SIZE: u16 = 300;

/// A rectangular room around the cameras, metres: walls to the front, left, back and right; floor below and ceiling
/// above.
struct Room {
    walls: [f32; 4],
    floor: f32,
    ceiling: f32,
}

const ROOM: Room = Room { walls: [4.0, 2.5, 6.0, 3.2], floor: 1.6, ceiling: 1.1 };

impl Room {
    /// The gray level that a level bearing (forward, left, up) meets.
    fn gray(&self, b: &Vector3<f32>) -> u8 {
        let wall = self.range(libm::atan2f(b.y, b.x)) / libm::hypotf(b.x, b.y).max(1e-6);
        if b.z * wall < -self.floor {
            70
        } else if b.z * wall > self.ceiling {
            190
        } else {
            130
        }
    }

    /// Range of the walls at an azimuth, radians counter-clockwise from forward.
    fn range(&self, azimuth: f32) -> f32 {
        let (sin, cos) = libm::sincosf(azimuth);
        let along = if cos > 0.0 { self.walls[0] } else { self.walls[2] } / cos.abs().max(1e-6);
        let across = if sin > 0.0 { self.walls[1] } else { self.walls[3] } / sin.abs().max(1e-6);
        along.min(across)
    }
}

fn rig() -> Rig {
    let focal = f32::from(SIZE) / 3.4;
    let centre = (f32::from(SIZE) - 1.0) / 2.0;
    let camera = Equidistant::new(Intrinsics { fx: focal, fy: focal, cx: centre, cy: centre }).unwrap();
    let view = View::new(Camera::Equidistant(camera), SIZE, SIZE);
    Rig::back_to_back(view, view).unwrap()
}

/// What both cameras see, for an up vector in camera 0.
fn frames(room: &Room, rig: &Rig, up: &Vector3<f32>) -> [Vec<u8>; 2] {
    let level = LevelFrame::new(up).unwrap();
    [0, 1].map(|camera| {
        let view = rig.view(camera).unwrap();
        let pixel = |i: u32| {
            let (x, y) = ((i % u32::from(SIZE)) as f32, (i / u32::from(SIZE)) as f32);
            let Some(bearing) = view.camera.unproject(Pixel { x, y }) else { return 0 };
            let (azimuth, elevation) = level.direction(&(view.rotation * bearing));
            let (sin, cos) = libm::sincosf(azimuth);
            let flat = libm::cosf(elevation);
            room.gray(&Vector3::new(flat * cos, flat * sin, libm::sinf(elevation)))
        };
        (0..u32::from(SIZE) * u32::from(SIZE)).map(pixel).collect()
    })
}

fn survey(
    room: &Room,
    up: &Vector3<f32>,
    cameras: &[usize],
    garbage: u8,
    height: Option<f32>,
) -> Box<RangeLikelihoods> {
    let rig = rig();
    let frames = frames(room, &rig, up);
    let (mut edges, mut support) = (vec![garbage; CELLS], vec![garbage; CELLS]);
    let buffers = Buffers { edges: &mut edges, support: &mut support };
    let mut surveyor = BoundaryFinder::new(buffers, &rig, LevelFrame::new(up).unwrap()).unwrap();
    for &camera in cameras {
        let image = GrayImage::new(&frames[camera], SIZE.into(), SIZE.into()).unwrap();
        surveyor.add(camera, &image, ExclusionMask::Unknown);
    }
    let mut ranges = Box::new(RangeLikelihoods::EMPTY);
    surveyor.finish().likeliest(height.map(height_rungs), &mut ranges);
    ranges
}

/// Relative errors of the ranges of all bins that have one.
fn errors(room: &Room, ranges: &RangeLikelihoods) -> Vec<f32> {
    let height = height_rungs(room.floor);
    let of_bin = |bin: usize| {
        let truth = room.range((bin as f32).to_radians());
        ranges.range(bin, height).map(|found| (found.metres / truth - 1.0).abs())
    };
    let mut errors: Vec<_> = (0..BINS).filter_map(of_bin).collect();
    errors.sort_by(f32::total_cmp);
    errors
}

/// The cameras hang upside down and tilted, as hands hold them.
fn tilted() -> Vector3<f32> {
    Vector3::new(0.15, 0.96, -0.2)
}

#[test]
fn ranges_of_a_room_are_found_from_any_tilt() {
    for up in [Vector3::new(0.0, -1.0, 0.0), tilted()] {
        let ranges = survey(&ROOM, &up, &[0, 1], 0, None);
        let errors = errors(&ROOM, &ranges);
        assert!(errors.len() > 340, "{} bins", errors.len());
        // A rung is 6.3 %: corners are rounded off by the support of the walls beside them.
        assert!(errors[errors.len() / 2] < 0.02, "median {}", errors[errors.len() / 2]);
        assert!(errors[errors.len() * 9 / 10] < 0.06, "{:?}", &errors[errors.len() * 9 / 10..]);
        let ceiling = ranges.ceiling_ratio() * ROOM.floor;
        assert!((ceiling / ROOM.ceiling - 1.0).abs() < 0.07, "ceiling {ceiling}");
    }
}

#[test]
fn a_known_height_bounds_the_room() {
    // 1.6 m and 1.1 m.
    let ranges = survey(&ROOM, &tilted(), &[0, 1], 0, Some(ROOM.floor));
    let room = ROOM.floor * (1.0 + ranges.ceiling_ratio());
    assert!((2.4..3.0).contains(&room), "{room}");
}

#[test]
fn one_camera_leaves_the_other_half_unknown() {
    let up = Vector3::new(0.0, -1.0, 0.0);
    let ranges = survey(&ROOM, &up, &[0], 0, None);
    assert!(ranges.knows(0) && !ranges.knows(180));
    assert!(ranges.range(180, 0).is_none());
    let nothing = (0..RUNGS as i8).all(|rung| ranges.row(rung as usize, 0)[180] == 0);
    assert!(nothing, "what is unknown must not count");
}

#[test]
fn the_lent_memory_does_not_matter() {
    let up = tilted();
    assert_eq!(survey(&ROOM, &up, &[0, 1], 0, None), survey(&ROOM, &up, &[0, 1], 0xa5, None));
    let rig = rig();
    let (mut edges, mut support) = (vec![0; CELLS - 1], vec![0; CELLS]);
    let buffers = Buffers { edges: &mut edges, support: &mut support };
    assert!(BoundaryFinder::new(buffers, &rig, LevelFrame::new(&up).unwrap()).is_none(), "too short");
}

#[test]
fn blank_frames_prefer_nothing() {
    let room = Room { walls: [1e6; 4], floor: 1e9, ceiling: 1e9 };
    let ranges = survey(&room, &tilted(), &[0, 1], 0, None);
    // What is left is what is expected before looking: the same in all directions.
    for rung in 0..72 {
        let row = ranges.row(rung, 0);
        assert!(row.iter().all(|value| *value == row[0]), "rung {rung}");
    }
}

#[test]
fn heights_are_shifts() {
    assert_eq!(height_rungs(NOMINAL_HEIGHT_M), 0);
    assert_eq!(height_rungs(NOMINAL_HEIGHT_M * libm::expf(3.0 * RUNG)), 3);
    let [least, most] = HEIGHTS_M.map(height_rungs);
    assert!((least..=most).all(|rungs| height_rungs(height_m(rungs)) == rungs));
    assert_eq!(height_rungs(0.0), height_rungs(HEIGHTS_M[0]));
    assert_eq!(height_rungs(f32::NAN), height_rungs(HEIGHTS_M[0]));
    let ranges = survey(&ROOM, &tilted(), &[0, 1], 0, None);
    let [low, high] = [0, 5].map(|height| ranges.range(90, height).unwrap().metres);
    assert!((high / low - libm::expf(5.0 * RUNG)).abs() < 1e-3);
    assert_eq!(ranges.row(20, 0), ranges.row(25, 5));
}

/// Evidence of a floor at rung 30 all around, and of ceilings that lie by so many rungs higher.
fn cells(ceilings: &[(usize, u8)]) -> Vec<u8> {
    let mut cells = vec![0; CELLS];
    let (floor, above) = cells.split_at_mut(RUNGS * BINS);
    floor[30 * BINS..31 * BINS].fill(60);
    for &(offset, evidence) in ceilings {
        above[(30 - offset) * BINS..][..BINS].fill(evidence);
    }
    cells
}

#[test]
fn ceilings_come_by_evidence() {
    let cells = cells(&[(2, 30), (5, 50), (12, 40), (16, 10), (20, 20)]);
    let survey = BoundaryEvidence::new(&cells, [true; BINS]).unwrap();
    assert_eq!(survey.ceilings(None), [5, 12, 2, 20]);
    // The room is 4.5 m at most: a ceiling at 1.25 camera heights of 2 m.
    let low = survey.ceilings(Some(height_rungs(2.0)));
    assert_eq!(low.first(), Some(&2), "{low:?}");
    let mut ranges = Box::new(RangeLikelihoods::EMPTY);
    survey.ranges(12, &mut ranges);
    assert!((ranges.ceiling_ratio() - libm::expf(12.0 * RUNG)).abs() < 1e-5);
    survey.likeliest(None, &mut ranges);
    assert!((ranges.ceiling_ratio() - libm::expf(5.0 * RUNG)).abs() < 1e-5);
    assert!(BoundaryEvidence::new(&cells[1..], [true; BINS]).is_none());
    assert_eq!(
        BoundaryEvidence::new(survey.cells(), *survey.known()).unwrap().ceilings(None),
        survey.ceilings(None)
    );
}

#[test]
fn nothing_seen_has_a_ceiling_too() {
    let cells = vec![0; CELLS];
    assert_eq!(BoundaryEvidence::new(&cells, [false; BINS]).unwrap().ceilings(None).len(), 1);
}
