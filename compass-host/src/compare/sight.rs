//! Up vector and ranges: the core against the reference, on frames of the plan.

use super::{CompareError, Stage};
use crate::calibration::Calibration;
use crate::dataset::tum::Pose;
use crate::frame::{Frame, SegmentDetector};
use crate::plan_import::PlanRaster;
use crate::reference::{attitude as reference, boundary as real};
use crate::simulate::{Renderer, Scene, SceneOptions};
use compass_core::base::ladder::RUNG;
use compass_core::base::num::SupportNats;
use compass_core::base::raster::GrayImage;
use compass_core::vision::attitude::{self, Arc, Parameters, UP_ERROR_DEG, UpHint};
use compass_core::vision::boundary::{
    self, BoundaryFinder, EDGE_LEVELS, EDGES_PPM, EVIDENCE_ERROR, RangeLikelihoods,
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
    /// Cells with equal edges, and all cells.
    edges: [usize; 2],
    evidence: Vec<f64>,
    ratios: Vec<f64>,
}

/// Up vector, edges, their support and the likelihood of ranges at random interior poses of the plan. Each step of the
/// reference starts from the core's result of the step before.
///
/// # Errors
/// A plan without interior.
pub fn stages(raster: &PlanRaster, seed: u64) -> Result<Vec<Stage>, CompareError> {
    let rig = Calibration::nominal().rig([Some(FRAME); 2])?;
    let scene = Scene::new(&SceneOptions::default(), raster);
    let renderer = Renderer::new(&scene, &rig, None);
    let mut detectors = [(); 2].map(|()| SegmentDetector::new(FRAME.0, FRAME.1));
    let mut found = Differences::default();
    for (x, y, heading) in super::interior_poses(raster, POSES, seed)? {
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
        let [mut edges, mut support] = [(); 2].map(|()| vec![0; boundary::CELLS]);
        // A finder dropped before it has finished leaves the raw edges.
        let drawn = boundary_finder(rig, images, level, [&mut edges, &mut support]).map(drop);
        let raw = edges.clone();
        let known = |edge: &u8| (*edge > 0).then(|| f64::from(*edge) - 1.0);
        let exact = real::edges(rig, images.each_ref().map(Some), level.up().cast());
        for pair in raw.iter().map(known).zip(&exact) {
            let (Some(core), Some(exact)) = pair else { continue };
            let alike = (core - exact).abs() <= f64::from(EDGE_LEVELS);
            self.edges = [self.edges[0] + usize::from(alike), self.edges[1] + 1];
        }
        let mut ranges = Box::new(RangeLikelihoods::EMPTY);
        if let (Some(()), Some(finder)) =
            (drawn, boundary_finder(rig, images, level, [&mut edges, &mut support]))
        {
            finder.finish().likeliest(None, &mut ranges);
        }
        let nats: Vec<_> = support.iter().map(|cell| f64::from(SupportNats::from_bits(*cell))).collect();
        let exact = real::support(&raw.iter().map(known).collect::<Vec<_>>());
        self.evidence.extend(nats.iter().zip(exact).map(|(core, exact)| (core - exact).abs()));
        let ceiling = (ranges.ceiling_ratio().ln() / RUNG).round() as isize;
        let exact = real::log_ratios(&nats, ceiling);
        for (rung, exact) in exact.chunks_exact(real::BINS).enumerate() {
            // At this height the core's rungs are the reference's.
            let row = ranges.row(rung, LEAD).iter().zip(exact).enumerate();
            let known = row.filter(|(bin, _)| ranges.knows(*bin));
            self.ratios.extend(known.map(|(_, (core, exact))| (f64::from(*core) - exact).abs()));
        }
    }

    fn stages(self) -> Vec<Stage> {
        let [alike, all] = self.edges;
        let edges = Stage::share("boundary: edges alike within 2 gray levels", [alike, all], EDGES_PPM);
        let bound = f64::from(EVIDENCE_ERROR);
        vec![
            Stage::at_most("attitude: up vector", "degrees", self.up_deg, f64::from(UP_ERROR_DEG)),
            edges,
            Stage::at_most("boundary: evidence of edges", "nat", self.evidence, bound),
            Stage::at_most("boundary: log-likelihood ratio of ranges", "nat", self.ratios, bound),
        ]
    }
}

/// The height, in rungs, at which the ladder starts at rung 0.
const LEAD: i8 = 9;

/// A finder that has processed both frames.
fn boundary_finder<'a, 'r>(
    rig: &'r Rig,
    images: &[GrayImage<'_>; 2],
    level: LevelFrame,
    [edges, support]: [&'a mut [u8]; 2],
) -> Option<BoundaryFinder<'a, 'r>> {
    let mut finder = BoundaryFinder::new(boundary::Buffers { edges, support }, rig, level)?;
    for (camera, image) in images.iter().enumerate() {
        finder.add(camera, image, ExclusionMask::Unknown);
    }
    Some(finder)
}
