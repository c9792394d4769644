//! What was understood of a plan: walls, structure, glazing, doors, what was left out, interior, candidates.

use std::fmt;
use std::path::Path;

use plotters::style::RGBColor;

use super::axes::Axes;
use super::canvas::{CENTRE, Canvas, Rect};
use super::error::{DrawError, Drawn, FigureError};
use super::page::{Entry, Page, Symbol};
use super::plan::{MapLayout, PlanPicture};
use super::style::{
    DISAGREE, INK, MUTED, OPEN, PLAN_WALL, Pen, TICK_PX, WALL, WINDOW, nice_step, number, tint,
};

/// Space to the right of the plot for the scale bar and the arrow of +y.
const BESIDE: f64 = 150.0;
/// Most rings: more would hide the plan.
const MOST_RINGS: usize = 300;
/// Walls that are no structure.
const PARTITION: RGBColor = WALL;
const INTERIOR: RGBColor = RGBColor(0x8c, 0xc5, 0x7e);

/// Tells a property of the pixel in a column and a row of the plan.
pub type Property<'a> = &'a dyn Fn(u32, u32) -> bool;

/// What to draw over a plan.
#[derive(Clone, Copy)]
pub struct PlanSurveyPicture<'a> {
    /// Whether a pixel is structure; `None`: not known.
    pub is_structure: Option<Property<'a>>,
    /// Whether a pixel is a door.
    pub is_door: Option<Property<'a>>,
    /// Whether something is drawn there that is no part of the plan.
    pub is_left_out: Option<Property<'a>>,
    /// Whether a pixel is inside the building.
    pub is_inside: Option<Property<'a>>,
    /// Candidate positions in metres.
    pub candidates: &'a [[f64; 2]],
    /// Suspicious places: centre and radius in metres.
    pub suspects: &'a [([f64; 2], f64)],
}

impl fmt::Debug for PlanSurveyPicture<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PlanSurveyPicture")
            .field("candidates", &self.candidates.len())
            .field("suspects", &self.suspects.len())
            .finish_non_exhaustive()
    }
}

impl PlanSurveyPicture<'_> {
    /// The colour of a pixel, and how much it comes before others in the same square of the picture.
    fn colour(&self, plan: &PlanPicture<'_>, x: u32, y: u32) -> Option<(u8, RGBColor)> {
        let is = |property: Option<Property<'_>>| property.is_some_and(|property| property(x, y));
        if (plan.is_window)(x, y) {
            Some((5, WINDOW))
        } else if (plan.is_wall)(x, y) {
            let structure = self.is_structure.is_none_or(|property| property(x, y));
            Some(if structure { (4, PLAN_WALL) } else { (3, PARTITION) })
        } else if is(self.is_door) {
            Some((2, OPEN))
        } else if is(self.is_left_out) {
            Some((1, tint(MUTED, 0.7)))
        } else {
            is(self.is_inside).then_some((0, tint(INTERIOR, 0.4)))
        }
    }

    fn legend(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        let mut entry = |shown: bool, symbol: Symbol, label: String| {
            if shown {
                entries.push(Entry::new(symbol, label));
            }
        };
        let has_structure = self.is_structure.is_some();
        entry(has_structure, Symbol::Patch(PLAN_WALL), "structure".into());
        entry(true, Symbol::Patch(if has_structure { PARTITION } else { PLAN_WALL }), "wall".into());
        entry(true, Symbol::Patch(WINDOW), "glazing".into());
        entry(self.is_door.is_some(), Symbol::Patch(OPEN), "door (open)".into());
        entry(self.is_left_out.is_some(), Symbol::Patch(tint(MUTED, 0.7)), "left out".into());
        entry(self.is_inside.is_some(), Symbol::Patch(tint(INTERIOR, 0.4)), "interior".into());
        let candidates = format!("candidates ({})", self.candidates.len());
        entry(!self.candidates.is_empty(), Symbol::Dot(MUTED), candidates);
        let suspects = format!("suspicious ({})", self.suspects.len());
        entry(!self.suspects.is_empty(), Symbol::Line(Pen::solid(DISAGREE, 4.0)), suspects);
        entries
    }
}

/// Draws a plan as it was understood.
///
/// # Errors
/// [`FigureError`] when the file cannot be written, the plan is empty or a position is not finite.
pub fn draw_plan_survey(
    path: &Path,
    plan: &PlanPicture<'_>,
    data: &PlanSurveyPicture<'_>,
    caption: &str,
) -> Result<(), FigureError> {
    let prepare = || -> Result<MapLayout, DrawError> {
        MapLayout::new(plan.extent(data.candidates)?, Page::INNER_WIDTH, BESIDE)
    };
    let layout = prepare().map_err(|e| FigureError::draw(path, &*e))?;
    let page = Page { path, caption, legend: data.legend(), body: layout.body() };
    page.draw(|canvas, body| {
        let axes = layout.axes(body);
        plan.paint(canvas, &axes, |x, y| data.colour(plan, x, y))?;
        for &[x, y] in data.candidates {
            canvas.disc(axes.at(x, y), 2.0, MUTED)?;
        }
        draw_suspects(canvas, &axes, data)?;
        axes.draw_frame(canvas)?;
        draw_scale(canvas, &axes)
    })
}

fn draw_suspects(canvas: &Canvas<'_>, axes: &Axes, data: &PlanSurveyPicture<'_>) -> Drawn {
    let px_per_m = axes.frame.width() / (axes.x.to - axes.x.from);
    for &([x, y], radius_m) in data.suspects.iter().take(MOST_RINGS) {
        let radius = (radius_m * px_per_m).max(6.0) + 4.0;
        let [cx, cy] = axes.at(x, y);
        let around = (0..=24).map(|n| {
            let (sin, cos) = (f64::from(n) * std::f64::consts::TAU / 24.0).sin_cos();
            [cx + radius * cos, cy + radius * sin]
        });
        canvas.line(&around.collect::<Vec<_>>(), Pen::solid(DISAGREE, 3.0))?;
    }
    Ok(())
}

/// A bar of a round length and an arrow along +y, to the right of the plot.
fn draw_scale(canvas: &Canvas<'_>, axes: &Axes) -> Drawn {
    let Rect { right, top, .. } = axes.frame;
    let px_per_m = axes.frame.width() / (axes.x.to - axes.x.from);
    let metres = [0.1, 0.2, 0.5].into_iter().chain([nice_step(40.0 / px_per_m)]).fold(0.0, f64::max);
    let metres = if metres * px_per_m > BESIDE - 30.0 { nice_step(metres / 2.0) } else { metres };
    let (x, width) = (right + 20.0, (metres * px_per_m).min(BESIDE - 30.0));
    let y = top + 150.0;
    canvas.line(&[[x, y], [x + width, y]], Pen::solid(INK, 5.0))?;
    canvas.text([x + width / 2.0, y + 24.0], TICK_PX, CENTRE, &format!("{} m", number(metres)))?;
    let middle = right + 60.0;
    canvas.line(&[[middle, top + 100.0], [middle, top + 50.0]], Pen::solid(INK, 5.0))?;
    canvas.polygon(&[[middle - 12.0, top + 52.0], [middle + 12.0, top + 52.0], [middle, top + 28.0]], INK)?;
    canvas.text([middle, top + 10.0], TICK_PX, CENTRE, "+y")
}
