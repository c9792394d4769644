//! From frames to a pose, with what was seen on the way.

use crate::message::{Reply, floats, reply};
use crate::progress::Told;
use compass_host::compass_core::base::ladder::HEIGHTS_M;
use compass_host::compass_core::base::scan::Scan;
use compass_host::compass_core::descriptor::Descriptor;
use compass_host::compass_core::descriptor::similarity::{Candidate, Query, Similarity, Weights};
use compass_host::compass_core::descriptor::spectrum::Correlator;
use compass_host::compass_core::map::site_map::SiteMap;
use compass_host::compass_core::pose::FloorLayer;
use compass_host::compass_core::vision::camera::{Bearing, Rig};
use compass_host::compass_core::vision::level_frame::LevelFrame;
use compass_host::compass_core::vision::panorama::Resolution;
use compass_host::compass_core::vision::windows::Window;
use compass_host::compass_core::{Fix, ScoredPose};
use compass_host::output::pose_bits;
use compass_host::up_by_plan::{Placed, locate_by_plan};
use compass_host::{
    Calibration, Covariance, Frame, HeightPrior, Locator, Mount, PlanDescriptor, PosePrior, Progress as _,
    Settings, SiteFile, VisualDescriptor, doubt, outline,
};
use serde::{Deserialize, Serialize};

/// Most candidates that are scored by the descriptor: a score takes some milliseconds.
const MOST_HEAT: usize = 2500;

/// What is asked.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Question {
    /// Which side of cam0's image is up: `auto`, `upright` or `inverted`.
    mount: String,
    /// Height of cam0 above the floor, metres, if it is known.
    #[serde(default)]
    camera_height: Option<f32>,
    /// Least probability of a pose that is said.
    #[serde(default = "half")]
    min_probability: f64,
}

const fn half() -> f64 {
    0.5
}

/// A pose, with the keys of the command's JSON.
#[derive(Serialize)]
struct Pose<'a> {
    floor: &'a str,
    x: f64,
    y: f64,
    heading_deg: f64,
    score: f64,
    covariance: [[f32; 3]; 3],
    bits: String,
}

/// Lines in the image of a camera, pixels.
#[derive(Default, Serialize)]
struct Overlay {
    /// x and y of both ends.
    segments: Vec<[f32; 4]>,
    windows: Vec<Vec<[f64; 2]>>,
    /// The floor's edge as seen, and as the plan has it at the pose.
    floor: Vec<Option<[f64; 2]>>,
    ceiling: Vec<Option<[f64; 2]>>,
    plan_floor: Vec<Option<[f64; 2]>>,
    plan_ceiling: Vec<Option<[f64; 2]>>,
}

#[derive(Serialize)]
struct Located<'a> {
    /// The likeliest pose, if it is sure.
    pose: Option<&'a Pose<'a>>,
    probability: f64,
    /// Why the pose is not sure.
    reason: Option<String>,
    margin: f64,
    camera_height_m: f32,
    ceiling_height_m: f32,
    up_in_cam0: [f32; 3],
    candidates: &'a [Pose<'a>],
    overlays: [Option<Overlay>; 2],
    /// Whether each direction was seen, and what there: 0 open, 1 window, 2 wall.
    hit: Vec<Option<u8>>,
}

/// Frames whose place is sought, and where.
#[derive(Debug)]
pub(crate) struct Sought<'a> {
    pub(crate) site: &'a SiteFile,
    pub(crate) calibration: &'a Calibration,
    pub(crate) frames: [Option<&'a Frame>; 2],
}

impl Sought<'_> {
    /// The reply, and the descriptor as seen, if frames tell which way is up.
    pub(crate) fn locate(&self, question: &Question) -> Result<(Reply, Option<VisualDescriptor>), String> {
        let mount: Mount = question.mount.parse().map_err(|error| format!("mount: {error}"))?;
        let heights = heights(question.camera_height)?;
        let sizes = self.frames.map(|frame| frame.map(|frame| (frame.width(), frame.height())));
        let rig = self.calibration.rig(sizes).map_err(|error| error.to_string())?;
        let floors = self.site.floors();
        let mut locator =
            Locator::new(&floors, rig, Settings::FULL).map_err(|error| format!("the site {error}"))?;
        let (resolution, layers) = (locator.resolution(), locator.layers().to_vec());
        let mut segmented = locator.segment(self.frames).map_err(|error| error.to_string())?;
        let segments = [0, 1].map(|camera| {
            segmented.segments(camera).iter().map(|s| [s.x1, s.y1, s.x2, s.y2]).collect::<Vec<_>>()
        });
        let placed = mount
            .candidates(&mut segmented)
            .and_then(|ups| locate_by_plan(segmented, &ups, heights, &PosePrior::UNKNOWN));
        let Placed { up, mut seen, fix } = match placed {
            Ok(placed) => placed,
            Err(error) if error.is_answer() => {
                let reason = doubt::with_fault(error.to_string(), doubt::of_frames(self.frames));
                return Ok((self.nothing(reason, segments), None));
            }
            Err(error) => return Err(error.to_string()),
        };
        let windows = seen.windows().to_vec();
        let descriptor = VisualDescriptor::of(&mut seen, HeightPrior::both(fix.heights()));
        let sure = fix.best().is_some() && f64::from(fix.probability()) >= question.min_probability;
        let plan = if sure { plan_scan(&fix, &layers) } else { None };
        let view = Seen {
            rig: &rig,
            up,
            windows: &windows,
            descriptor: &descriptor,
            plan: plan.as_ref(),
            fix: &fix,
        };
        let mut overlays = segments.map(Some);
        let overlays = [0, 1].map(|camera| {
            let segments = overlays[camera].take()?;
            self.frames[camera].map(|_| view.overlay(camera, segments, resolution))
        });
        let candidates: Vec<Pose<'_>> = fix
            .poses()
            .iter()
            .zip(fix.covariances())
            .map(|(pose, spread)| Pose::new(pose, spread, &layers))
            .collect();
        let reason = (!sure).then(|| {
            let reason =
                doubt::with_fault(doubt::of_fix(&fix, question.min_probability), doubt::of_maps(&floors));
            doubt::with_fault(reason, doubt::of_frames(self.frames))
        });
        let json = Located {
            pose: candidates.first().filter(|_| sure),
            probability: f64::from(fix.probability()),
            reason,
            margin: fix.margin().to_num(),
            camera_height_m: fix.camera_height_m(),
            ceiling_height_m: fix.ceiling_height_m(),
            up_in_cam0: [up.x, up.y, up.z],
            candidates: &candidates,
            overlays,
            hit: descriptor.hit.iter().map(|hit| hit.map(|hit| hit as u8)).collect(),
        };
        Ok((reply(&json, &[]), Some(descriptor)))
    }

    /// The reply to frames that do not tell.
    fn nothing(&self, reason: String, segments: [Vec<[f32; 4]>; 2]) -> Reply {
        let mut at = 0;
        let overlays = segments.map(|segments| {
            let there = self.frames[at].is_some();
            at += 1;
            there.then(|| Overlay { segments, ..Overlay::default() })
        });
        let json = Located {
            pose: None,
            probability: 0.0,
            reason: Some(reason),
            margin: 0.0,
            camera_height_m: 0.0,
            ceiling_height_m: 0.0,
            up_in_cam0: [0.0; 3],
            candidates: &[],
            overlays,
            hit: Vec::new(),
        };
        reply(&json, &[])
    }
}

impl<'a> Pose<'a> {
    fn new(scored: &ScoredPose, covariance: &Covariance, layers: &[FloorLayer<'a>]) -> Self {
        Self {
            floor: layers.get(usize::from(scored.layer)).map_or("", |layer| layer.name),
            x: scored.at.x.to_num(),
            y: scored.at.y.to_num(),
            heading_deg: f64::from(scored.heading.to_microdegrees()) / 1e6,
            score: scored.score.to_num(),
            covariance: covariance.rows(),
            bits: pose_bits(scored),
        }
    }
}

/// What was seen with an up vector.
struct Seen<'a> {
    rig: &'a Rig,
    up: Bearing,
    windows: &'a [Window],
    descriptor: &'a VisualDescriptor,
    plan: Option<&'a Scan>,
    fix: &'a Fix<'a>,
}

impl Seen<'_> {
    fn overlay(&self, camera: usize, segments: Vec<[f32; 4]>, resolution: Resolution) -> Overlay {
        let Some((view, level)) = self.rig.view(camera).zip(LevelFrame::new(&self.up)) else {
            return Overlay { segments, ..Overlay::default() };
        };
        let windows = self.windows.iter().map(|window| outline::window(window, view, &level, resolution));
        let height = self.descriptor.height;
        let seen = self.descriptor.ranges.map(|range| range.map(|range| f64::from(range.metres)));
        let planned = self.plan.map(|plan| PlanDescriptor::from(plan).range_m.map(Some));
        let edge = |ranges: &[Option<f64>; 360], above: f64| outline::boundary(ranges, above, view, &level);
        let [floor_m, ceiling_m] = [-height.camera_m, height.ceiling_m - height.camera_m].map(f64::from);
        let [camera_m, whole_m] = [self.fix.camera_height_m(), self.fix.ceiling_height_m()].map(f64::from);
        let of_plan = |above: f64| planned.as_ref().map_or_else(Vec::new, |ranges| edge(ranges, above));
        Overlay {
            segments,
            windows: windows.filter(|outline| outline.len() > 1).collect(),
            floor: edge(&seen, floor_m),
            ceiling: edge(&seen, ceiling_m),
            plan_floor: of_plan(-camera_m),
            plan_ceiling: of_plan(whole_m - camera_m),
        }
    }
}

/// What the plan has around the pose of a fix, on the layer that fits best.
fn plan_scan(fix: &Fix<'_>, layers: &[FloorLayer<'_>]) -> Option<Scan> {
    let best = fix.best()?;
    let mut scan = Scan::OPEN;
    layers.get(usize::from(best.layer))?.plan.scan(best.at, best.heading, &mut scan).ok()?;
    Some(scan)
}

/// Of candidates all over the floor x, y and their score by the descriptor, the best over all headings: what the paper's
/// matching says. Of more than [`MOST_HEAT`] every second, third and so on.
pub(crate) fn heat(map: &SiteMap<'_>, descriptor: &VisualDescriptor) -> Vec<u8> {
    let (mut query, mut correlator) = (Box::new(Query::EMPTY), Box::new(Correlator::new()));
    let seen = Descriptor::from(&descriptor.scan);
    query.set(&seen, &descriptor.confidence, Weights::EQUAL, Similarity::Centred);
    query.load(&mut correlator);
    let stride = map.len().div_ceil(MOST_HEAT).max(1);
    let work = Told.begin(map.len().div_ceil(stride), "scoring");
    let mut scan = Scan::OPEN;
    let scores = map.iter().enumerate().step_by(stride).filter_map(|(number, record)| {
        work.step();
        record.scan(&mut scan);
        let peak = query.peak(&Candidate::from(&Descriptor::from(&scan)), &mut correlator);
        let at = map.position(number)?;
        Some([at.x.to_num(), at.y.to_num(), peak.score().to_num()])
    });
    floats(scores.flatten())
}

fn heights(camera_m: Option<f32>) -> Result<HeightPrior, String> {
    let [least, most] = HEIGHTS_M;
    match camera_m {
        None => Ok(HeightPrior::UNKNOWN),
        Some(metres) if (least..=most).contains(&metres) => Ok(HeightPrior::camera(metres)),
        Some(metres) => Err(format!("camera height: {metres} is not {least} to {most} m")),
    }
}
