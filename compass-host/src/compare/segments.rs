//! Line segments: the core's detector against the reference, on a frame of the plan.

use super::{CompareError, Stage};
use crate::calibration::Calibration;
use crate::dataset::tum::Pose;
use crate::frame::{Frame, SegmentDetector};
use crate::interior::Places;
use crate::plan_import::PlanRaster;
use crate::reference::segments as reference;
use crate::simulate::{Renderer, Scene, SceneOptions};
use compass_core::vision::segments::{Parameters, SEGMENT_COVERAGE, Segment};

/// Segments match within this distance and angle.
const DISTANCE_PX: f64 = 2.0;
const ANGLE_DEG: f64 = 5.0;
/// Size of the frame, pixels.
const FRAME: (u32, u32) = (736, 720);
/// Height of the camera above the floor, metres.
const HEIGHT_M: f64 = 1.6;

/// Number of poses.
const POSES: usize = 3;

/// The smoothed image, and the share of either detector's segment length that the other finds, in frames of the plan
/// at random interior poses.
///
/// # Errors
/// A plan without interior, or a place that cannot be inside.
pub fn stages(raster: &PlanRaster, places: &Places, seed: u64) -> Result<Vec<Stage>, CompareError> {
    let rig = Calibration::nominal().rig([Some(FRAME); 2])?;
    let scene = Scene::in_places(&SceneOptions::default(), raster, places)?;
    let renderer = Renderer::new(&scene, &rig, None);
    let mut detector = SegmentDetector::new(FRAME.0, FRAME.1);
    let mut smoothed = vec![];
    // Matched length and total length, of the core's and of the reference's segments.
    let mut lengths = [[0.0; 2]; 2];
    for (x, y, heading) in super::poses_in_places(raster, places, POSES, seed)? {
        let pose = Pose::looking(0, [x, y, HEIGHT_M], heading, 8.0, 185.0);
        for image in renderer.render(&pose).into_iter().flatten() {
            let frame = Frame::from_rgb(image).ok_or(CompareError::Frame)?;
            let (width, height) = (frame.width() as usize, frame.height() as usize);
            let gray = frame.gray();
            let (found, _) = detector.detect(&gray, None, &Parameters::default())?;
            let ours: Vec<_> = found.iter().map(ends).collect();
            let blurred = reference::blur(gray.pixels(), width, height);
            let core = detector.smoothed(&gray);
            smoothed.extend(core.pixels().iter().zip(&blurred).map(|(a, b)| f64::from(a.abs_diff(*b))));
            let theirs = reference::detect(gray.pixels(), width, height, &reference::Options::default());
            let theirs: Vec<_> = theirs.iter().map(|s| [s.start, s.end]).collect();
            for (lengths, (a, b)) in lengths.iter_mut().zip([(&ours, &theirs), (&theirs, &ours)]) {
                let total: f64 = a.iter().map(length).sum();
                lengths[0] += coverage(a, b) * total;
                lengths[1] += total;
            }
        }
    }
    let bound = f64::from(SEGMENT_COVERAGE);
    let [ours, theirs] = lengths.map(|[found, all]| vec![if all > 0.0 { found / all } else { 1.0 }]);
    Ok(vec![
        Stage::at_most("segments: smoothed image", "gray level", smoothed, 1.0),
        Stage::at_least("segments: core's found by the reference", "share of length", ours, bound),
        Stage::at_least("segments: reference's found by the core", "share of length", theirs, bound),
    ])
}

/// The two ends of a segment of the core.
#[must_use]
pub fn ends(s: &Segment) -> [[f64; 2]; 2] {
    [[s.x1, s.y1], [s.x2, s.y2]].map(|end| end.map(f64::from))
}

/// The share of the length of `a` that lies within 2 px and 5 degrees of a segment of `b`; 1 if `a` is empty.
#[must_use]
pub fn coverage(a: &[[[f64; 2]; 2]], b: &[[[f64; 2]; 2]]) -> f64 {
    let total: f64 = a.iter().map(length).sum();
    let covered = |s: &[[f64; 2]; 2]| {
        let pieces = length(s).ceil().max(1.0);
        let near: Vec<_> = b.iter().filter(|t| angle_deg(s, t) <= ANGLE_DEG).collect();
        let middle = |k: f64| [0, 1].map(|i| s[0][i] + (s[1][i] - s[0][i]) * (k + 0.5) / pieces);
        let hit = (0..pieces as u32)
            .filter(|k| near.iter().any(|t| distance(middle(f64::from(*k)), t) <= DISTANCE_PX));
        length(s) * hit.count() as f64 / pieces
    };
    if total > 0.0 { a.iter().map(covered).sum::<f64>() / total } else { 1.0 }
}

fn length([p, q]: &[[f64; 2]; 2]) -> f64 {
    (q[0] - p[0]).hypot(q[1] - p[1])
}

/// The angle between two segments whose ends may be exchanged.
fn angle_deg(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> f64 {
    let direction = |[p, q]: &[[f64; 2]; 2]| (q[1] - p[1]).atan2(q[0] - p[0]).to_degrees();
    let turn = (direction(a) - direction(b)).rem_euclid(180.0);
    turn.min(180.0 - turn)
}

fn distance(point: [f64; 2], [p, q]: &[[f64; 2]; 2]) -> f64 {
    let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
    let along = ((point[0] - p[0]) * dx + (point[1] - p[1]) * dy) / (dx * dx + dy * dy).max(1e-12);
    let along = along.clamp(0.0, 1.0);
    (point[0] - p[0] - along * dx).hypot(point[1] - p[1] - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_counts_length() {
        let a = [[[0.0, 0.0], [10.0, 0.0]], [[0.0, 50.0], [0.0, 60.0]]];
        let b = [[[15.0, 1.0], [5.0, 1.0]]];
        // Pieces in the first's second half, and those within 2 px of the other's end.
        assert!((coverage(&a, &b) - 0.3).abs() < 0.06, "{}", coverage(&a, &b));
        assert!((coverage(&b, &a) - 0.6).abs() < 0.11, "{}", coverage(&b, &a));
        assert!((coverage(&[], &a) - 1.0).abs() < 1e-12);
        assert!(coverage(&a, &[]).abs() < 1e-12);
    }
}
