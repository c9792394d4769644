//! Edges along the range axis of floor and ceiling, on a raster of azimuth and log range.
//!
//! A point on the floor at a range of `e^u` camera heights lies `atan(e^-u)` below the horizon. Rows at equal distances in
//! `u` are equal steps of log range for every camera height: a different height shifts the rows. The ceiling is mirrored at
//! the horizon, with its own height above the camera.

use super::cells::{DEEPEST, RUNGS, SURFACES};
use crate::base::ladder::RUNG;
use crate::base::num::{BINS, count_as_i32, index_of};
use crate::base::raster::GrayImage;
use crate::vision::panorama::Resolution;
use crate::vision::projector::{CameraView, Node, Projector};
use crate::vision::sample::{ExclusionMask, SUBPIXEL, sample_bilinear};

/// Azimuth stride of the projection grid, degrees; positions between its nodes are interpolated.
const GRID_DEG: usize = 4;
/// Range stride of the projection grid, rungs.
const GRID_RUNGS: usize = 2;
/// Nodes of the grid at one azimuth.
const NODES: usize = RUNGS.div_ceil(GRID_RUNGS) + 1;
/// Units of position between nodes along the range axis.
const PATCH: i32 = 32;
/// Extent of the box filter of a sample, half a rung, in 1/[`PATCH`] of a patch.
const BOX: i32 = PATCH / count_as_i32(GRID_RUNGS) / 2;
/// Largest number of taps of the box filter.
const MOST_TAPS: i32 = 4;
/// Approximate distance of the taps, pixels.
const TAP_PX: i32 = 2;
/// Units of azimuth per [`GRID_DEG`]: quarters of a degree.
const ACROSS: i32 = 16;
/// Azimuth samples of a patch and their bins: two per bin, a quarter of a degree to either side of its middle.
const AZIMUTHS: [(i32, usize); 8] = [(1, 0), (3, 1), (5, 1), (7, 2), (9, 2), (11, 3), (13, 3), (15, 4)];
/// Azimuth samples for images below 3 pixels per degree: one per bin.
const COARSE_AZIMUTHS: [(i32, usize); 4] = [(0, 0), (4, 1), (8, 2), (12, 3)];
/// Largest edge that a byte can store beside 0, which is unknown.
const MOST_EDGE: u8 = 254;

/// Adds one camera's image to `edges`, by surface (floor, ceiling), rung and bin: 0 where unknown, else 1 + the absolute
/// difference of the gray levels at the near and the far end of the rung.
pub(super) fn draw(edges: &mut [u8], seen: &CameraView<'_>) {
    let (Some(projector), Some(view)) = (Projector::new(seen), seen.rig.view(seen.camera)) else {
        return;
    };
    let azimuths: &[_] =
        if Resolution::of(view) == Resolution::COARSE { &COARSE_AZIMUTHS } else { &AZIMUTHS };
    for (surface, edges) in edges.chunks_exact_mut(RUNGS * BINS).take(SURFACES).enumerate() {
        let elevations: [_; NODES] = core::array::from_fn(|node| {
            let (sin, cos) = elevation(node * GRID_RUNGS);
            (if surface == 0 { -sin } else { sin }, cos)
        });
        let nodes = |column: usize| {
            let azimuth = libm::sincosf((column * GRID_DEG) as f32 * (core::f32::consts::PI / 180.0));
            elevations.map(|elevation| projector.node(azimuth, elevation))
        };
        let mut right = nodes(0);
        for column in 0..BINS / GRID_DEG {
            let left = nodes(column + 1);
            if right.iter().zip(&left).any(|(r, l)| r.lead > 0 || l.lead > 0) {
                for &(across, bin) in azimuths {
                    let mut samples = [0; RUNGS + 1];
                    sample(&mut samples, (&right, &left), across, seen.image, seen.excluded);
                    store(edges, (column * GRID_DEG + bin) % BINS, &samples);
                }
            }
            right = left;
        }
    }
}

/// Sine and cosine of the elevation of the near end of a rung, upwards.
fn elevation(rung: usize) -> (f32, f32) {
    let cot = libm::expf(DEEPEST + rung as f32 * RUNG);
    let length = libm::sqrtf(1.0 + cot * cot);
    (1.0 / length, cot / length)
}

/// The gray levels at the ends of the rungs, at an azimuth `across` sixteenths of the way between two columns of nodes; 0
/// where unknown, excluded, or nearer to the axis of the other camera.
#[expect(clippy::indexing_slicing, reason = "coordinates 0, 1 and 2 of arrays of three")]
fn sample(
    samples: &mut [u8; RUNGS + 1],
    (right, left): (&[Node; NODES], &[Node; NODES]),
    across: i32,
    image: &GrayImage<'_>,
    excluded: ExclusionMask<'_>,
) {
    let blend = |from: i32, to: i32| from * (ACROSS - across) + to * across;
    let mixed = |(r, l): (&Node, &Node)| {
        let usable = r.usable && l.usable;
        usable.then(|| [blend(r.x, l.x), blend(r.y, l.y), blend(r.lead, l.lead)])
    };
    let mut ends = samples.chunks_mut(GRID_RUNGS);
    let mut near = right.iter().zip(left).map(mixed);
    let Some(mut here) = near.next() else { return };
    for far in near {
        let Some(ends) = ends.next() else { return };
        if let (Some(a), Some(b)) = (here, far) {
            let taps = taps(a, b);
            for (sample, position) in
                ends.iter_mut().zip((0..).step_by(index_of(PATCH / count_as_i32(GRID_RUNGS))))
            {
                let at = |k: usize, at: i32| (a[k] * (PATCH - at) + b[k] * at) / (ACROSS * PATCH);
                if at(2, position) > 0 {
                    *sample = mean(taps, |tap| {
                        let position = position + (2 * tap + 1 - taps) * BOX / (2 * taps);
                        sample_bilinear(image, excluded, at(0, position), at(1, position))
                    });
                }
            }
        }
        here = far;
    }
}

/// Number of taps of the box filter, by the extent of a patch in the image.
fn taps(a: [i32; 3], b: [i32; 3]) -> i32 {
    let patch = (a[0].abs_diff(b[0]) + a[1].abs_diff(b[1])) >> (SUBPIXEL + ACROSS.trailing_zeros());
    (patch.cast_signed() / (2 * count_as_i32(GRID_RUNGS) * TAP_PX)).clamp(1, MOST_TAPS)
}

/// The mean of `taps` gray levels, 0 if one of them is unknown.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the mean of gray levels is a gray level"
)]
fn mean(taps: i32, gray: impl Fn(i32) -> u8) -> u8 {
    let mut sum = 0;
    for tap in 0..taps {
        let level = i32::from(gray(tap));
        if level == 0 {
            return 0;
        }
        sum += level;
    }
    (sum / taps.max(1)) as u8
}

/// Stores the edges of one azimuth sample in its bin, or their mean with those of the bin's other sample.
fn store(edges: &mut [u8], bin: usize, samples: &[u8; RUNGS + 1]) {
    for (row, ends) in edges.chunks_exact_mut(BINS).zip(samples.windows(2)) {
        let (&[near, far], Some(cell)) = (ends, row.get_mut(bin)) else { return };
        if near == 0 || far == 0 {
            continue;
        }
        let edge = 1 + near.abs_diff(far).min(MOST_EDGE - 1);
        *cell = if *cell == 0 { edge } else { cell.midpoint(edge) };
    }
}
