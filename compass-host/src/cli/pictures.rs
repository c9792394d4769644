//! The plan-side pictures of the paper, for `describe` and `demo`.

use super::pose::Pose;
use anyhow::Result;
use compass_core::map::site_map::SiteMap;
use compass_host::figures::{self, MapPose, PlanPicture, Scores, SiteMapPicture};
use compass_host::output::create_dir;
use compass_host::plan_descriptor::PlanDescriptor;
use compass_host::plan_import::PlanRaster;
use std::path::Path;

/// Calls `draw` with the plan in the form that the figures take.
pub(super) fn with_plan<T>(raster: &PlanRaster, draw: impl FnOnce(&PlanPicture<'_>) -> T) -> T {
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let (is_wall, is_window) = (|x: u32, y: u32| walls.get(x, y), |x: u32, y: u32| windows.get(x, y));
    draw(&PlanPicture {
        width: raster.width,
        height: raster.height,
        resolution_m: raster.resolution_m,
        origin: raster.origin,
        is_wall: &is_wall,
        is_window: &is_window,
    })
}

/// Writes the four pictures of one descriptor: `rays.png`, `polar.png`, `descriptor.png`, `profile.png`.
pub(super) fn describe(
    dir: &Path,
    raster: &PlanRaster,
    at: [f64; 2],
    heading_deg: f64,
    described: &PlanDescriptor,
) -> Result<()> {
    create_dir(dir)?;
    let PlanDescriptor { range_m, hit, channels } = described;
    with_plan(raster, |plan| figures::draw_rays(&dir.join("rays.png"), plan, at, heading_deg, range_m, hit))?;
    figures::draw_polar(&dir.join("polar.png"), range_m, hit)?;
    figures::draw_descriptor(&dir.join("descriptor.png"), channels)?;
    figures::draw_profile(&dir.join("profile.png"), range_m, &described.gradient_m(), hit)?;
    Ok(())
}

/// Draws the candidates of a map over its plan, by their scores if there are any, with the true pose and the answers.
pub(super) fn site_map(
    path: &Path,
    raster: &PlanRaster,
    map: &SiteMap<'_>,
    scores: Option<Scores<'_>>,
    (position, heading_deg): ([f64; 2], f64),
    answers: &[Pose<'_>],
) -> Result<()> {
    let positions: Vec<[f64; 2]> = (0..map.len())
        .filter_map(|index| map.position(index))
        .map(|at| [at.x.to_num(), at.y.to_num()])
        .collect();
    let pose = |p: &Pose<'_>| MapPose { position: [p.x.0, p.y.0], heading_deg: p.heading_deg.0 };
    let alternatives: Vec<MapPose> = answers.iter().skip(1).map(pose).collect();
    let picture = SiteMapPicture {
        candidates: &positions,
        scores,
        truth: Some(MapPose { position, heading_deg }),
        found: answers.first().map(pose),
        alternatives: &alternatives,
    };
    with_plan(raster, |plan| figures::draw_site_map(path, plan, &picture))?;
    Ok(())
}
