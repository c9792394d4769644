//! Camera calibrations as Kalibr writes them (`camchain.yaml`, `camchain-imucam.yaml`).
//!
//! | `camera_model` | `distortion_model` | `intrinsics` | `distortion_coeffs` |
//! |---|---|---|---|
//! | `pinhole` | `equidistant` | fx, fy, cx, cy | k1 to k4, of theta^3 to theta^9 |
//! | `eucm` | `none` | alpha, beta, fx, fy, cx, cy | none |
//!
//! Cameras `cam0` and `cam1` are read, and `rostopic` of `imu0`; anything else is ignored. The extrinsics of cam1 come
//! from `T_cam_imu` of both, or from `T_cn_cnm1` of cam1. A first line `%YAML:1.0`, as `OpenCV` writes it, is
//! accepted.

use std::path::{Path, PathBuf};

use compass_core::vision::camera::{CameraError, Eucm, Intrinsics, KannalaBrandt, Rig, View};
use nalgebra::{Matrix3, Matrix4, Vector3};
use serde::Deserialize;
use thiserror::Error;

use crate::image_file::one_line;
use crate::reference::camera::{Camera, Model};

/// Largest deviation of a rotation in the file from orthonormal: allows for values rounded to three decimals.
const ORTHONORMAL: f64 = 2e-3;

/// Largest difference of the two sources of cam1's extrinsics, in metres and as elements of a rotation.
const AGREEING: f64 = 2e-3;

/// A first coefficient within this of 1 is the linear one, which Kalibr omits.
const LEADING_ONE: f64 = 0.1;

/// Longest side of an image in pixels.
const MAX_SIDE: u32 = 65_535;

/// The file of [`Calibration::nominal`].
pub const NOMINAL_YAML: &str = include_str!("calibration/nominal.yaml");

/// Why a calibration could not be read or used: one line that names the file at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not YAML of the expected form.
    #[error("{}: not a Kalibr camera chain: {reason}", path.display())]
    Yaml {
        /// The file.
        path: PathBuf,
        /// The parser's message, in one line.
        reason: String,
    },
    /// A field is missing or invalid.
    #[error("{}: {field}: {problem}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field, such as `cam0.intrinsics`.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The image has another aspect ratio than the calibrated one.
    #[error(
        "{}: cam{camera} is calibrated for {} x {} pixels, the image has {} x {}: not the same shape{hint}",
        path.display(), calibrated.0, calibrated.1, image.0, image.1
    )]
    Shape {
        /// The file.
        path: PathBuf,
        /// Index of the camera: 0 or 1.
        camera: usize,
        /// Width and height in the file.
        calibrated: (u32, u32),
        /// Width and height of the image.
        image: (u32, u32),
        /// A hint at the cause, or empty.
        hint: &'static str,
    },
    /// The core rejected the rig.
    #[error("{}: {source}", path.display())]
    Rig {
        /// The file.
        path: PathBuf,
        /// The core's error.
        source: CameraError,
    },
}

/// One camera of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedCamera {
    /// Lens and intrinsics for images of the calibrated size.
    pub camera: Camera,
    /// Width and height of the calibrated image, pixels.
    pub resolution: (u32, u32),
    /// `T_cam_imu`: transforms points from the IMU's axes to the camera's, metres.
    pub from_imu: Option<Matrix4<f64>>,
    /// `T_cn_cnm1`: transforms points from the previous camera's axes to this one's, metres.
    pub from_previous: Option<Matrix4<f64>>,
    /// `timeshift_cam_imu`: seconds to add to the image's time to get the IMU's; 0 when absent.
    pub timeshift_s: f64,
    /// `rostopic`: topic of its images in a ROS bag.
    pub topic: Option<String>,
}

impl CalibratedCamera {
    /// The core's camera for an image of this size.
    ///
    /// # Errors
    /// Parameters that the core rejects.
    pub fn core(
        &self,
        (width, height): (u32, u32),
    ) -> Result<compass_core::vision::camera::Camera, CameraError> {
        let (calibrated_width, calibrated_height) = self.resolution;
        let (sx, sy) = (ratio(width, calibrated_width), ratio(height, calibrated_height));
        core_camera(&self.camera.scaled(sx, sy))
    }

    /// Whether an image of this size can be the calibrated one resized, sides rounded to pixels.
    fn has_shape_of(&self, (width, height): (u32, u32)) -> bool {
        let range = |side: u32, calibrated: u32| {
            let (side, calibrated) = (f64::from(side), f64::from(calibrated));
            ((side - 0.5) / calibrated, (side + 0.5) / calibrated)
        };
        let (x, y) = (range(width, self.resolution.0), range(height, self.resolution.1));
        x.0 <= y.1 && y.0 <= x.1
    }
}

/// The core's camera from the reference's.
///
/// # Errors
/// Parameters that the core rejects.
pub fn core_camera(camera: &Camera) -> Result<compass_core::vision::camera::Camera, CameraError> {
    use compass_core::vision::camera::{Camera as Core, Equidistant};
    let ([fx, fy], [cx, cy]) = (camera.focal, camera.centre);
    let i = Intrinsics { fx: fx as f32, fy: fy as f32, cx: cx as f32, cy: cy as f32 };
    Ok(match camera.model {
        Model::KannalaBrandt(k) => Core::KannalaBrandt(KannalaBrandt::new(i, k.map(|k| k as f32))?),
        Model::Eucm { alpha, beta } => Core::Eucm(Eucm::new(i, alpha as f32, beta as f32)?),
        Model::Equidistant => Core::Equidistant(Equidistant::new(i)?),
    })
}

fn ratio(a: u32, b: u32) -> f64 {
    f64::from(a) / f64::from(b)
}

/// The contents of a calibration file.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The file.
    pub path: PathBuf,
    /// cam0 and cam1; `None` for one that is not in the file.
    pub cameras: [Option<CalibratedCamera>; 2],
    /// `rostopic` of `imu0`: topic of its readings in a ROS bag. Kalibr itself writes it into another file.
    pub imu_topic: Option<String>,
}

impl Calibration {
    /// An invented rig, for use without a calibration: two Kannala-Brandt fisheyes of about 190 degrees and 736 x 720
    /// pixels, back to back, 38 mm apart.
    ///
    /// # Panics
    /// Never: the embedded file is valid, as a test checks.
    #[must_use]
    pub fn nominal() -> Self {
        Self::parse(Path::new("nominal.yaml"), NOMINAL_YAML.as_bytes().to_vec()).expect("tested")
    }

    /// Reads and checks a calibration file.
    ///
    /// # Errors
    /// [`CalibrationError`]: the file cannot be read, is not a camera chain, or a field is missing or invalid.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let bytes = std::fs::read(path)
            .map_err(|source| CalibrationError::Read { path: path.to_path_buf(), source })?;
        Self::parse(path, bytes)
    }

    fn parse(path: &Path, bytes: Vec<u8>) -> Result<Self, CalibrationError> {
        let yaml = |reason: String| CalibrationError::Yaml { path: path.to_path_buf(), reason };
        let text = String::from_utf8(bytes).map_err(|_| yaml("not UTF-8 text".to_owned()))?;
        let chain: Chain = serde_saphyr::from_str(&without_directive(&text))
            .map_err(|error| yaml(one_line(&error.without_snippet().to_string())))?;
        if chain.cam0.is_none() && chain.cam1.is_none() {
            return Err(yaml("neither cam0 nor cam1 is there".to_owned()));
        }
        let read = |number: usize, fields: Option<Fields>| {
            fields.map(|fields| Entry { path, number }.camera(fields)).transpose()
        };
        Ok(Self {
            path: path.to_path_buf(),
            cameras: [read(0, chain.cam0)?, read(1, chain.cam1)?],
            imu_topic: chain.imu0.and_then(|imu| imu.rostopic),
        })
    }

    /// The rig for images of these sizes (width, height); `None` for a camera that is not used.
    ///
    /// # Errors
    /// A camera that is not in the file, an image of another aspect ratio than the calibrated one, or a cam1 without
    /// extrinsics in the file.
    pub fn rig(&self, sizes: [Option<(u32, u32)>; 2]) -> Result<Rig, CalibrationError> {
        let [front, back] = sizes;
        let front = front.map(|size| self.view(0, size)).transpose()?;
        let mut back = back.map(|size| self.view(1, size)).transpose()?;
        if let Some(view) = &mut back {
            let place = self.place_of_cam1()?;
            view.rotation = rotation(&place).cast();
            view.position = translation(&place).cast();
        }
        let refused = |source| CalibrationError::Rig { path: self.path.clone(), source };
        Rig::new([front, back]).map_err(refused)
    }

    /// A single camera in the role of cam0, for an image of this size.
    fn view(&self, number: usize, size: (u32, u32)) -> Result<View, CalibrationError> {
        let entry = Entry { path: &self.path, number };
        let Some(calibrated) = &self.cameras[number] else {
            return Err(entry.wrong("", "this camera is asked for, but not in the file"));
        };
        let (width, height) = size;
        if !calibrated.has_shape_of(size) {
            let turned = calibrated.has_shape_of((height, width));
            return Err(CalibrationError::Shape {
                path: self.path.clone(),
                camera: number,
                calibrated: calibrated.resolution,
                image: size,
                hint: if turned { "; are width and height swapped?" } else { "" },
            });
        }
        let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
        let Some((width, height)) = sides.filter(|&(width, height)| width > 0 && height > 0) else {
            let problem =
                format!("the image has {width} x {height} pixels; each side must be 1 to {MAX_SIDE}");
            return Err(entry.wrong("", problem));
        };
        let camera = calibrated.core(size).map_err(|error| entry.wrong("intrinsics", error.to_string()))?;
        Ok(View::new(camera, width, height))
    }

    /// The transform from cam1's axes to cam0's.
    fn place_of_cam1(&self) -> Result<Matrix4<f64>, CalibrationError> {
        let [cam0, cam1] = self.cameras.each_ref();
        let imu = |camera: Option<&CalibratedCamera>| camera.and_then(|camera| camera.from_imu);
        let by_imu = imu(cam0.as_ref()).zip(imu(cam1.as_ref())).map(|(t0, t1)| t0 * inverse(&t1));
        let direct = cam1.as_ref().and_then(|camera| camera.from_previous).map(|t| inverse(&t));
        let entry = Entry { path: &self.path, number: 1 };
        match (by_imu, direct) {
            (Some(a), Some(b)) if (a - b).amax() > AGREEING => {
                let problem = format!(
                    "disagrees with T_cam_imu of cam0 and cam1 (by up to {:.4} in an element)",
                    (a - b).amax()
                );
                Err(entry.wrong("T_cn_cnm1", problem))
            }
            (Some(place), _) | (None, Some(place)) => Ok(place),
            (None, None) => Err(entry.wrong(
                "T_cn_cnm1",
                "missing, and T_cam_imu is not given for both cameras: where cam1 is remains open",
            )),
        }
    }
}

fn rotation(t: &Matrix4<f64>) -> Matrix3<f64> {
    t.fixed_view::<3, 3>(0, 0).into_owned()
}

fn translation(t: &Matrix4<f64>) -> Vector3<f64> {
    t.fixed_view::<3, 1>(0, 3).into_owned()
}

fn rigid(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Matrix4<f64> {
    let mut t = rotation.to_homogeneous();
    t.fixed_view_mut::<3, 1>(0, 3).copy_from(translation);
    t
}

fn inverse(t: &Matrix4<f64>) -> Matrix4<f64> {
    let back = rotation(t).transpose();
    rigid(&back, &-(back * translation(t)))
}

/// The text with its `%YAML` line blanked, which `OpenCV` writes with a colon that is invalid in YAML; line numbers
/// are unchanged.
fn without_directive(text: &str) -> String {
    let text = text.trim_start_matches('\u{feff}');
    match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("%YAML") => format!("\n{rest}"),
        _ => text.to_owned(),
    }
}

#[derive(Deserialize)]
struct Chain {
    cam0: Option<Fields>,
    cam1: Option<Fields>,
    imu0: Option<Imu>,
}

#[derive(Deserialize)]
struct Imu {
    rostopic: Option<String>,
}

/// One camera as written; errors about missing fields name the camera.
#[derive(Deserialize)]
struct Fields {
    camera_model: Option<String>,
    distortion_model: Option<String>,
    intrinsics: Option<Vec<f64>>,
    distortion_coeffs: Option<Vec<f64>>,
    resolution: Option<Vec<i64>>,
    #[serde(rename = "T_cam_imu")]
    from_imu: Option<Vec<Vec<f64>>>,
    #[serde(rename = "T_cn_cnm1")]
    from_previous: Option<Vec<Vec<f64>>>,
    timeshift_cam_imu: Option<f64>,
    rostopic: Option<String>,
}

/// The origin of a value, for its errors.
#[derive(Clone, Copy)]
struct Entry<'a> {
    path: &'a Path,
    number: usize,
}

impl Entry<'_> {
    fn wrong(&self, field: &str, problem: impl Into<String>) -> CalibrationError {
        let dot = if field.is_empty() { "" } else { "." };
        CalibrationError::Field {
            path: self.path.to_path_buf(),
            field: format!("cam{}{dot}{field}", self.number),
            problem: problem.into(),
        }
    }

    fn needed<T>(&self, field: &str, value: Option<T>) -> Result<T, CalibrationError> {
        value.ok_or_else(|| self.wrong(field, "missing"))
    }

    fn camera(&self, fields: Fields) -> Result<CalibratedCamera, CalibrationError> {
        let resolution = self.resolution(fields.resolution.as_deref())?;
        let (model, pinhole) = self.model(&fields)?;
        let camera = self.lens(model, pinhole)?;
        self.check_centre(&camera, resolution)?;
        let transform =
            |field, rows: Option<Vec<Vec<f64>>>| rows.map(|rows| self.transform(field, &rows)).transpose();
        let timeshift_s = fields.timeshift_cam_imu.unwrap_or(0.0);
        if !timeshift_s.is_finite() {
            return Err(self.wrong("timeshift_cam_imu", format!("{timeshift_s} is no number of seconds")));
        }
        Ok(CalibratedCamera {
            camera,
            resolution,
            from_imu: transform("T_cam_imu", fields.from_imu)?,
            from_previous: transform("T_cn_cnm1", fields.from_previous)?,
            timeshift_s,
            topic: fields.rostopic,
        })
    }

    fn resolution(&self, resolution: Option<&[i64]>) -> Result<(u32, u32), CalibrationError> {
        let sides = self.needed("resolution", resolution)?;
        let side = |value: i64| u32::try_from(value).ok().filter(|side| (1..=MAX_SIDE).contains(side));
        if let [width, height] = *sides
            && let Some(sides) = side(width).zip(side(height))
        {
            return Ok(sides);
        }
        let problem = format!("is {sides:?}; [width, height] of 1 to {MAX_SIDE} pixels is needed");
        Err(self.wrong("resolution", problem))
    }

    /// The lens and fx, fy, cx, cy.
    fn model(&self, fields: &Fields) -> Result<(Model, [f64; 4]), CalibrationError> {
        let camera_model = self.needed("camera_model", fields.camera_model.as_deref())?;
        let distortion_model = fields.distortion_model.as_deref();
        let coefficients = fields.distortion_coeffs.as_deref();
        match camera_model {
            "pinhole" => {
                let distortion_model = self.needed("distortion_model", distortion_model)?;
                if distortion_model != "equidistant" {
                    let problem =
                        format!("'{distortion_model}' is not supported with pinhole, only equidistant");
                    return Err(self.wrong("distortion_model", problem));
                }
                let k = self.coefficients(coefficients)?;
                Ok((Model::KannalaBrandt(k), self.intrinsics(fields, "fx, fy, cx, cy")?))
            }
            "eucm" => {
                if !matches!(distortion_model, None | Some("none"))
                    || coefficients.is_some_and(|c| !c.is_empty())
                {
                    return Err(self.wrong("distortion_model", "eucm takes none, and no coefficients"));
                }
                let [alpha, beta, fx, fy, cx, cy] = self.intrinsics(fields, "alpha, beta, fx, fy, cx, cy")?;
                Ok((Model::Eucm { alpha, beta }, [fx, fy, cx, cy]))
            }
            other => {
                let problem =
                    format!("'{other}' is not supported, only pinhole with equidistant distortion, and eucm");
                Err(self.wrong("camera_model", problem))
            }
        }
    }

    /// The intrinsics, as many as there are `names`.
    fn intrinsics<const N: usize>(&self, fields: &Fields, names: &str) -> Result<[f64; N], CalibrationError> {
        let values = self.needed("intrinsics", fields.intrinsics.as_deref())?;
        self.check_finite("intrinsics", values)?;
        values.try_into().map_err(|_| {
            self.wrong("intrinsics", format!("has {} values; [{names}] are needed", values.len()))
        })
    }

    fn coefficients(&self, values: Option<&[f64]>) -> Result<[f64; 4], CalibrationError> {
        const FIELD: &str = "distortion_coeffs";
        let values = self.needed(FIELD, values)?;
        self.check_finite(FIELD, values)?;
        if values.first().is_some_and(|first| (first - 1.0).abs() < LEADING_ONE) {
            let problem = format!(
                "starts with {}, the coefficient of theta, which is 1 and must be left out: \
                 [k1, k2, k3, k4] belong to theta^3, theta^5, theta^7 and theta^9",
                values[0]
            );
            return Err(self.wrong(FIELD, problem));
        }
        values.try_into().map_err(|_| {
            let problem = format!(
                "has {} values; four are needed, [k1, k2, k3, k4] of theta^3, theta^5, theta^7 and theta^9 \
                 (where others count k1 to k5, k1 belongs to theta, is 1 and must be left out)",
                values.len()
            );
            self.wrong(FIELD, problem)
        })
    }

    fn check_finite(&self, field: &str, values: &[f64]) -> Result<(), CalibrationError> {
        if values.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        Err(self.wrong(field, format!("is {values:?}; finite numbers are needed")))
    }

    /// The lens, if the core supports it.
    fn lens(&self, model: Model, [fx, fy, cx, cy]: [f64; 4]) -> Result<Camera, CalibrationError> {
        let camera = Camera { model, focal: [fx, fy], centre: [cx, cy] };
        core_camera(&camera).map_err(|error| {
            let polynomial = matches!(model, Model::KannalaBrandt(_)) && error == CameraError::Field;
            let field = if polynomial { "distortion_coeffs" } else { "intrinsics" };
            self.wrong(field, format!("{error}"))
        })?;
        Ok(camera)
    }

    fn check_centre(&self, camera: &Camera, (width, height): (u32, u32)) -> Result<(), CalibrationError> {
        let [cx, cy] = camera.centre;
        let within = |c: f64, side: u32| c > -0.5 && c < f64::from(side) - 0.5;
        if within(cx, width) && within(cy, height) {
            return Ok(());
        }
        let turned = within(cx, height) && within(cy, width);
        let (field, hint) =
            if turned { ("resolution", "; are width and height swapped?") } else { ("intrinsics", "") };
        let problem =
            format!("principal point ({cx}, {cy}) lies outside the {width} x {height} pixels{hint}");
        Err(self.wrong(field, problem))
    }

    /// A rigid transform from four rows of four; its rotation is made exactly orthonormal.
    fn transform(&self, field: &str, rows: &[Vec<f64>]) -> Result<Matrix4<f64>, CalibrationError> {
        if rows.len() != 4 || rows.iter().any(|row| row.len() != 4) {
            return Err(self.wrong(field, "is no matrix of four rows of four numbers"));
        }
        rows.iter().try_for_each(|row| self.check_finite(field, row))?;
        let t = Matrix4::from_fn(|row, column| rows[row][column]);
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(self.wrong(field, format!("last row is {:?}; [0, 0, 0, 1] is needed", rows[3])));
        }
        let turn = rotation(&t);
        let off = (turn * turn.transpose() - Matrix3::identity()).amax();
        if off > ORTHONORMAL {
            let problem = format!("is no rotation: its rows are off orthonormal by {off:.4}");
            return Err(self.wrong(field, problem));
        }
        if turn.determinant() < 0.0 {
            return Err(self.wrong(field, "is no rotation: it mirrors"));
        }
        Ok(rigid(&orthonormal(&turn), &translation(&t)))
    }
}

/// The closest rotation, by Newton's iteration for the polar decomposition, from one already near.
fn orthonormal(near: &Matrix3<f64>) -> Matrix3<f64> {
    (0..4).fold(*near, |r, _| 1.5 * r - 0.5 * r * r.transpose() * r)
}

#[cfg(test)]
mod tests;
