//! The report of an evaluation: its pictures and its page.

use super::error::Result;
use super::frame_errors::FrameErrors;
use super::largest_errors;
use super::row::Row;
use crate::dataset::faults::{Fault, Faults};
use crate::figures::{self, ErrorCurve, ErrorSeries, Fix, TrajectoryPicture};
use crate::report::{Picture, Section, Table, write_html};
use crate::wall_check::Walls;
use compass_core::map::plan::Plan;
use std::path::Path;

/// Number of worst frames that are listed.
const WORST: usize = 12;

/// The contents of the report.
#[derive(Debug)]
pub struct ReportData<'a> {
    /// The page's title.
    pub title: &'a str,
    /// The plan of the floor.
    pub plan: Plan<'a>,
    /// The localization methods, the single frames first, the track second.
    pub rows: &'a [Row],
    /// The frames in order of time.
    pub frames: &'a [FrameErrors],
    /// Whether each frame's single answer is correct, where there is ground truth.
    pub right: &'a [Option<bool>],
    /// Mean milliseconds by stage.
    pub milliseconds: &'a [(String, f64)],
    /// The state of the plan's walls, as observed.
    pub walls: &'a Walls,
    /// Pictures of the worst frames.
    pub largest_errors: &'a [Picture],
    /// What of the recording was left out.
    pub faults: &'a Faults,
    /// What else there is to know of the recording.
    pub notes: &'a [String],
}

/// Draws the pictures and writes `report.html`.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write(dir: &Path, data: &ReportData<'_>) -> Result<()> {
    draw_plan(&dir.join("trajectory.png"), data)?;
    let first = data.frames.first().map_or(0, |frame| frame.timestamp_ns);
    let seconds: Vec<f64> = data.frames.iter().map(|f| (f.timestamp_ns - first) as f64 / 1e9).collect();
    let errors = |row: usize| -> Vec<f64> { data.frames.iter().map(|frame| frame.metres[row]).collect() };
    let [single, track] = [errors(0), errors(1)];
    let curves = [
        ErrorCurve { label: "single frames", metres: &single, joined: false },
        ErrorCurve { label: "track", metres: &track, joined: true },
    ];
    figures::draw_errors_over_time(&dir.join("errors.png"), &seconds, &curves)?;
    draw_distribution(&dir.join("recall.png"), data)?;
    let pairs = data.frames.iter().zip(data.right);
    let answers: Vec<_> = pairs.filter_map(|(frame, right)| Some((frame.margin, (*right)?))).collect();
    figures::draw_reliability(&dir.join("reliability.png"), &answers)?;
    figures::with_packed_plan(&data.plan, |plan| {
        figures::draw_wall_check(&dir.join("walls.png"), plan, data.walls)
    })?;
    Ok(write_html(&dir.join("report.html"), data.title, &sections(data))?)
}

fn draw_plan(path: &Path, data: &ReportData<'_>) -> Result<()> {
    let truth: Vec<_> = data.frames.iter().filter_map(|frame| frame.truth).collect();
    let fixes = data.frames.iter().filter_map(|f| Some(Fix { position: f.single?, truth: f.truth }));
    let fixes: Vec<_> = fixes.collect();
    let pieces: Vec<Vec<_>> = data
        .frames
        .split(|frame| frame.track.is_none())
        .map(|piece| piece.iter().filter_map(|frame| frame.track).collect())
        .collect();
    let caption = format!("{} frames: where they were and where they were found", data.frames.len());
    let picture = TrajectoryPicture { caption: &caption, truth: &truth, fixes: &fixes, track: &pieces };
    figures::with_packed_plan(&data.plan, |plan| figures::draw_trajectory(path, plan, &picture))?;
    Ok(())
}

fn draw_distribution(path: &Path, data: &ReportData<'_>) -> Result<()> {
    let scored: Vec<&FrameErrors> = data.frames.iter().filter(|frame| frame.truth.is_some()).collect();
    let of = |row: usize| -> [Vec<f64>; 2] {
        let metres = scored.iter().map(|frame| frame.metres[row]).collect();
        [metres, scored.iter().map(|frame| frame.degrees[row]).collect()]
    };
    let errors: Vec<_> = (0..data.rows.len()).map(of).collect();
    let series: Vec<_> = data
        .rows
        .iter()
        .zip(&errors)
        .map(|(row, [metres, degrees])| ErrorSeries {
            label: row.name,
            position_m: metres,
            heading_deg: degrees,
        })
        .collect();
    Ok(figures::draw_error_cdf(path, &series)?)
}

fn sections(data: &ReportData<'_>) -> Vec<Section> {
    let picture = |file: &str, caption: &str| Picture { file: file.into(), caption: caption.into() };
    let sections = vec![
        Section {
            title: "How well?".into(),
            text: vec![
                "Single: each frame by itself. Track: the sequence, each frame with those before it. Oracle: the same \
                 search as for single frames, with evidence that the plan gives at the true pose; what it misses \
                 the matcher misses. Paper: the cosine of descriptors of what was seen, of all five channels plain and \
                 centred, and centred of the hit type and of the range alone."
                    .into(),
            ],
            tables: vec![recall(data.rows), headings(data)],
            pictures: vec![
                picture("trajectory.png", "Truth, frames by themselves and track over the plan"),
                picture("errors.png", "Position error over time"),
                picture("recall.png", "Share of frames by error"),
            ],
        },
        Section {
            title: "When to believe it".into(),
            pictures: vec![picture("reliability.png", "Right answers by margin")],
            ..Section::default()
        },
        Section {
            title: "As built".into(),
            text: vec![
                "Where the track was sure: do the walls of the plan stand where they are drawn, or does one look \
                 through them? What hides a wall says nothing."
                    .into(),
            ],
            pictures: vec![picture("walls.png", "Walls of the plan, as they were seen")],
            ..Section::default()
        },
        Section {
            title: "Worst frames".into(),
            tables: vec![worst_frames(data)],
            pictures: data.largest_errors.to_vec(),
            ..Section::default()
        },
        Section {
            title: "Time".into(),
            tables: vec![Table {
                caption: "Mean milliseconds of a frame, one thread".into(),
                ..Table::pairs(data.milliseconds.iter().map(|(stage, ms)| (stage.clone(), format!("{ms:.1}"))))
            }],
            ..Section::default()
        },
    ];
    sections.into_iter().chain(left_out(data)).collect()
}

/// What of the recording was not used, if there is anything.
fn left_out(data: &ReportData<'_>) -> Option<Section> {
    let faults = data.faults;
    if faults.is_empty() && data.notes.is_empty() {
        return None;
    }
    let row = |fault: &Fault| vec![fault.place.clone(), fault.problem.clone()];
    let table = Table {
        caption: format!("{faults}; the first {} of them", faults.first().len()),
        head: ["where", "problem"].map(String::from).into(),
        rows: faults.first().iter().map(row).collect(),
    };
    Some(Section {
        title: "Left out".into(),
        text: data.notes.to_vec(),
        tables: if faults.is_empty() { vec![] } else { vec![table] },
        ..Section::default()
    })
}

fn recall(rows: &[Row]) -> Table {
    let head = ["", "frames", "median (m)", "median (deg)", "0.1 m", "0.5 m", "1 m", "1 m, 30 deg", "score"];
    let cells = |row: &Row| {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        vec![
            row.name.to_owned(),
            row.scored.to_string(),
            metric(row.median_position_error_m.0, 2),
            metric(row.median_heading_error_deg.0, 1),
            percent(row.recall_at_0_1_m.0),
            percent(row.recall_at_0_5_m.0),
            percent(row.recall_at_1_m.0),
            percent(row.recall_at_1_m_30_deg.0),
            format!("{:.1}", row.challenge_score.0),
        ]
    };
    Table {
        caption: "Recall, and the mean of 100 exp(-0.46 error)".into(),
        head: head.map(String::from).into(),
        rows: rows.iter().map(cells).collect(),
    }
}

/// Named heading errors: the angle from the true heading, degrees.
const CONFUSIONS: [(&str, f64); 3] =
    [("right", 0.0), ("a quarter turn off", 90.0), ("half a turn off", 180.0)];
/// Tolerance for a named heading error, degrees.
const ALIKE_DEG: f64 = 15.0;

/// Typical heading confusions: rooms are symmetric end to end, and buildings have right angles.
fn headings(data: &ReportData<'_>) -> Table {
    let scored: Vec<&FrameErrors> = data.frames.iter().filter(|frame| frame.truth.is_some()).collect();
    let share = |count: usize| format!("{:.1} %", 100.0 * count as f64 / scored.len().max(1) as f64);
    let row = |(number, row): (usize, &Row)| {
        let errors = || scored.iter().map(|frame| frame.degrees[number]);
        let counts = CONFUSIONS.map(|(_, turn)| errors().filter(|e| (e - turn).abs() <= ALIKE_DEG).count());
        let none = errors().filter(|error| !error.is_finite()).count();
        let rest = scored.len() - none - counts.iter().sum::<usize>();
        let cells = counts.into_iter().chain([rest, none]).map(share);
        [row.name.to_owned()].into_iter().chain(cells).collect()
    };
    let head = [""].into_iter().chain(CONFUSIONS.map(|(name, _)| name)).chain(["otherwise", "no pose"]);
    Table {
        caption: "Headings, to 15 degrees, wherever the position".into(),
        head: head.map(String::from).collect(),
        rows: data.rows.iter().enumerate().map(row).collect(),
    }
}

/// A number, or a dash if there is none.
fn metric(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "\u{2013}".to_owned() }
}

fn worst_frames(data: &ReportData<'_>) -> Table {
    let frames = largest_errors::by_error(data.frames);
    let at = |position: Option<[f64; 2]>| {
        position.map_or("\u{2013}".to_owned(), |[x, y]| format!("{x:.2}, {y:.2}"))
    };
    let rows = frames.iter().take(WORST).map(|frame| {
        vec![
            format!("t {}", frame.timestamp_ns),
            at(frame.truth),
            at(frame.single),
            metric(frame.metres[0], 2),
            metric(frame.degrees[0], 1),
            metric(frame.metres[1], 2),
            frame.problem.clone().unwrap_or_else(|| format!("{:.1}", frame.margin)),
        ]
    });
    let head =
        ["frame (ns)", "truth (m)", "found (m)", "off (m)", "off (deg)", "track off (m)", "margin (nats)"];
    Table {
        caption: "By the error of the frame by itself".into(),
        head: head.map(String::from).into(),
        rows: rows.collect(),
    }
}
