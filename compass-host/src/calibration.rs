//! Camera calibrations.
//!
//! | file | read of it |
//! |---|---|
//! | Kalibr `camchain.yaml`, `camchain-imucam.yaml`, `OpenVINS` | cameras `cam0`, `cam1`, ...; `rostopic` of `imu0` |
//! | Basalt JSON (`value0`) | `T_imu_cam`, `intrinsics`, `resolution`, `cam_time_offset_ns` |
//! | ROS `camera_info` YAML | one camera |
//!
//! | `camera_model` | `distortion_model` | `intrinsics` | `distortion_coeffs` |
//! |---|---|---|---|
//! | `pinhole` | `equidistant` | fx, fy, cx, cy | k1 to k4, of theta^3 to theta^9 |
//! | `pinhole` | `radtan`, `none` | fx, fy, cx, cy | k1, k2, p1, p2 |
//! | `omni` | `radtan`, `none` | xi, fx, fy, cx, cy | k1, k2, p1, p2 |
//! | `ds` | `none` | xi, alpha, fx, fy, cx, cy | none |
//! | `eucm` | `none` | alpha, beta, fx, fy, cx, cy | none |
//!
//! The place of a camera comes from `T_cam_imu` or `T_imu_cam` of both, or from `T_cn_cnm1` along the chain. A line
//! `%YAML:1.0`, as `OpenCV` writes it, and matrices of `OpenCV` are accepted. Cameras that are not asked for may be of
//! any model.

use crate::image_file::one_line;
use crate::input;
use compass_core::vision::camera::{Rig, View};
use nalgebra::Matrix4;
use serde_saphyr::NonFiniteFloatPolicy;
use std::path::{Path, PathBuf};

mod basalt;
mod camera;
mod camera_info;
mod choice;
mod error;
mod kalibr;
mod lens;
mod node;
mod transform;

pub use camera::CalibratedCamera;
pub use choice::CameraNames;
pub use error::CalibrationError;
pub use lens::core_camera;

use camera::{Entry, alone, relative};
use error::Refusal;
use lens::MAX_SIDE;
use node::Node;

/// The file of [`Calibration::nominal`].
pub const NOMINAL_YAML: &str = include_str!("calibration/nominal.yaml");

/// The contents of a calibration file: two of its cameras in the roles of cam0 and cam1.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The file.
    pub path: PathBuf,
    /// Names of the cameras in the file; `None` for a role without one.
    pub names: [Option<String>; 2],
    /// The cameras; `None` for one that is not in the file, or whose fields are invalid.
    pub cameras: [Option<CalibratedCamera>; 2],
    /// `rostopic` of `imu0`: topic of its readings in a ROS bag.
    pub imu_topic: Option<String>,
    /// Why a camera of the file cannot be used.
    refused: [Option<Refusal>; 2],
    /// From the second camera's axes to the first one's.
    place: Result<Matrix4<f64>, Refusal>,
}

impl Calibration {
    /// An invented rig, for use without a calibration: two Kannala-Brandt fisheyes of about 190 degrees and 736 x 720
    /// pixels, back to back, 38 mm apart.
    ///
    /// # Panics
    /// Never: the embedded file is valid, as a test checks.
    #[must_use]
    pub fn nominal() -> Self {
        let bytes = NOMINAL_YAML.as_bytes().to_vec();
        Self::parse(Path::new("nominal.yaml"), bytes, &CameraNames::default()).expect("tested")
    }

    /// Reads a calibration file: its cameras `cam0` and `cam1`.
    ///
    /// # Errors
    /// As [`Self::load_cameras`].
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        Self::load_cameras(path, &CameraNames::default())
    }

    /// Reads a calibration file: the named cameras.
    ///
    /// # Errors
    /// [`CalibrationError`]: the file cannot be read or is of another kind, it has none of the cameras, or none that is
    /// valid. A camera whose fields are invalid beside a valid one is refused by [`Self::rig`], when it is asked for.
    pub fn load_cameras(path: &Path, names: &CameraNames) -> Result<Self, CalibrationError> {
        let bytes = input::read(path, input::limits().settings_bytes)
            .map_err(|source| CalibrationError::Read { path: path.to_path_buf(), source })?;
        Self::parse(path, bytes, names)
    }

    fn parse(path: &Path, bytes: Vec<u8>, names: &CameraNames) -> Result<Self, CalibrationError> {
        let form = |reason: String| CalibrationError::Form { path: path.to_path_buf(), reason };
        let text =
            String::from_utf8(bytes).map_err(|_| form("not a calibration: not UTF-8 text".to_owned()))?;
        // A number that is not finite is named with its field.
        let options = serde_saphyr::options! { non_finite_float_policy: NonFiniteFloatPolicy::PassThrough };
        let root: Node =
            serde_saphyr::from_str_with_options(&without_directive(&text), options).map_err(|error| {
                form(format!("not valid YAML: {}", one_line(&error.without_snippet().to_string())))
            })?;
        let entries = entries(&root).map_err(form)?;
        let mut slots = [None; 2];
        for (slot, name) in slots.iter_mut().zip(&names.0) {
            *slot = name.as_ref().and_then(|name| entries.iter().position(|entry| entry.name == *name));
        }
        if slots == [None; 2] {
            let asked: Vec<_> = names.0.iter().flatten().map(String::as_str).collect();
            let there: Vec<_> = entries.iter().map(|entry| entry.name.as_str()).collect();
            let reason = format!("has no {}, but {}", asked.join(" and no "), there.join(", "));
            return Err(form(reason));
        }
        let refused = slots.map(|slot| entries[slot?].camera.as_ref().err().cloned());
        let cameras = slots.map(|slot| entries[slot?].camera.as_ref().ok().cloned());
        if let ([None, None], Some(refusal)) = (&cameras, refused.iter().flatten().next()) {
            return Err(refusal.clone().within(path.to_path_buf()));
        }
        let place = match slots {
            [Some(first), Some(second)] => relative(&entries, first, second),
            [None, Some(only)] => alone(&entries[only]),
            _ => Ok(Matrix4::identity()),
        };
        let imu_topic = kalibr::imu_topic(&root);
        Ok(Self { path: path.to_path_buf(), names: names.0.clone(), cameras, imu_topic, refused, place })
    }

    /// Checks that no camera of the file is refused, for callers that take all of them.
    ///
    /// # Errors
    /// The field of a camera that is invalid.
    pub fn all_valid(&self) -> Result<(), CalibrationError> {
        match self.refused.iter().flatten().next() {
            Some(refusal) => Err(refusal.clone().within(self.path.clone())),
            None => Ok(()),
        }
    }

    /// Whether the file has a camera in a role, whether or not it is valid.
    #[must_use]
    pub fn is_in_file(&self, number: usize) -> bool {
        self.cameras.get(number).is_some_and(Option::is_some)
            || self.refused.get(number).is_some_and(Option::is_some)
    }

    /// Whether both cameras are valid and it is known where they are.
    #[must_use]
    pub fn places_both(&self) -> bool {
        self.cameras.iter().all(Option::is_some) && self.place.is_ok()
    }

    /// The name of the camera in a role.
    #[must_use]
    pub fn name(&self, number: usize) -> &str {
        let role = if number == 0 { "cam0" } else { "cam1" };
        self.names.get(number).and_then(Option::as_deref).unwrap_or(role)
    }

    /// The rig for images of these sizes (width, height); `None` for a camera that is not used.
    ///
    /// # Errors
    /// A camera that is not in the file or invalid, an image of another aspect ratio than the calibrated one, or a cam1
    /// without extrinsics in the file.
    pub fn rig(&self, sizes: [Option<(u32, u32)>; 2]) -> Result<Rig, CalibrationError> {
        let [front, back] = sizes;
        let front = front.map(|size| self.view(0, size)).transpose()?;
        let mut back = back.map(|size| self.view(1, size)).transpose()?;
        if let Some(view) = &mut back {
            let place = self.place_of_cam1()?;
            view.rotation = transform::rotation(&place).cast();
            view.position = transform::translation(&place).cast();
        }
        let refused = |source| CalibrationError::Rig { path: self.path.clone(), source };
        Rig::new([front, back]).map_err(refused)
    }

    fn wrong(&self, number: usize, field: &str, problem: impl Into<String>) -> CalibrationError {
        Refusal::new(field, problem).of(self.name(number)).within(self.path.clone())
    }

    /// A single camera in the role of cam0, for an image of this size.
    fn view(&self, number: usize, size: (u32, u32)) -> Result<View, CalibrationError> {
        if let Some(refusal) = &self.refused[number] {
            return Err(refusal.clone().within(self.path.clone()));
        }
        let Some(calibrated) = &self.cameras[number] else {
            return Err(self.wrong(number, "", "this camera is asked for, but not in the file"));
        };
        let (width, height) = size;
        if !calibrated.has_shape_of(size) {
            let turned = calibrated.has_shape_of((height, width));
            return Err(CalibrationError::Shape {
                path: self.path.clone(),
                camera: self.name(number).to_owned(),
                calibrated: calibrated.resolution,
                image: size,
                hint: if turned { "; are width and height swapped?" } else { "" },
            });
        }
        let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
        let Some((width, height)) = sides.filter(|&(width, height)| width > 0 && height > 0) else {
            let problem =
                format!("the image has {width} x {height} pixels; each side must be 1 to {MAX_SIDE}");
            return Err(self.wrong(number, "", problem));
        };
        let core = calibrated.core(size);
        let camera = core.map_err(|error| self.wrong(number, "intrinsics", error.to_string()))?;
        Ok(View::new(camera, width, height))
    }

    /// The transform from cam1's axes to cam0's.
    fn place_of_cam1(&self) -> Result<Matrix4<f64>, CalibrationError> {
        self.place.clone().map_err(|refusal| refusal.within(self.path.clone()))
    }
}

/// The cameras of a file of any known form; else what it is.
fn entries(root: &Node) -> Result<Vec<Entry>, String> {
    if root.entries().iter().any(|(key, _)| kalibr::is_camera(key)) {
        return Ok(kalibr::entries(root));
    }
    if root.get(basalt::ROOT).is_some() {
        return Ok(basalt::entries(root)).and_then(|found| {
            if found.is_empty() { Err("value0.intrinsics: no camera in it".to_owned()) } else { Ok(found) }
        });
    }
    if camera_info::is_one(root) {
        return Ok(vec![camera_info::entry(root)]);
    }
    let looks_like = if root.get("model_type").is_some() {
        "this looks like a camera file of VINS (camodocal), which is not read; "
    } else if root.get("sensor_type").is_some() || root.get("T_BS").is_some() {
        "this looks like a sensor.yaml of EuRoC, which is not read; "
    } else if root.get("image").is_some() && root.get("resolution").is_some() {
        "this looks like a map of map_server; "
    } else {
        ""
    };
    Err(format!(
        "not a calibration: {looks_like}expected cam0, cam1, ... of Kalibr or OpenVINS, value0 of Basalt, or a \
         camera_info of ROS"
    ))
}

/// The text with its `%YAML` line blanked, which `OpenCV` writes with a colon that is invalid in YAML; comments may
/// stand before it. Line numbers are unchanged.
fn without_directive(text: &str) -> String {
    let text = text.trim_start_matches('\u{feff}');
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.starts_with("%YAML") {
            let end = at + line.trim_end_matches(['\r', '\n']).len();
            return format!("{}{}", &text[..at], &text[end..]);
        }
        if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
            break;
        }
        at += line.len();
    }
    text.to_owned()
}

#[cfg(test)]
mod tests;
