//! A picture of poses on the plan of a floor, for notebooks.

use crate::error::wrong;
use crate::fix::Pose;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use compass_host::SiteFile;
use compass_host::figures::{MapPose, SiteMapPicture, draw_site_map, with_packed_plan};
use pyo3::PyResult;

/// The picture as PNG in base64: the best pose, and its alternatives on the same floor.
pub(crate) fn of_poses(site: &SiteFile, floor: u8, poses: &[Pose]) -> PyResult<String> {
    let floors = site.floors();
    let found = floors.get(usize::from(floor)).and_then(|floor| floor.floor);
    let (name, plan) = found
        .and_then(|floor| Some((floor.name(), floor.plan(0)?)))
        .ok_or_else(|| wrong("the site has no plan"))?;
    let here: Vec<MapPose> = poses
        .iter()
        .filter(|pose| pose.is_on(name))
        .map(Pose::place)
        .map(|(position, heading_deg)| MapPose { position, heading_deg })
        .collect();
    let mut here = here.into_iter();
    let found = here.next();
    let alternatives: Vec<MapPose> = here.collect();
    let picture =
        SiteMapPicture { candidates: &[], scores: None, truth: None, found, alternatives: &alternatives };
    let folder = tempfile::tempdir().map_err(wrong)?;
    let path = folder.path().join("poses.png");
    with_packed_plan(&plan, |plan| draw_site_map(&path, plan, &picture)).map_err(wrong)?;
    Ok(STANDARD.encode(std::fs::read(&path).map_err(wrong)?))
}

/// Text as HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
