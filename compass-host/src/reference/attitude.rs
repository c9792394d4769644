//! Vertical vanishing point: arcs from the reference's lenses, directions by eigenvalue decomposition.

use super::camera::Camera;
use compass_core::vision::camera::View;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Largest angle of an arc's ends from the optical axis, least arc length, and length at which the weight saturates,
/// degrees.
const FIELD_DEG: f64 = 92.0;
const LENGTH_DEG: [f64; 2] = [0.1, 25.0];
/// Arcs whose midpoint is this near to a direction are uninformative about it, degrees.
const NEAR_DEG: f64 = 20.0;
/// Upper limit of iterations until the weights are stable.
const ROUNDS: usize = 200;

/// A segment on the unit sphere, in the axes of camera 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    normal: Vector3<f64>,
    middle: Vector3<f64>,
    weight: f64,
}

impl Arc {
    /// The arc between two pixels of a view; `None` out of the field, or if it is too short.
    #[must_use]
    pub fn new(ends: [[f64; 2]; 2], view: &View) -> Option<Self> {
        let camera = Camera::from(&view.camera);
        let limit = f64::from(view.camera.max_angle()).min(FIELD_DEG.to_radians());
        let bearing =
            |pixel| Some(view.rotation.cast::<f64>() * Vector3::from(camera.unproject(pixel, limit)?));
        let (a, b) = (bearing(ends[0])?, bearing(ends[1])?);
        let length = a.cross(&b).norm().atan2(a.dot(&b)).to_degrees();
        let [least, most] = LENGTH_DEG;
        (length >= least).then(|| Self {
            normal: a.cross(&b).normalize(),
            middle: (a + b).normalize(),
            weight: length.min(most),
        })
    }

    /// The angle by which the arc must turn about its midpoint to point to a direction, relative to the tolerance: the
    /// squared ratio of the sines.
    fn residual(&self, direction: &Vector3<f64>, tolerance_deg: f64) -> f64 {
        let near = self.middle.dot(direction);
        if near.abs() > NEAR_DEG.to_radians().cos() {
            return 1.0;
        }
        let off = self.normal.dot(direction) / tolerance_deg.to_radians().sin();
        off * off / (1.0 - near * near)
    }
}

/// The consensus direction near `start`: it minimizes the weighted sum of squared sines to the great circles of the
/// arcs around it; weights and direction are updated in turn until neither changes.
#[must_use]
pub fn refined(arcs: &[Arc], start: Vector3<f64>, tolerance_deg: f64) -> Vector3<f64> {
    let mut direction = start.normalize();
    for _ in 0..ROUNDS {
        let mut scatter = Matrix3::zeros();
        for arc in arcs {
            let weight = arc.weight * (1.0 - arc.residual(&direction, tolerance_deg)).max(0.0);
            scatter += arc.normal * arc.normal.transpose() * weight;
        }
        let eigen = SymmetricEigen::new(scatter);
        let next = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        direction = if next.dot(&direction) < 0.0 { -next } else { next };
    }
    direction
}
