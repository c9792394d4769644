//! The calibration of one camera as ROS stores it: `camera_info` YAML of `camera_calibration_parsers`.

use super::camera::{CalibratedCamera, Entry, Place};
use super::error::Refusal;
use super::lens::{self, Names};
use super::node::Node;
use crate::reference::camera::Model;

const NAMES: Names = Names {
    intrinsics: "camera_matrix",
    coefficients: "distortion_coefficients",
    resolution: "image_width, image_height",
};

/// Whether a file is one.
pub(super) fn is_one(root: &Node) -> bool {
    root.get(NAMES.intrinsics).is_some() && root.get("image_width").is_some()
}

/// The camera, as `cam0`.
pub(super) fn entry(root: &Node) -> Entry {
    Entry { name: "cam0".to_owned(), camera: camera(root), place: Ok(Place::default()) }
}

fn camera(root: &Node) -> Result<CalibratedCamera, Refusal> {
    let side = |name: &str| root.get(name).and_then(Node::number).unwrap_or(f64::NAN);
    let resolution = lens::resolution(NAMES.resolution, &[side("image_width"), side("image_height")])?;
    let numbers = |name: &str| {
        let numbers = root.get(name).and_then(Node::numbers);
        numbers.ok_or_else(|| Refusal::new(name, "is missing or has no data of numbers"))
    };
    let matrix = numbers(NAMES.intrinsics)?;
    lens::finite(NAMES.intrinsics, &matrix)?;
    let [fx, _, cx, _, fy, cy, ..] = matrix[..] else {
        return Err(Refusal::new(NAMES.intrinsics, format!("has {} values; nine are needed", matrix.len())));
    };
    let distortion = || lens::radtan(NAMES.coefficients, &numbers(NAMES.coefficients)?);
    let model = match root.get("distortion_model").and_then(Node::text) {
        Some("equidistant" | "fisheye") => {
            lens::polynomial(NAMES.coefficients, &numbers(NAMES.coefficients)?)?
        }
        Some("plumb_bob" | "rational_polynomial") => Model::Omni { xi: 0.0, distortion: distortion()? },
        None => Model::Omni { xi: 0.0, distortion: [0.0; 5] },
        Some(other) => {
            let problem = format!(
                "'{other}' is not supported, only equidistant, fisheye, plumb_bob and rational_polynomial"
            );
            return Err(Refusal::new("distortion_model", problem));
        }
    };
    let camera = lens::checked(&NAMES, model, [fx, fy, cx, cy], resolution)?;
    Ok(CalibratedCamera {
        camera,
        resolution,
        from_imu: None,
        from_previous: None,
        timeshift_s: 0.0,
        topic: None,
    })
}
