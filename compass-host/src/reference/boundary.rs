//! Ranges: edges across floor and ceiling by exact projection, their support and the likelihoods in real numbers.
//!
//! A cell is a surface (floor, ceiling), a rung of log range and a bin of azimuth.

use super::camera::Camera;
use compass_core::base::raster::GrayImage;
use compass_core::vision::camera::{Rig, View};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Rungs, bins, and cells of both surfaces.
pub const RUNGS: usize = 90;
/// Azimuth bins.
pub const BINS: usize = 360;
/// Cells of both surfaces.
pub const CELLS: usize = 2 * RUNGS * BINS;

/// Ranges from 0.4 m to 30 m span 71 rungs; that of 0.4 m, at a height of 1.5 m, is number 9.
const NEAREST_M: f64 = 0.4;
const FARTHEST_M: f64 = 30.0;
const LADDER: f64 = 72.0;
const NOMINAL_M: f64 = 1.5;
const LEAD: f64 = 9.0;

/// Distance at which the bearings of both cameras meet, metres, and largest angle from the axis, degrees.
const MEETING_M: f64 = 6.0;
const RIM_DEG: f64 = 95.0;
/// Samples in the mean over half a rung.
const SAMPLES: u32 = 8;

/// The strongest tenth of edges begins at a log of `ln 3`, but at no fewer gray levels than this.
const LEAST_SCALE: f64 = 3.0;
/// Evidence in nats for the log of a cell's own edge, and of each of its six neighbours' strongest: floor, ceiling.
const WEIGHTS: [[f64; 2]; 2] = [[23.0, 23.0], [45.0, 74.0]];
/// Share of directions without information about the plan.
const OUTLIERS: f64 = 0.3;

/// Natural logarithm of the ratio of neighbouring rungs.
fn rung() -> f64 {
    (FARTHEST_M / NEAREST_M).ln() / (LADDER - 1.0)
}

/// Edge strengths in gray levels of smoothed frames, `None` where unobserved.
#[must_use]
pub fn edges(rig: &Rig, images: [Option<&GrayImage<'_>>; 2], up: Vector3<f64>) -> Vec<Option<f64>> {
    let up = up.normalize();
    let forward = (Vector3::z() - up * up.z).normalize();
    let axes = Matrix3::from_columns(&[forward, up.cross(&forward), up]);
    let calibrated = |(n, view): (usize, &View)| Some((n, Camera::from(&view.camera), *view, images[n]?));
    let cameras: Vec<_> = rig.views().filter_map(calibrated).collect();
    // The gray level at the end of a rung: the camera that sees it, and its value.
    let end = |surface: usize, rung_end: usize, azimuth_deg: f64| {
        let at = |offset: f64| {
            let u = (NEAREST_M / NOMINAL_M).ln() + (rung_end as f64 + offset - LEAD - 0.5) * rung();
            let elevation = (-u).exp().atan() * if surface == 0 { -1.0 } else { 1.0 };
            let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth_deg.to_radians().sin_cos(), elevation.sin_cos());
            axes * Vector3::new(cos_e * cos_a, cos_e * sin_a, sin_e) * MEETING_M
        };
        let bearing = |view: &View, point: Vector3<f64>| {
            (view.rotation.cast::<f64>().transpose() * (point - view.position.cast())).normalize()
        };
        let nearness = |entry: &&(usize, Camera, View, &GrayImage<'_>)| bearing(&entry.2, at(0.0)).z;
        let (number, camera, view, image) =
            cameras.iter().max_by(|a, b| nearness(a).total_cmp(&nearness(b)))?;
        if bearing(view, at(0.0)).z <= RIM_DEG.to_radians().cos() {
            return None;
        }
        let sample = |k: u32| {
            let offset = (f64::from(k) + 0.5) / f64::from(SAMPLES) * 0.5 - 0.25;
            gray(image, camera.project(bearing(view, at(offset)).into())?)
        };
        let sum = (0..SAMPLES).map(sample).sum::<Option<f64>>()?;
        Some((*number, sum / f64::from(SAMPLES)))
    };
    let edge = |surface: usize, rung: usize, azimuth_deg: f64| {
        let (near, far) = (end(surface, rung, azimuth_deg)?, end(surface, rung + 1, azimuth_deg)?);
        (near.0 == far.0).then(|| (near.1 - far.1).abs())
    };
    let cell = |index: usize| {
        let (surface, rung, bin) = (index / (RUNGS * BINS), index / BINS % RUNGS, index % BINS);
        let samples: Vec<_> =
            [-0.25, 0.25].iter().filter_map(|off| edge(surface, rung, bin as f64 + off)).collect();
        (!samples.is_empty()).then(|| samples.iter().sum::<f64>() / samples.len() as f64)
    };
    (0..CELLS).into_par_iter().map(cell).collect()
}

/// Bilinear; `None` within a pixel of the border.
fn gray(image: &GrayImage<'_>, [x, y]: [f64; 2]) -> Option<f64> {
    let (width, height) = (f64::from(image.width()), f64::from(image.height()));
    let (column, row) = (x.floor(), y.floor());
    if column < 1.0 || row < 1.0 || column + 2.0 >= width || row + 2.0 >= height {
        return None;
    }
    let pixel = |dx: f64, dy: f64| f64::from(image.row((row + dy) as usize)[(column + dx) as usize]);
    let (u, v) = (x - column, y - row);
    let across = |dy: f64| pixel(0.0, dy) * (1.0 - u) + pixel(1.0, dy) * u;
    Some(across(0.0) * (1.0 - v) + across(1.0) * v)
}

/// Evidence of every cell in nats, from edges in gray levels: `ln(1 + 2 edge / scale)` of its own edge and of the
/// strongest ones within reach in the neighbouring bins.
#[must_use]
pub fn support(edges: &[Option<f64>]) -> Vec<f64> {
    let mut known: Vec<f64> = edges.iter().flatten().copied().collect();
    known.sort_by(f64::total_cmp);
    let scale = known.get(known.len() / 100 * 90).copied().unwrap_or(0.0).max(LEAST_SCALE);
    let log = |edge: &Option<f64>| edge.map_or(0.0, |edge| (2.0 * edge / scale).ln_1p());
    let logs: Vec<f64> = edges.iter().map(log).collect();
    let at = |surface: usize, rung: isize, bin: isize| {
        let rung = usize::try_from(rung).ok().filter(|rung| *rung < RUNGS);
        let bin = bin.rem_euclid(BINS as isize) as usize;
        rung.map_or(0.0, |rung| logs[(surface * RUNGS + rung) * BINS + bin])
    };
    let cell = |index: usize| {
        let (surface, rung, bin) = (index / (RUNGS * BINS), index / BINS % RUNGS, index % BINS);
        let (rung, bin) = (rung as isize, bin as isize);
        let strongest = |beside: isize| {
            let reach = beside.abs();
            (-reach..=reach).map(|k| at(surface, rung + k, bin + beside)).fold(0.0, f64::max)
        };
        let others: f64 = [-3, -2, -1, 1, 2, 3].into_iter().map(strongest).sum();
        let [own, other] = WEIGHTS[surface];
        // 32 units of log, 1/256 of 1/16 nat each.
        ((own * at(surface, rung, bin) + other * others) * 32.0 / 256.0 / 16.0).min(255.0 / 16.0)
    };
    (0..CELLS).map(cell).collect()
}

/// Log-likelihood ratios in nats by rung and bin, from the evidence in nats, for a ceiling that is higher above the
/// camera than the floor is below it by a number of rungs.
#[must_use]
pub fn log_ratios(evidence: &[f64], ceiling: isize) -> Vec<f64> {
    let total = |rung: usize, bin: usize| {
        let above = usize::try_from(rung as isize - ceiling).ok().filter(|rung| *rung < RUNGS);
        let above = above.map_or(0.0, |above| evidence[(RUNGS + above) * BINS + bin]);
        let x = 2.0 * (rung as f64 - LEAD) / (LADDER - 1.0) - 1.0;
        evidence[rung * BINS + bin] + above + 1.3 * x - 2.87 * x * x
    };
    let mut ratios = vec![0.0; RUNGS * BINS];
    for bin in 0..BINS {
        let totals: Vec<f64> = (0..RUNGS).map(|rung| total(rung, bin)).collect();
        let best = totals.iter().copied().fold(f64::MIN, f64::max);
        let sum: f64 = totals.iter().map(|total| (total - best).exp()).sum();
        for (rung, total) in totals.iter().enumerate() {
            let share = (total - best).exp() / sum;
            ratios[rung * BINS + bin] = ((1.0 - OUTLIERS) * LADDER * share + OUTLIERS).ln();
        }
    }
    ratios
}
