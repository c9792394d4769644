//! The segments by vanishing point (paper: roll and pitch).

use anyhow::Result;
use compass_core::vision::attitude::{Arc, Axes};
use compass_core::vision::camera::{Bearing, Rig, View};
use compass_core::vision::level_frame::LevelFrame;
use compass_core::vision::segments::Segment;
use compass_host::figures::{self, Layer};
use compass_host::frame::Frame;
use compass_host::output::create_dir;
use plotters::style::RGBColor;
use std::path::Path;

const GRAY: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);
/// The vertical and the two axes.
const COLOURS: [RGBColor; 3] =
    [RGBColor(0x20, 0x90, 0xff), RGBColor(0x20, 0xe0, 0x40), RGBColor(0xff, 0x90, 0x00)];
/// Points per great circle.
const STEPS: u16 = 720;
/// Radius of the ring around a vanishing point, as a share of the image's width.
const RING: f64 = 0.012;

/// The contents of the pictures.
pub(super) struct Lines<'a> {
    pub(super) frames: [Option<&'a Frame>; 2],
    pub(super) rig: &'a Rig,
    /// Line segments of each frame.
    pub(super) segments: [Vec<Segment>; 2],
    /// Largest angle between a segment and its vanishing point, degrees.
    pub(super) tolerance_deg: f32,
    pub(super) level: &'a LevelFrame,
    pub(super) axes: Option<Axes>,
}

impl Lines<'_> {
    /// Writes `camN_gravity.png` for each camera.
    pub(super) fn draw(&self, dir: &Path) -> Result<()> {
        create_dir(dir)?;
        for (camera, frame) in self.frames.iter().enumerate() {
            let Some((frame, view)) = frame.zip(self.rig.view(camera)) else { continue };
            let mut layers = self.segments(camera, view);
            layers.extend(self.circles(view, f64::from(frame.width())));
            let caption = format!(
                "Segments of cam{camera} by vanishing point, with the great circles that join the three points"
            );
            figures::draw_overlay(&dir.join(format!("cam{camera}_gravity.png")), &caption, frame, &layers)?;
        }
        Ok(())
    }

    /// The three directions that are known.
    fn directions(&self) -> Vec<(String, Bearing)> {
        let mut all = vec![("vertical".to_owned(), self.level.up())];
        if let Some(axes) = self.axes {
            let directions = axes.directions(self.level).into_iter().enumerate();
            all.extend(directions.map(|(n, direction)| {
                (format!("horizontal at {:.0}°", axes.azimuth_deg + 90.0 * n as f32), direction)
            }));
        }
        all
    }

    fn segments(&self, camera: usize, view: &View) -> Vec<Layer> {
        let layer =
            |((name, _), colour): (&(String, Bearing), RGBColor)| Layer::new(name.as_str(), colour, 3.5);
        let directions = self.directions();
        let mut layers = vec![Layer::new("no one's", GRAY, 1.5)];
        layers.extend(directions.iter().zip(COLOURS).map(layer));
        for segment in &self.segments[camera] {
            let Some(arc) = Arc::new(segment, view, camera as u32) else { continue };
            let Segment { x1, y1, x2, y2, .. } = *segment;
            let ends = [[x1, y1], [x2, y2]].map(|end| end.map(f64::from)).to_vec();
            let upright = arc.agreement(&self.level.up(), self.tolerance_deg) > 0.0;
            let along = || self.axes.and_then(|axes| axes.axis_of(&arc, self.level));
            let class = if upright { 1 } else { along().map_or(0, |axis| 2 + axis) };
            layers[class].lines.push(ends);
        }
        layers
    }

    /// The great circles perpendicular to the three directions, and small circles around their ends.
    fn circles(&self, view: &View, width: f64) -> Vec<Layer> {
        let mut layers = Vec::new();
        for ((name, direction), colour) in self.directions().into_iter().zip(COLOURS) {
            let mut layer = Layer::unnamed(colour, 1.5);
            layer.lines = circle(view, &direction);
            for (sign, end) in [(1.0, '+'), (-1.0, '\u{2212}')] {
                if let Some(at) = seen(view, &(direction * sign)) {
                    layer.lines.push(ring(at, RING * width));
                    let note = match (name.as_str(), end) {
                        ("vertical", '+') => "up".to_owned(),
                        ("vertical", _) => "down".to_owned(),
                        _ => format!("{end}{}", name.trim_start_matches("horizontal at ")),
                    };
                    layer.notes.push(([at[0], at[1] - RING * width], note));
                }
            }
            layers.push(layer);
        }
        layers
    }
}

/// The pixel of a direction in camera 0's axes, if it is in the image.
fn seen(view: &View, direction: &Bearing) -> Option<[f64; 2]> {
    let pixel = view.camera.project(&view.rotation.tr_mul(direction))?;
    let inside =
        (0.0..f32::from(view.width)).contains(&pixel.x) && (0.0..f32::from(view.height)).contains(&pixel.y);
    inside.then(|| [pixel.x, pixel.y].map(f64::from))
}

/// The visible pieces of the great circle perpendicular to a direction.
fn circle(view: &View, pole: &Bearing) -> Vec<Vec<[f64; 2]>> {
    let smallest = pole.iamin();
    let side = pole.cross(&Bearing::ith(smallest, 1.0)).normalize();
    let other = pole.cross(&side);
    let mut pieces = vec![Vec::new()];
    for step in 0..=STEPS {
        let (sin, cos) = (std::f32::consts::TAU * f32::from(step) / f32::from(STEPS)).sin_cos();
        match (seen(view, &(side * cos + other * sin)), pieces.last_mut()) {
            (Some(at), Some(piece)) => piece.push(at),
            (None, Some(piece)) if !piece.is_empty() => pieces.push(Vec::new()),
            _ => {}
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

fn ring([x, y]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let point = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
        [x + radius * cos, y + radius * sin]
    };
    (0..=24).map(point).collect()
}
