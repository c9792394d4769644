//! The pictures of `--debug-dir`: what was found in camera frames, and the candidates.

use anyhow::Result;
use compass_core::base::num::{BINS, CellNats};
use compass_core::base::raster::GrayImage;
use compass_core::base::scan::{STEPS_PER_METRE, Scan};
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::windows::{ImageWindow, Rejection};
use compass_core::vision::boundary::CELLS;
use compass_core::vision::camera::{Pixel, Rig, View};
use compass_core::vision::level_frame::{LevelFrame, NOMINAL_RANGE_M};
use compass_core::vision::segments::Segment;
use compass_core::vision::windows::{Window, WindowEvidence};
use compass_host::compare::float_levels;
use compass_host::figures::{self, Layer, PanoramaPicture, RingPicture};
use compass_host::frame::Frame;
use compass_host::locator::{Considered, Seen};
use compass_host::outline;
use compass_host::output::create_dir;
use compass_host::paper_finder::PaperFinder;
use compass_host::visual_descriptor::VisualDescriptor;
use plotters::style::RGBColor;
use std::path::Path;

/// Largest difference in azimuth between a segment's midpoint and the window side that it borders, degrees.
const BESIDE_DEG: f32 = 0.75;
/// Largest difference in azimuth between the ends of such a segment, degrees.
const LEAN_DEG: f32 = 1.5;

const GREEN: RGBColor = RGBColor(0x00, 0xd0, 0x30);
const RED: RGBColor = RGBColor(0xff, 0x20, 0x20);
const BLUE: RGBColor = RGBColor(0x40, 0xa0, 0xff);
const YELLOW: RGBColor = RGBColor(0xff, 0xd0, 0x00);

/// The results of the window finder in the level frame for a pair of frames.
pub(super) struct Found<'a> {
    pub(super) frames: [Option<&'a Frame>; 2],
    pub(super) rig: &'a Rig,
    /// Line segments of each frame.
    pub(super) segments: [Vec<Segment>; 2],
    /// The candidates from which the windows were selected.
    pub(super) considered: Considered,
    pub(super) level: LevelFrame,
    pub(super) windows: &'a [Window],
    pub(super) window_evidence: &'a WindowEvidence,
    /// The descriptor with metric ranges, and the evidence of the boundaries of floor and ceiling ([`CELLS`] values), if
    /// they were computed.
    pub(super) ranges: Option<(&'a VisualDescriptor, &'a [CellNats])>,
    /// The scan of the plan, if there is one.
    pub(super) plan: Option<&'a Scan>,
}

/// The evidence of the boundaries of floor and ceiling.
pub(super) fn boundaries(seen: &mut Seen<'_, '_>) -> Vec<CellNats> {
    seen.boundaries().map_or_else(Vec::new, |evidence| evidence.cells().to_vec())
}

/// The probability of each rung of a surface and bin, from log-likelihood ratios.
fn probability(boundaries: &[CellNats]) -> Vec<f32> {
    let mut cells: Vec<f32> = boundaries.iter().map(|cell| cell.to_num::<f32>().exp()).collect();
    for surface in cells.chunks_mut(CELLS / 2) {
        for bin in 0..BINS {
            let whole: f32 = surface.iter().skip(bin).step_by(BINS).sum();
            surface.iter_mut().skip(bin).step_by(BINS).for_each(|cell| *cell /= whole);
        }
    }
    cells
}

impl Found<'_> {
    /// Writes `ring.png`, `polar.png`, for each camera `camN_segments.png` and `camN_windows.png`, and with ranges
    /// `panorama.png`, `boundaries.png` and `descriptor.png`.
    pub(super) fn draw(&self, dir: &Path) -> Result<()> {
        create_dir(dir)?;
        for (camera, frame) in self.frames.iter().enumerate() {
            let Some((frame, view)) = frame.zip(self.rig.view(camera)) else { continue };
            self.draw_segments(&dir.join(format!("cam{camera}_segments.png")), camera, frame, view)?;
            self.draw_windows(&dir.join(format!("cam{camera}_windows.png")), camera, frame, view)?;
        }
        let (hit, known) =
            (&self.window_evidence.hit, self.window_evidence.confidence.sixteenths().map(|c| c > 0));
        let Considered { panorama, resolution, boxes, edges } = &self.considered;
        let picture = RingPicture {
            ring: GrayImage::new(panorama, resolution.columns() as u32, resolution.rows() as u32)?,
            resolution: *resolution,
            windows: self.windows,
            boxes,
            edges,
            hit,
            known: &known,
        };
        figures::draw_ring(&dir.join("ring.png"), &picture)?;
        figures::draw_seen(&dir.join("polar.png"), hit, &known, self.plan.map(|plan| &plan.hit))?;
        if let Some((surroundings, boundaries)) = self.ranges {
            self.draw_panorama(&dir.join("panorama.png"), surroundings, None)?;
            let probability = probability(boundaries);
            self.draw_panorama(&dir.join("boundaries.png"), surroundings, Some(&probability))?;
            self.draw_descriptors(&dir.join("descriptor.png"), surroundings)?;
        }
        Ok(())
    }

    fn draw_panorama(
        &self,
        path: &Path,
        VisualDescriptor { height, ranges, .. }: &VisualDescriptor,
        probability: Option<&[f32]>,
    ) -> Result<()> {
        let resolution = self.considered.resolution;
        let corners = |w: &Window| {
            [w.azimuth_deg(resolution), w.elevation_deg(resolution)].map(|pair| pair.map(f64::from))
        };
        let windows: Vec<_> = self.windows.iter().map(corners).collect();
        let metres = self.plan.map(|plan| plan.steps.map(|s| f64::from(s) / f64::from(STEPS_PER_METRE)));
        let picture = PanoramaPicture {
            // The probability says more than the likeliest range.
            ranges: &ranges.map(|range| {
                range.filter(|_| probability.is_none()).map(|r| [r.metres, r.confidence].map(f64::from))
            }),
            plan: metres.as_ref(),
            heights_m: [height.camera_m, height.ceiling_m - height.camera_m].map(f64::from),
            windows: &windows,
            probability,
        };
        figures::draw_panorama(path, &picture, |azimuth, elevation| self.colour(azimuth, elevation))?;
        Ok(())
    }

    /// The colour in a direction of the level frame, from the camera whose axis is nearest.
    fn colour(&self, azimuth: f32, elevation: f32) -> Option<[u8; 3]> {
        let point = self.level.bearing(azimuth, elevation) * NOMINAL_RANGE_M;
        let seen_by = |(camera, view): (usize, &View)| {
            let bearing = view.rotation.tr_mul(&(point - view.position)).normalize();
            let pixel = view.camera.project(&bearing)?;
            Some((bearing.z, self.frames[camera]?.colour(pixel)?))
        };
        let nearest = self.rig.views().filter_map(seen_by).max_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, colour)| colour)
    }

    /// The observed descriptor without unknown bins, and the plan's below it.
    fn draw_descriptors(&self, path: &Path, descriptor: &VisualDescriptor) -> Result<()> {
        let mut seen = float_levels(&Descriptor::from(&descriptor.scan));
        for channel in &mut seen {
            let known = descriptor.confidence.sixteenths().iter().map(|c| *c > 0);
            channel.iter_mut().zip(known).filter(|(_, known)| !known).for_each(|(v, _)| *v = f64::NAN);
        }
        let plan = self.plan.map(|plan| float_levels(&Descriptor::from(plan)));
        let mut named = vec![("seen", &seen)];
        named.extend(plan.as_ref().map(|plan| ("plan", plan)));
        figures::draw_descriptors(path, &named)?;
        Ok(())
    }

    fn draw_segments(&self, path: &Path, camera: usize, frame: &Frame, view: &View) -> Result<()> {
        let mut all = Layer::new("segments", GREEN, 2.0);
        let mut edges = Layer::new("of these at the sides of windows", RED, 4.0);
        for segment in &self.segments[camera] {
            all.lines.push(line(segment));
            if self.windows.iter().any(|w| self.borders(segment, view, w)) {
                edges.lines.push(line(segment));
            }
        }
        let caption = format!("Line segments in the frame of cam{camera}");
        figures::draw_overlay(path, &caption, frame, &[all, edges])?;
        Ok(())
    }

    /// Whether a segment runs along the left or right side of a window.
    fn borders(&self, segment: &Segment, view: &View, window: &Window) -> bool {
        let end = |x, y| {
            let bearing = view.camera.unproject(Pixel { x, y })?;
            let point = view.rotation * bearing * NOMINAL_RANGE_M + view.position;
            let (azimuth, elevation) = self.level.direction(&point.normalize());
            Some((azimuth.to_degrees(), elevation.to_degrees()))
        };
        let (Some(a), Some(b)) = (end(segment.x1, segment.y1), end(segment.x2, segment.y2)) else {
            return false;
        };
        let resolution = self.considered.resolution;
        let (sides, [sill, lintel]) = (window.azimuth_deg(resolution), window.elevation_deg(resolution));
        let lean = turned(b.0 - a.0);
        let middle = a.0 + lean / 2.0;
        lean.abs() <= LEAN_DEG
            && a.1.max(b.1) > sill
            && a.1.min(b.1) < lintel
            && sides.iter().any(|side| turned(side - middle).abs() <= BESIDE_DEG)
    }

    fn draw_windows(&self, path: &Path, camera: usize, frame: &Frame, view: &View) -> Result<()> {
        let mut here = Layer::new("windows that this camera sees", RED, 4.0);
        let mut there = Layer::new("the other camera's", YELLOW, 2.0);
        for window in self.windows {
            let outline = outline::window(window, view, &self.level, self.considered.resolution);
            if outline.len() < 2 {
                continue;
            }
            if usize::from(window.camera) == camera {
                let highest = outline.iter().copied().reduce(|a, b| if b[1] < a[1] { b } else { a });
                let note = format!("{:.1}", f64::from(window.score)).replace('-', "\u{2212}");
                here.notes.extend(highest.map(|at| (at, note)));
                here.lines.push(outline);
            } else {
                there.lines.push(outline);
            }
        }
        let caption = format!("Windows in the frame of cam{camera}, with their log odds");
        figures::draw_overlay(path, &caption, frame, &[there, here])?;
        Ok(())
    }
}

/// An angle in degrees, wrapped to [-180, 180).
fn turned(angle: f32) -> f32 {
    (angle + 180.0).rem_euclid(360.0) - 180.0
}

fn line(segment: &Segment) -> Vec<[f64; 2]> {
    let Segment { x1, y1, x2, y2, .. } = *segment;
    vec![[f64::from(x1), f64::from(y1)], [f64::from(x2), f64::from(y2)]]
}

/// Writes `segments.png`: a frame with its segments in green.
pub(super) fn segments(dir: &Path, frame: &Frame, segments: &[Segment]) -> Result<()> {
    create_dir(dir)?;
    let mut all = Layer::new("segments", GREEN, 2.0);
    all.lines.extend(segments.iter().map(line));
    figures::draw_overlay(&dir.join("segments.png"), "Line segments", frame, &[all])?;
    Ok(())
}

/// Rejection reasons of the paper's finder, in the order of its checks: name and colour.
const REJECTIONS: [(Rejection, &str, RGBColor); 6] = [
    (Rejection::Dark, "too dark", RGBColor(0x50, 0x50, 0xff)),
    (Rejection::LowContrast, "no brighter than beside", RGBColor(0x00, 0xc0, 0xd0)),
    (Rejection::Texture, "as even as a wall", RGBColor(0xc0, 0x60, 0xff)),
    (Rejection::Periphery, "at the rim", RGBColor(0xff, 0x90, 0x00)),
    (Rejection::Red, "red", RGBColor(0xff, 0x60, 0xa0)),
    (Rejection::Suppressed, "overlaps a better one", YELLOW),
];

/// Writes `camN_paper.png`: the proposals of the paper's finder in a frame, and the accepted ones.
pub(super) fn paper(dir: &Path, camera: usize, frame: &Frame, finder: &PaperFinder) -> Result<()> {
    create_dir(dir)?;
    let width = f64::from(frame.width());
    let mut layers: Vec<_> =
        REJECTIONS.iter().map(|(_, name, colour)| Layer::new(*name, *colour, 1.5)).collect();
    for proposal in finder.proposals() {
        let reason = REJECTIONS.iter().position(|(reason, ..)| proposal.rejection == Some(*reason));
        if let Some(layer) = reason.and_then(|reason| layers.get_mut(reason)) {
            layer.lines.push(rectangle(&proposal.window));
        }
    }
    let mut edges = Layer::new("edges", GREEN, 3.0);
    edges.lines.extend(finder.edges().iter().map(|edge| {
        let x = f64::from(edge.x) / 16.0;
        vec![[x, f64::from(edge.y0) - 0.5], [x, f64::from(edge.y1) - 0.5]]
    }));
    let mut band = Layer::new("borders of the band", BLUE, 3.0);
    let (first, last) = finder.band();
    let rows = [first, last].map(|row| f64::from(row) - 0.5);
    band.lines.extend(rows.map(|y| vec![[-0.5, y], [width - 0.5, y]]));
    let mut windows = Layer::new("windows, with their scores", RED, 5.0);
    for window in finder.windows() {
        windows.lines.push(rectangle(window));
        let top = [f64::from(window.x0.midpoint(window.x1)), f64::from(window.y0)];
        windows.notes.push((top, window.score.to_string()));
    }
    layers.extend([band, edges, windows]);
    let caption = format!("The paper's finder on the frame of cam{camera}: proposals by why they go");
    figures::draw_overlay(&dir.join(format!("cam{camera}_paper.png")), &caption, frame, &layers)?;
    Ok(())
}

fn rectangle(window: &ImageWindow) -> Vec<[f64; 2]> {
    let [x0, y0, x1, y1] = [window.x0, window.y0, window.x1, window.y1].map(|v| f64::from(v) - 0.5);
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]
}
