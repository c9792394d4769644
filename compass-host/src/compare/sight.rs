//! Up vector and ranges: the core against the reference, on frames of the plan.

use super::{CompareError, Stage};
use crate::calibration::Calibration;
use crate::dataset::tum::Pose;
use crate::frame::{Frame, SegmentDetector};
use crate::interior::Places;
use crate::plan_import::PlanRaster;
use crate::reference::{attitude as reference, boundary as real};
use crate::simulate::{Renderer, Scene, SceneOptions};
use compass_core::base::num::CellNats;
use compass_core::base::raster::GrayImage;
use compass_core::vision::attitude::{self, Arc, Parameters, UP_ERROR_DEG, UpHint};
use compass_core::vision::boundary::{
    self, BoundaryFinder, EVIDENCE_ERROR, EVIDENCE_PPM, GRAY_LEVELS, GRAY_PPM,
};
use compass_core::vision::camera::{Bearing, Rig};
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::sample::ExclusionMask;
use compass_core::vision::segments::Segment;
use compass_core::vision::windows::segment_parameters;

/// Size of the frames, pixels.
const FRAME: (u32, u32) = (736, 720);
/// Height of the camera above the floor, metres.
const HEIGHT_M: f64 = 1.6;
/// Number of poses.
const POSES: usize = 3;

/// Differences over all poses.
#[derive(Debug, Default)]
struct Differences {
    up_deg: Vec<f64>,
    /// Cells with equal gray levels, and all cells.
    gray: [usize; 2],
    /// Cells with equal evidence, and all cells.
    evidence: [usize; 2],
}

/// Up vector, edges, their support and the likelihood of ranges at random interior poses of the plan. Each step of the
/// reference starts from the core's result of the step before.
///
/// # Errors
/// A plan without interior, or a place that cannot be inside.
pub fn stages(raster: &PlanRaster, places: &Places, seed: u64) -> Result<Vec<Stage>, CompareError> {
    let rig = Calibration::nominal().rig([Some(FRAME); 2])?;
    let scene = Scene::in_places(&SceneOptions::default(), raster, places)?;
    let renderer = Renderer::new(&scene, &rig, None);
    let mut detectors = [(); 2].map(|()| SegmentDetector::new(FRAME.0, FRAME.1));
    let mut found = Differences::default();
    for (x, y, heading) in super::poses_in_places(raster, places, POSES, seed)? {
        let pose = Pose::looking(0, [x, y, HEIGHT_M], heading, 8.0, 185.0);
        let up: Bearing = pose.up_in_camera().cast();
        let [front, back] = renderer.render(&pose).map(|image| image.and_then(Frame::from_rgb));
        let frames = [front.ok_or(CompareError::Frame)?, back.ok_or(CompareError::Frame)?];
        let mut segments = Vec::new();
        for (camera, view) in rig.views() {
            let (of, _) =
                detectors[camera].detect(&frames[camera].gray(), None, &segment_parameters(view))?;
            segments.extend(of.iter().map(|segment| (*segment, camera)));
        }
        found.add_up(&rig, &segments, up);
        let images = [0, 1].map(|camera: usize| frames[camera].gray());
        let smoothed = [0, 1].map(|camera: usize| detectors[camera].smoothed(&images[camera]));
        found.add_ranges(&rig, &smoothed, LevelFrame::new(&up).ok_or(CompareError::Heading)?);
    }
    Ok(found.stages())
}

impl Differences {
    fn add_up(&mut self, rig: &Rig, segments: &[(Segment, usize)], up: Bearing) {
        let parameters = Parameters::default();
        let view = |camera: usize| rig.view(camera);
        let arcs: Vec<_> =
            segments.iter().filter_map(|(s, camera)| Arc::new(s, view(*camera)?, *camera as u32)).collect();
        let again: Vec<_> = segments
            .iter()
            .filter_map(|(s, camera)| reference::Arc::new(super::segments::ends(s), view(*camera)?))
            .collect();
        if let Some(core) = attitude::vertical(&arcs, UpHint::Up(up), &parameters) {
            let exact = reference::refined(&again, up.cast(), f64::from(parameters.tolerance_deg));
            let core = core.up.cast::<f64>();
            self.up_deg.push(core.cross(&exact).norm().atan2(core.dot(&exact)).to_degrees());
        }
    }

    fn add_ranges(&mut self, rig: &Rig, images: &[GrayImage<'_>; 2], level: LevelFrame) {
        let mut gray = vec![0; boundary::RASTER_CELLS];
        let mut work = Box::<boundary::Work>::default();
        let mut evidence = vec![CellNats::ZERO; boundary::CELLS];
        let buffers = boundary::Buffers { gray: &mut gray, work: &mut work, evidence: &mut evidence };
        let Some(mut finder) = BoundaryFinder::new(buffers, rig, level) else { return };
        for (camera, image) in images.iter().enumerate() {
            finder.add(camera, image, ExclusionMask::Unknown);
        }
        let _ = finder.finish();
        let cells = real::gray_levels(rig, images.each_ref().map(Some), level.up().cast());
        for (core, exact) in gray.iter().zip(&cells) {
            let (true, Some((exact, _))) = (*core > 0, exact) else { continue };
            count(&mut self.gray, f64::from(*core) - exact, f64::from(GRAY_LEVELS));
        }
        // From the core's gray levels; the camera of each cell is that of the reference.
        let raster: Vec<_> = gray
            .iter()
            .zip(&cells)
            .map(|(core, exact)| (*core > 0).then(|| (f64::from(*core), exact.map_or(0, |exact| exact.1))))
            .collect();
        for (core, exact) in evidence.iter().zip(real::evidence(&raster)) {
            count(&mut self.evidence, f64::from(*core) - exact, f64::from(EVIDENCE_ERROR));
        }
    }

    fn stages(self) -> Vec<Stage> {
        vec![
            Stage::at_most("attitude: up vector", "degrees", self.up_deg, f64::from(UP_ERROR_DEG)),
            Stage::share("boundary: gray levels alike within 2", self.gray, GRAY_PPM),
            Stage::share("boundary: evidence alike within 0.25 nat", self.evidence, EVIDENCE_PPM),
        ]
    }
}

/// Counts a difference: those within a bound, and all.
fn count([alike, all]: &mut [usize; 2], difference: f64, bound: f64) {
    *alike += usize::from(difference.abs() <= bound);
    *all += 1;
}
