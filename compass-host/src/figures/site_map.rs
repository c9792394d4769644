//! The candidates of a site map over the plan, with poses.

use std::path::Path;

use super::axes::{Axes, draw_colour_bar};
use super::canvas::{Canvas, Rect};
use super::error::{DrawError, Drawn, FigureError};
use super::page::{Entry, Page, Symbol, draw_pose};
use super::plan::{MapLayout, PlanPicture};
use super::style::{FOUND, MUTED, TRUTH, number, tint, viridis};

/// Space to the right of the plot for the colour bar of the scores.
const BAR_ROOM: f64 = 190.0;

/// A pose on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPose {
    /// Metres, x right and y up.
    pub position: [f64; 2],
    /// Degrees counter-clockwise from +x.
    pub heading_deg: f64,
}

/// A value for each candidate.
#[derive(Debug, Clone, Copy)]
pub struct Scores<'a> {
    /// Name of the value, for the colour bar.
    pub label: &'a str,
    /// One value per candidate; a value that is not finite is drawn grey.
    pub values: &'a [f64],
}

/// The contents of the picture.
#[derive(Debug, Clone, Copy, Default)]
pub struct SiteMapPicture<'a> {
    /// Candidate positions in metres.
    pub candidates: &'a [[f64; 2]],
    /// Values that colour the candidates.
    pub scores: Option<Scores<'a>>,
    /// The true pose.
    pub truth: Option<MapPose>,
    /// The pose found.
    pub found: Option<MapPose>,
    /// Its alternatives.
    pub alternatives: &'a [MapPose],
}

impl SiteMapPicture<'_> {
    fn poses(&self) -> impl Iterator<Item = MapPose> {
        self.alternatives.iter().copied().chain(self.truth).chain(self.found)
    }

    fn check(&self) -> Drawn {
        match self.scores {
            Some(scores) if scores.values.len() != self.candidates.len() => {
                Err(format!("{} scores for {} candidates", scores.values.len(), self.candidates.len()).into())
            }
            _ => Ok(()),
        }
    }

    /// The range of the finite scores, widened when they are all equal.
    fn score_range(&self) -> Option<[f64; 2]> {
        let finite = self.scores?.values.iter().copied().filter(|s| s.is_finite());
        let [low, high] =
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)]);
        (low <= high).then_some(if high > low { [low, high] } else { [low - 0.5, high + 0.5] })
    }

    fn legend(&self) -> Vec<Entry> {
        let candidates = format!("candidates ({})", self.candidates.len());
        let mut entries = Vec::new();
        if self.scores.is_none() && !self.candidates.is_empty() {
            entries.push(Entry::new(Symbol::Dot(MUTED), candidates));
        }
        if self.truth.is_some() {
            entries.push(Entry::new(Symbol::Pose(TRUTH), "true pose"));
        }
        if self.found.is_some() {
            entries.push(Entry::new(Symbol::Pose(FOUND), "found pose"));
        }
        if !self.alternatives.is_empty() {
            let label = format!("alternatives ({})", self.alternatives.len());
            entries.push(Entry::new(Symbol::Pose(tint(FOUND, 0.55)), label));
        }
        entries
    }

    fn caption(&self) -> String {
        let count = self.candidates.len();
        match (self.truth, self.found) {
            (Some(truth), Some(found)) => {
                let [dx, dy] = [0, 1].map(|n| truth.position[n] - found.position[n]);
                let turn = (truth.heading_deg - found.heading_deg).rem_euclid(360.0);
                format!(
                    "{count} candidates; the pose found is off by {} m and {}°",
                    number(dx.hypot(dy)),
                    number((turn.min(360.0 - turn) * 10.0).round() / 10.0)
                )
            }
            (None, Some(_)) if count == 0 => "The pose found on the plan".to_owned(),
            _ => format!("Site map with {count} candidates"),
        }
    }
}

/// Draws candidate positions over the plan, coloured by their scores if given, and the true pose, the pose found and
/// its alternatives.
///
/// # Errors
/// [`FigureError`] when the file cannot be written, the plan is empty, a position is not finite, or
/// the number of scores differs from that of the candidates.
pub fn draw_site_map(
    path: &Path,
    plan: &PlanPicture<'_>,
    data: &SiteMapPicture<'_>,
) -> Result<(), FigureError> {
    let range = data.score_range();
    let prepare = || -> Result<MapLayout, DrawError> {
        data.check()?;
        let poses = data.poses().map(|pose| pose.position);
        let points: Vec<_> = data.candidates.iter().copied().chain(poses).collect();
        let beside = if range.is_some() { BAR_ROOM } else { 0.0 };
        MapLayout::new(plan.extent(&points)?, Page::INNER_WIDTH, beside)
    };
    let layout = prepare().map_err(|e| FigureError::draw(path, &*e))?;
    let page = Page { path, caption: &data.caption(), legend: data.legend(), body: layout.body() };
    page.draw(|canvas, body| {
        let axes = layout.axes(body);
        axes.draw_grid(canvas)?;
        draw_candidates(canvas, &axes, data, range)?;
        plan.draw(canvas, &axes)?;
        draw_poses(canvas, &axes, data)?;
        axes.draw_frame(canvas)?;
        match (range, data.scores) {
            (Some(range), Some(scores)) => {
                let right = axes.frame.right;
                let bar = Rect { left: right + 28.0, right: right + 62.0, ..axes.frame };
                draw_colour_bar(canvas, bar, range, 6, scores.label)
            }
            _ => Ok(()),
        }
    })
}

fn draw_candidates(
    canvas: &Canvas<'_>,
    axes: &Axes,
    data: &SiteMapPicture<'_>,
    range: Option<[f64; 2]>,
) -> Drawn {
    let radius = dot_radius(axes, data.candidates);
    let score = |n: usize| data.scores.map_or(f64::NAN, |s| s.values[n]);
    let mut order: Vec<usize> = (0..data.candidates.len()).collect();
    // The best last, so that no worse one covers them.
    order.sort_by(|&a, &b| score(a).total_cmp(&score(b)));
    for n in order {
        let [x, y] = data.candidates[n];
        let colour = match range {
            Some([low, high]) if score(n).is_finite() => viridis((score(n) - low) / (high - low)),
            _ => MUTED,
        };
        canvas.disc(axes.at(x, y), radius, colour)?;
    }
    Ok(())
}

/// The largest radius at which candidates spread evenly over their bounding box do not touch.
fn dot_radius(axes: &Axes, candidates: &[[f64; 2]]) -> f64 {
    let side = |axis: usize| {
        let values = || candidates.iter().map(|c| c[axis]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let px_per_m = axes.frame.width() / (axes.x.to - axes.x.from);
    let area = (side(0) * px_per_m).max(1.0) * (side(1) * px_per_m).max(1.0);
    (0.36 * (area / candidates.len().max(1) as f64).sqrt()).clamp(1.5, 9.0)
}

fn draw_poses(canvas: &Canvas<'_>, axes: &Axes, data: &SiteMapPicture<'_>) -> Drawn {
    let draw = |pose: &MapPose, radius: f64, colour| {
        let [x, y] = pose.position;
        draw_pose(canvas, axes.at(x, y), pose.heading_deg, radius, colour)
    };
    for pose in data.alternatives {
        draw(pose, 10.0, tint(FOUND, 0.55))?;
    }
    if let Some(pose) = &data.truth {
        draw(pose, 18.0, TRUTH)?;
    }
    match &data.found {
        Some(pose) => draw(pose, 10.0, FOUND),
        None => Ok(()),
    }
}
