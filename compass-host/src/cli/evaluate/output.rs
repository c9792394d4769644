//! The result of an evaluation as text and as JSON.

use crate::cli::pose::covariance;
use compass_host::dataset::faults::{Fault, Faults, Item};
use compass_host::evaluate::judged::JudgedFrame;
use compass_host::evaluate::{Coverage, Found, Misses, Row};
use compass_host::output::{Decimal, Variance};
use compass_host::site_file::SiteFloor;
use compass_host::wall_check::WallSummary;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, Serialize)]
pub(super) struct Output<'a> {
    pub(super) frames: usize,
    /// Number of frames that an earlier run had finished.
    pub(super) resumed: usize,
    /// Number of frames with ground truth.
    pub(super) scored: usize,
    /// Number of frames without evidence.
    pub(super) unseen: usize,
    /// What of the recording and of the ground truth was left out.
    pub(super) left_out: LeftOut<'a>,
    /// What else there is to know of the recording.
    pub(super) notes: &'a [String],
    /// The topics read from a bag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) topics: Option<String>,
    /// Number of frames by source of the up vector: image, IMU or both.
    pub(super) up_from: BTreeMap<&'static str, usize>,
    /// How many errors of right answers lie within 1, 2 and 3 standard deviations.
    pub(super) coverage: Coverage,
    pub(super) rows: Vec<Row>,
    pub(super) milliseconds: BTreeMap<String, Decimal>,
    pub(super) walls: WallSummary,
    pub(super) report: PathBuf,
    pub(super) results: Vec<Frame<'a>>,
}

#[derive(Debug, Serialize)]
pub(super) struct LeftOut<'a> {
    frames: usize,
    readings: usize,
    poses: usize,
    /// The first of them.
    first: Vec<LeftOutItem<'a>>,
    #[serde(skip)]
    counts: String,
}

#[derive(Debug, Serialize)]
struct LeftOutItem<'a> {
    place: &'a str,
    problem: &'a str,
}

impl<'a> From<&'a Faults> for LeftOut<'a> {
    fn from(faults: &'a Faults) -> Self {
        let item = |fault: &'a Fault| LeftOutItem { place: &fault.place, problem: &fault.problem };
        Self {
            frames: faults.left_out(Item::Frame),
            readings: faults.left_out(Item::Reading),
            poses: faults.left_out(Item::Pose),
            first: faults.first().iter().map(item).collect(),
            counts: faults.to_string(),
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct Frame<'a> {
    pub(super) timestamp_ns: u64,
    /// Why the frame gave no evidence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) problem: Option<&'a str>,
    /// The source of the up vector.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) up_from: Option<&'static str>,
    /// Lead of the single frame's pose over the best one elsewhere, nats.
    pub(super) margin: Decimal,
    /// Lead over the second best explanation, which may be that the place is not in the plan, nats.
    pub(super) lead: Decimal,
    /// Probability of the single frame's pose.
    pub(super) probability: Decimal,
    pub(super) single: Option<Placed<'a>>,
    /// Covariance of x, y and heading of the single frame's pose, if it is right: m2, m rad and rad2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) covariance: Option<[[Variance; 3]; 3]>,
    pub(super) track: Option<Tracked<'a>>,
    pub(super) oracle: Option<Placed<'a>>,
    pub(super) paper_plain: Option<Placed<'a>>,
    pub(super) paper_centred: Option<Placed<'a>>,
    pub(super) paper_hit_type: Option<Placed<'a>>,
    pub(super) paper_range: Option<Placed<'a>>,
}

impl<'a> Frame<'a> {
    /// A frame, with floor names where there are several floors.
    pub(super) fn of(frame: &'a JudgedFrame<'_>, floors: &[SiteFloor<'a>]) -> Self {
        let placed = |found: Option<&Found>, row: usize| {
            found.map(|found| {
                let layer = frame.judge.layers.get(usize::from(found.layer));
                let floor = layer.and_then(|layer| floors.get(usize::from(layer.floor)));
                let name = floor.and_then(SiteFloor::name).filter(|_| floors.len() > 1);
                Placed::new(found, name, frame.truth.map(|_| frame.misses[row]))
            })
        };
        let single = &frame.record.single;
        Self {
            timestamp_ns: frame.record.timestamp_ns,
            problem: frame.record.problem.as_deref(),
            up_from: frame.record.up.map(|_| frame.record.up_from.name()),
            margin: Decimal(frame.record.margin()),
            lead: Decimal(frame.record.lead()),
            probability: Decimal(f64::from(frame.record.probability())),
            single: placed(single.first(), 0),
            covariance: frame.record.covariance.map(covariance),
            track: placed(frame.track.as_ref(), 1).zip(frame.estimate).map(|(placed, estimate)| Tracked {
                placed,
                probability: Decimal(f64::from(estimate.probability)),
                spread_m: Decimal(f64::from(estimate.spread_m)),
            }),
            oracle: placed(frame.record.oracle.first(), 2),
            paper_plain: placed(frame.record.paper[0].as_ref(), 3),
            paper_centred: placed(frame.record.paper[1].as_ref(), 4),
            paper_hit_type: placed(frame.record.paper[2].as_ref(), 5),
            paper_range: placed(frame.record.paper[3].as_ref(), 6),
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct Tracked<'a> {
    #[serde(flatten)]
    pub(super) placed: Placed<'a>,
    pub(super) probability: Decimal,
    pub(super) spread_m: Decimal,
}

/// A pose and its errors; null on the wrong floor.
#[derive(Debug, Serialize)]
pub(super) struct Placed<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<&'a str>,
    x: Decimal,
    y: Decimal,
    heading_deg: Decimal,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_error_m: Option<Decimal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading_error_deg: Option<Decimal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    challenge_score: Option<Decimal>,
}

impl<'a> Placed<'a> {
    pub(super) fn new(found: &Found, floor: Option<&'a str>, misses: Option<Misses>) -> Self {
        let [x, y] = found.position().map(Decimal);
        Self {
            floor,
            x,
            y,
            heading_deg: Decimal(found.heading_deg()),
            position_error_m: misses.map(|misses| Decimal(misses.metres)),
            heading_error_deg: misses.map(|misses| Decimal(misses.degrees)),
            challenge_score: misses.map(|misses| Decimal(misses.score())),
        }
    }
}

impl Output<'_> {
    /// The table of recall and the other key figures.
    pub(super) fn summary(&self) -> String {
        let mut text = format!(
            "{} frames, {} with a truth, {} unseen, {} from an earlier run\n",
            self.frames, self.scored, self.unseen, self.resumed
        );
        for note in self.notes {
            let _ = writeln!(text, "note: {note}");
        }
        if let Some(LeftOutItem { place, problem }) = self.left_out.first.first() {
            let _ = writeln!(text, "left out: {}; the first: {place}: {problem}", self.left_out.counts);
        }
        if let Some(topics) = &self.topics {
            let _ = writeln!(text, "topics: {topics}");
        }
        let ups: Vec<_> = self.up_from.iter().map(|(from, count)| format!("{from} {count}")).collect();
        let _ = writeln!(text, "up from: {}", ups.join(", "));
        let _ = writeln!(text, "{:<15} frames  median     0.1 m  0.5 m    1 m  1 m 30\u{b0}  score", "");
        for row in &self.rows {
            let percent = |share: Decimal| 100.0 * share.0;
            let _ = writeln!(
                text,
                "{:<15} {:>6}  {:>6.2} m  {:>5.1}  {:>5.1}  {:>5.1}  {:>7.1}  {:>5.1}",
                row.name,
                row.scored,
                row.median_position_error_m.0,
                percent(row.recall_at_0_1_m),
                percent(row.recall_at_0_5_m),
                percent(row.recall_at_1_m),
                percent(row.recall_at_1_m_30_deg),
                row.challenge_score.0,
            );
        }
        if self.coverage.answers > 0 {
            let percent =
                |shares: &[Decimal; 3]| shares.map(|share| format!("{:.0}", 100.0 * share.0)).join(", ");
            let _ = writeln!(
                text,
                "of {} right answers, within 1, 2, 3 standard deviations: position {} % (39, 86, 99 expected), heading {} % \
                 (68, 95, 99.7)",
                self.coverage.answers,
                percent(&self.coverage.position),
                percent(&self.coverage.heading),
            );
        }
        let stages: Vec<_> =
            self.milliseconds.iter().map(|(stage, ms)| format!("{stage} {:.1}", ms.0)).collect();
        let _ = writeln!(text, "milliseconds: {}\nreport {}", stages.join(", "), self.report.display());
        text
    }
}
