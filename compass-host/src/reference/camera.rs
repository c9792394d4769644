//! The camera models: image radius as a function of the angle, everything else by bisection; tangential distortion by
//! iteration.
//!
//! Axes and pixel centres are the core's: x right, y down, z forward; the top left pixel is (0, 0).

use compass_core::vision::camera::{Camera as CoreCamera, Radtan, WIDEST_ANGLE, WIDEST_RADIUS};

/// The image radius at an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Model {
    /// Polynomial with k1 to k4 at theta^3 to theta^9.
    KannalaBrandt([f64; 4]),
    /// Enhanced unified camera model.
    Eucm {
        /// 0 to 1.
        alpha: f64,
        /// Above 0.
        beta: f64,
    },
    /// Double sphere model.
    DoubleSphere {
        /// Above -1, to 1.
        xi: f64,
        /// 0 to 1.
        alpha: f64,
    },
    /// Unified omnidirectional model; xi 0 is the pinhole.
    Omni {
        /// From 0 up.
        xi: f64,
        /// k1, k2, p1, p2 and k3 of `OpenCV`.
        distortion: [f64; 5],
    },
    /// Radius equal to the angle.
    Equidistant,
}

impl Model {
    /// The radius in focal lengths from the principal point, at an angle in radians from the axis; without tangential
    /// distortion.
    #[must_use]
    pub fn radius(&self, theta: f64) -> f64 {
        let (sin, cos) = theta.sin_cos();
        match *self {
            Self::KannalaBrandt([k1, k2, k3, k4]) => {
                theta + k1 * theta.powi(3) + k2 * theta.powi(5) + k3 * theta.powi(7) + k4 * theta.powi(9)
            }
            Self::Eucm { alpha, beta } => {
                sin / (alpha * (beta * sin * sin + cos * cos).sqrt() + (1.0 - alpha) * cos)
            }
            Self::DoubleSphere { xi, alpha } => {
                let moved = cos + xi;
                sin / (alpha * sin.hypot(moved) + (1.0 - alpha) * moved)
            }
            Self::Omni { xi, distortion: [k1, k2, _, _, k3] } => {
                let r = sin / (cos + xi);
                r + k1 * r.powi(3) + k2 * r.powi(5) + k3 * r.powi(7)
            }
            Self::Equidistant => theta,
        }
    }

    /// The tangential distortion at an angle, in the direction (c, s) around the axis.
    fn tangential(&self, theta: f64, [c, s]: [f64; 2]) -> [f64; 2] {
        let Self::Omni { xi, distortion: [_, _, p1, p2, _] } = *self else { return [0.0; 2] };
        let r = theta.sin() / (theta.cos() + xi);
        let (x, y) = (r * c, r * s);
        [2.0 * p1 * x * y + p2 * (r * r + 2.0 * x * x), p1 * (r * r + 2.0 * y * y) + 2.0 * p2 * x * y]
    }
}

/// Most rounds in which the tangential distortion is taken out.
const ROUNDS: usize = 400;

/// A camera in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The lens.
    pub model: Model,
    /// Focal lengths along x and y, pixels.
    pub focal: [f64; 2],
    /// Principal point, pixels.
    pub centre: [f64; 2],
}

impl Camera {
    /// The largest angle, in radians, up to which the radius grows with the angle and stays within the
    /// core's limits.
    #[must_use]
    pub fn max_angle(&self) -> f64 {
        const STEP: f64 = 1e-4;
        let (mut theta, mut radius) = (0.0, 0.0);
        while theta + STEP <= f64::from(WIDEST_ANGLE) {
            let next = self.model.radius(theta + STEP);
            // A denominator that crosses zero turns the radius negative; NaN ends the field as well.
            if !(next > radius && next <= f64::from(WIDEST_RADIUS)) {
                break;
            }
            (theta, radius) = (theta + STEP, next);
        }
        theta
    }

    /// The pixel of a bearing of any length; `None` straight behind. The field of view is not checked.
    #[must_use]
    pub fn project(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        let across = x.hypot(y);
        if across == 0.0 {
            return (z > 0.0).then_some(self.centre);
        }
        let (theta, around) = (across.atan2(z), [x / across, y / across]);
        let radius = self.model.radius(theta);
        let aside = self.model.tangential(theta, around);
        let pixel =
            |axis: usize| self.focal[axis] * (radius * around[axis] + aside[axis]) + self.centre[axis];
        Some([pixel(0), pixel(1)])
    }

    /// The bearing of length 1 of a pixel whose angle is at most `limit`; `None` further out.
    #[must_use]
    pub fn unproject(&self, [x, y]: [f64; 2], limit: f64) -> Option<[f64; 3]> {
        let target = [(x - self.centre[0]) / self.focal[0], (y - self.centre[1]) / self.focal[1]];
        let mut found = self.bearing(target, limit)?;
        for _ in 0..ROUNDS {
            let across = found[0].hypot(found[1]);
            if across == 0.0 {
                break;
            }
            let around = [found[0] / across, found[1] / across];
            let aside = self.model.tangential(across.atan2(found[2]), around);
            let next = self.bearing([target[0] - aside[0], target[1] - aside[1]], limit)?;
            let moved = (0..3).map(|axis| (next[axis] - found[axis]).abs()).fold(0.0, f64::max);
            found = next;
            if moved < 1e-15 {
                break;
            }
        }
        Some(found)
    }

    /// The bearing of a position in focal lengths, without tangential distortion.
    fn bearing(&self, [x, y]: [f64; 2], limit: f64) -> Option<[f64; 3]> {
        let radius = x.hypot(y);
        if radius == 0.0 {
            return Some([0.0, 0.0, 1.0]);
        }
        // NaN is outside the field.
        let within = radius <= self.model.radius(limit);
        if !within {
            return None;
        }
        let (mut low, mut high) = (0.0, limit);
        for _ in 0..64 {
            let middle = 0.5 * (low + high);
            if self.model.radius(middle) < radius { low = middle } else { high = middle }
        }
        let (sin, cos) = (0.5 * (low + high)).sin_cos();
        Some([sin * x / radius, sin * y / radius, cos])
    }

    /// The camera of the image resized by `sx` and `sy`; the outer edges of the image coincide.
    #[must_use]
    pub fn scaled(&self, sx: f64, sy: f64) -> Self {
        let [cx, cy] = self.centre;
        Self {
            model: self.model,
            focal: [self.focal[0] * sx, self.focal[1] * sy],
            centre: [(cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5],
        }
    }
}

impl From<&CoreCamera> for Camera {
    fn from(camera: &CoreCamera) -> Self {
        let i = camera.intrinsics();
        let model = match camera {
            CoreCamera::KannalaBrandt(lens) => Model::KannalaBrandt(lens.coefficients().map(f64::from)),
            CoreCamera::Eucm(lens) => {
                Model::Eucm { alpha: f64::from(lens.alpha()), beta: f64::from(lens.beta()) }
            }
            CoreCamera::DoubleSphere(lens) => {
                Model::DoubleSphere { xi: f64::from(lens.xi()), alpha: f64::from(lens.alpha()) }
            }
            CoreCamera::Omni(lens) => {
                let Radtan { k1, k2, p1, p2, k3 } = lens.distortion();
                Model::Omni { xi: f64::from(lens.xi()), distortion: [k1, k2, p1, p2, k3].map(f64::from) }
            }
            CoreCamera::Equidistant(_) => Model::Equidistant,
        };
        Self { model, focal: [f64::from(i.fx), f64::from(i.fy)], centre: [f64::from(i.cx), f64::from(i.cy)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_round() {
        let models = [
            Model::Equidistant,
            Model::KannalaBrandt([0.03, -0.012, -0.001, 0.0001]),
            Model::Eucm { alpha: 0.65, beta: 0.9 },
            Model::DoubleSphere { xi: -0.2, alpha: 0.59 },
            Model::Omni { xi: 1.4, distortion: [-0.02, 0.003, 4e-4, -7e-4, 0.0] },
        ];
        for model in models {
            // An omnidirectional lens shows a radius by 1 + xi smaller.
            let zoom = if let Model::Omni { xi, .. } = model { 1.0 + xi } else { 1.0 };
            let camera = Camera { model, focal: [430.0 * zoom, 431.0 * zoom], centre: [700.0, 690.0] };
            let limit = camera.max_angle();
            assert!(limit > 1.9, "{model:?} {limit}");
            for (x, y) in [(700.0, 690.0), (12.0, 700.5), (650.25, 1300.0), (1200.0, 260.0)] {
                let [u, v] = camera.project(camera.unproject([x, y], limit).unwrap()).unwrap();
                assert!((u - x).hypot(v - y) < 1e-9, "{model:?}: {x} {y}, {u} {v}");
            }
        }
    }
}
