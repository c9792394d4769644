//! `compass demo`: the whole pipeline on the bundled sample building.

use super::exit::Outcome;
use super::pose::Pose;
use super::progress::Bars;
use super::{pictures, plan};
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::base::confidence::Confidence;
use compass_core::base::scan::Scan;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::Answer;
use compass_core::descriptor::similarity::{Candidate, Query, Similarity, Weights};
use compass_core::descriptor::spectrum::Correlator;
use compass_core::map::site_map::SiteMap;
use compass_host::figures::{self, Curve, HitComparison, Scores, Shifts};
use compass_host::localizer::{Localizer, MatchOptions};
use compass_host::noise::disturb;
use compass_host::output::{Decimal, create_dir, write_png};
use compass_host::plan_descriptor::PlanDescriptor;
use compass_host::plan_import::PlanRaster;
use compass_host::report::{Picture, Section, Table, write_html};
use compass_host::sample::{self, DEMO_POSE};
use compass_host::site::{BuildOptions, PackedPlan, build_with_progress};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Disturbance of the demo's query.
const NOISE: f64 = 1.0;

mod from_frames;

#[derive(Debug, clap::Args)]
pub(super) struct Demo {
    /// Where to write report and pictures
    #[arg(long, value_name = "DIR", default_value = "compass-demo")]
    out: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    truth: Truth,
    found: Pose<'static>,
    /// From rendered frames, at another place.
    seen: Option<Pose<'static>>,
    seen_probability: Decimal,
    position_error_m: Decimal,
    heading_error_deg: Decimal,
    margin: Decimal,
    candidates: usize,
    report: PathBuf,
}

#[derive(Debug, Serialize)]
struct Truth {
    x: Decimal,
    y: Decimal,
    heading_deg: Decimal,
}

/// The results of the demo.
struct Run {
    raster: PlanRaster,
    plan: PackedPlan,
    map: Vec<u8>,
    /// The scan of the plan, and the disturbed query.
    clean: Scan,
    query: Scan,
    answer: Answer,
    build_seconds: f64,
    search_ms: f64,
}

impl Run {
    fn new() -> Result<Self> {
        let (raster, plan) = plan::sample()?;
        let started = Instant::now();
        let map = build_with_progress(&raster, &plan, None, &BuildOptions::default(), &Bars)?;
        let build_seconds = started.elapsed().as_secs_f64();
        let (at, heading) = DEMO_POSE;
        let clean = plan.scan(at, heading)?;
        let mut query = clean;
        disturb(&mut query, NOISE, 1);
        let (answer, search_ms) = search(&map, &query)?;
        Ok(Self { raster, plan, map, clean, query, answer, build_seconds, search_ms })
    }

    fn map(&self) -> Result<SiteMap<'_>> {
        SiteMap::new(&self.map).context("sample map")
    }

    fn poses(&self) -> Result<Vec<Pose<'static>>> {
        let map = self.map()?;
        Ok(self.answer.matches().iter().map(|m| Pose::of(m, &map, None)).collect())
    }
}

fn search(map: &[u8], query: &Scan) -> Result<(Answer, f64)> {
    let mut localizer = Localizer::new(SiteMap::new(map)?);
    let started = Instant::now();
    let answer = localizer.locate(query, &MatchOptions::default());
    Ok((answer, started.elapsed().as_secs_f64() * 1e3))
}

impl Demo {
    pub(super) fn run(&self) -> Result<Outcome> {
        self.json.check()?;
        create_dir(&self.out)?;
        let run = Run::new()?;
        let poses = run.poses()?;
        let Some(found) = poses.first().copied() else { return Ok(Outcome::No) };
        let report = self.out.join("report.html");
        draw(&self.out, &run, &poses)?;
        let seen = from_frames::run(&self.out.join("seen"), &run.raster, &run.plan)?;
        let mut sections = sections(&run, &poses);
        sections.insert(0, seen.section());
        write_html(&report, "COMPASS on its sample building", &sections)?;
        let (at, heading) = DEMO_POSE;
        let (position_error, heading_error) = found.error(at, heading);
        let summary = seen.summary()
            + &format!(
                "plan    x {:.3} m  y {:.3} m  heading {heading:.1} degrees\n\
             found   x {:.3} m  y {:.3} m  heading {:.1} degrees  (score {:.3}, {:.3} above the next)\n\
             off by {position_error:.2} m and {heading_error:.1} degrees, among {} candidates 0.5 m apart\n\
             report {}\n",
                at[0],
                at[1],
                found.x.0,
                found.y.0,
                found.heading_deg.0,
                found.score.0,
                run.answer.margin().to_num::<f64>(),
                run.map()?.len(),
                report.display(),
            );
        let output = Output {
            truth: Truth { x: Decimal(at[0]), y: Decimal(at[1]), heading_deg: Decimal(heading) },
            found,
            seen: seen.poses.first().copied(),
            seen_probability: Decimal(seen.probability),
            position_error_m: Decimal(position_error),
            heading_error_deg: Decimal(heading_error),
            margin: Decimal(run.answer.margin().to_num()),
            candidates: run.map()?.len(),
            report,
        };
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }
}

fn draw(dir: &Path, run: &Run, poses: &[Pose<'_>]) -> Result<()> {
    let (at, heading) = DEMO_POSE;
    // Input files for the other commands.
    write_png(&dir.join("sample-building.png"), &sample::image(&sample::building()))?;
    pictures::describe(dir, &run.raster, at, heading, &PlanDescriptor::from(&run.clean))?;
    let matched = matched_scan(run)?;
    let curves = curves(run)?;
    let [plain, centred] = curves;
    let hits = HitComparison {
        first_label: "disturbed query",
        first: &run.query.hit,
        second_label: "best candidate",
        second: &matched.hit,
        known: None,
        cosine: hit_cosine(&run.query, &matched, Similarity::Plain),
        centred: hit_cosine(&run.query, &matched, Similarity::Centred),
    };
    figures::draw_hits_polar(&dir.join("hits-polar.png"), &hits)?;
    figures::draw_hits_linear(&dir.join("hits-linear.png"), &hits)?;
    let curves = [Curve { label: "plain", score: &plain }, Curve { label: "centred", score: &centred }];
    figures::draw_correlation(&dir.join("correlation.png"), &curves, Shifts::Turn)?;
    draw_map(dir, run, poses)
}

/// The best candidate's scan, rotated to the heading found.
fn matched_scan(run: &Run) -> Result<Scan> {
    let map = run.map()?;
    let mut scan = Scan::OPEN;
    if let Some(best) = run.answer.best()
        && let Some(record) = map.get(best.candidate as usize)
    {
        record.scan(&mut scan);
        scan.steps.rotate_left(usize::from(best.peak.shift));
        scan.hit.rotate_left(usize::from(best.peak.shift));
    }
    Ok(scan)
}

/// Cosine of the hit types of two scans with the same heading.
fn hit_cosine(query: &Scan, other: &Scan, similarity: Similarity) -> f64 {
    let mut prepared = Box::new(Query::EMPTY);
    prepared.set(&Descriptor::from(query), &Confidence::CERTAIN, Weights::HIT_TYPE, similarity);
    prepared.score(&Candidate::from(&Descriptor::from(other)), 0).to_num()
}

/// Plain and centred score of the best candidate at every heading.
fn curves(run: &Run) -> Result<[[f64; 360]; 2]> {
    let map = run.map()?;
    let mut scan = Scan::OPEN;
    if let Some(record) = run.answer.best().and_then(|best| map.get(best.candidate as usize)) {
        record.scan(&mut scan);
    }
    let candidate = Candidate::from(&Descriptor::from(&scan));
    let (mut query, mut correlator) = (Box::new(Query::EMPTY), Box::new(Correlator::new()));
    Ok([Similarity::Plain, Similarity::Centred].map(|similarity| {
        query.set(&Descriptor::from(&run.query), &Confidence::CERTAIN, Weights::EQUAL, similarity);
        query.load(&mut correlator);
        let mut scores = [Default::default(); 360];
        query.scores(&candidate, &mut correlator, &mut scores);
        scores.map(|s| s.to_num())
    }))
}

fn draw_map(dir: &Path, run: &Run, poses: &[Pose<'_>]) -> Result<()> {
    let map = run.map()?;
    let (mut query, mut correlator) = (Box::new(Query::EMPTY), Box::new(Correlator::new()));
    query.set(&Descriptor::from(&run.query), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
    query.load(&mut correlator);
    let mut scan = Scan::OPEN;
    let values: Vec<f64> = map
        .iter()
        .map(|record| {
            record.scan(&mut scan);
            query.peak(&Candidate::from(&Descriptor::from(&scan)), &mut correlator).score().to_num()
        })
        .collect();
    let scores = Scores { label: "best centred score over all headings", values: &values };
    pictures::site_map(&dir.join("site-map.png"), &run.raster, &map, Some(scores), DEMO_POSE, poses)
}

fn sections(run: &Run, poses: &[Pose<'_>]) -> Vec<Section> {
    let picture = |file: &str, caption: &str| Picture { file: file.into(), caption: caption.into() };
    let (at, heading) = DEMO_POSE;
    let rows = poses.iter().enumerate().map(|(rank, pose)| {
        let (metres, degrees) = pose.error(at, heading);
        vec![
            (rank + 1).to_string(),
            format!("{:.2}, {:.2}", pose.x.0, pose.y.0),
            format!("{:.0}", pose.heading_deg.0),
            format!("{:.4}", pose.score.0),
            format!("{metres:.2}"),
            format!("{degrees:.1}"),
        ]
    });
    let head = ["rank", "x, y (m)", "heading (deg)", "score", "off (m)", "off (deg)"].map(String::from);
    vec![
        Section {
            title: "Where am I? From the plan itself".into(),
            text: vec![format!(
                "The query was cast from the plan at x {:.2} m, y {:.2} m, heading {heading:.0} degrees and \
                 disturbed: 3 % of range noise, 5 % of hit types mistaken, two occluders.",
                at[0], at[1]
            )],
            tables: vec![Table { caption: "Answers".into(), head: head.into(), rows: rows.collect() }],
            pictures: vec![picture("site-map.png", "All candidates by their best score; truth and answers")],
        },
        Section {
            title: "From the plan".into(),
            tables: vec![Table::pairs([
                ("map bytes", run.map.len().to_string()),
                ("map built in", format!("{:.2} s", run.build_seconds)),
                ("search took", format!("{:.2} ms", run.search_ms)),
            ])],
            pictures: vec![
                picture("rays.png", "360 rays over the plan by what they hit"),
                picture("polar.png", "Range by bearing"),
                picture("profile.png", "Range and gradient by bearing, shaded by hit type"),
                picture("descriptor.png", "The descriptor: five channels of 360 bins"),
            ],
            ..Section::default()
        },
        Section {
            title: "Matching".into(),
            pictures: vec![
                picture("correlation.png", "Score of the best candidate by heading shift"),
                picture("hits-polar.png", "Hit types of query and best candidate: agreement in green"),
                picture("hits-linear.png", "The same, unrolled"),
            ],
            ..Section::default()
        },
    ]
}
