//! The surfaces around a place by column: one ray is marched through the plan per azimuth, and pixels look up their
//! column.

use super::grid::{Layer, Surface};
use super::panes::spread;
use super::scene::Scene;
use std::f64::consts::TAU;

/// Columns of a full turn: 0.05 degrees each, less than half a pixel at 465 pixels a radian.
const COLUMNS: usize = 7200;

/// Columns to either side whose hits are fitted for a wall's direction.
const SAMPLES: usize = 8;

/// Wall directions are quantized to this: textures need a direction that does not flicker.
const NORMAL_STEPS: f64 = 24.0;

/// A surface of a column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// Metres on the floor.
    pub(super) range: f32,
    pub(super) surface: Surface,
    /// Horizontal, towards the camera.
    pub(super) normal: [f32; 2],
}

/// All columns around a place.
#[derive(Debug)]
pub(super) struct Fan {
    /// First face of each column, and the end.
    starts: Vec<u32>,
    faces: Vec<Face>,
}

impl Fan {
    pub(super) fn new(scene: &Scene, from: [f64; 2]) -> Self {
        let direction = |column: usize| {
            let angle = TAU * column as f64 / COLUMNS as f64;
            [libm::cos(angle), libm::sin(angle)]
        };
        let (mut starts, mut layers) = (vec![0], Vec::new());
        for column in 0..COLUMNS {
            scene.grid.cast(from, direction(column), &scene.panes, &mut layers);
            starts.push(layers.len() as u32);
        }
        let cast = Cast { scene, starts: &starts, layers: &layers };
        let mut faces = Vec::with_capacity(layers.len());
        for column in 0..COLUMNS {
            for number in 0..cast.column(column).len() {
                faces.push(cast.face(column, number, direction(column)));
            }
        }
        Self { starts, faces }
    }

    /// The faces in the direction of an azimuth in degrees, 0 to 360, nearest first.
    pub(super) fn towards(&self, azimuth_deg: f32) -> View<'_> {
        let at = azimuth_deg * (COLUMNS as f32 / 360.0);
        let low = at as usize;
        let share = at - low as f32;
        let (low, high) = (low % COLUMNS, (low + 1) % COLUMNS);
        if share < 0.5 {
            View { faces: self.column(low), other: self.column(high), share }
        } else {
            View { faces: self.column(high), other: self.column(low), share: 1.0 - share }
        }
    }

    fn column(&self, column: usize) -> &[Face] {
        &self.faces[self.starts[column] as usize..self.starts[column + 1] as usize]
    }
}

/// The nearest column and its neighbour on the other side, with the interpolation weight `share` of the latter.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    faces: &'a [Face],
    other: &'a [Face],
    share: f32,
}

impl<'a> View<'a> {
    /// The faces with ranges interpolated between the two columns, where both hit the same surface: 1 / range is
    /// linear over a plane.
    pub(super) fn faces(self) -> impl Iterator<Item = Face> + use<'a> {
        self.faces.iter().enumerate().map(move |(number, face)| {
            let (r, mut face) = (face.range, *face);
            if let Some(other) = self.other.get(number)
                && std::mem::discriminant(&other.surface) == std::mem::discriminant(&face.surface)
                && (other.range - r).abs() < 0.02 + 0.02 * r
                && r > 0.0
                && other.range > 0.0
            {
                face.range = 1.0 / ((1.0 - self.share) / r + self.share / other.range);
            }
            face
        })
    }
}

/// The hits from which faces are made.
struct Cast<'a> {
    scene: &'a Scene,
    starts: &'a [u32],
    layers: &'a [Layer],
}

impl Cast<'_> {
    fn column(&self, column: usize) -> &[Layer] {
        &self.layers[self.starts[column] as usize..self.starts[column + 1] as usize]
    }

    fn face(&self, column: usize, number: usize, direction: [f64; 2]) -> Face {
        let Layer { range, surface } = self.column(column)[number];
        let (normal, range) = match surface {
            Surface::Outdoors => ([-direction[0], -direction[1]], range),
            Surface::Glass(pane, _) => {
                let [x, y] = self.scene.panes.list[pane as usize].along.map(f64::from);
                ([-y, x], range)
            }
            Surface::Wall => self.wall(column, number, direction),
        };
        let towards = normal[0] * direction[0] + normal[1] * direction[1];
        let sign = if towards > 0.0 { -1.0 } else { 1.0 };
        Face { range, surface, normal: normal.map(|v| (v * sign) as f32) }
    }

    /// Normal of the wall, and the range without the quantization of the raster.
    fn wall(&self, column: usize, number: usize, direction: [f64; 2]) -> ([f64; 2], f32) {
        let range = self.column(column)[number].range;
        let (before, after) = (self.run(column, number, -1), self.run(column, number, 1));
        let here = [place(column, range)];
        let fits = [
            Fit::new(before.iter().chain(&here).chain(&after).copied()),
            Fit::new(here.iter().chain(&after).copied()),
            Fit::new(before.iter().chain(&here).copied()),
        ];
        let cell = self.scene.grid.resolution;
        let good = |fit: &&Fit| fit.residual < 0.6 * cell;
        let best = fits
            .iter()
            .find(good)
            .unwrap_or_else(|| if fits[1].residual < fits[2].residual { &fits[1] } else { &fits[2] });
        let normal = [-best.along[1], best.along[0]];
        // The fitted line may move the hit by at most the raster's quantization error.
        let across = direction[0] * normal[0] + direction[1] * normal[1];
        let offset = (best.mean[0] * normal[0] + best.mean[1] * normal[1]) / across;
        let smooth = offset.clamp(f64::from(range) - cell, f64::from(range) + cell);
        let range = if across.abs() > 0.05 && best.residual < cell { smooth as f32 } else { range };
        let angle = libm::atan2(normal[1], normal[0]);
        let angle = (angle / TAU * NORMAL_STEPS).round() * TAU / NORMAL_STEPS;
        ([libm::cos(angle), libm::sin(angle)], range)
    }

    /// Hits of the columns to one side, about a centimetre apart, as long as they are contiguous.
    fn run(&self, column: usize, number: usize, side: isize) -> Vec<[f64; 2]> {
        let range = self.column(column)[number].range;
        let spacing = f64::from(range) * TAU / COLUMNS as f64;
        let stride = (self.scene.grid.resolution.max(0.01) / spacing.max(1e-6)).clamp(1.0, 300.0) as isize;
        let mut run = Vec::with_capacity(SAMPLES);
        let mut last = place(column, range);
        for k in 1..=SAMPLES as isize {
            let column = (column as isize + side * k * stride).rem_euclid(COLUMNS as isize) as usize;
            let Some(layer) = self.column(column).get(number) else { break };
            let at = place(column, layer.range);
            let gap = [at[0] - last[0], at[1] - last[1]];
            let gap2 = gap[0] * gap[0] + gap[1] * gap[1];
            let most = 6.0 * self.scene.grid.resolution.max(spacing);
            if layer.surface != Surface::Wall || gap2 > most * most {
                break;
            }
            run.push(at);
            last = at;
        }
        run
    }
}

/// A hit, relative to the camera.
fn place(column: usize, range: f32) -> [f64; 2] {
    let angle = TAU * column as f64 / COLUMNS as f64;
    [f64::from(range) * libm::cos(angle), f64::from(range) * libm::sin(angle)]
}

/// A line through hits.
struct Fit {
    mean: [f64; 2],
    along: [f64; 2],
    /// Largest distance of a hit from it; infinite for fewer than three.
    residual: f64,
}

impl Fit {
    fn new(hits: impl Iterator<Item = [f64; 2]> + Clone) -> Self {
        let count = hits.clone().count();
        let sum = hits.clone().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        let mean = sum.map(|v| v / count as f64);
        let along = spread(hits.clone());
        let off = |p: [f64; 2]| ((p[1] - mean[1]) * along[0] - (p[0] - mean[0]) * along[1]).abs();
        let residual = hits.map(off).fold(0.0, f64::max);
        Self { mean, along, residual: if count < 3 { f64::INFINITY } else { residual } }
    }
}
