//! Gray levels of floor and ceiling on a raster of azimuth and log range.
//!
//! A point on the floor at a range of `e^u` camera heights lies `atan(e^-u)` below the horizon. Rows at equal distances in
//! `u` are equal steps of log range for every camera height: a different height shifts the rows. The ceiling is mirrored at
//! the horizon, with its own height above the camera.

use super::cells::{DEEPEST, ROWS, SURFACES};
use crate::base::ladder::RUNG;
use crate::base::num::{BINS, count_as_i32, index_of};
use crate::base::raster::GrayImage;
use crate::vision::projector::{CameraView, Node, Projector};
use crate::vision::sample::{ExclusionMask, SUBPIXEL, sample_bilinear};

/// Azimuth stride of the projection grid, degrees; positions between its nodes are interpolated.
const GRID_DEG: usize = 4;
/// Range stride of the projection grid, rows.
const GRID_ROWS: usize = 4;
/// Nodes of the grid at one azimuth.
const NODES: usize = ROWS.div_ceil(GRID_ROWS) + 1;
/// Units of position between nodes along the range axis.
const PATCH: i32 = 32;
/// Extent of the box filter of a sample, one row, in 1/[`PATCH`] of a patch.
const BOX: i32 = PATCH / count_as_i32(GRID_ROWS);
/// Largest number of taps of the box filter.
const MOST_TAPS: i32 = 4;
/// Approximate distance of the taps, pixels.
const TAP_PX: i32 = 2;
/// Units of azimuth per [`GRID_DEG`]: quarters of a degree.
const ACROSS: i32 = 16;
/// Bytes of a row of bits, one per bin.
pub(super) const OWNER_BYTES: usize = BINS.div_ceil(8);
/// Azimuths of a patch, in units of [`ACROSS`], one for each bin.
const AZIMUTHS: [i32; GRID_DEG] = [0, 4, 8, 12];

/// Adds one camera's image to the raster of gray levels by surface (floor, ceiling), row and bin: 0 where unknown. Each
/// cell that camera 1 sees is marked by a bit of `owner`.
#[inline(always)]
pub(super) fn draw(gray: &mut [u8], owner: &mut [[u8; OWNER_BYTES]], seen: &CameraView<'_>) {
    let Some(projector) = Projector::new(seen) else { return };
    let surfaces = gray.chunks_exact_mut(ROWS * BINS).zip(owner.chunks_exact_mut(ROWS));
    for (surface, (gray, owner)) in surfaces.take(SURFACES).enumerate() {
        let elevations: [_; NODES] = core::array::from_fn(|node| {
            let (sin, cos) = elevation(node * GRID_ROWS);
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
                for (bin, across) in AZIMUTHS.into_iter().enumerate() {
                    let mut samples = [0; ROWS];
                    sample(&mut samples, (&right, &left), across, seen.image, seen.excluded);
                    store(gray, owner, (column * GRID_DEG + bin) % BINS, &samples, seen.camera);
                }
            }
            right = left;
        }
    }
}

/// Sine and cosine of the elevation of a row, upwards.
fn elevation(row: usize) -> (f32, f32) {
    let cot = libm::expf(DEEPEST + row as f32 * (RUNG / 2.0));
    let length = libm::sqrtf(1.0 + cot * cot);
    (1.0 / length, cot / length)
}

/// The gray levels of the rows, at an azimuth `across` sixteenths of the way between two columns of nodes; 0
/// where unknown, excluded, or nearer to the axis of the other camera.
#[inline(always)]
fn sample(
    samples: &mut [u8; ROWS],
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
    let mut ends = samples.chunks_mut(GRID_ROWS);
    let mut near = right.iter().zip(left).map(mixed);
    let Some(mut here) = near.next() else { return };
    for far in near {
        let Some(ends) = ends.next() else { return };
        if let (Some(a), Some(b)) = (here, far) {
            let taps = taps(a, b);
            for (sample, position) in
                ends.iter_mut().zip((0..).step_by(index_of(PATCH / count_as_i32(GRID_ROWS))))
            {
                let between = |[a, b]: [i32; 2], at: i32| (a * (PATCH - at) + b * at) / (ACROSS * PATCH);
                let [x, y, lead] = [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]]];
                if between(lead, position) > 0 {
                    *sample = mean(taps, |tap| {
                        let offset = ((2 * tap + 1 - taps) * BOX).checked_div(2 * taps).unwrap_or(0);
                        let position = position + offset;
                        sample_bilinear(image, excluded, between(x, position), between(y, position))
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
    (patch.cast_signed() / (count_as_i32(GRID_ROWS) * TAP_PX)).clamp(1, MOST_TAPS)
}

/// The mean of `taps` gray levels, 0 if one of them is unknown.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the mean of gray levels is a gray level"
)]
#[inline(always)]
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

/// Stores the gray levels of one bin.
#[inline(always)]
fn store(gray: &mut [u8], owner: &mut [[u8; OWNER_BYTES]], bin: usize, samples: &[u8; ROWS], camera: usize) {
    for ((row, owner), sample) in gray.chunks_exact_mut(BINS).zip(owner).zip(samples) {
        let (Some(cell), Some(owner)) = (row.get_mut(bin), owner.get_mut(bin / 8)) else { return };
        if *sample > 0 {
            *cell = *sample;
            *owner = if camera == 0 { *owner & !(1 << (bin % 8)) } else { *owner | 1 << (bin % 8) };
        }
    }
}
