//! Solids in the rooms: boxes and ellipsoids, and the people made of them.

use super::style::Colour;
use nalgebra::Vector3;
use rand::{Rng, RngExt as _};

/// The shape of a solid within its half axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    Box,
    Ellipsoid,
}

/// A solid, turned about the vertical. Metres in the map, heights above the floor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    pub(super) shape: Shape,
    pub(super) centre: [f32; 3],
    pub(super) half: [f32; 3],
    /// Cosine and sine of the turn.
    pub(super) turn: [f32; 2],
    pub(super) colour: Colour,
}

/// Where a ray meets a solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met<'a> {
    /// Along the ray, metres.
    pub(super) distance: f32,
    pub(super) normal: Vector3<f32>,
    /// The point in the solid's own axes, metres.
    pub(super) place: Vector3<f32>,
    pub(super) solid: &'a Solid,
}

impl Solid {
    fn ellipsoid(centre: [f32; 3], half: [f32; 3], turn: [f32; 2], colour: Colour) -> Self {
        Self { shape: Shape::Ellipsoid, centre, half, turn, colour }
    }

    /// A vector in the solid's own axes.
    fn own(&self, v: Vector3<f32>) -> Vector3<f32> {
        let [c, s] = self.turn;
        Vector3::new(c * v.x + s * v.y, c * v.y - s * v.x, v.z)
    }

    fn back(&self, v: Vector3<f32>) -> Vector3<f32> {
        let [c, s] = self.turn;
        Vector3::new(c * v.x - s * v.y, c * v.y + s * v.x, v.z)
    }

    /// Radius of the circle around it on the floor.
    pub(super) fn radius(&self) -> f32 {
        (self.half[0] * self.half[0] + self.half[1] * self.half[1]).sqrt()
    }

    /// Metres on the floor from a point to its edge, below 0 inside.
    pub(super) fn gap(&self, x: f32, y: f32) -> f32 {
        let v = self.own(Vector3::new(x - self.centre[0], y - self.centre[1], 0.0));
        (v.x.abs() - self.half[0]).max(v.y.abs() - self.half[1])
    }

    /// The first intersection of a ray from `from` towards `direction`, of length 1.
    pub(super) fn meet(&self, from: Vector3<f32>, direction: Vector3<f32>) -> Option<Met<'_>> {
        let from = self.own(from - Vector3::from(self.centre));
        let direction = self.own(direction);
        let (distance, normal) = match self.shape {
            Shape::Box => self.meet_box(from, direction)?,
            Shape::Ellipsoid => self.meet_ellipsoid(from, direction)?,
        };
        Some(Met { distance, normal: self.back(normal), place: from + direction * distance, solid: self })
    }

    fn meet_box(&self, from: Vector3<f32>, direction: Vector3<f32>) -> Option<(f32, Vector3<f32>)> {
        let (mut enter, mut leave, mut normal) = (f32::MIN, f32::MAX, Vector3::zeros());
        for axis in 0..3 {
            let (o, d, h) = (from[axis], direction[axis], self.half[axis]);
            if d.abs() < 1e-9 {
                if o.abs() > h {
                    return None;
                }
                continue;
            }
            let near = (-h * d.signum() - o) / d;
            if near > enter {
                enter = near;
                normal = Vector3::zeros();
                normal[axis] = -d.signum();
            }
            leave = leave.min((h * d.signum() - o) / d);
        }
        (enter > 0.0 && enter < leave).then_some((enter, normal))
    }

    fn meet_ellipsoid(&self, from: Vector3<f32>, direction: Vector3<f32>) -> Option<(f32, Vector3<f32>)> {
        let half = Vector3::from(self.half);
        let (o, d) = (from.component_div(&half), direction.component_div(&half));
        let (a, b, c) = (d.dot(&d), o.dot(&d), o.dot(&o) - 1.0);
        let root = b * b - a * c;
        if root < 0.0 {
            return None;
        }
        let t = (-b - root.sqrt()) / a;
        (t > 0.0).then(|| (t, (o + d * t).component_div(&half).normalize()))
    }
}

/// A standing person, with or without a red vest.
pub(super) fn person(at: [f32; 2], red: bool, rng: &mut impl Rng) -> Vec<Solid> {
    let mut draw = || rng.random::<f32>();
    let tall = (1.62 + 0.3 * draw()) / 1.75;
    let angle = std::f32::consts::TAU * draw();
    let turn = [libm::cosf(angle), libm::sinf(angle)];
    let others = [[0.05, 0.06, 0.1], [0.55, 0.32, 0.03], [0.12, 0.12, 0.13]];
    let vest = if red { [0.6, 0.025, 0.03] } else { others[(draw() * 3.0) as usize % 3] };
    let helmets = [[0.6, 0.03, 0.03], [0.7, 0.7, 0.68], [0.65, 0.45, 0.02]];
    let helmet = if red { helmets[(draw() * 3.0) as usize % 3] } else { helmets[1] };
    let trousers = [0.02, 0.02, 0.025];
    let part = |aside: f32, z: f32, half: [f32; 3], colour: Colour| {
        let centre = [at[0] - aside * turn[1], at[1] + aside * turn[0], z * tall];
        Solid::ellipsoid(centre, half.map(|v| v * tall), turn, colour)
    };
    let stride = 0.09 + 0.06 * draw();
    vec![
        part(stride, 0.43, [0.09, 0.08, 0.45], trousers),
        part(-stride, 0.43, [0.09, 0.08, 0.45], trousers),
        part(0.0, 1.15, [0.15, 0.22, 0.36], vest),
        part(0.26, 1.1, [0.08, 0.065, 0.33], vest),
        part(-0.26, 1.1, [0.08, 0.065, 0.33], vest),
        part(0.0, 1.6, [0.1, 0.09, 0.13], [0.33, 0.2, 0.15]),
        part(0.0, 1.69, [0.14, 0.12, 0.08], helmet),
    ]
}

/// The carrier of the rig, standing behind, beside and below camera 0, and the mount; `forward` is the horizontal
/// direction of the camera's axis. `side` is 1 or -1.
pub(super) fn operator(camera: Vector3<f32>, forward: [f32; 2], side: f32) -> Vec<Solid> {
    let [fx, fy] = forward;
    let place = |ahead: f32, aside: f32, up: f32| {
        let aside = aside * side;
        [camera.x + ahead * fx - aside * fy, camera.y + ahead * fy + aside * fx, camera.z + up]
    };
    let (red, dark) = ([0.62, 0.022, 0.02], [0.012, 0.012, 0.014]);
    let turn = forward;
    vec![
        Solid::ellipsoid(place(-0.02, 0.4, -0.19), [0.15, 0.12, 0.1], turn, red),
        Solid::ellipsoid(place(0.0, 0.4, -0.29), [0.1, 0.09, 0.13], turn, [0.33, 0.2, 0.15]),
        Solid::ellipsoid(place(-0.03, 0.42, -0.68), [0.16, 0.24, 0.27], turn, red),
        Solid::ellipsoid(place(-0.02, 0.0, -0.19), [0.05, 0.1, 0.03], turn, dark),
        Solid::ellipsoid(place(-0.02, 0.0, -0.45), [0.025, 0.025, 0.28], turn, dark),
    ]
}

/// Solids by their azimuth from a place, in whole degrees.
#[derive(Debug)]
pub(super) struct Sight<'a> {
    bins: Vec<Vec<&'a Solid>>,
}

impl<'a> Sight<'a> {
    /// The `solids` visible from a place, within 25 m.
    pub(super) fn new(solids: impl Iterator<Item = &'a Solid>, from: Vector3<f32>) -> Self {
        let mut bins = vec![Vec::new(); 360];
        for solid in solids {
            let (dx, dy) = (solid.centre[0] - from.x, solid.centre[1] - from.y);
            let distance = (dx * dx + dy * dy).sqrt();
            // The shadow extends beyond the solid.
            let radius = solid.radius() + SHADOW_M;
            if distance > 25.0 {
                continue;
            }
            if distance <= radius {
                bins.iter_mut().for_each(|bin| bin.push(solid));
                continue;
            }
            let middle = libm::atan2f(dy, dx).to_degrees();
            let half = libm::asinf(radius / distance).to_degrees();
            let (first, last) = ((middle - half).floor() as i32, (middle + half).floor() as i32);
            for degree in first..=last {
                bins[degree.rem_euclid(360) as usize].push(solid);
            }
        }
        Self { bins }
    }

    /// The solids that may lie in the direction of an azimuth in degrees, 0 to 360.
    pub(super) fn towards(&self, azimuth_deg: f32) -> &[&'a Solid] {
        self.bins.get(azimuth_deg as usize).map_or(&[], Vec::as_slice)
    }
}

/// Distance from a solid at which its shadow on the floor ends, metres.
pub(super) const SHADOW_M: f32 = 0.25;
