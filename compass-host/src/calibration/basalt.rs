//! Calibrations of Basalt: JSON with `value0`.

use super::camera::{CalibratedCamera, Entry, Place};
use super::error::Refusal;
use super::lens::{self, Names};
use super::node::Node;
use super::transform;
use crate::reference::camera::Model;

/// The key that holds everything.
pub(super) const ROOT: &str = "value0";

const NAMES: Names = Names { intrinsics: "intrinsics", coefficients: "intrinsics", resolution: "resolution" };

/// Nanoseconds in a second.
const NANOSECONDS: f64 = 1e9;

/// The cameras, named `cam0`, `cam1` and so on.
pub(super) fn entries(root: &Node) -> Vec<Entry> {
    let Some(value) = root.get(ROOT) else { return Vec::new() };
    let count = value.get("intrinsics").and_then(Node::list).map_or(0, <[Node]>::len);
    (0..count).map(|number| entry(value, number)).collect()
}

fn entry(value: &Node, number: usize) -> Entry {
    let owner = |refusal: Refusal| Refusal { field: format!("{ROOT}.{}", refusal.field), ..refusal };
    let place = place(value, number).map_err(owner);
    let camera = place.clone().and_then(|place| camera(value, number, place).map_err(owner));
    Entry { name: format!("cam{number}"), camera, place }
}

fn item<'a>(value: &'a Node, name: &str, number: usize) -> Result<&'a Node, Refusal> {
    let item = value.get(name).and_then(Node::list).and_then(|list| list.get(number));
    item.ok_or_else(|| Refusal::new(format!("{name}[{number}]"), "missing"))
}

fn place(value: &Node, number: usize) -> Result<Place, Refusal> {
    if value.get("T_imu_cam").is_none() {
        return Ok(Place::default());
    }
    let pose = item(value, "T_imu_cam", number)?;
    let to_imu = transform::from_quaternion(&format!("T_imu_cam[{number}]"), pose)?;
    Ok(Place { from_imu: Some(transform::inverse(&to_imu)), from_previous: None })
}

fn camera(value: &Node, number: usize, place: Place) -> Result<CalibratedCamera, Refusal> {
    let sides = item(value, "resolution", number)?.numbers().unwrap_or_default();
    let resolution = lens::resolution(&format!("resolution[{number}]"), &sides)?;
    let (model, pinhole) = model(item(value, "intrinsics", number)?, number)?;
    let camera = lens::checked(&NAMES, model, pinhole, resolution)
        .map_err(|refusal| Refusal { field: format!("{}[{number}]", refusal.field), ..refusal })?;
    let offset = value.get("cam_time_offset_ns").and_then(Node::number).unwrap_or(0.0);
    Ok(CalibratedCamera {
        camera,
        resolution,
        from_imu: place.from_imu,
        from_previous: None,
        timeshift_s: offset / NANOSECONDS,
        topic: None,
    })
}

/// The lens, and fx, fy, cx, cy.
fn model(node: &Node, number: usize) -> Result<(Model, [f64; 4]), Refusal> {
    let field = |key: &str| format!("intrinsics[{number}].{key}");
    let kind = node.get("camera_type").and_then(Node::text);
    let kind = kind.ok_or_else(|| Refusal::new(field("camera_type"), "missing"))?;
    let part = |key: &str| {
        let number = node.get("intrinsics").and_then(|parts| parts.get(key)).and_then(Node::number);
        let number = number.filter(|number| number.is_finite());
        number.ok_or_else(|| {
            Refusal::new(field(&format!("intrinsics.{key}")), "is missing or no finite number")
        })
    };
    let parts = |keys: &[&str]| keys.iter().map(|key| part(key)).collect::<Result<Vec<_>, _>>();
    let model = match kind {
        "ds" => Model::DoubleSphere { xi: part("xi")?, alpha: part("alpha")? },
        "eucm" => Model::Eucm { alpha: part("alpha")?, beta: part("beta")? },
        // The unified model is the enhanced one with beta 1.
        "ucm" => Model::Eucm { alpha: part("alpha")?, beta: 1.0 },
        "kb4" => lens::polynomial(&field("intrinsics"), &parts(&["k1", "k2", "k3", "k4"])?)?,
        "pinhole" => Model::Omni { xi: 0.0, distortion: [0.0; 5] },
        "pinhole-radtan8" => {
            let values = parts(&["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"])?;
            Model::Omni { xi: 0.0, distortion: lens::radtan(&field("intrinsics"), &values)? }
        }
        other => {
            let problem =
                format!("'{other}' is not supported, only ds, eucm, ucm, kb4, pinhole and pinhole-radtan8");
            return Err(Refusal::new(field("camera_type"), problem));
        }
    };
    Ok((model, [part("fx")?, part("fy")?, part("cx")?, part("cy")?]))
}
