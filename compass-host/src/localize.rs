//! From a pair of frames to a pose: all steps with their defaults, in one call.

use crate::eyes::{Eyes, EyesError, Mount};
use crate::frame::Frame;
use crate::locator::Locator;
use compass_core::base::ladder::height_rungs;
use compass_core::pose::locate::{Fix, HeightPrior};

/// Finds where in a site a pair of frames was taken.
///
/// `frames` are those of cam0 and cam1, of the sizes that the rig of `eyes` was made for; one may be missing.
/// `mount` says which side of cam0's image is up; `camera_height_m` is the height of cam0 above the floor in metres,
/// which is estimated when absent.
///
/// # Errors
/// [`EyesError`]: the image does not tell which way is up, or a frame is larger than the rig's.
pub fn localize(
    locator: &mut Locator<'_>,
    eyes: &mut Eyes,
    frames: [Option<&Frame>; 2],
    mount: Mount,
    camera_height_m: Option<f32>,
) -> Result<Fix, EyesError> {
    eyes.detect(frames)?;
    let up = eyes.vertical(frames, mount)?.up;
    let seen = eyes.windows(frames, &up)?;
    let (windows, up) = (seen.sighting, seen.level.up());
    let boundary = eyes.survey(frames, &up)?;
    let prior = HeightPrior { height: camera_height_m.map(height_rungs), ceiling: None };
    Ok(locator.locate(&boundary, prior, &windows))
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
        let mut locator = Locator::new(&site.floors()).unwrap();
        let mut eyes = Eyes::new(rig);
        let frames = frames.each_ref().map(Option::as_ref);
        let fix = localize(&mut locator, &mut eyes, frames, Mount::Inverted, None).unwrap();
        let best = fix.answer.best().unwrap();
        let off = [best.at.x.to_num::<f64>() - x, best.at.y.to_num::<f64>() - y];
        assert!(off[0].hypot(off[1]) < 0.5, "{off:?} m off");
        let dark = [None, None];
        assert!(matches!(
            localize(&mut locator, &mut Eyes::new(rig), dark, Mount::Inverted, None),
            Err(EyesError::NoVertical)
        ));
    }
}
