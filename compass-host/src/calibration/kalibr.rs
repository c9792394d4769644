//! Camera chains as Kalibr writes them (`camchain.yaml`, `camchain-imucam.yaml`), and as `OpenVINS` reads them.

use super::camera::{AGREEING, CalibratedCamera, Entry, Place};
use super::error::Refusal;
use super::lens::{self, Names};
use super::node::Node;
use super::transform;
use crate::reference::camera::Model;
use nalgebra::Matrix4;

const NAMES: Names =
    Names { intrinsics: "intrinsics", coefficients: "distortion_coeffs", resolution: "resolution" };

/// Models that are read, for messages.
const SUPPORTED: &str = "pinhole with equidistant, radtan or none, omni with radtan or none, ds, and eucm";

/// Whether a key names a camera: `cam0`, `cam1` and so on.
pub(super) fn is_camera(key: &str) -> bool {
    key.strip_prefix("cam").is_some_and(|n| !n.is_empty() && n.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The cameras of a chain in the order of their numbers.
pub(super) fn entries(root: &Node) -> Vec<Entry> {
    let mut cameras: Vec<_> = root.entries().iter().filter(|(key, _)| is_camera(key)).collect();
    cameras.sort_by_key(|(key, _)| (key.len(), key.clone()));
    cameras.into_iter().map(|(name, node)| entry(name, node)).collect()
}

fn entry(name: &str, node: &Node) -> Entry {
    let place = place(node).map_err(|refusal| refusal.of(name));
    let camera = place.clone().and_then(|place| camera(node, place).map_err(|refusal| refusal.of(name)));
    Entry { name: name.to_owned(), camera, place }
}

/// The topic of the IMU; Kalibr itself writes it into another file.
pub(super) fn imu_topic(root: &Node) -> Option<String> {
    root.get("imu0")?.get("rostopic")?.text().map(str::to_owned)
}

fn place(node: &Node) -> Result<Place, Refusal> {
    let read = |name: &str| node.get(name).map(|rows| transform::from_rows(name, rows)).transpose();
    let forward: Option<Matrix4<f64>> = read("T_cam_imu")?;
    let backward = read("T_imu_cam")?.map(|t| transform::inverse(&t));
    if let (Some(a), Some(b)) = (forward, backward)
        && (a - b).amax() > AGREEING
    {
        return Err(Refusal::new("T_imu_cam", "is not the inverse of T_cam_imu"));
    }
    Ok(Place { from_imu: forward.or(backward), from_previous: read("T_cn_cnm1")? })
}

fn camera(node: &Node, place: Place) -> Result<CalibratedCamera, Refusal> {
    let (model, pinhole) = model(node)?;
    let resolution = lens::resolution(NAMES.resolution, &numbers(node, NAMES.resolution)?)?;
    let camera = lens::checked(&NAMES, model, pinhole, resolution)?;
    let timeshift_s = match node.get("timeshift_cam_imu") {
        None => 0.0,
        Some(value) => value
            .number()
            .filter(|seconds| seconds.is_finite())
            .ok_or_else(|| Refusal::new("timeshift_cam_imu", format!("is {value}, no number of seconds")))?,
    };
    let topic = node.get("rostopic").and_then(Node::text).map(str::to_owned);
    let Place { from_imu, from_previous } = place;
    Ok(CalibratedCamera { camera, resolution, from_imu, from_previous, timeshift_s, topic })
}

fn needed<'a>(node: &'a Node, name: &str) -> Result<&'a Node, Refusal> {
    node.get(name).ok_or_else(|| Refusal::new(name, "missing"))
}

fn text<'a>(node: &'a Node, name: &str) -> Result<&'a str, Refusal> {
    let value = needed(node, name)?;
    value.text().ok_or_else(|| Refusal::new(name, format!("is {value}; a name is needed")))
}

fn numbers(node: &Node, name: &str) -> Result<Vec<f64>, Refusal> {
    let value = needed(node, name)?;
    value.numbers().ok_or_else(|| Refusal::new(name, format!("is {value}; a list of numbers is needed")))
}

/// The lens, and fx, fy, cx, cy.
fn model(node: &Node) -> Result<(Model, [f64; 4]), Refusal> {
    const PINHOLE: &str = "fx, fy, cx, cy";
    let camera_model = text(node, "camera_model")?;
    let distortion_model = || text(node, "distortion_model");
    let distortion = |name: &str| match name {
        "radtan" => lens::radtan(NAMES.coefficients, &numbers(node, NAMES.coefficients)?),
        _ => no_coefficients(node, camera_model).map(|()| [0.0; 5]),
    };
    match camera_model {
        "pinhole" => match distortion_model()? {
            "equidistant" => {
                let k = lens::polynomial(NAMES.coefficients, &numbers(node, NAMES.coefficients)?)?;
                Ok((k, intrinsics(node, PINHOLE)?))
            }
            name @ ("radtan" | "none") => {
                let model = Model::Omni { xi: 0.0, distortion: distortion(name)? };
                Ok((model, intrinsics(node, PINHOLE)?))
            }
            other => Err(unsupported("distortion_model", other, camera_model)),
        },
        "omni" => match distortion_model()? {
            name @ ("radtan" | "none") => {
                let [xi, fx, fy, cx, cy] = intrinsics(node, "xi, fx, fy, cx, cy")?;
                Ok((Model::Omni { xi, distortion: distortion(name)? }, [fx, fy, cx, cy]))
            }
            other => Err(unsupported("distortion_model", other, camera_model)),
        },
        "eucm" => {
            undistorted(node, camera_model)?;
            let [alpha, beta, fx, fy, cx, cy] = intrinsics(node, "alpha, beta, fx, fy, cx, cy")?;
            Ok((Model::Eucm { alpha, beta }, [fx, fy, cx, cy]))
        }
        "ds" => {
            undistorted(node, camera_model)?;
            let [xi, alpha, fx, fy, cx, cy] = intrinsics(node, "xi, alpha, fx, fy, cx, cy")?;
            Ok((Model::DoubleSphere { xi, alpha }, [fx, fy, cx, cy]))
        }
        other => {
            let problem = format!("'{other}' is not supported, only {SUPPORTED}");
            Err(Refusal::new("camera_model", problem))
        }
    }
}

fn unsupported(field: &str, name: &str, camera_model: &str) -> Refusal {
    Refusal::new(field, format!("'{name}' is not supported with {camera_model}, only {SUPPORTED}"))
}

fn undistorted(node: &Node, camera_model: &str) -> Result<(), Refusal> {
    match node.get("distortion_model") {
        None => no_coefficients(node, camera_model),
        Some(name) if name.text() == Some("none") => no_coefficients(node, camera_model),
        Some(_) => {
            Err(Refusal::new("distortion_model", format!("{camera_model} takes none, and no coefficients")))
        }
    }
}

fn no_coefficients(node: &Node, camera_model: &str) -> Result<(), Refusal> {
    match node.get(NAMES.coefficients).map(Node::numbers) {
        None => Ok(()),
        // OpenCV and OpenVINS write zeros where there is nothing.
        Some(Some(values)) if camera_model != "eucm" && values.iter().all(|value| *value == 0.0) => Ok(()),
        Some(Some(values)) if values.is_empty() => Ok(()),
        Some(_) => {
            Err(Refusal::new("distortion_model", format!("{camera_model} takes no coefficients without one")))
        }
    }
}

/// The intrinsics, as many as there are `names`.
fn intrinsics<const N: usize>(node: &Node, names: &str) -> Result<[f64; N], Refusal> {
    let values = numbers(node, NAMES.intrinsics)?;
    lens::finite(NAMES.intrinsics, &values)?;
    values.as_slice().try_into().map_err(|_| {
        Refusal::new(NAMES.intrinsics, format!("has {} values; [{names}] are needed", values.len()))
    })
}
