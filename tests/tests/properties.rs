//! Properties of matching over arbitrary scans, and the exact search against an exhaustive one.

use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, ChannelValue, Score};
use compass_core::base::scan::{Hit, MAX_STEPS, Scan};
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::Match;
use compass_core::descriptor::similarity::{Candidate, Peak, Query, Similarity, Weights};
use compass_core::descriptor::spectrum::Correlator;
use compass_core::map::site_map::SiteMap;
use compass_host::compare::interior_poses;
use compass_host::localizer::{Localizer, MatchOptions};
use compass_host::noise::disturb;
use compass_tests::{sample_map, sample_plan};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;

const KINDS: [Similarity; 2] = [Similarity::Plain, Similarity::Centred];

/// Scans of a few stretches each, as in rooms.
fn any_scan() -> impl Strategy<Value = Scan> {
    let stretch = (1..60_usize, 1..=MAX_STEPS, 0..3_u8, -8..8_i32);
    vec(stretch, 1..40).prop_map(|stretches| {
        let mut bins = stretches.iter().cycle().flat_map(|&(length, steps, hit, slope)| {
            (0..length as i32).map(move |k| ((i32::from(steps) + k * slope).clamp(1, 1500) as u16, hit))
        });
        let mut scan = Scan::OPEN;
        for (steps, hit) in scan.steps.iter_mut().zip(&mut scan.hit) {
            let (s, h) = bins.next().unwrap();
            (*steps, *hit) = match h {
                0 => (s, Hit::Wall),
                1 => (s, Hit::Window),
                _ => (MAX_STEPS, Hit::Open),
            };
        }
        scan
    })
}

fn any_kind() -> impl Strategy<Value = Similarity> {
    prop_oneof![Just(Similarity::Plain), Just(Similarity::Centred)]
}

fn any_weights() -> impl Strategy<Value = Weights> {
    proptest::array::uniform5(0..=255_u8).prop_map(Weights)
}

fn query(scan: &Scan, confidence: &Confidence, weights: Weights, kind: Similarity) -> Box<Query> {
    let mut query = Box::new(Query::EMPTY);
    query.set(&Descriptor::from(scan), confidence, weights, kind);
    query
}

fn certain(scan: &Scan, kind: Similarity) -> Box<Query> {
    query(scan, &Confidence::CERTAIN, Weights::EQUAL, kind)
}

fn candidate(scan: &Scan) -> Candidate {
    Candidate::from(&Descriptor::from(scan))
}

fn turned(scan: &Scan, degrees: usize) -> Scan {
    let mut scan = *scan;
    scan.steps.rotate_left(degrees);
    scan.hit.rotate_left(degrees);
    scan
}

fn peak(query: &Query, candidate: &Candidate) -> Peak {
    let mut correlator = Correlator::new();
    query.load(&mut correlator);
    query.peak(candidate, &mut correlator)
}

/// The best candidate and heading by scoring all candidates at all headings; the first of equal ones.
fn brute_force(map: &SiteMap<'_>, query: &Query) -> Match {
    let mut scan = Scan::OPEN;
    let mut best = Match::NONE;
    let mut correlator = Correlator::new();
    query.load(&mut correlator);
    for (number, record) in (0..).zip(map.iter()) {
        record.scan(&mut scan);
        // That it is the best of all shifts is a separate property, below.
        let peak = query.peak(&candidate(&scan), &mut correlator);
        if peak.score_bits > best.peak.score_bits {
            best = Match { candidate: number, peak };
        }
    }
    best
}

fn assert_exact(localizer: &mut Localizer<'_>, scan: &Scan, options: &MatchOptions, what: &str) {
    let answer = localizer.locate(scan, options);
    let expected =
        brute_force(localizer.map(), &query(scan, &Confidence::CERTAIN, options.weights, options.similarity));
    assert_eq!(answer.best(), Some(&expected), "{what}");
    assert!(answer.exhaustive, "{what}");
}

#[test]
fn the_exact_search_finds_what_scoring_everything_finds() {
    let (raster, plan) = sample_plan();
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    for (seed, (x, y, heading)) in (0..).zip(interior_poses(raster, 6, 77).unwrap()) {
        for level in [0.0, 1.0, 4.0] {
            let mut scan = plan.scan([x, y], heading).unwrap();
            disturb(&mut scan, level, seed);
            for similarity in KINDS {
                let weights = if seed % 2 == 0 { Weights::EQUAL } else { Weights([3, 40, 0, 9, 1]) };
                let options = MatchOptions { similarity, weights, prefilter: None };
                let what = format!("{x},{y} {heading}, noise {level}, {similarity:?}, {weights:?}");
                assert_exact(&mut localizer, &scan, &options, &what);
            }
        }
    }
}

#[test]
fn the_exact_search_holds_for_scans_from_nowhere() {
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for number in 0..6 {
        let scan = any_scan().new_tree(&mut runner).unwrap().current();
        for similarity in KINDS {
            let options = MatchOptions { similarity, ..MatchOptions::default() };
            assert_exact(&mut localizer, &scan, &options, &format!("scan {number}, {similarity:?}"));
        }
    }
}

/// Half of the circle is observed, some of it with low confidence.
#[test]
fn the_masked_search_finds_what_scoring_everything_finds() {
    let (raster, plan) = sample_plan();
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    let seen =
        Confidence::new(&core::array::from_fn(|bin| if bin < 180 { 16 - (bin / 20) as u8 } else { 0 }));
    for (seed, (x, y, heading)) in (0..).zip(interior_poses(raster, 2, 78).unwrap()) {
        let mut scan = plan.scan([x, y], heading).unwrap();
        disturb(&mut scan, 1.0, seed);
        for (similarity, weights) in [
            (Similarity::Plain, Weights::EQUAL),
            (Similarity::Centred, Weights::EQUAL),
            (Similarity::Centred, Weights::HIT_TYPE),
        ] {
            let options = MatchOptions { similarity, weights, prefilter: None };
            let answer = localizer.locate_masked(&scan, &seen, &options);
            let expected = brute_force(localizer.map(), &query(&scan, &seen, weights, similarity));
            assert_eq!(answer.best(), Some(&expected), "{x},{y} {heading}, {similarity:?}, {weights:?}");
            assert!(answer.exhaustive);
        }
    }
}

/// A round room without windows scores the same at every heading: some candidate must still win.
#[test]
fn the_exact_search_survives_a_query_without_features() {
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    for steps in [1, 100, 1500] {
        let scan = Scan { steps: [steps; BINS], hit: [Hit::Wall; BINS] };
        let options = MatchOptions { similarity: Similarity::Plain, ..MatchOptions::default() };
        assert_exact(&mut localizer, &scan, &options, &format!("all {steps} steps"));
    }
}

#[test]
fn turning_the_query_turns_the_heading() {
    let (raster, plan) = sample_plan();
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    for (seed, (x, y, heading)) in (0..).zip(interior_poses(raster, 4, 5).unwrap()) {
        let mut scan = plan.scan([x, y], heading).unwrap();
        disturb(&mut scan, 1.0, seed);
        for similarity in KINDS {
            let options = MatchOptions { similarity, ..MatchOptions::default() };
            let first = *localizer.locate(&scan, &options).best().unwrap();
            for degrees in [1, 90, 123, 359] {
                let found = *localizer.locate(&turned(&scan, degrees), &options).best().unwrap();
                assert_eq!(found.candidate, first.candidate);
                assert_eq!(usize::from(found.peak.shift), (usize::from(first.peak.shift) + degrees) % BINS);
                assert_eq!(found.peak.score_bits, first.peak.score_bits);
            }
        }
    }
}

#[test]
fn a_pose_turned_on_the_spot_is_found_turned() {
    let (_, plan) = sample_plan();
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    let mut find = |heading: f64| {
        let scan = plan.scan([13.37, 3.68], heading).unwrap();
        *localizer.locate(&scan, &MatchOptions::default()).best().unwrap()
    };
    let first = find(10.0);
    for degrees in [0_u16, 45, 200, 345] {
        let found = find(10.0 + f64::from(degrees));
        assert_eq!(found.candidate, first.candidate, "turned by {degrees}");
        assert_eq!(found.peak.shift, (first.peak.shift + degrees) % 360, "turned by {degrees}");
    }
}

/// An open field, or hit types alone with only walls, have no contrast to compare.
#[test]
fn a_query_of_norm_zero_scores_zero() {
    let flat = Scan { steps: [200; BINS], hit: [Hit::Wall; BINS] };
    let (_, plan) = sample_plan();
    let room = plan.scan([13.37, 3.68], 0.0).unwrap();
    let unknown = Confidence::new(&[0; BINS]);
    let cases = [
        query(&flat, &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred),
        query(&room, &unknown, Weights::EQUAL, Similarity::Plain),
        query(&room, &unknown, Weights::EQUAL, Similarity::Centred),
        query(&room, &Confidence::CERTAIN, Weights([0; 5]), Similarity::Plain),
        query(&Scan::OPEN, &Confidence::CERTAIN, Weights::HIT_TYPE, Similarity::Plain),
    ];
    let mut correlator = Correlator::new();
    for (number, query) in cases.iter().enumerate() {
        assert_eq!(query.squared_norm(), 0, "case {number}");
        for other in [&room, &flat, &Scan::OPEN] {
            let other = candidate(other);
            query.load(&mut correlator);
            assert_eq!(
                query.peak(&other, &mut correlator),
                Peak { shift: 0, score_bits: 0 },
                "case {number}"
            );
            let mut scores = [Score::ONE; BINS];
            query.scores(&other, &mut correlator, &mut scores);
            assert!(scores.iter().all(|s| *s == 0), "case {number}");
        }
    }
    // The search returns without a panic, and without a result.
    let mut localizer = Localizer::new(SiteMap::new(sample_map()).unwrap());
    let answer = localizer.locate(&flat, &MatchOptions::default());
    assert_eq!(answer.margin(), 0);
    assert!(answer.best().is_none_or(|best| best.peak.score_bits == 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn proptest_scores_are_cosines(a in any_scan(), b in any_scan(), kind in any_kind(), weights in any_weights()) {
        let query = query(&a, &Confidence::CERTAIN, weights, kind);
        let other = candidate(&b);
        for shift in 0..BINS {
            let score: f64 = query.score(&other, shift).to_num();
            let lowest = if kind == Similarity::Plain { 0.0 } else { -1.0 };
            prop_assert!((lowest..=1.0).contains(&score), "{score}");
        }
    }

    #[test]
    fn proptest_a_scan_fits_itself_turned(scan in any_scan(), degrees in 0..BINS, kind in any_kind()) {
        let query = certain(&turned(&scan, degrees), kind);
        prop_assume!(query.squared_norm() > 0);
        let score: f64 = query.score(&candidate(&scan), degrees).to_num();
        prop_assert!((score - 1.0).abs() < 1e-6, "{score}");
    }

    #[test]
    fn proptest_turning_moves_the_peak(a in any_scan(), b in any_scan(), degrees in 0..BINS, kind in any_kind()) {
        let other = candidate(&b);
        let (straight, round) = (certain(&a, kind), certain(&turned(&a, degrees), kind));
        let (first, second) = (peak(&straight, &other), peak(&round, &other));
        prop_assert_eq!(first.score_bits, second.score_bits);
        // Of equal peaks the first is chosen, so the shift may be another one with the same score.
        let back = (usize::from(second.shift) + BINS - degrees) % BINS;
        prop_assert_eq!(straight.score(&other, back).to_bits(), first.score_bits);
    }

    #[test]
    fn proptest_the_peak_is_the_best_of_all_shifts(a in any_scan(), b in any_scan(), kind in any_kind()) {
        let (query, other) = (certain(&a, kind), candidate(&b));
        let scores: Vec<i32> = (0..BINS).map(|shift| query.score(&other, shift).to_bits()).collect();
        let best = *scores.iter().max().unwrap();
        let shift = scores.iter().position(|s| *s == best).unwrap() as u16;
        prop_assert_eq!(peak(&query, &other), Peak { shift, score_bits: best });
    }

    #[test]
    fn proptest_masked_bins_do_not_count(
        a in any_scan(), other in any_scan(), b in any_scan(), from in 0..BINS, length in 1..300_usize,
        kind in any_kind(), weights in any_weights(), trust in 1..=16_u8,
    ) {
        let hidden: Vec<usize> = (from..from + length).map(|bin| bin % BINS).collect();
        let (mut confidence, mut levels, mut disturbed) = ([trust; BINS], Descriptor::from(&a), Descriptor::from(&a));
        let elsewhere = Descriptor::from(&other);
        for &bin in &hidden {
            confidence[bin] = 0;
            for channel in 0..5 {
                disturbed.levels[channel][bin] = elsewhere.levels[channel][bin];
            }
        }
        let confidence = Confidence::new(&confidence);
        let candidate = candidate(&b);
        let prepared = |descriptor: &Descriptor| {
            let mut query = Box::new(Query::EMPTY);
            query.set(descriptor, &confidence, weights, kind);
            query
        };
        let (clean, masked) = (prepared(&levels), prepared(&disturbed));
        for shift in 0..BINS {
            prop_assert_eq!(clean.score(&candidate, shift), masked.score(&candidate, shift));
        }
        prop_assert_eq!(peak(&clean, &candidate), peak(&masked, &candidate));
        // A bin with confidence does count.
        let seen = (from + length) % BINS;
        levels.levels[1][seen] = ChannelValue::from_num(1.5);
        let changed = prepared(&levels);
        prop_assert_ne!(changed.channel(1), clean.channel(1));
    }

    #[test]
    fn proptest_equal_confidence_is_certainty(a in any_scan(), b in any_scan(), kind in any_kind(), trust in 1..16_u8) {
        let (sure, same) = (certain(&a, kind), query(&a, &Confidence::new(&[trust; BINS]), Weights::EQUAL, kind));
        let other = candidate(&b);
        for shift in (0..BINS).step_by(7) {
            let difference = (sure.score(&other, shift) - same.score(&other, shift)).abs();
            prop_assert!(difference <= 1e-6, "{difference}");
        }
    }
}
