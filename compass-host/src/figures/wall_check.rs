//! The plan's walls that were confirmed, and those found absent.

use std::path::Path;

use super::canvas::Rect;
use super::error::{DrawError, FigureError};
use super::page::{Entry, Page, Symbol};
use super::plan::{MapLayout, PlanPicture};
use super::style::{AGREE, DISAGREE, FOUND, MUTED};
use crate::wall_check::{TILE_M, Verdict, Walls};

/// Space to the right of the plot.
const MARGIN: f64 = 20.0;
/// Radius of a position in pixels.
const DOT: f64 = 4.0;

/// Draws the verdicts on the walls of a plan, and the positions of the observations.
///
/// # Errors
/// [`FigureError`] when the file cannot be written, the plan is empty, or a position is not finite.
pub fn draw_wall_check(path: &Path, plan: &PlanPicture<'_>, walls: &Walls) -> Result<(), FigureError> {
    let layout = plan
        .extent(walls.seen_from())
        .and_then(|extent| MapLayout::new(extent, Page::INNER_WIDTH, MARGIN))
        .map_err(|e| FigureError::draw(path, &*e))?;
    let kinds = [
        (Verdict::Unclear, MUTED, "seen, not clearly"),
        (Verdict::Stands, AGREE, "stands as drawn"),
        (Verdict::Absent, DISAGREE, "one looks through"),
    ];
    let entry = |(verdict, colour, label): &(Verdict, _, &str)| {
        Entry::new(Symbol::Dot(*colour), format!("{label} ({:.0} m)", walls.metres(*verdict)))
    };
    let mut legend: Vec<Entry> = kinds.iter().map(entry).collect();
    legend.push(Entry::new(Symbol::Dot(FOUND), "seen from"));
    Page { path, caption: "Walls of the plan, as they were seen", legend, body: layout.body() }.draw(
        |canvas, body| -> Result<(), DrawError> {
            let axes = layout.axes(body);
            axes.draw_grid(canvas)?;
            plan.draw(canvas, &axes)?;
            for (verdict, colour, _) in kinds {
                for ([x, y], _) in walls.tiles().filter(|(_, tile)| tile.verdict() == verdict) {
                    let [left, top] = axes.at(x - TILE_M / 2.0, y + TILE_M / 2.0);
                    let [right, bottom] = axes.at(x + TILE_M / 2.0, y - TILE_M / 2.0);
                    canvas.fill(Rect { left, top, right, bottom }, colour)?;
                }
            }
            for &[x, y] in walls.seen_from() {
                canvas.disc(axes.at(x, y), DOT, FOUND)?;
            }
            axes.draw_frame(canvas)
        },
    )
}
