//! The radiance along a ray: walls, floor, ceiling, glazing with what is behind it, and solids.

use super::fan::Fan;
use super::grid::Surface;
use super::panes::Pane;
use super::scene::Scene;
use super::solids::{Met, SHADOW_M, Shape, Sight, Solid};
use super::style::Colour;
use super::texture::{grain, hash, line, noise, unit};
use nalgebra::Vector3;

/// Transmission of a pane.
const GLASS: f32 = 0.88;

/// The renderer of one camera's rays.
pub(super) struct Shader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) fan: &'a Fan,
    pub(super) sight: &'a Sight<'a>,
    /// In the map, z above the floor.
    pub(super) from: Vector3<f32>,
    /// Radians that a sample covers.
    pub(super) sample: f32,
}

/// A ray of length 1 with its parts on the floor.
struct Ray {
    direction: Vector3<f32>,
    /// The horizontal direction, of length 1.
    flat: [f32; 2],
    /// Metres up per metre on the floor.
    slope: f32,
    /// Metres along the ray per metre on the floor.
    stretch: f32,
    azimuth_deg: f32,
}

impl Ray {
    fn new(direction: Vector3<f32>) -> Self {
        let flat = (direction.x * direction.x + direction.y * direction.y).sqrt().max(1e-6);
        let degrees = libm::atan2f(direction.y, direction.x).to_degrees();
        let azimuth_deg = if degrees < 0.0 { degrees + 360.0 } else { degrees };
        Self {
            direction,
            flat: [direction.x / flat, direction.y / flat],
            slope: direction.z / flat,
            stretch: 1.0 / flat,
            azimuth_deg: azimuth_deg.min(359.999),
        }
    }
}

impl Shader<'_> {
    /// The radiance from a direction of the map, of length 1.
    pub(super) fn radiance(&self, direction: Vector3<f32>) -> Colour {
        let ray = Ray::new(direction);
        let solids = self.sight.towards(ray.azimuth_deg);
        let met = solids
            .iter()
            .filter_map(|solid| solid.meet(self.from, direction))
            .min_by(|a, b| a.distance.total_cmp(&b.distance));
        let reach = met.map_or(f32::MAX, |met| met.distance / ray.stretch);
        let level = self.level_range(&ray);
        let mut through = 1.0;
        let seen = |through: f32, colour: Colour| colour.map(|v| v * through);
        for face in self.fan.towards(ray.azimuth_deg).faces() {
            let stop = face.range.min(level);
            if let Some(met) = met
                && reach < stop
            {
                return seen(through, self.solid(&met));
            }
            if level < face.range {
                return seen(through, self.level(&ray, level, solids));
            }
            match face.surface {
                Surface::Wall => return seen(through, self.wall(&ray, face.range, face.normal, None)),
                Surface::Outdoors => return seen(through, self.outdoors(&ray)),
                Surface::Glass(pane, far) => {
                    let pane = &self.scene.panes.list[pane as usize];
                    if let Some(colour) = self.opening(&ray, pane, [face.range, far], face.normal) {
                        return seen(through, colour);
                    }
                    through *= GLASS;
                }
            }
        }
        seen(through, self.outdoors(&ray))
    }

    /// Range of the intersection with floor or ceiling.
    fn level_range(&self, ray: &Ray) -> f32 {
        let height = if ray.slope > 0.0 { self.scene.look.ceiling - self.from.z } else { -self.from.z };
        if ray.slope == 0.0 { f32::MAX } else { (height / ray.slope).max(0.0) }
    }

    fn point(&self, ray: &Ray, range: f32) -> [f32; 3] {
        [
            self.from.x + ray.flat[0] * range,
            self.from.y + ray.flat[1] * range,
            self.from.z + ray.slope * range,
        ]
    }

    /// Metres that a sample covers at a range, across the ray.
    fn footprint(&self, ray: &Ray, range: f32) -> f32 {
        self.sample * range * ray.stretch
    }

    /// A wall; `concrete` is a number for faces that are never plastered.
    fn wall(&self, ray: &Ray, range: f32, normal: [f32; 2], concrete: Option<u32>) -> Colour {
        let (look, at) = (&self.scene.look, self.point(ray, range));
        let [x, y, z] = at;
        let across = -(ray.flat[0] * normal[0] + ray.flat[1] * normal[1]);
        let footprint = self.footprint(ray, range);
        let slanted = footprint / across.clamp(0.1, 1.0);
        let u = x * normal[1] - y * normal[0];
        // Faces in one plane are of one kind. The offset avoids planes of whole centimetres on a quantization border.
        let plane = ((x * normal[0] + y * normal[1] + 0.0537) / 0.3).floor() as i32;
        let turn = ((normal[0] * 8.0).round() * 32.0 + (normal[1] * 8.0).round()) as i32;
        let kind = concrete.unwrap_or_else(|| hash(look.seed, [plane, turn, 1]));
        let plastered = concrete.is_none() && unit(kind) < look.plastered;
        let mut value = 0.93 + 0.14 * unit(kind.rotate_left(11));
        value *= self.mottled(at, slanted, if plastered { 0.5 } else { 1.0 });
        if !plastered {
            let phase = look.panel[0] * unit(kind.rotate_left(21));
            let seam = line(u - phase, look.panel[0], 0.012, slanted).max(line(
                z,
                look.panel[1],
                0.01,
                footprint / ray.stretch.max(1.0),
            ));
            value *= 1.0 - look.joint * 0.6 * seam;
            value *= 1.0 - 0.5 * tie_holes([u - phase, z], look.panel, slanted);
        }
        let corner = |d: f32| 1.0 / (1.0 + (d / 0.09) * (d / 0.09));
        value *= 1.0 - 0.28 * corner(z) - 0.15 * corner(look.ceiling - z);
        value *= 1.0 + 0.16 * (normal[0] * look.sun[0] + normal[1] * look.sun[1]);
        value *= self.scene.light.at(x + 0.2 * normal[0], y + 0.2 * normal[1]);
        let albedo = if plastered { look.plaster } else { look.wall };
        albedo.map(|v| v * value)
    }

    /// Stains and grain of concrete, a factor around 1.
    fn mottled(&self, at: [f32; 3], footprint: f32, strength: f32) -> f32 {
        let look = &self.scene.look;
        let large = grain(look.seed, at, 0.9, footprint) + 0.6 * grain(look.seed ^ 1, at, 0.21, footprint);
        let fine = grain(look.seed ^ 2, at, 0.035, footprint);
        let cloud = 0.8 * grain(look.seed ^ 3, at, 3.1, footprint);
        (1.0 + strength * look.mottle * (cloud + large + 0.7 * fine)).max(0.1)
    }

    /// Floor or ceiling.
    fn level(&self, ray: &Ray, range: f32, solids: &[&Solid]) -> Colour {
        let (look, at) = (&self.scene.look, self.point(ray, range));
        let [x, y, _] = at;
        let down = ray.slope < 0.0;
        let footprint = self.footprint(ray, range);
        let slanted = footprint / ray.direction.z.abs().max(0.1);
        let (albedo, [bay_x, bay_y], width) =
            if down { (look.floor, look.floor_bay, 0.008) } else { (look.slab, look.slab_bay, 0.022) };
        let joint = line(x + 0.37, bay_x, width, slanted).max(line(y - 0.53, bay_y, width, slanted));
        let mut value = self.mottled(at, slanted, if down { 1.3 } else { 0.7 });
        value *= 1.0 - look.joint * joint;
        if down {
            value *= self.litter(at, slanted);
            value *= solids.iter().map(|solid| shadow(solid, x, y)).fold(1.0, f32::min);
        }
        value *= (if down { 1.1 } else { 0.95 }) * self.scene.light.at(x, y);
        albedo.map(|v| v * value)
    }

    /// Specks of dust and plaster on the floor, bright or dark.
    fn litter(&self, [x, y, _]: [f32; 3], footprint: f32) -> f32 {
        const CELL: f32 = 0.22;
        let cell = [x, y].map(|v| (v / CELL).floor());
        let kind = hash(self.scene.look.seed, [cell[0] as i32, cell[1] as i32, 5]);
        if unit(kind) > 0.06 {
            return 1.0;
        }
        let size = 0.008 + 0.03 * unit(kind.rotate_left(7));
        let offset = [kind.rotate_left(13), kind.rotate_left(22)].map(|h| 0.2 + 0.6 * unit(h));
        let d = [x / CELL - cell[0] - offset[0], y / CELL - cell[1] - offset[1]].map(|v| v * CELL);
        let distance = (d[0] * d[0] + 2.0 * d[1] * d[1]).sqrt();
        let inside = ((size - distance) / footprint.max(0.002) + 0.5).clamp(0.0, 1.0);
        let strength = if kind & 1 == 0 { 0.5 } else { -0.4 };
        1.0 + strength * inside
    }

    /// The opaque parts of an opening; `None` where it is open.
    fn opening(&self, ray: &Ray, pane: &Pane, [near, far]: [f32; 2], normal: [f32; 2]) -> Option<Colour> {
        let look = &self.scene.look;
        let height = |range: f32| self.from.z + ray.slope * range;
        let open = |z: f32| z > pane.sill && z < pane.lintel;
        if !open(height(near)) {
            return Some(self.wall(ray, near, normal, Some(1)));
        }
        // Glass and frame in the middle of the depth, sill and soffit before them.
        let at = self.point(ray, (near + far) / 2.0);
        let light = self.scene.light.at(at[0] + 0.2 * normal[0], at[1] + 0.2 * normal[1]);
        if !open(at[2]) {
            let value = light * if ray.slope < 0.0 { 1.25 } else { 0.8 };
            return Some(look.wall.map(|v| v * value));
        }
        let frame = pane.is_frame([at[0], at[1]], at[2], look.frame_width);
        frame.then(|| look.frame.map(|v| v * light * 0.8))
    }

    /// Sky, trees and ground, mostly overexposed.
    fn outdoors(&self, ray: &Ray) -> Colour {
        let look = &self.scene.look;
        let [x, y] = ray.flat;
        let place = |scale: f32, up: f32| [x * scale, y * scale, ray.slope * up];
        let treeline = 0.12 + 0.3 * noise(look.seed ^ 11, [x * 2.3, y * 2.3, 0.5]);
        let sky = [0.95, 1.0, 1.06].map(|v| v * look.outside);
        let leaves = 0.5
            + 0.35 * noise(look.seed ^ 12, place(9.0, 9.0))
            + 0.25 * noise(look.seed ^ 13, place(30.0, 30.0));
        let green = look.green.map(|v| v * look.outside * leaves.max(0.1));
        let ground = [0.42, 0.41, 0.38].map(|v| v * look.outside * (0.8 + 0.4 * leaves));
        let mix =
            |a: Colour, b: Colour, t: f32| -> Colour { std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t) };
        let step = |edge: f32, width: f32| ((ray.slope - edge) / width + 0.5).clamp(0.0, 1.0);
        let colour = mix(mix(ground, green, step(-0.22, 0.1)), sky, step(treeline, 0.04));
        mix(colour, sky, look.haze)
    }

    fn solid(&self, met: &Met<'_>) -> Colour {
        let at = met.place;
        let centre = met.solid.centre;
        let lit = self.scene.light.at(centre[0], centre[1]);
        let sun = self.scene.look.sun;
        let facing = 0.8 + 0.2 * met.normal.z + 0.2 * (met.normal.x * sun[0] + met.normal.y * sun[1]);
        let seed = self.scene.look.seed ^ centre[0].to_bits();
        let mut value = lit * facing * (1.0 + 0.06 * noise(seed, [at.x * 9.0, at.y * 9.0, at.z * 9.0]));
        if met.solid.shape == Shape::Box {
            // Courses of whatever is stacked.
            let footprint = self.sample * met.distance;
            value *= 1.0 - 0.35 * line(at.z + met.solid.half[2], 0.31, 0.012, footprint);
        }
        met.solid.colour.map(|v| v * value)
    }
}

/// Holes of formwork ties at the quarters of panels.
fn tie_holes([u, z]: [f32; 2], [width, height]: [f32; 2], footprint: f32) -> f32 {
    let near = |v: f32, spacing: f32| {
        let v = v + spacing / 2.0;
        v - (v / spacing).round() * spacing
    };
    let (du, dz) = (near(u - width / 4.0, width / 2.0), near(z - height / 4.0, height / 2.0));
    let distance = (du * du + dz * dz).sqrt();
    ((0.014 - distance) / footprint.max(0.001) + 0.5).clamp(0.0, 1.0)
}

/// Share of the light on the floor near a solid.
fn shadow(solid: &Solid, x: f32, y: f32) -> f32 {
    let foot = solid.centre[2] - solid.half[2];
    if foot > 0.3 {
        return 1.0;
    }
    let gap = solid.gap(x, y).max(0.0);
    0.45 + 0.55 * (gap / SHADOW_M).min(1.0)
}
