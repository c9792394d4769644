//! From a pair of frames to a pose: all stages with their default options, in one call.

use crate::frame::Frame;
use crate::locator::{Locator, SeeError};
use crate::up::Mount;
use crate::up_by_plan::locate_by_plan;
use compass_core::{Fix, HeightPrior, PosePrior};

/// Finds the pose in a site from which a pair of frames was taken.
///
/// `frames` are those of cam0 and cam1, in the sizes for which the locator's rig was made. `mount` says which side of
/// cam0's image is up; of [`Mount::Auto`] both are tried, and the plan [decides](locate_by_plan), which takes twice the time.
///
/// # Errors
/// [`SeeError`]: the up vector cannot be determined from the image, or the frames do not match the rig.
pub fn localize<'a>(
    locator: &mut Locator<'a>,
    frames: [Option<&Frame>; 2],
    mount: Mount,
    heights: HeightPrior,
) -> Result<Fix<'a>, SeeError> {
    let mut segmented = locator.segment(frames)?;
    let ups = mount.candidates(&mut segmented)?;
    Ok(locate_by_plan(segmented, &ups, heights, &PosePrior::UNKNOWN)?.fix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Calibration;
    use crate::dataset::tum::Pose;
    use crate::output::write_file;
    use crate::plan_import::PlanRaster;
    use crate::sample::{FRAME_POSE, building};
    use crate::simulate::{Scene, SceneOptions, render};
    use crate::site::{BuildOptions, PackedPlan};
    use crate::site_file::{SiteFile, floor_bytes};
    use compass_core::Settings;

    #[test]
    fn rendered_frames_are_found_where_they_were_rendered() {
        let raster = PlanRaster::from(building());
        let plan = PackedPlan::new(&raster).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sample.site");
        write_file(&path, &floor_bytes("sample", &raster, &plan, None, &BuildOptions::default()).unwrap())
            .unwrap();
        let site = SiteFile::read(&path).unwrap();
        let ([x, y], heading) = FRAME_POSE;
        let rig = Calibration::nominal().rig([Some((736, 720)); 2]).unwrap();
        let pose = Pose::looking(0, [x, y, 1.6], heading, 4.0, 187.0);
        let frames = render(&Scene::new(&SceneOptions::default(), &raster), &rig, &pose)
            .map(|image| image.and_then(Frame::from_rgb));
        let mut locator = Locator::new(&site.floors(), rig, Settings::FULL).unwrap();
        let frames = frames.each_ref().map(Option::as_ref);
        let fix = localize(&mut locator, frames, Mount::Inverted, HeightPrior::UNKNOWN).unwrap();
        let pose = fix.pose().unwrap();
        assert_eq!(fix.floor_name(), Some("sample"));
        let off = [pose.at.x.to_num::<f64>() - x, pose.at.y.to_num::<f64>() - y];
        assert!(off[0].hypot(off[1]) < 0.5, "{off:?} m off");
        // Not told, the plan decides the same, with the other side as a rival.
        let untold = localize(&mut locator, frames, Mount::Auto, HeightPrior::UNKNOWN).unwrap();
        assert_eq!(untold.poses(), fix.poses());
        assert!(
            fix.rival().is_none() && untold.rival().is_some_and(|rival| rival < fix.best().unwrap().score)
        );
        assert!(untold.margin() <= fix.margin());
        let missing = localize(&mut locator, [None, None], Mount::Inverted, HeightPrior::UNKNOWN);
        assert_eq!(missing.unwrap_err().to_string(), "the frame of cam0 is missing");
        let black = Frame::from_rgb(image::RgbImage::new(736, 720)).unwrap();
        let dark = localize(&mut locator, [Some(&black); 2], Mount::Inverted, HeightPrior::UNKNOWN);
        assert!(matches!(dark, Err(SeeError::NoVertical)));
    }
}
