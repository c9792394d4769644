//! Dual-fisheye frames rendered from a floor plan: the plan's walls and glazing as a floor of concrete with
//! windows, through the lenses of a calibration.
//!
//! Everything is drawn procedurally from seeds: the same options give the same bytes on every machine, for any number
//! of threads.
//!
//! # Axes
//! Map: x right, y up, z up from the floor. Poses are those of camera 0 (x right, y down, z forward).

pub mod dataset;
mod fan;
mod grid;
mod light;
mod panes;
mod scene;
mod sensor;
mod shade;
mod solids;
mod style;
mod texture;

pub use scene::{Scene, SceneOptions};

use crate::dataset::tum::Pose;
use compass_core::vision::camera::{Camera, Pixel, Rig, View};
use fan::Fan;
use image::RgbImage;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use sensor::Exposure;
use shade::Shader;
use solids::{Sight, Solid};

/// Half the field of view of the lenses, radians: 95.5 degrees.
const FIELD: f32 = 1.667;

/// Angle over which the image fades out towards its rim, radians.
const RIM: f32 = 0.03;

/// With one sample per pixel, pixels that differ from a neighbour by this share of their sum take four.
const EDGE: f32 = 0.12;

/// Upper limit of a sample's light: the glare of a window would otherwise dominate the pixel.
const GLARE: f32 = 4.0;

/// Widest image that is supersampled by default.
const SUPERSAMPLED: u16 = 800;

/// Renders a pair of frames with the default sampling: see [`Renderer`] to render many.
///
/// A camera that the rig lacks has no frame.
#[must_use]
pub fn render(scene: &Scene, rig: &Rig, pose: &Pose) -> [Option<RgbImage>; 2] {
    Renderer::new(scene, rig, None).render(pose)
}

/// A scene with a rig to render it through; the bearings of all pixels are precomputed.
#[derive(Debug)]
pub struct Renderer<'a> {
    scene: &'a Scene,
    lenses: [Option<Lens>; 2],
}

impl<'a> Renderer<'a> {
    /// Prepares the lenses. Each pixel takes the mean of `samples` x `samples` rays; when absent, 2 x 2 for
    /// images up to 800 pixels wide, 1 above.
    #[must_use]
    pub fn new(scene: &'a Scene, rig: &Rig, samples: Option<u16>) -> Self {
        let lens = |number: usize| {
            rig.view(number).map(|view| {
                let small = if view.width <= SUPERSAMPLED { 2 } else { 1 };
                Lens::new(view, samples.unwrap_or(small).max(1))
            })
        };
        Self { scene, lenses: [lens(0), lens(1)] }
    }

    /// The numbers of the cameras that the rig has.
    pub fn cameras(&self) -> impl Iterator<Item = usize> {
        (0..2).filter(|&number| self.lenses[number].is_some())
    }

    /// The frames at a pose; `None` for a camera that the rig lacks.
    #[must_use]
    pub fn render(&self, pose: &Pose) -> [Option<RgbImage>; 2] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.scene.options.seed ^ pose.timestamp_ns);
        let company = self.company(pose, &mut rng);
        self.lenses.each_ref().map(|lens| {
            let exposure = lens.as_ref()?.expose(self.scene, pose, &company);
            Some(exposure.develop(&self.scene.look, &mut rng))
        })
    }

    /// Position of camera 0 above the floor.
    fn camera(&self, pose: &Pose) -> Vector3<f64> {
        pose.position - Vector3::z() * self.scene.options.floor_m
    }

    /// The people around a pose, and the carrier of the rig.
    fn company(&self, pose: &Pose, rng: &mut Xoshiro256PlusPlus) -> Vec<Solid> {
        let (scene, camera) = (self.scene, self.camera(pose));
        let mut solids = Vec::new();
        if scene.options.operator {
            let forward = pose.rotation * Vector3::z();
            let flat = (forward.x * forward.x + forward.y * forward.y).sqrt();
            let forward = if flat > 1e-6 { [forward.x / flat, forward.y / flat] } else { [1.0, 0.0] };
            let side = if scene.options.style % 2 == 0 { -1.0 } else { 1.0 };
            solids.extend(solids::operator(camera.cast(), forward.map(|v| v as f32), side));
        }
        for number in 0..scene.options.people {
            // A visible place, if random draws find one soon.
            for _ in 0..40 {
                let angle = rng.random::<f64>() * std::f64::consts::TAU;
                let distance = 1.4 + 5.6 * rng.random::<f64>();
                let direction = [libm::cos(angle), libm::sin(angle)];
                let at = [camera.x + distance * direction[0], camera.y + distance * direction[1]];
                let seen = scene.grid.range([camera.x, camera.y], direction, &scene.panes) > distance + 0.3;
                if seen && scene.grid.room(at[0], at[1]) > 0.3 {
                    let red = number == 0 || rng.random::<f64>() < 0.5;
                    solids.extend(solids::person(at.map(|v| v as f32), red, rng));
                    break;
                }
            }
        }
        solids
    }
}

/// A camera with the bearings of its samples.
#[derive(Debug)]
struct Lens {
    width: usize,
    height: usize,
    /// Samples along a side of a pixel.
    samples: usize,
    /// In the camera, row by row of samples; beyond the field zero.
    bearings: Vec<[f32; 3]>,
    camera: Camera,
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    /// Radians that a sample covers.
    sample: f32,
}

impl Lens {
    fn new(view: &View, samples: u16) -> Self {
        let (width, height) = (usize::from(view.width), usize::from(view.height));
        let samples = usize::from(samples);
        let side = width * samples;
        let place = |k: usize| (k as f32 + 0.5) / samples as f32 - 0.5;
        let bearing = |at: usize| {
            let bearing = view.camera.unproject(Pixel { x: place(at % side), y: place(at / side) });
            bearing.map_or([0.0; 3], Into::into)
        };
        let bearings = (0..side * height * samples).into_par_iter().map(bearing).collect();
        let focal = view.camera.intrinsics().fx * samples as f32;
        Self {
            width,
            height,
            samples,
            bearings,
            camera: view.camera,
            rotation: view.rotation.cast(),
            position: view.position.cast(),
            sample: 1.0 / focal,
        }
    }

    /// The light on the sensor.
    fn expose(&self, scene: &Scene, pose: &Pose, company: &[Solid]) -> Exposure {
        let turn = pose.rotation.to_rotation_matrix().into_inner();
        let rotation: Matrix3<f32> = (turn * self.rotation).cast();
        let place = pose.position + turn * self.position - Vector3::z() * scene.options.floor_m;
        let from: Vector3<f32> = place.cast();
        let fan = Fan::new(scene, [place.x, place.y]);
        // The carrier does not walk through a box.
        let boxes = scene.boxes.iter().filter(|solid| solid.gap(from.x, from.y) > 0.5);
        let sight = Sight::new(boxes.chain(company), from);
        let shader = Shader { scene, fan: &fan, sight: &sight, from, sample: self.sample };
        let pixel = |at: usize| self.pixel(&shader, &rotation, at % self.width, at / self.width);
        let (mut light, vignette): (Vec<_>, _) =
            (0..self.width * self.height).into_par_iter().map(pixel).unzip();
        if self.samples == 1 {
            self.refine(&shader, &rotation, &mut light);
        }
        Exposure { width: self.width, height: self.height, light, vignette }
    }

    /// Light and vignetting of a pixel.
    fn pixel(&self, shader: &Shader<'_>, rotation: &Matrix3<f32>, x: usize, y: usize) -> ([f32; 3], f32) {
        let (mut light, mut vignette) = ([0.0; 3], 0.0);
        let mut seen = 0.0;
        for row in y * self.samples..(y + 1) * self.samples {
            let first = (row * self.width + x) * self.samples;
            for bearing in &self.bearings[first..first + self.samples] {
                let passed = transmission(*bearing);
                if passed > 0.0 {
                    let radiance = shader.radiance(rotation * Vector3::from(*bearing));
                    light = std::array::from_fn(|i| light[i] + radiance[i].min(GLARE));
                    vignette += passed;
                    seen += 1.0;
                }
            }
        }
        let count = (self.samples * self.samples) as f32;
        (light.map(|v: f32| v / f32::max(seen, 1.0)), vignette / count)
    }
}

impl Lens {
    /// Takes four samples of the pixels along edges.
    fn refine(&self, shader: &Shader<'_>, rotation: &Matrix3<f32>, light: &mut [[f32; 3]]) {
        let differs = |at: usize, there: usize| {
            let (a, b) = (light[at][1], light.get(there).map_or(light[at][1], |v| v[1]));
            (a - b).abs() > EDGE * (a + b)
        };
        let around = |at: usize| [at + 1, at + self.width, at.wrapping_sub(1), at.wrapping_sub(self.width)];
        let edges: Vec<usize> = (0..light.len())
            .into_par_iter()
            .filter(|&at| around(at).into_iter().any(|there| differs(at, there)))
            .collect();
        let finer: Vec<_> = edges.par_iter().map(|&at| self.four(shader, rotation, at)).collect();
        for (at, finer) in edges.into_iter().zip(finer) {
            light[at] = finer.unwrap_or(light[at]);
        }
    }

    /// The mean of four samples of a pixel; `None` when not all of them are in the field.
    fn four(&self, shader: &Shader<'_>, rotation: &Matrix3<f32>, at: usize) -> Option<[f32; 3]> {
        let (x, y) = ((at % self.width) as f32, (at / self.width) as f32);
        let mut sum = [0.0; 3];
        for (dx, dy) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
            let bearing = self.camera.unproject(Pixel { x: x + dx, y: y + dy })?;
            let radiance = shader.radiance(rotation * bearing);
            sum = std::array::from_fn(|i| sum[i] + radiance[i].min(GLARE) / 4.0);
        }
        Some(sum)
    }
}

/// Transmission of the lens at a bearing: decreasing towards the rim, 0 beyond.
fn transmission(bearing: [f32; 3]) -> f32 {
    if bearing == [0.0; 3] {
        return 0.0;
    }
    let angle = libm::acosf(bearing[2].clamp(-1.0, 1.0));
    let rim = ((FIELD - angle) / RIM).clamp(0.0, 1.0);
    let share = angle / FIELD;
    rim * (1.0 - 0.45 * share * share * share * share)
}

#[cfg(test)]
mod tests;
