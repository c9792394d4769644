//! Lenses by the names of their models, checked.

use super::error::Refusal;
use crate::reference::camera::{Camera, Model};
use compass_core::vision::camera::{
    CameraError, DoubleSphere, Equidistant, Eucm, Intrinsics, KannalaBrandt, Omni, Radtan,
};

/// A first coefficient within this of 1 is the linear one, which Kalibr omits.
const LEADING_ONE: f64 = 0.1;

/// Longest side of an image in pixels.
pub(super) const MAX_SIDE: u32 = 65_535;

/// The core's camera from the reference's.
///
/// # Errors
/// Parameters that the core rejects.
pub fn core_camera(camera: &Camera) -> Result<compass_core::vision::camera::Camera, CameraError> {
    use compass_core::vision::camera::Camera as Core;
    let ([fx, fy], [cx, cy]) = (camera.focal, camera.centre);
    let i = Intrinsics { fx: fx as f32, fy: fy as f32, cx: cx as f32, cy: cy as f32 };
    Ok(match camera.model {
        Model::KannalaBrandt(k) => Core::KannalaBrandt(KannalaBrandt::new(i, k.map(|k| k as f32))?),
        Model::Eucm { alpha, beta } => Core::Eucm(Eucm::new(i, alpha as f32, beta as f32)?),
        Model::DoubleSphere { xi, alpha } => {
            Core::DoubleSphere(DoubleSphere::new(i, xi as f32, alpha as f32)?)
        }
        Model::Omni { xi, distortion } => {
            let [k1, k2, p1, p2, k3] = distortion.map(|value| value as f32);
            Core::Omni(Omni::new(i, xi as f32, Radtan { k1, k2, p1, p2, k3 })?)
        }
        Model::Equidistant => Core::Equidistant(Equidistant::new(i)?),
    })
}

/// The names of the fields of a lens in a file, for its errors.
pub(super) struct Names {
    pub(super) intrinsics: &'static str,
    pub(super) coefficients: &'static str,
    pub(super) resolution: &'static str,
}

/// The lens, if the core supports it for an image of this size.
pub(super) fn checked(
    names: &Names,
    model: Model,
    [fx, fy, cx, cy]: [f64; 4],
    (width, height): (u32, u32),
) -> Result<Camera, Refusal> {
    let camera = Camera { model, focal: [fx, fy], centre: [cx, cy] };
    core_camera(&camera).map_err(|error| {
        let is_of_coefficients = match model {
            Model::KannalaBrandt(_) => true,
            Model::Omni { distortion, .. } => distortion != [0.0; 5],
            _ => false,
        };
        let by_coefficients = error == CameraError::Field && is_of_coefficients;
        let field = if by_coefficients { names.coefficients } else { names.intrinsics };
        Refusal::new(field, error.to_string())
    })?;
    let within = |c: f64, side: u32| c > -0.5 && c < f64::from(side) - 0.5;
    if within(cx, width) && within(cy, height) {
        return Ok(camera);
    }
    let turned = within(cx, height) && within(cy, width);
    let (field, hint) =
        if turned { (names.resolution, "; are width and height swapped?") } else { (names.intrinsics, "") };
    let problem = format!("principal point ({cx}, {cy}) lies outside the {width} x {height} pixels{hint}");
    Err(Refusal::new(field, problem))
}

/// Width and height in pixels in the field `name`.
pub(super) fn resolution(name: &str, sides: &[f64]) -> Result<(u32, u32), Refusal> {
    let side = |value: f64| {
        let whole = value.fract() == 0.0 && (1.0..=f64::from(MAX_SIDE)).contains(&value);
        whole.then_some(value as u32)
    };
    if let [width, height] = *sides
        && let Some(sides) = side(width).zip(side(height))
    {
        return Ok(sides);
    }
    Err(Refusal::new(name, format!("is {sides:?}; [width, height] of 1 to {MAX_SIDE} pixels is needed")))
}

/// Refuses numbers in the field `name` that are not finite.
pub(super) fn finite(name: &str, values: &[f64]) -> Result<(), Refusal> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Refusal::new(name, format!("is {values:?}; finite numbers are needed")))
}

/// k1 to k4 of a Kannala-Brandt lens from the field `name`.
pub(super) fn polynomial(name: &str, values: &[f64]) -> Result<Model, Refusal> {
    finite(name, values)?;
    if values.first().is_some_and(|first| (first - 1.0).abs() < LEADING_ONE) {
        let problem = format!(
            "starts with {}, the coefficient of theta, which is 1 and must be left out: \
             [k1, k2, k3, k4] belong to theta^3, theta^5, theta^7 and theta^9",
            values[0]
        );
        return Err(Refusal::new(name, problem));
    }
    let k = values.try_into().map_err(|_| {
        let problem = format!(
            "has {} values; four are needed, [k1, k2, k3, k4] of theta^3, theta^5, theta^7 and theta^9 \
             (where others count k1 to k5, k1 belongs to theta, is 1 and must be left out)",
            values.len()
        );
        Refusal::new(name, problem)
    })?;
    Ok(Model::KannalaBrandt(k))
}

/// Radial and tangential distortion from the field `name`: k1, k2, p1, p2, then k3 and more that must be 0.
pub(super) fn radtan(name: &str, values: &[f64]) -> Result<[f64; 5], Refusal> {
    finite(name, values)?;
    let (first, more) = values.split_at(values.len().min(5));
    if more.iter().any(|value| *value != 0.0) {
        let problem =
            format!("is {values:?}; of the rational model only k1, k2, p1, p2 and k3 are supported");
        return Err(Refusal::new(name, problem));
    }
    let mut distortion = [0.0; 5];
    match first.len() {
        4 | 5 => distortion[..first.len()].copy_from_slice(first),
        count => {
            let problem = format!("has {count} values; [k1, k2, p1, p2] or [k1, k2, p1, p2, k3] are needed");
            return Err(Refusal::new(name, problem));
        }
    }
    Ok(distortion)
}
