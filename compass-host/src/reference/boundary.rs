//! Boundaries of floor and ceiling in real numbers: gray levels by exact projection, and their evidence by the definition.
//!
//! A cell is a surface (floor, ceiling), a row of log range in steps of half a rung and a bin of azimuth.

use super::camera::Camera;
use compass_core::base::raster::GrayImage;
use compass_core::vision::camera::{Rig, View};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Rows, bins, and cells of both surfaces.
pub const ROWS: usize = 181;
/// Azimuth bins.
pub const BINS: usize = 360;
/// Cells of both surfaces.
pub const CELLS: usize = 2 * ROWS * BINS;
/// Rungs of evidence: every second row, from the second on.
pub const RUNGS: usize = ROWS / 2;

/// Ranges from 0.4 m to 30 m span 71 rungs; row 0 lies 9.5 rungs before 0.4 m at a height of 1.5 m.
const NEAREST_M: f64 = 0.4;
const FARTHEST_M: f64 = 30.0;
const LADDER: f64 = 72.0;
const NOMINAL_M: f64 = 1.5;
const LEAD: f64 = 9.5;

/// Distance at which the bearings of both cameras meet, metres, and largest angle from the axis, degrees.
const MEETING_M: f64 = 6.0;
const RIM_DEG: f64 = 95.0;
/// Samples in the mean over half a rung.
const SAMPLES: u32 = 8;

/// The gray level of a cell and the camera that sees it; `None` where unobserved.
pub type Cell = Option<(f64, usize)>;

/// Natural logarithm of the range of a row in units of the height.
fn log_range(row: f64) -> f64 {
    (NEAREST_M / NOMINAL_M).ln() + (row / 2.0 - LEAD) * (FARTHEST_M / NEAREST_M).ln() / (LADDER - 1.0)
}

/// Gray levels of all cells.
#[must_use]
pub fn gray_levels(rig: &Rig, images: [Option<&GrayImage<'_>>; 2], up: Vector3<f64>) -> Vec<Cell> {
    let up = up.normalize();
    let forward = (Vector3::z() - up * up.z).normalize();
    let axes = Matrix3::from_columns(&[forward, up.cross(&forward), up]);
    let calibrated = |(n, view): (usize, &View)| Some((n, Camera::from(&view.camera), *view, images[n]?));
    let cameras: Vec<_> = rig.views().filter_map(calibrated).collect();
    let level = |surface: usize, row: usize, azimuth_deg: f64| -> Cell {
        let at = |offset: f64| {
            let elevation =
                (-log_range(row as f64 + offset)).exp().atan() * if surface == 0 { -1.0 } else { 1.0 };
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
            let offset = (f64::from(k) + 0.5) / f64::from(SAMPLES) - 0.5;
            gray(image, camera.project(bearing(view, at(offset)).into())?)
        };
        let sum = (0..SAMPLES).map(sample).sum::<Option<f64>>()?;
        Some((sum / f64::from(SAMPLES), *number))
    };
    let cell = |index: usize| {
        let (surface, row, bin) = (index / (ROWS * BINS), index / BINS % ROWS, index % BINS);
        level(surface, row, bin as f64)
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

/// Slopes of boundaries, rungs per degree.
const SLOPES: [f64; 3] = [0.0, 0.6, -0.6];
/// Weights of the logarithms of strength and significance at widths of 1 and 4 rows, of the regions nearer and farther, and
/// of u and u^2.
const FLOOR_BY_REGION: [f64; 8] = [2.93, 1.69, -1.33, 0.54, 1.09, 1.01, 2.75, -3.31];
const FLOOR: [f64; 8] = [3.60, 0.0, 1.61, 0.0, 0.0, 0.0, 3.25, -4.69];
const CEILING: [f64; 8] = [2.64, 3.39, -1.65, 0.23, 0.0, 0.0, 1.91, -4.70];
/// Probability of the image's boundary by its distance from the plan's, rungs, and the first distance.
const FLOOR_TOLERANCE: (isize, &[f64]) = (-2, &[0.015, 0.115, 0.28, 0.29, 0.17, 0.085, 0.045]);
const CEILING_TOLERANCE: (isize, &[f64]) = (-2, &[0.08, 0.24, 0.36, 0.24, 0.08]);

/// Evidence in nats by surface, rung and bin, from the gray levels of the cells.
#[must_use]
pub fn evidence(cells: &[Cell]) -> Vec<f64> {
    let (floor, ceiling) = cells.split_at(ROWS * BINS);
    let region = region(floor, ceiling);
    let mut evidence = surface(floor, &[FLOOR_BY_REGION, FLOOR], &region, FLOOR_TOLERANCE);
    evidence.extend(surface(ceiling, &[CEILING], &region, CEILING_TOLERANCE));
    evidence
}

fn surface(
    cells: &[Cell],
    variants: &[[f64; 8]],
    region: &(impl Fn(f64) -> f64 + Sync),
    (least, tolerance): (isize, &[f64]),
) -> Vec<f64> {
    let at = |row: isize, bin: isize| {
        let bin = bin.rem_euclid(BINS as isize) as usize;
        usize::try_from(row).ok().filter(|row| *row < ROWS).and_then(|row| cells[row * BINS + bin])
    };
    let differences = [1, 4].map(|width: isize| -> Vec<Option<f64>> {
        let difference = |index: usize| {
            let (row, bin) = ((index / BINS) as isize, (index % BINS) as isize);
            let all: Option<Vec<_>> = (-width..=width).map(|k| at(row + k, bin)).collect();
            let all = all?;
            let sum: f64 =
                (1..=width as usize).map(|k| all[width as usize + k].0 - all[width as usize - k].0).sum();
            (all[0].1 == all[all.len() - 1].1).then_some(sum / width as f64)
        };
        (0..ROWS * BINS).map(difference).collect()
    });
    // Strength and significance along a slope.
    let oriented = |width: usize, row: usize, bin: usize, slope: f64| {
        let taps = (-3_isize..=3).filter_map(|k| {
            let row = usize::try_from(row as isize + (2.0 * slope * k as f64).round() as isize).ok()?;
            let bin = (bin as isize + k).rem_euclid(BINS as isize) as usize;
            differences[width].get(row * BINS + bin).copied().flatten()
        });
        let taps: Vec<f64> = taps.collect();
        if taps.len() < 3 {
            return [0.0; 2];
        }
        let n = taps.len() as f64;
        let mean = taps.iter().sum::<f64>() / n;
        let variance = taps.iter().map(|tap| tap * tap).sum::<f64>() / n - mean * mean;
        [mean.abs(), mean.abs() / (variance.max(0.0) / n + 0.35 * 0.35).sqrt()]
    };
    let scales = [0, 1].map(|width| {
        let level =
            (0..RUNGS * BINS).map(|index| oriented(width, 2 * (index / BINS) + 1, index % BINS, 0.0)[0]);
        let mut strengths: Vec<f64> = level.filter(|strength| *strength > 0.0).collect();
        strengths.sort_by(f64::total_cmp);
        strengths.get(strengths.len() / 10 * 9).copied().unwrap_or(0.0).max(1.0)
    });
    let ratio = |row: isize, bin: usize| {
        let three = (-1..=1).map(|k| at(row, bin as isize + k).map_or(0.0, |cell| region(cell.0)));
        three.sum::<f64>() / 3.0
    };
    let column = |bin: usize| -> Vec<f64> {
        let mass = |variant: &[f64; 8]| -> Vec<f64> {
            let of_row = |row: usize| {
                cells[row * BINS + bin].map_or(0.0, |_| {
                    let u = 2.0 * row as f64 / (ROWS as f64 - 1.0) - 1.0;
                    let near: f64 = (1..=8).map(|k| ratio(row as isize - k, bin)).sum::<f64>() / 8.0;
                    let far: f64 = (1..=8).map(|k| -ratio(row as isize + k, bin)).sum::<f64>() / 8.0;
                    let sum_over_slopes = SLOPES.iter().map(|slope| {
                        let [g1, t1] = oriented(0, row, bin, *slope);
                        let [g4, t4] = oriented(1, row, bin, *slope);
                        let logs = [2.0 * g1 / scales[0], t1, 2.0 * g4 / scales[1], t4].map(f64::ln_1p);
                        let features = [logs[0], logs[1], logs[2], logs[3], near, far, u, u * u];
                        features.iter().zip(variant).map(|(f, w)| f * w).sum::<f64>().exp()
                    });
                    sum_over_slopes.sum()
                })
            };
            let mass: Vec<f64> = (0..RUNGS).map(|rung| of_row(2 * rung + 1)).collect();
            let whole: f64 = mass.iter().sum();
            mass.iter().map(|m| if whole > 0.0 { m / whole } else { 0.0 }).collect()
        };
        let variants: Vec<_> = variants.iter().map(mass).collect();
        let is_seen = |rung: usize| cells[(2 * rung + 1) * BINS + bin].is_some();
        let known = (0..RUNGS).filter(|rung| is_seen(*rung)).count();
        let value = |rung: usize| {
            let (mut spread, mut unseen) = (0.0, 1.0);
            for (share, distance) in tolerance.iter().zip(least..) {
                let Some(rung) = rung.checked_add_signed(distance).filter(|rung| *rung < RUNGS) else {
                    continue;
                };
                spread += variants.iter().map(|v| share * v[rung]).sum::<f64>() / variants.len() as f64;
                unseen -= if is_seen(rung) { *share } else { 0.0 };
            }
            if known < 30 { 0.0 } else { (0.5 * (known as f64 * spread + unseen) + 0.5).ln() }
        };
        (0..RUNGS).map(value).collect()
    };
    let columns: Vec<Vec<f64>> = (0..BINS).into_par_iter().map(column).collect();
    (0..RUNGS * BINS).map(|index| columns[index % BINS][index / BINS]).collect()
}

/// Gray levels of a bin of a histogram, and bins.
const STEP: f64 = 22.0;
const HISTOGRAM: usize = 12;

/// Log-likelihood ratio of "floor" against "wall" by gray level.
fn region(floor: &[Cell], ceiling: &[Cell]) -> impl Fn(f64) -> f64 + Sync + use<> {
    let near = histogram(&[(floor, 38.0..=62.0)]);
    let far = histogram(&[(floor, 1.5..=8.0), (ceiling, 1.5..=14.0)]);
    let of_bin: Vec<f64> =
        near.iter().zip(far).map(|(a, b)| ((a + 0.0014) / (b + 0.0014)).ln().clamp(-1.5, 1.5)).collect();
    move |gray| {
        let position = gray / STEP + 0.5;
        let below = (position.floor() as isize - 1).max(0) as usize;
        let above = (position.floor() as usize).min(HISTOGRAM - 1);
        of_bin[below] + (of_bin[above] - of_bin[below]) * position.fract()
    }
}

fn histogram(parts: &[(&[Cell], std::ops::RangeInclusive<f64>)]) -> [f64; HISTOGRAM] {
    let mut counts = [0.0; HISTOGRAM];
    for (cells, degrees) in parts {
        for (index, cell) in cells.iter().enumerate() {
            let cot = log_range((index / BINS) as f64).exp();
            if let (Some((gray, _)), true) = (cell, degrees.contains(&(1.0 / cot).atan().to_degrees())) {
                counts[(gray / STEP) as usize] += cot / (1.0 + cot * cot);
            }
        }
    }
    let whole: f64 = counts.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    std::array::from_fn(|bin| {
        let at = |bin: usize| counts.get(bin).copied().unwrap_or(0.0);
        (at(bin.wrapping_sub(1)) + 2.0 * at(bin) + at(bin + 1)) / (4.0 * whole)
    })
}
