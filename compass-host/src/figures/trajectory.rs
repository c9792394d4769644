//! The true path of a recording and the estimated positions, over the plan.

use std::path::Path;

use super::axes::draw_colour_bar;
use super::canvas::{Canvas, Px, Rect};
use super::error::{DrawError, FigureError};
use super::page::{Entry, Page, Symbol};
use super::plan::{MapLayout, PlanPicture};
use super::style::{DISAGREE, FOUND, INK, MUTED, Pen, TRUTH, tint, viridis};

/// Space to the right of the plot for the colour bar of the errors.
const BAR_ROOM: f64 = 190.0;
/// Errors from here on get the last colour, metres.
const WORST_M: f64 = 2.0;
/// Radius of a fix in pixels, and width of its rim.
const DOT: f64 = 8.0;
const RIM: f64 = 2.0;
/// Radius of a position of the track in pixels.
const TRACK_DOT: f64 = 4.0;
/// Longer steps of the track are not drawn, metres.
const JUMP_M: f64 = 5.0;

/// An estimated position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Metres, x right and y up.
    pub position: [f64; 2],
    /// True position, metres; without it the fix is grey.
    pub truth: Option<[f64; 2]>,
}

/// The contents of the picture.
#[derive(Debug, Clone, Copy)]
pub struct TrajectoryPicture<'a> {
    /// The caption.
    pub caption: &'a str,
    /// The true path in metres.
    pub truth: &'a [[f64; 2]],
    /// The single-frame estimates.
    pub fixes: &'a [Fix],
    /// The track in pieces, in metres; empty for none.
    pub track: &'a [Vec<[f64; 2]>],
}

impl TrajectoryPicture<'_> {
    fn legend(&self) -> Vec<Entry> {
        let mut entries = vec![
            Entry::new(Symbol::Line(Pen::solid(TRUTH, 5.0)), "truth"),
            Entry::new(Symbol::Dot(viridis(0.0)), format!("single frames ({})", self.fixes.len())),
            Entry::new(Symbol::Line(error_pen()), "their errors"),
        ];
        if !self.track.is_empty() {
            entries.push(Entry::new(Symbol::Line(Pen::solid(FOUND, 4.0)), "track"));
        }
        entries
    }
}

fn error_pen() -> Pen {
    Pen { dash: Some([9.0, 7.0]), ..Pen::solid(tint(DISAGREE, 0.6), 2.0) }
}

/// Draws a true trajectory, the single-frame positions coloured by their error and connected to the truth, and the
/// track over the plan.
///
/// # Errors
/// [`FigureError`] when the file cannot be written, the plan is empty, or a position is not finite.
pub fn draw_trajectory(
    path: &Path,
    plan: &PlanPicture<'_>,
    data: &TrajectoryPicture<'_>,
) -> Result<(), FigureError> {
    let prepare = || -> Result<MapLayout, DrawError> {
        let fixes = data.fixes.iter().map(|fix| fix.position);
        let tracks = data.track.iter().flatten().copied();
        let points: Vec<_> = data.truth.iter().copied().chain(fixes).chain(tracks).collect();
        MapLayout::new(plan.extent(&points)?, Page::INNER_WIDTH, BAR_ROOM)
    };
    let layout = prepare().map_err(|e| FigureError::draw(path, &*e))?;
    let page = Page { path, caption: data.caption, legend: data.legend(), body: layout.body() };
    page.draw(|canvas, body| {
        let axes = layout.axes(body);
        let px = |[x, y]: [f64; 2]| axes.at(x, y);
        axes.draw_grid(canvas)?;
        plan.draw(canvas, &axes)?;
        let way: Vec<Px> = data.truth.iter().map(|&at| px(at)).collect();
        canvas.line(&way, Pen::solid(TRUTH, 5.0))?;
        for fix in data.fixes {
            if let Some(truth) = fix.truth {
                canvas.line(&[px(fix.position), px(truth)], error_pen())?;
            }
        }
        for piece in data.track {
            // Segment by segment: mitred joints of thick lines stick out at sharp turns.
            for pair in piece.windows(2).filter(|pair| distance(pair[0], pair[1]) < JUMP_M) {
                canvas.line(&[px(pair[0]), px(pair[1])], Pen::solid(FOUND, 4.0))?;
            }
            piece.iter().try_for_each(|&at| canvas.disc(px(at), TRACK_DOT, FOUND))?;
        }
        data.fixes.iter().try_for_each(|fix| draw_fix(canvas, px(fix.position), fix))?;
        axes.draw_frame(canvas)?;
        let right = axes.frame.right;
        let bar = Rect { left: right + 28.0, right: right + 62.0, ..axes.frame };
        draw_colour_bar(canvas, bar, [0.0, WORST_M], 4, "error of a single frame (m), and above")
    })
}

fn draw_fix(canvas: &Canvas<'_>, at: Px, fix: &Fix) -> Result<(), DrawError> {
    let error = fix.truth.map(|truth| distance(fix.position, truth));
    canvas.disc(at, DOT + RIM, INK)?;
    canvas.disc(at, DOT, error.map_or(MUTED, |error| viridis(error / WORST_M)))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
