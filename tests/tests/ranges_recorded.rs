//! Ranges and headings from rendered pairs against the plan they were rendered from: needs `COMPASS_DATA`.
//!
//! The frames show the building between its shell and its finished state: some partitions of the plan are missing. A
//! wall surely stands where the plan as drawn and its structure alone meet one at the same range (within 5 %): errors
//! count there, and what hides the wall (clutter, an operator) counts as an error. Where the two differ it is not
//! known which one is seen; those bins count only in the share within 10 % of either, which judges the confidence.

use compass_core::boundary::height_rungs;
use compass_core::camera::Bearing;
use compass_core::descriptor::Descriptor;
use compass_core::likelihood::{Rows, Table};
use compass_core::scan::{Hit, Scan};
use compass_core::sight;
use compass_core::similarity::{Candidate, Query, Similarity, Weights};
use compass_core::windows::level::Sighting;
use compass_host::calibration::Calibration;
use compass_host::dataset::tum::{self, Pose};
use compass_host::eyes::Eyes;
use compass_host::frame::Frame;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
use compass_host::plan_import::{self, PlanOptions};
use compass_host::site::PackedPlan;
use compass_host::surroundings::Surroundings;
use compass_tests::{angle, recordings};
use std::path::Path;

/// Ranges are judged up to here, metres.
const FARTHEST_M: f64 = 8.0;
/// Layers that differ by less show one wall.
const SAME: f64 = 0.05;

/// Largest median relative error of range where the wall surely stands, and least share of bins with an answer.
const MEDIAN: f64 = 0.05;
const ANSWERED: f64 = 0.85;
/// Least share within 10 % of the bins of confidence above 3/4.
const SURE: f64 = 0.6;
/// Pairs, of eight, whose heading the evidence table finds at the true position within [`TURN_DEG`] at least.
const HEADINGS: usize = 6;
const TURN_DEG: f64 = 2.0;

/// The plan as drawn and its structure.
fn layers(data: &Path) -> [PackedPlan; 2] {
    let plans = data.join("hilti/floorplans");
    let mut options = PlanOptions::new(&plans.join("masks_with_windows/floor_1.png"));
    options.walls = Some(plans.join("masks_no_windows/floor_1.png"));
    let raster = plan_import::load(&options).unwrap();
    let structure = keep_structure(&raster, DEFAULT_THICKNESS_M).unwrap();
    [raster, structure].map(|raster| PackedPlan::new(&raster).unwrap())
}

/// What one pair shows.
struct Look {
    pose: Pose,
    seen: Surroundings,
    sighting: Sighting,
    evidence: Box<Table>,
    /// Scans of the layers at the true pose, and at the true position with heading 0; none inside a wall.
    ahead: [Option<Scan>; 2],
    east: [Option<Scan>; 2],
}

fn looks(data: &Path) -> Vec<Look> {
    let rendered = data.join("rendered/floor_1");
    let poses = tum::read(&rendered.join("groundtruth.txt")).unwrap();
    let calibration = Calibration::load(&data.join("hilti/config/kalibr_imucam_chain.yaml")).unwrap();
    let layers = layers(data);
    let mut eyes: Option<Eyes> = None;
    let look = |pose: &Pose| {
        let read = |camera: &str| {
            let name = format!("{}.jpg", pose.timestamp_ns);
            Frame::read(&rendered.join(camera).join("data").join(name)).unwrap()
        };
        let pair = ["cam0", "cam1"].map(read);
        let frames = pair.each_ref().map(Some);
        let eyes = eyes.get_or_insert_with(|| {
            let sizes = pair.each_ref().map(|frame| Some((frame.width(), frame.height())));
            Eyes::new(calibration.rig(sizes).unwrap())
        });
        let up: Bearing = pose.up_in_camera().cast();
        let height_m = pose.position.z as f32;
        eyes.detect(frames).unwrap();
        let sighting = eyes.windows(frames, &up).unwrap().sighting;
        let ranges = eyes.ranges(frames, &up, Some(height_m)).unwrap();
        let mut evidence = Box::new(Table::EMPTY);
        sight::evidence(ranges, height_rungs(height_m), &sighting, &mut evidence);
        let seen = Surroundings::new(ranges, &sighting, Some(height_m));
        let at = [pose.position.x, pose.position.y];
        let scans = |heading: f64| layers.each_ref().map(|layer| layer.scan(at, heading).ok());
        let (ahead, east) = (scans(pose.heading_deg()), scans(0.0));
        Look { pose: *pose, seen, sighting, evidence, ahead, east }
    };
    poses.iter().map(look).collect()
}

fn metres(scan: &Scan, bin: usize) -> f64 {
    f64::from(scan.steps[bin]) * 0.02
}

impl Look {
    /// The range of the wall that surely stands in a bin.
    fn certain(&self, bin: usize) -> Option<f64> {
        let [Some(plan), Some(structure)] = &self.ahead else { return None };
        let (a, b) = (metres(plan, bin), metres(structure, bin));
        ((a - b).abs() <= SAME * b && a < FARTHEST_M && plan.hit[bin] != Hit::Open).then_some(a)
    }

    /// Whether a range lies within 10 % of a layer's.
    fn agrees(&self, bin: usize, range: f64) -> bool {
        self.ahead.iter().flatten().any(|scan| (range / metres(scan, bin) - 1.0).abs() <= 0.1)
    }

    /// Degrees by which the heading of the highest score is off; of both layers the one that scores higher counts.
    fn off(&self, scores: impl Fn(&Scan) -> [f64; 360]) -> f64 {
        let all = self.east.iter().flatten().flat_map(|scan| scores(scan).into_iter().enumerate());
        let best = all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        angle(best.0 as f64, self.pose.heading_deg())
    }

    fn off_by_channels(&self, weights: Weights) -> f64 {
        let mut query = Box::new(Query::EMPTY);
        let Surroundings { scan, confidence, .. } = &self.seen;
        let only_hits = weights == Weights::HIT_TYPE;
        let confidence = if only_hits { &self.sighting.confidence } else { confidence };
        query.set(&Descriptor::from(scan), confidence, weights, Similarity::Centred);
        self.off(|scan| {
            let candidate = Candidate::from(&Descriptor::from(scan));
            std::array::from_fn(|heading| query.score(&candidate, heading).to_num())
        })
    }

    fn off_by_evidence(&self) -> f64 {
        let mut rows = Box::new(Rows::<360>::BLANK);
        rows.set(&self.evidence);
        self.off(|scan| {
            let mut scores = [0; 360];
            rows.scores(&Rows::<360>::planes(scan), &mut scores);
            scores.map(f64::from)
        })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn share(count: usize, of: usize) -> f64 {
    count as f64 / of.max(1) as f64
}

/// Relative errors of range of the bins where a wall surely stands.
fn errors(look: &Look, within: impl Fn(f64) -> bool) -> Vec<f64> {
    let of = |bin: usize| {
        let truth = look.certain(bin).filter(|truth| within(*truth))?;
        Some(f64::from(look.seen.ranges[bin]?.metres) / truth - 1.0)
    };
    (0..360).filter_map(of).collect()
}

fn magnitudes(errors: &[f64]) -> Vec<f64> {
    errors.iter().map(|error| error.abs()).collect()
}

#[test]
fn ranges_are_those_of_the_plan() {
    let Some(data) = recordings("ranges_are_those_of_the_plan") else { return };
    let looks = looks(&data);
    assert_eq!(looks.len(), 8);
    println!(
        "pair: bins with a range; of a wall that surely stands below 8 m; median error, median of its magnitude, share within 10 %; ceiling"
    );
    let mut all = Vec::new();
    let mut answered = 0;
    for look in &looks {
        let known = look.seen.ranges.iter().flatten().count();
        let found = errors(look, |_| true);
        println!(
            "{:5.1} {:5.1}: {known} {:4}  {:+6.3} {:6.3} {:5.2}  ceiling {:.2} m of camera {:.2} m",
            look.pose.position.x,
            look.pose.position.y,
            found.len(),
            median(found.clone()),
            median(magnitudes(&found)),
            share(found.iter().filter(|e| e.abs() <= 0.1).count(), found.len()),
            look.seen.height.ceiling_m,
            look.seen.height.camera_m,
        );
        answered += known;
        all.extend(found);
    }
    for [least, most] in [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 6.0], [6.0, 8.0]] {
        let band: Vec<_> = looks.iter().flat_map(|l| errors(l, |t| (least..most).contains(&t))).collect();
        let near: Vec<_> = band.iter().copied().filter(|e| e.abs() < 0.2).collect();
        println!(
            "{least} to {most} m: {} bins, median error {:+.3} (of those within 20 % {:+.3}), of its magnitude {:.3}",
            band.len(),
            median(band.clone()),
            median(near),
            median(magnitudes(&band))
        );
    }
    let (worst, answered) = (median(magnitudes(&all)), share(answered, 8 * 360));
    println!(
        "all: {} bins, median error {:+.3}, of its magnitude {worst:.3}; answered {answered:.3}",
        all.len(),
        median(all.clone())
    );
    assert!(all.len() > 500 && worst <= MEDIAN, "{} bins, {worst}", all.len());
    assert!(answered >= ANSWERED, "{answered}");
    confidence_is_earned(&looks);
}

fn confidence_is_earned(looks: &[Look]) {
    let mut classes = [[0_usize; 2]; 4];
    let mut sums = [0.0; 4];
    for look in looks {
        for (bin, range) in look.seen.ranges.iter().enumerate().filter_map(|(bin, r)| Some((bin, (*r)?))) {
            let class = ((range.confidence * 4.0) as usize).min(3);
            classes[class][0] += usize::from(look.agrees(bin, f64::from(range.metres)));
            classes[class][1] += 1;
            sums[class] += f64::from(range.confidence);
        }
    }
    for ([right, of], sum) in classes.iter().zip(sums) {
        println!(
            "confidence {:.2}: {of} bins, {:.3} within 10 % of a layer",
            sum / *of as f64,
            share(*right, *of)
        );
    }
    let [low, .., high] = classes.map(|[right, of]| share(right, of));
    assert!(high >= SURE && high > low, "{classes:?}");
}

#[test]
fn headings_are_found_at_the_true_position() {
    let Some(data) = recordings("headings_are_found_at_the_true_position") else { return };
    let looks = looks(&data);
    let range = Weights([16, 0, 0, 0, 0]);
    println!("degrees off by hit type, range, all channels, evidence");
    let mut within = [0; 4];
    for look in &looks {
        let off = [
            look.off_by_channels(Weights::HIT_TYPE),
            look.off_by_channels(range),
            look.off_by_channels(Weights::EQUAL),
            look.off_by_evidence(),
        ];
        let [x, y] = [look.pose.position.x, look.pose.position.y];
        println!("{x:5.1} {y:5.1}: {}", off.map(|off| format!("{off:6.1}")).join(" "));
        within.iter_mut().zip(off).for_each(|(count, off)| *count += usize::from(off <= TURN_DEG));
    }
    println!("within {TURN_DEG} degrees: {within:?} of {}", looks.len());
    assert!(within[3] >= HEADINGS, "{within:?}");
}
