//! The core against the float reference, stage by stage.
//!
//! The bounds are the core's own, declared beside each stage's type.

pub mod camera;
pub mod segments;
pub mod sight;

use crate::calibration::CalibrationError;
use crate::interior::{self, InteriorError, InteriorOptions, Places};
use crate::plan_import::PlanRaster;
use crate::progress::{Progress, Silent};
use crate::reference;
use crate::site::PackedPlan;
use compass_core::base::confidence::Confidence;
use compass_core::base::scan::Scan;
use compass_core::descriptor::channels::{DEVIATION_REACH, LEVEL_ERROR};
use compass_core::descriptor::similarity::{Candidate, Query, SCORE_ERROR, Similarity, Weights};
use compass_core::descriptor::spectrum::{self, Complex, Correlator, FFT_SNR_DB, FFT_WORST_LSB};
use compass_core::descriptor::{Channel, Descriptor};
use compass_core::map::plan::AGREEING_RAYS_PPM;
use compass_core::vision::segments::SegmentsError;
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex64};
use thiserror::Error;

/// Why stages could not be compared on a plan.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The plan has no interior.
    #[error(transparent)]
    Interior(#[from] InteriorError),
    /// The nominal calibration does not fit the frames.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The detector refused a frame.
    #[error(transparent)]
    Segments(#[from] SegmentsError),
    /// A frame was not rendered.
    #[error("a rendered frame")]
    Frame,
    /// The up vector defines no heading.
    #[error("a heading")]
    Heading,
}

/// One stage of the comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Name of the quantity compared.
    pub name: &'static str,
    /// Unit of the three figures.
    pub unit: &'static str,
    /// The worst difference (for shares and ratios: the lowest value).
    pub worst: f64,
    /// The median difference.
    pub typical: f64,
    /// The bound of the worst (for shares and ratios: the least value).
    pub bound: f64,
    /// Number of values compared.
    pub compared: usize,
    /// Whether the bound holds.
    pub in_bounds: bool,
}

impl Stage {
    fn at_most(name: &'static str, unit: &'static str, mut differences: Vec<f64>, bound: f64) -> Self {
        differences.sort_by(f64::total_cmp);
        let worst = differences.last().copied().unwrap_or(0.0);
        let typical = differences.get(differences.len() / 2).copied().unwrap_or(0.0);
        Self { name, unit, worst, typical, bound, compared: differences.len(), in_bounds: worst <= bound }
    }

    fn at_least(name: &'static str, unit: &'static str, mut values: Vec<f64>, bound: f64) -> Self {
        values.sort_by(f64::total_cmp);
        let worst = values.first().copied().unwrap_or(bound);
        let typical = values.get(values.len() / 2).copied().unwrap_or(bound);
        Self { name, unit, worst, typical, bound, compared: values.len(), in_bounds: worst >= bound }
    }

    /// The ratio of the first to the second of two counts, with a bound in parts per million.
    fn share(name: &'static str, [alike, all]: [usize; 2], least_ppm: u32) -> Self {
        let share = alike as f64 / all.max(1) as f64;
        let stage = Self::at_least(name, "share", vec![share], f64::from(least_ppm) / 1e6);
        Self { compared: all, ..stage }
    }
}

/// A pose with the scans of both implementations.
struct Pair {
    fixed: Scan,
    float: reference::Scan,
}

impl Pair {
    fn agrees(&self, bin: usize) -> bool {
        let steps = (self.float.range_m[bin] / reference::march::STEP_M).round();
        self.fixed.hit[bin] == self.float.hit[bin] && (f64::from(self.fixed.steps[bin]) - steps).abs() <= 1.0
    }

    /// Whether all ranges that a channel value depends on are equal.
    fn equal_around(&self, bin: usize, reach: usize) -> bool {
        (0..=2 * reach).map(|k| (bin + 360 + k - reach) % 360).all(|j| {
            let steps = (self.float.range_m[j] / reference::march::STEP_M).round();
            self.fixed.hit[j] == self.float.hit[j] && f64::from(self.fixed.steps[j]) == steps
        })
    }
}

/// Compares all stages at `poses` random interior positions of a plan, with random headings.
///
/// # Errors
/// A plan without interior.
pub fn compare(
    raster: &PlanRaster,
    plan: &PackedPlan,
    poses: usize,
    seed: u64,
) -> Result<Vec<Stage>, InteriorError> {
    compare_with_progress(raster, plan, &Places::default(), poses, seed, &Silent)
}

/// [`compare`] with the inside at `places`, if they name any, and with progress reports.
///
/// # Errors
/// As [`compare`], and a place that cannot be inside.
pub fn compare_with_progress(
    raster: &PlanRaster,
    plan: &PackedPlan,
    places: &Places,
    poses: usize,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<Stage>, InteriorError> {
    let poses = poses_in_places(raster, places, poses, seed)?;
    let float_plan = reference::Plan::new(
        &raster.walls_mask(),
        &raster.windows_mask(),
        raster.resolution_m,
        raster.origin,
    );
    let steps = progress.begin(poses.len(), "casting poses");
    let cast = |&(x, y, heading): &(f64, f64, f64)| {
        steps.step();
        Some(Pair { fixed: plan.scan([x, y], heading).ok()?, float: float_plan.scan(x, y, heading)? })
    };
    let pairs: Vec<Pair> = poses.par_iter().filter_map(cast).collect();
    drop(steps);
    let mut stages = vec![march_stage(&pairs)];
    stages.extend(channel_stages(&pairs));
    stages.extend(fft_stages(seed));
    stages.extend(score_stages(&pairs));
    Ok(stages)
}

/// Random free positions inside the building, in cells without occupied pixels.
///
/// # Errors
/// A plan without interior.
pub fn interior_poses(
    raster: &PlanRaster,
    count: usize,
    seed: u64,
) -> Result<Vec<(f64, f64, f64)>, InteriorError> {
    poses_in_places(raster, &Places::default(), count, seed)
}

/// [`interior_poses`] with the inside at `places`, if they name any.
///
/// # Errors
/// As [`interior_poses`], and a place that cannot be inside.
pub fn poses_in_places(
    raster: &PlanRaster,
    places: &Places,
    count: usize,
    seed: u64,
) -> Result<Vec<(f64, f64, f64)>, InteriorError> {
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let options = InteriorOptions::with_places(places.clone(), raster.origin);
    let inside = interior::find(&walls, &windows, raster.resolution_m, &options)?;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut poses = Vec::with_capacity(count);
    // An interior is at least a square metre, but it may be a small part of a large raster.
    for _ in 0..count.saturating_mul(1_000_000) {
        if poses.len() == count {
            break;
        }
        let (u, v) = (rng.random::<f64>(), rng.random::<f64>());
        let (column, row) = (u * f64::from(raster.width), v * f64::from(raster.height));
        if inside.is_inside_px(column as u32, row as u32) {
            let x = raster.origin[0] + column * raster.resolution_m;
            let y = raster.origin[1] + row * raster.resolution_m;
            poses.push((x, y, rng.random::<f64>() * 360.0));
        }
    }
    Ok(poses)
}

fn march_stage(pairs: &[Pair]) -> Stage {
    let agreeing: usize = pairs.iter().map(|p| (0..360).filter(|&j| p.agrees(j)).count()).sum();
    let rays = 360 * pairs.len();
    Stage::share("march: rays of the same hit within one step", [agreeing, rays], AGREEING_RAYS_PPM)
}

fn channel_stages(pairs: &[Pair]) -> Vec<Stage> {
    let names = [
        "descriptor: channel 0, r / r_max",
        "descriptor: channel 1, hit type",
        "descriptor: channel 2, |dr/dtheta| / 5 m",
        "descriptor: channel 3, 1 / (1 + r)",
        "descriptor: channel 4, std(r) / 10 m",
    ];
    let reach = [0, 0, 1, 0, DEVIATION_REACH];
    let described: Vec<_> =
        pairs.par_iter().map(|p| (p, Descriptor::from(&p.fixed), reference::descriptor(&p.float))).collect();
    let stage = |channel: Channel| {
        let c = channel as usize;
        let differences = described.iter().flat_map(|(pair, fixed, float)| {
            (0..360)
                .filter(move |&j| pair.equal_around(j, reach[c]))
                .map(move |j| (fixed.channel(channel)[j].to_num::<f64>() - float[c][j]).abs())
        });
        Stage::at_most(names[c], "level", differences.collect(), LEVEL_ERROR.to_num())
    };
    Channel::ALL.map(stage).into()
}

fn fft_stages(seed: u64) -> [Stage; 2] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut snr, mut worst) = (Vec::new(), Vec::new());
    for _ in 0..50 {
        let mut part = || rng.random_range(-(1 << 29)..=1 << 29);
        let signal: Vec<Complex> = (0..1024).map(|_| Complex { re: part(), im: part() }).collect();
        let mut float: Vec<Complex64> =
            signal.iter().map(|c| Complex64::new(c.re.into(), c.im.into())).collect();
        FftPlanner::new().plan_fft_forward(1024).process(&mut float);
        let mut fixed = signal;
        assert!(spectrum::forward(&mut fixed), "1024 points are supported");
        let (mut power, mut noise) = (0.0, 0.0);
        for (k, expected) in float.iter().enumerate() {
            let found = fixed[k.reverse_bits() >> (usize::BITS - 10)];
            let error = Complex64::new(found.re.into(), found.im.into()) - expected / 1024.0;
            power += expected.norm_sqr() / 1024.0 / 1024.0;
            noise += error.norm_sqr();
            worst.push(error.re.abs().max(error.im.abs()));
        }
        snr.push(10.0 * (power / noise).log10());
    }
    [
        Stage::at_least("spectrum: signal to noise, 1024 points", "dB", snr, f64::from(FFT_SNR_DB)),
        Stage::at_most("spectrum: worst part", "LSB", worst, f64::from(FFT_WORST_LSB)),
    ]
}

/// Scores of neighbouring poses against each other: the fixed-point descriptor's through the FFT and at its exact
/// peak, the float one's by direct sums.
fn score_stages(pairs: &[Pair]) -> Vec<Stage> {
    let weights = [1.0; 5];
    let sample = &pairs[..pairs.len().min(41)];
    let stage = |similarity: Similarity| {
        let centred = similarity == Similarity::Centred;
        let (mut scores, mut peaks) = (Vec::new(), Vec::new());
        let (mut query, mut correlator) = (Box::new(Query::EMPTY), Box::new(Correlator::new()));
        for (a, b) in sample.iter().zip(sample.iter().skip(1)) {
            query.set(&Descriptor::from(&a.fixed), &Confidence::CERTAIN, Weights::EQUAL, similarity);
            query.load(&mut correlator);
            let candidate = Candidate::from(&Descriptor::from(&b.fixed));
            let mut found = [Default::default(); 360];
            query.scores(&candidate, &mut correlator, &mut found);
            let fixed_a = float_levels(&Descriptor::from(&a.fixed));
            let fixed_b = float_levels(&Descriptor::from(&b.fixed));
            let (expected, _) = reference::similarity::scores(&fixed_a, &fixed_b, &weights, centred);
            scores.extend(found.iter().zip(&expected).map(|(f, e)| (f.to_num::<f64>() - e).abs()));
            let peak = query.peak(&candidate, &mut correlator);
            let best = expected.iter().copied().fold(f64::MIN, f64::max);
            // Ties may resolve differently: compare with the float score at the same shift.
            peaks.push(best - expected[usize::from(peak.shift)]);
        }
        let bound = SCORE_ERROR.to_num();
        let names = if centred {
            ["similarity: centred score through the FFT", "similarity: centred score lost at the peak found"]
        } else {
            ["similarity: plain score through the FFT", "similarity: plain score lost at the peak found"]
        };
        [Stage::at_most(names[0], "score", scores, bound), Stage::at_most(names[1], "score", peaks, bound)]
    };
    [Similarity::Plain, Similarity::Centred].into_iter().flat_map(stage).collect()
}

/// A fixed-point descriptor as floats.
#[must_use]
pub fn float_levels(descriptor: &Descriptor) -> reference::descriptor::Channels {
    descriptor.levels.map(|channel| channel.map(|level| level.to_num()))
}
