use super::*;
use crate::base::ladder::RUNG;
use crate::base::ladder::{HEIGHTS_M, NOMINAL_HEIGHT_M, height_m, height_rungs};
use crate::base::num::BINS;
use crate::vision::camera::{Camera, Equidistant, Intrinsics, Pixel, View};
use crate::vision::level_frame::LevelFrame;
use nalgebra::Vector3;
use std::vec::Vec;
use std::{boxed::Box, vec};

const SIZE: u16 = 300;

/// A rectangular room around the cameras: distances, in metres, of the walls at the front, left, back and right, of the
/// floor below and of the ceiling above.
struct Room {
    walls: [f32; 4],
    floor: f32,
    ceiling: f32,
}

const ROOM: Room = Room { walls: [4.0, 2.5, 6.0, 3.2], floor: 1.6, ceiling: 1.1 };

impl Room {
    /// The gray level at a bearing in the level frame (forward, left, up).
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

/// The frames of both cameras, for an up vector in camera 0.
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

fn range_likelihoods(
    room: &Room,
    up: &Vector3<f32>,
    cameras: &[usize],
    initial: u8,
    height: Option<f32>,
) -> Box<RangeLikelihoods> {
    let rig = rig();
    let frames = frames(room, &rig, up);
    let (mut gray, mut cells) =
        (vec![initial; RASTER_CELLS], vec![CellNats::from_bits(initial as i8); CELLS]);
    let mut work: Box<Work> = Box::default();
    bytemuck::bytes_of_mut(&mut *work).fill(initial);
    let buffers = Buffers { gray: &mut gray, work: &mut work, evidence: &mut cells };
    let mut finder = BoundaryFinder::new(buffers, &rig, LevelFrame::new(up).unwrap()).unwrap();
    for &camera in cameras {
        let image = GrayImage::new(&frames[camera], SIZE.into(), SIZE.into()).unwrap();
        finder.add(camera, &image, ExclusionMask::Unknown);
    }
    let mut ranges = Box::new(RangeLikelihoods::EMPTY);
    finder.finish().likeliest(height.map(height_rungs), &mut ranges);
    ranges
}

/// Relative errors of the ranges of all known bins, ascending.
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

/// The up vector of a rig that is mounted upside down and tilted.
fn tilted() -> Vector3<f32> {
    Vector3::new(0.15, 0.96, -0.2)
}

#[test]
fn ranges_of_a_room_are_found_level_and_tilted() {
    for up in [Vector3::new(0.0, -1.0, 0.0), tilted()] {
        let ranges = range_likelihoods(&ROOM, &up, &[0, 1], 0, None);
        let errors = errors(&ROOM, &ranges);
        assert!(errors.len() > 340, "{} bins", errors.len());
        // The tolerance expects the edge up to a rung, 6.3 %, beyond the drawn wall; means over neighbours round corners off.
        assert!(errors[errors.len() / 2] < 0.06, "median {}", errors[errors.len() / 2]);
        assert!(errors[errors.len() * 9 / 10] < 0.1, "{:?}", &errors[errors.len() * 9 / 10..]);
        let ceiling = ranges.ceiling_ratio() * ROOM.floor;
        assert!((ceiling / ROOM.ceiling - 1.0).abs() < 0.07, "ceiling {ceiling}");
    }
}

#[test]
fn a_known_camera_height_bounds_the_ceiling() {
    // 1.6 m and 1.1 m.
    let ranges = range_likelihoods(&ROOM, &tilted(), &[0, 1], 0, Some(ROOM.floor));
    let room = ROOM.floor * (1.0 + ranges.ceiling_ratio());
    assert!((2.4..3.0).contains(&room), "{room}");
}

#[test]
fn one_camera_leaves_the_other_half_unknown() {
    let up = Vector3::new(0.0, -1.0, 0.0);
    let ranges = range_likelihoods(&ROOM, &up, &[0], 0, None);
    assert!(ranges.knows(0) && !ranges.knows(180));
    assert!(ranges.range(180, 0).is_none());
    let nothing = (0..RUNGS as i8).all(|rung| ranges.row(rung as usize, 0)[180] == 0);
    assert!(nothing, "unknown bins have no evidence");
}

#[test]
fn initial_contents_of_buffers_are_ignored() {
    let up = tilted();
    assert_eq!(
        range_likelihoods(&ROOM, &up, &[0, 1], 0, None),
        range_likelihoods(&ROOM, &up, &[0, 1], 0xa5, None)
    );
    let rig = rig();
    let (mut gray, mut cells) = (vec![0; RASTER_CELLS - 1], vec![CellNats::ZERO; CELLS]);
    let mut work: Box<Work> = Box::default();
    let buffers = Buffers { gray: &mut gray, work: &mut work, evidence: &mut cells };
    assert!(BoundaryFinder::new(buffers, &rig, LevelFrame::new(&up).unwrap()).is_none(), "too short");
}

#[test]
fn blank_frames_give_the_prior() {
    let room = Room { walls: [1e6; 4], floor: 1e9, ceiling: 1e9 };
    let ranges = range_likelihoods(&room, &tilted(), &[0, 1], 0, None);
    // Only the prior of rows remains, which prefers no range by more than a nat.
    for rung in 0..72 {
        let row = ranges.row(rung, 0);
        assert!(row.iter().all(|value| *value < 1), "rung {rung}: {row:?}");
    }
}

#[test]
fn camera_heights_shift_rows() {
    assert_eq!(height_rungs(NOMINAL_HEIGHT_M), 0);
    assert_eq!(height_rungs(NOMINAL_HEIGHT_M * libm::expf(3.0 * RUNG)), 3);
    let [least, most] = HEIGHTS_M.map(height_rungs);
    assert!((least..=most).all(|rungs| height_rungs(height_m(rungs)) == rungs));
    assert_eq!(height_rungs(0.0), height_rungs(HEIGHTS_M[0]));
    assert_eq!(height_rungs(f32::NAN), height_rungs(HEIGHTS_M[0]));
    let ranges = range_likelihoods(&ROOM, &tilted(), &[0, 1], 0, None);
    let [low, high] = [0, 5].map(|height| ranges.range(90, height).unwrap().metres);
    assert!((high / low - libm::expf(5.0 * RUNG)).abs() < 1e-3);
    assert_eq!(ranges.row(20, 0), ranges.row(25, 5));
}

/// Evidence of a floor at rung 30 in all directions, and of ceilings at the given shifts with the given evidence.
fn cells(ceilings: &[(usize, i8)]) -> Vec<CellNats> {
    let mut cells = vec![CellNats::from_bits(-8); CELLS];
    let (floor, above) = cells.split_at_mut(RUNGS * BINS);
    floor[30 * BINS..31 * BINS].fill(CellNats::from_bits(60));
    for &(offset, evidence) in ceilings {
        above[(30 - offset) * BINS..][..BINS].fill(CellNats::from_bits(evidence));
    }
    cells
}

#[test]
fn the_ceiling_is_guessed_by_agreement() {
    let cells = cells(&[(2, 30), (5, 50), (12, 40), (16, 10), (20, 20)]);
    let evidence = BoundaryEvidence::new(&cells).unwrap();
    assert_eq!(evidence.guess_ceiling(None), 5);
    // The ceiling is at most 4.5 m high: 1.25 camera heights of 2 m above the camera.
    assert_eq!(evidence.guess_ceiling(Some(height_rungs(2.0))), 2);
    let mut ranges = Box::new(RangeLikelihoods::EMPTY);
    evidence.ranges(12, &mut ranges);
    assert!((ranges.ceiling_ratio() - libm::expf(12.0 * RUNG)).abs() < 1e-5);
    evidence.likeliest(None, &mut ranges);
    assert!((ranges.ceiling_ratio() - libm::expf(5.0 * RUNG)).abs() < 1e-5);
    assert!(BoundaryEvidence::new(&cells[1..]).is_none());
    let nothing = vec![CellNats::ZERO; CELLS];
    assert_eq!(BoundaryEvidence::new(&nothing).unwrap().guess_ceiling(None), 0);
}
