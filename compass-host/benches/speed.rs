//! Speed of scans and queries beside plain float versions, on one thread.
//!
//! With `COMPASS_DATA` on floor 1 of the Hilti-Trimble data at full resolution, else on the bundled sample
//! building. `cargo bench -p compass-host`.

use compass_core::base::confidence::Confidence;
use compass_core::base::num::Turn;
use compass_core::base::scan::Scan;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::{Board, Exact, Group, Index, Match, exhaustive, shortlist};
use compass_core::descriptor::similarity::{Query, Similarity, Weights};
use compass_core::map::site_map::SiteMap;
use compass_core::{HeightPrior, Settings};
use compass_host::compare::interior_poses;
use compass_host::evaluate::perfect;
use compass_host::noise::disturb;
use compass_host::plan_import::{self, PlanOptions, PlanRaster};
use compass_host::reference;
use compass_host::sample;
use compass_host::site::{BuildOptions, PackedPlan, build, point};
use criterion::{Criterion, criterion_group, criterion_main};
use realfft::RealFftPlanner;
use rustfft::num_complex::Complex32;
use std::hint::black_box;
use std::path::PathBuf;

fn plan() -> PlanRaster {
    let Some(data) = std::env::var_os("COMPASS_DATA").map(PathBuf::from) else {
        eprintln!("COMPASS_DATA is unset: measuring on the sample building");
        return sample::building().into();
    };
    let floors = data.join("hilti/floorplans");
    let mut options = PlanOptions::new(floors.join("masks_with_windows/floor_1.png"));
    options.walls = Some(floors.join("masks_no_windows/floor_1.png"));
    plan_import::load(&options).expect("floor_1 of COMPASS_DATA")
}

/// 360 rays at a hundred interior positions in turn.
fn scans(c: &mut Criterion) {
    let raster = plan();
    let packed = PackedPlan::new(&raster).expect("a plan");
    let float = reference::Plan::new(
        &raster.walls_mask(),
        &raster.windows_mask(),
        raster.resolution_m,
        raster.origin,
    );
    let poses = interior_poses(&raster, 100, 1).expect("an interior");
    let free: Vec<_> = poses.into_iter().filter(|&(x, y, h)| packed.scan([x, y], h).is_ok()).collect();
    let (view, mut scan) = (packed.view(), Scan::OPEN);
    let mut group = c.benchmark_group("scan");
    let mut turn = free.iter().cycle();
    group.bench_function("core", |b| {
        b.iter(|| {
            let &(x, y, _) = turn.next().expect("a cycle");
            view.scan(point(x, y).expect("near"), Turn::ZERO, black_box(&mut scan))
        });
    });
    let mut turn = free.iter().cycle();
    group.bench_function("plain float stepping", |b| {
        b.iter(|| {
            let &(x, y, _) = turn.next().expect("a cycle");
            black_box(float.scan(x, y, 0.0))
        });
    });
    group.finish();
}

/// The spectra of one descriptor's channels after their means, and its norm.
fn spectra(scan: &Scan, planner: &mut RealFftPlanner<f32>) -> (Vec<Complex32>, f32) {
    let forward = planner.plan_fft_forward(360);
    let (mut all, mut energy) = (Vec::new(), 0.0);
    for channel in Descriptor::from(scan).levels {
        let mut values = channel.map(|l| l.to_num::<f32>());
        let mean = values.iter().sum::<f32>() / 360.0;
        values.iter_mut().for_each(|v| *v -= mean);
        energy += values.iter().map(|v| v * v).sum::<f32>();
        let mut out = forward.make_output_vec();
        forward.process(&mut values, &mut out).expect("360 points");
        all.extend(out);
    }
    (all, energy.sqrt())
}

/// One query against all candidates at all headings.
fn queries(c: &mut Criterion) {
    let raster = plan();
    let packed = PackedPlan::new(&raster).expect("a plan");
    // About 10,000 candidates on floor 1.
    let options = BuildOptions { spacing_m: 0.32, ..BuildOptions::default() };
    let bytes = build(&raster, &packed, None, &options).expect("a map");
    let map = SiteMap::new(&bytes).expect("a map");
    let mut groups = vec![Group::EMPTY; Index::groups(&map)];
    groups.iter_mut().enumerate().for_each(|(number, group)| group.fill(&map, number));
    let index = Index::new(&groups, &map).expect("the map's own index");
    let mut planner = RealFftPlanner::new();
    let mut scan = Scan::OPEN;
    let stored: Vec<_> = map
        .iter()
        .map(|record| {
            record.scan(&mut scan);
            spectra(&scan, &mut planner)
        })
        .collect();
    let poses = interior_poses(&raster, 40, 2).expect("an interior");
    for noise in [0.0, 1.0] {
        let scans: Vec<Scan> = poses
            .iter()
            .zip(0..)
            .filter_map(|(&(x, y, heading), seed)| {
                let mut scan = packed.scan([x, y], heading).ok()?;
                disturb(&mut scan, noise, seed);
                Some(scan)
            })
            .collect();
        let mut group = c.benchmark_group(format!("query of {} candidates, noise {noise}", map.len()));
        group.sample_size(40);
        bench_core(&mut group, &scans, &map, &index);
        let mut turn = scans.iter().cycle();
        group.bench_function("stored realfft spectra, every candidate", |b| {
            b.iter(|| score_all(turn.next().expect("a cycle"), &stored, &mut planner));
        });
        group.finish();
    }
}

type Group_<'a> = criterion::BenchmarkGroup<'a, criterion::measurement::WallTime>;

fn bench_core(group: &mut Group_<'_>, scans: &[Scan], map: &SiteMap<'_>, index: &Index<'_>) {
    let (mut query, mut work, mut board) =
        (Box::new(Query::EMPTY), Box::<Exact>::default(), Box::<Board>::default());
    let (mut bounds, mut pool) = (vec![0; map.len()], vec![Match::NONE; 512]);
    let set = |query: &mut Query, scan: &Scan| {
        query.set(&Descriptor::from(scan), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
    };
    let mut turn = scans.iter().cycle();
    group.bench_function("exact", |b| {
        b.iter(|| {
            set(&mut query, turn.next().expect("a cycle"));
            exhaustive(index, map, &query, None, &mut work, &mut bounds, &mut pool)
        });
    });
    let mut turn = scans.iter().cycle();
    group.bench_function("shortlist of 48", |b| {
        b.iter(|| {
            set(&mut query, turn.next().expect("a cycle"));
            shortlist(map, &query, None, &mut board, &mut [(0, 0); 48], &mut pool)
        });
    });
}

/// The best centred score, candidate and shift by one inverse transform a candidate.
fn score_all(
    scan: &Scan,
    stored: &[(Vec<Complex32>, f32)],
    planner: &mut RealFftPlanner<f32>,
) -> (f32, usize, usize) {
    let (query, _) = spectra(scan, planner);
    let inverse = planner.plan_fft_inverse(360);
    let (mut sum, mut out) = (inverse.make_input_vec(), inverse.make_output_vec());
    let mut scratch = inverse.make_scratch_vec();
    let mut best = (f32::MIN, 0, 0);
    for (candidate, (spectrum, norm)) in stored.iter().enumerate() {
        for (k, sum) in sum.iter_mut().enumerate() {
            *sum = (0..5).map(|c| query[181 * c + k].conj() * spectrum[181 * c + k]).sum();
        }
        (sum[0].im, sum[180].im) = (0.0, 0.0);
        inverse.process_with_scratch(&mut sum, &mut out, &mut scratch).expect("360 points");
        for (shift, value) in out.iter().enumerate() {
            if value / norm > best.0 {
                best = (value / norm, candidate, shift);
            }
        }
    }
    best
}

/// Perfect evidence against all candidates of a map of 0.5 m, with refinement.
fn likelihoods(c: &mut Criterion) {
    let raster = plan();
    let packed = PackedPlan::new(&raster).expect("a plan");
    let bytes = build(&raster, &packed, None, &BuildOptions::default()).expect("a map");
    let map = SiteMap::new(&bytes).expect("a map");
    let poses = interior_poses(&raster, 20, 3).expect("an interior");
    let (x, y, heading) =
        poses.into_iter().find(|&(x, y, h)| packed.scan([x, y], h).is_ok()).expect("a free pose");
    let evidence = perfect(&packed.scan([x, y], heading).expect("a free pose"));
    let mut group = c.benchmark_group(format!("likelihood of {} candidates", map.len()));
    group.sample_size(20);
    for (name, settings) in [("full", Settings::FULL), ("board", Settings::BOARD)] {
        let memory = vec![0; settings.memory_words(0, 0)];
        let mut locator: compass_core::Locator<'_, Vec<u32>> =
            compass_core::Locator::without_rig(settings, memory).expect("a preset");
        locator.add_floor("floor", map, packed.view()).expect("one layer");
        group.bench_function(name, |b| {
            b.iter(|| {
                locator.recall(&evidence.boundaries(), &evidence.windows()).locate(HeightPrior::camera(1.5))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, scans, queries, likelihoods);
criterion_main!(benches);
