//! What must not be said: poses for frames that show another building, or nothing that can be seen, or that are read with the wrong
//! lens or mounting. The bounds are of the answers that a robot would act on.

use compass_core::{HeightPrior, Settings};
use compass_host::calibration::{Calibration, NOMINAL_YAML};
use compass_host::dataset::tum::Pose;
use compass_host::plan_import::{PlanOptions, PlanRaster, load};
use compass_host::site::{BuildOptions, PackedPlan};
use compass_host::site_file::{SiteFile, floor_bytes};
use compass_host::up::Mount;
use compass_host::{Frame, Locator, localize};
use compass_tests::{sample_frames, sample_plan, sample_site};
use image::{GrayImage, Luma, RgbImage, imageops};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::Path;

const SIZE: (u32, u32) = (368, 360);
/// A robot acts on what is this probable.
const SURE: f32 = 0.8;
/// What is less probable is not said.
const SAID: f32 = 0.5;

/// Answers of a kind.
#[derive(Debug, Default)]
struct Tally {
    of: usize,
    right: usize,
    wrong: usize,
    wrong_and_sure: usize,
}

/// Poses in rooms of the sample building.
fn poses() -> Vec<Pose> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let (_, plan) = sample_plan();
    let mut poses = Vec::new();
    while poses.len() < 12 {
        let at = [random.random_range(1.5..30.5), random.random_range(1.5..20.5)];
        let heading = random.random_range(-180.0..180.0);
        let Ok(scan) = plan.scan(at, heading) else { continue };
        let inside = scan.steps.iter().all(|steps| (30..1500).contains(steps));
        if inside {
            let height = random.random_range(1.2..1.7);
            poses.push(Pose::looking(0, [at[0], at[1], height], heading, 3.0, 178.0));
        }
    }
    poses
}

type Pair = [RgbImage; 2];

/// A building that is not the sample: rooms of random sizes along a corridor.
fn foreign_site(folder: &Path, seed: u64) -> SiteFile {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let [width, height] = [random.random_range(900..1400), random.random_range(700..1000)];
    let mut plan = GrayImage::from_pixel(width + 100, height + 100, Luma([255]));
    let mut fill = |[x, y]: [u32; 2], [w, h]: [u32; 2]| {
        for (x, y) in (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y))) {
            plan.put_pixel(x, y, Luma([0]));
        }
    };
    for (at, size) in [
        ([50, 50], [width, 15]),
        ([50, 35 + height], [width, 15]),
        ([50, 50], [15, height]),
        ([35 + width, 50], [15, height]),
    ] {
        fill(at, size);
    }
    let corridor = random.random_range(height / 3..height / 2);
    for (from, to) in [(50, 50 + corridor), (50 + corridor + 100, 35 + height)] {
        let mut x = 50;
        while x + 250 < 50 + width {
            let room = random.random_range(125..350).min(width + 50 - x);
            fill([x + room - 5, from], [5, to - from]);
            // The wall to the corridor, with a door of 0.45 m on either side of it in pixels of 0.02 m.
            let wall = if from == 50 { to - 5 } else { from };
            let door = random.random_range(10..room - 60);
            fill([x, wall], [door, 5]);
            fill([x + door + 45, wall], [room - door - 45, 5]);
            x += room;
        }
    }
    let path = folder.join(format!("foreign{seed}.png"));
    plan.save(&path).unwrap();
    let raster = load(&PlanOptions { resolution_m: Some(0.02), ..PlanOptions::new(path) }).unwrap();
    site_of(folder, &raster)
}

fn site_of(folder: &Path, raster: &PlanRaster) -> SiteFile {
    let plan = PackedPlan::new(raster).unwrap();
    let bytes = floor_bytes("foreign", raster, &plan, None, &BuildOptions::default()).unwrap();
    let path = folder.join("foreign.site");
    std::fs::write(&path, bytes).unwrap();
    SiteFile::read(&path).unwrap()
}

/// What is told of the frames.
struct Told {
    calibration: Calibration,
    mount: Mount,
}

impl Told {
    fn right() -> Self {
        Self { calibration: Calibration::nominal(), mount: Mount::Inverted }
    }
}

/// Localizes pairs on a site; an answer that is not at its pose is wrong, as is any if there is no pose.
fn tally<'a>(site: &SiteFile, told: &Told, pairs: impl Iterator<Item = (&'a Pair, Option<Pose>)>) -> Tally {
    let floors = site.floors();
    let rig = told.calibration.rig([Some(SIZE); 2]).unwrap();
    let mut locator = Locator::new(&floors, rig, Settings::FULL).unwrap();
    let mut tally = Tally::default();
    for (pair, truth) in pairs {
        tally.of += 1;
        let frames = pair.clone().map(Frame::from_rgb);
        let frames = frames.each_ref().map(Option::as_ref);
        // That no direction is vertical is an answer too.
        let Ok(fix) = localize(&mut locator, frames, told.mount, HeightPrior::UNKNOWN) else { continue };
        let (Some(pose), probability) = (fix.pose(), fix.probability()) else { continue };
        let is_right = truth.is_some_and(|truth| {
            let [x, y] = [pose.at.x.to_num::<f64>(), pose.at.y.to_num::<f64>()];
            let turn =
                compass_tests::angle(f64::from(pose.heading.to_microdegrees()) / 1e6, truth.heading_deg());
            (x - truth.position.x).hypot(y - truth.position.y) <= 1.0 && turn.abs() <= 30.0
        });
        match (probability >= SAID, is_right) {
            (true, true) => tally.right += 1,
            (true, false) => {
                tally.wrong += 1;
                tally.wrong_and_sure += usize::from(probability >= SURE);
            }
            (false, _) => {}
        }
    }
    tally
}

fn mapped(pair: &Pair, level: impl Fn(u8) -> u8) -> Pair {
    pair.clone().map(|mut frame| {
        frame.iter_mut().for_each(|sample| *sample = level(*sample));
        frame
    })
}

#[test]
fn what_shows_nothing_or_another_building_is_not_said() {
    let folder = tempfile::tempdir().unwrap();
    let home = {
        let path = folder.path().join("sample.site");
        std::fs::write(&path, sample_site()).unwrap();
        SiteFile::read(&path).unwrap()
    };
    let poses = poses();
    let pairs: Vec<Pair> = poses.iter().map(|pose| sample_frames(pose, SIZE)).collect();
    let with_truth = |pairs: &[Pair]| {
        let right = Told::right();
        let truths = poses.iter().map(|pose| Some(*pose));
        tally(&home, &right, pairs.iter().zip(truths))
    };
    let own = with_truth(&pairs);
    assert!(own.right >= 6 && own.wrong == 0, "what is left to say: {own:?}");

    let changed = |change: &dyn Fn(&Pair) -> Pair| pairs.iter().map(change).collect::<Vec<_>>();
    let dark = changed(&|pair| mapped(pair, |level| level / 40));
    let bright = changed(&|pair| mapped(pair, |level| level.saturating_mul(9)));
    let blurred = changed(&|pair| pair.each_ref().map(|frame| imageops::fast_blur(frame, 9.0)));
    let turned = changed(&|pair| {
        pair.each_ref().map(|frame| {
            let quarter = imageops::rotate90(frame);
            imageops::resize(&quarter, SIZE.0, SIZE.1, imageops::FilterType::Triangle)
        })
    });
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut noise = || RgbImage::from_fn(SIZE.0, SIZE.1, |_, _| image::Rgb([random.random::<u8>(); 3]));
    let noise: Vec<Pair> = (0..4).map(|_| [noise(), noise()]).collect();

    let path = folder.path().join("wide.yaml");
    std::fs::write(&path, NOMINAL_YAML.replace("[232.", "[372.")).unwrap();
    let wide = Calibration::load(&path).unwrap();
    assert_ne!(wide.cameras, Calibration::nominal().cameras);
    let wrong_lens = Told { calibration: wide, mount: Mount::Inverted };
    let upside_down = Told { calibration: Calibration::nominal(), mount: Mount::Upright };
    let nowhere = |pairs: &[Pair], site: &SiteFile, told: &Told| {
        tally(site, told, pairs.iter().zip(std::iter::repeat(None)))
    };
    let right = Told::right();
    let mut kinds = vec![
        ("dark", with_truth(&dark)),
        ("bright", with_truth(&bright)),
        ("blurred", with_truth(&blurred)),
        ("turned", nowhere(&turned, &home, &right)),
        ("noise", nowhere(&noise, &home, &right)),
        ("wrong lens", nowhere(&pairs, &home, &wrong_lens)),
        ("upside down", nowhere(&pairs, &home, &upside_down)),
    ];
    for seed in 1..=3 {
        kinds.push(("foreign", nowhere(&pairs, &foreign_site(folder.path(), seed), &right)));
    }
    for (kind, tally) in &kinds {
        println!("{kind}: {tally:?}");
    }
    let sum = |count: fn(&Tally) -> usize| kinds.iter().map(|(_, tally)| count(tally)).sum::<usize>();
    let (of, wrong, sure) =
        (sum(|tally| tally.of), sum(|tally| tally.wrong), sum(|tally| tally.wrong_and_sure));
    assert!(wrong * 100 <= of * 3 && sure == 0, "of {of}: {wrong} wrong, {sure} of them sure: {kinds:?}");
}
