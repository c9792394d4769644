//! The second half of the demo: from two rendered frames to a pose.

use crate::cli::debug::{Found, boundaries};
use crate::cli::localize::pose_of;
use crate::cli::pictures;
use crate::cli::pose::Pose;
use crate::cli::progress::Bars;
use anyhow::{Context as _, Result};
use compass_core::{HeightPrior, Settings};
use compass_host::calibration::{Calibration, NOMINAL_YAML};
use compass_host::dataset::tum;
use compass_host::frame::Frame;
use compass_host::locator::{Locator, see};
use compass_host::output::{Decimal, create_dir, write_file, write_png};
use compass_host::plan_import::PlanRaster;
use compass_host::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
use compass_host::report::{Picture, Section, Table};
use compass_host::sample::{FRAME_HEIGHT_M, FRAME_PITCH_ROLL_DEG, FRAME_PIXELS, FRAME_POSE};
use compass_host::simulate::{Scene, SceneOptions, render};
use compass_host::site::{BuildOptions, PackedPlan};
use compass_host::site_file::{SiteFile, floor_bytes_with_progress};
use compass_host::up::Mount;
use compass_host::visual_descriptor::VisualDescriptor;
use std::path::Path;
use std::time::Instant;

/// The results for the frames.
pub(super) struct Seen {
    pub(super) poses: Vec<Pose<'static>>,
    pub(super) probability: f64,
    pub(super) camera_height_m: f64,
    pub(super) milliseconds: f64,
}

/// Renders two frames, writes them, their calibration and a site file into `dir`, finds their pose and draws how.
pub(super) fn run(dir: &Path, raster: &PlanRaster, plan: &PackedPlan) -> Result<Seen> {
    create_dir(dir)?;
    let path = dir.join("sample.site");
    let structure = PackedPlan::new(&keep_structure(raster, DEFAULT_THICKNESS_M)?)?;
    let site =
        floor_bytes_with_progress("sample", raster, plan, Some(&structure), &BuildOptions::default(), &Bars)?;
    write_file(&path, &site)?;
    let file = SiteFile::read(&path)?;
    let floors = file.floors();
    let ([x, y], heading) = FRAME_POSE;
    let [pitch, roll] = FRAME_PITCH_ROLL_DEG;
    let pose = tum::Pose::looking(0, [x, y, FRAME_HEIGHT_M], heading, pitch, roll);
    let rig = Calibration::nominal().rig([Some(FRAME_PIXELS); 2])?;
    write_file(&dir.join("calibration.yaml"), NOMINAL_YAML.as_bytes())?;
    let images = render(&Scene::new(&SceneOptions::default(), raster), &rig, &pose);
    for (camera, image) in images.iter().enumerate() {
        let image = image.as_ref().context("the rig has two cameras")?;
        write_png(&dir.join(format!("cam{camera}.png")), image)?;
    }
    let frames = images.map(|image| image.and_then(Frame::from_rgb));
    let frames = frames.each_ref().map(Option::as_ref);
    let mut locator = Locator::new(&floors, rig, Settings::FULL)?;
    locator.watch().keeps_considered = true;
    let started = Instant::now();
    let mut segmented = locator.segment(frames)?;
    let up = Mount::Inverted.vertical(&mut segmented)?.up;
    let segments = [0, 1].map(|camera| segmented.segments(camera).to_vec());
    let levelled = segmented.level(&up)?;
    let level = levelled.frame();
    let mut seen = see(levelled);
    let fix = seen.locate(HeightPrior::UNKNOWN);
    let milliseconds = started.elapsed().as_secs_f64() * 1e3;
    let (window_evidence, windows) = (&seen.window_evidence().clone(), &seen.windows().to_vec());
    let descriptor = VisualDescriptor::of(&mut seen, HeightPrior::both(fix.heights()));
    let boundaries = boundaries(&mut seen);
    let truth = plan.scan([x, y], heading)?;
    let (plan, ranges, rig) = (Some(&truth), Some((&descriptor, &boundaries[..])), &rig);
    let considered = locator.watch().considered().context("the panorama was drawn")?;
    Found { frames, rig, segments, considered, level, windows, window_evidence, ranges, plan }.draw(dir)?;
    let poses: Vec<_> = fix.poses().iter().map(|scored| pose_of(scored, None)).collect();
    pictures::site_map(&dir.join("map.png"), raster, &floors[0].map, None, FRAME_POSE, &poses)?;
    let probability = f64::from(fix.probability());
    Ok(Seen { poses, probability, camera_height_m: f64::from(fix.camera_height_m()), milliseconds })
}

impl Seen {
    /// The printed summary.
    pub(super) fn summary(&self) -> String {
        let ([x, y], heading) = FRAME_POSE;
        let truth = format!("frames  x {x:.3} m  y {y:.3} m  heading {heading:.1} degrees\n");
        let Some(best) = self.poses.first() else { return truth + "found   nothing\n" };
        let (metres, degrees) = best.error([x, y], heading);
        format!(
            "{truth}found   x {:.3} m  y {:.3} m  heading {:.1} degrees  (probability {:.2})\n\
             off by {metres:.2} m and {degrees:.1} degrees, {:.0} ms from frames to pose\n",
            best.x.0, best.y.0, best.heading_deg.0, self.probability, self.milliseconds
        )
    }

    /// The section of the report.
    pub(super) fn section(&self) -> Section {
        let ([x, y], heading) = FRAME_POSE;
        let picture = |file: &str, caption: &str| Picture { file: file.into(), caption: caption.into() };
        let rows = self.poses.iter().enumerate().map(|(rank, pose)| {
            let (metres, degrees) = pose.error([x, y], heading);
            let Decimal(score) = pose.score;
            vec![
                (rank + 1).to_string(),
                format!("{:.2}, {:.2}", pose.x.0, pose.y.0),
                format!("{:.1}", pose.heading_deg.0),
                format!("{score:.0}"),
                format!("{metres:.2}"),
                format!("{degrees:.1}"),
            ]
        });
        let head = ["rank", "x, y (m)", "heading (deg)", "score (nats)", "off (m)", "off (deg)"];
        Section {
            title: "Where am I? From two frames".into(),
            text: vec![format!(
                "Two fisheye frames were rendered at x {x:.2} m, y {y:.2} m, heading {heading:.1} degrees, and nothing \
                 but the plan, the lenses and that the rig hangs upside down was told. The likeliest pose is within 1 m \
                 with a probability of {:.2}; the camera was found to be {:.2} m above the floor (truth: {FRAME_HEIGHT_M} m).",
                self.probability, self.camera_height_m
            )],
            tables: vec![Table {
                caption: "Answers".into(),
                head: head.map(String::from).into(),
                rows: rows.collect(),
            }],
            pictures: vec![
                picture("seen/map.png", "Truth and answers"),
                picture("seen/cam0.png", "The frame of cam0, as the sensor has it"),
                picture("seen/cam1.png", "The frame of cam1"),
                picture(
                    "seen/panorama.png",
                    "All around, levelled: floor and ceiling as found, windows, and what the plan says",
                ),
                picture("seen/descriptor.png", "The descriptor as seen, and the plan's at the true pose"),
            ],
        }
    }
}
