//! Cameras, frames, poses and scans as the header has them.

use crate::failure::Failure;
use crate::prior::CompassHeights;
use compass_core::base::num::Metres;
use compass_core::map::site::MAX_NAME_BYTES;
use compass_core::pose::FloorLayer;
use compass_core::{
    BitMask, Camera, CameraError, DoubleSphere, Estimate, Eucm, ExclusionMask, Fix, Frame, GrayImage,
    Intrinsics, KannalaBrandt, LocateError, Motion, Nats, Omni, Radtan, Scan, ScoredPose, View,
};
use core::ffi::c_char;
use core::{fmt, slice};

/// Directions of a scan: direction j looks along heading + j degrees, counter-clockwise.
pub const COMPASS_BINS: usize = 360;
/// Millimetres in a step of a range.
pub const COMPASS_STEP_MM: u32 = 20;
/// Most poses of a fix: the best and its alternatives.
pub const COMPASS_MAX_POSES: usize = 10;
/// Most layers of floors: a floor of a site has one or two, the plan as drawn and its structure.
pub const COMPASS_MAX_LAYERS: usize = 16;
/// Most pixels of an image.
pub const COMPASS_MAX_PIXELS: u32 = 67_108_864;
/// Bytes of a floor's name with the zero behind it, UTF-8.
pub const COMPASS_NAME_BYTES: usize = 24;

const _: () = assert!(COMPASS_BINS == compass_core::base::num::BINS);
const _: () = assert!(COMPASS_STEP_MM == compass_core::base::scan::STEP_MM);
const _: () = assert!(COMPASS_MAX_POSES == compass_core::base::pose::MAX_ALTERNATIVES);
const _: () = assert!(COMPASS_NAME_BYTES == MAX_NAME_BYTES + 1);
const _: () = assert!(Nats::FRAC_NBITS == 4 && Metres::FRAC_NBITS == 32, "as the comments say");

/// The formula of a lens.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompassLensModel {
    /// Kannala and Brandt: "equidistant" in Kalibr, "fisheye" in OpenCV.
    KannalaBrandt = 1,
    /// Enhanced unified camera model: "eucm" in Kalibr.
    Eucm = 2,
    /// Double sphere model: "ds" in Kalibr.
    DoubleSphere = 3,
    /// Unified omnidirectional model with distortion: "omni" with "radtan" or "none" in Kalibr; with xi 0 its "pinhole" with
    /// these.
    Omni = 4,
}

/// A model as C gives it: any number. The header calls it `CompassLensModel`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct AnyLensModel(pub(crate) i32);

/// Parameters of COMPASS_LENS_MODEL_KANNALA_BRANDT.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassKannalaBrandt {
    /// Coefficients k1 to k4.
    pub k: [f32; 4],
}

/// Parameters of COMPASS_LENS_MODEL_EUCM.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassEucm {
    /// Share of the sphere in the model, 0 to 1.
    pub alpha: f32,
    /// Squared ratio of the ellipsoid's axes, above 0.
    pub beta: f32,
}

/// Parameters of COMPASS_LENS_MODEL_DOUBLE_SPHERE.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassDoubleSphere {
    /// Distance of the two centres, above -1, at most 1.
    pub xi: f32,
    /// Share of the second sphere in the model, 0 to 1.
    pub alpha: f32,
}

/// Parameters of COMPASS_LENS_MODEL_OMNI.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassOmni {
    /// Distance of the sphere's centre from that of the projection, from 0 up: 0 is a pinhole.
    pub xi: f32,
    /// Radial coefficients k1 to k3, of the radius to the powers of 2, 4 and 6; Kalibr has no k3.
    pub k: [f32; 3],
    /// Tangential coefficients p1 and p2.
    pub p: [f32; 2],
}

/// Parameters of the lens: those of its model.
#[repr(C)]
#[derive(Clone, Copy)]
pub union CompassLensParameters {
    /// Of COMPASS_LENS_MODEL_KANNALA_BRANDT.
    pub kannala_brandt: CompassKannalaBrandt,
    /// Of COMPASS_LENS_MODEL_EUCM.
    pub eucm: CompassEucm,
    /// Of COMPASS_LENS_MODEL_DOUBLE_SPHERE.
    pub double_sphere: CompassDoubleSphere,
    /// Of COMPASS_LENS_MODEL_OMNI.
    pub omni: CompassOmni,
}

impl fmt::Debug for CompassLensParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CompassLensParameters").finish_non_exhaustive()
    }
}

/// A lens; the centre of the top left pixel is (0, 0).
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassLens {
    /// Which of the parameters hold.
    pub model: AnyLensModel,
    /// Focal length along x, pixels.
    pub fx: f32,
    /// Focal length along y, pixels.
    pub fy: f32,
    /// Principal point along x, pixels.
    pub cx: f32,
    /// Principal point along y, pixels.
    pub cy: f32,
    /// Parameters of the model.
    pub parameters: CompassLensParameters,
}

/// A fisheye camera. Axes are x right, y down, z forward.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassCamera {
    /// Its lens.
    pub lens: CompassLens,
    /// Pixels along x.
    pub width: u16,
    /// Pixels along y.
    pub height: u16,
    /// Turns bearings of this camera into bearings of camera 0, row by row: the identity for camera 0.
    pub rotation: [f32; 9],
    /// Where this camera is in the axes of camera 0, metres: zeros for camera 0.
    pub position_m: [f32; 3],
}

/// Departure from the identity that rounding explains.
const ROUNDED: f32 = 1e-4;

impl CompassCamera {
    /// The camera of this number.
    ///
    /// # Errors
    /// Failures of [`CompassStatus::Camera`](crate::CompassStatus::Camera). The rig checks size and rotation.
    pub(crate) fn view(&self, number: u8) -> Result<View, Failure> {
        if u32::from(self.width) * u32::from(self.height) > COMPASS_MAX_PIXELS {
            return Err(Failure::Pixels { camera: number });
        }
        if number == 0 && !self.is_at_the_origin() {
            return Err(Failure::FirstCamera);
        }
        let mut view = View::new(self.lens.camera(number)?, self.width, self.height);
        view.rotation.copy_from_slice(&self.rotation);
        view.rotation.transpose_mut();
        [view.position.x, view.position.y, view.position.z] = self.position_m;
        Ok(view)
    }

    fn is_at_the_origin(&self) -> bool {
        const IDENTITY: [f32; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let near = |value: &f32, expected: &f32| (value - expected).abs() <= ROUNDED;
        self.rotation.iter().zip(&IDENTITY).all(|(value, expected)| near(value, expected))
            && self.position_m.iter().all(|value| *value == 0.0)
    }
}

impl CompassLens {
    fn camera(&self, number: u8) -> Result<Camera, Failure> {
        const KANNALA_BRANDT: i32 = CompassLensModel::KannalaBrandt as i32;
        const EUCM: i32 = CompassLensModel::Eucm as i32;
        const DOUBLE_SPHERE: i32 = CompassLensModel::DoubleSphere as i32;
        const OMNI: i32 = CompassLensModel::Omni as i32;
        let Self { fx, fy, cx, cy, parameters, .. } = *self;
        let intrinsics = Intrinsics { fx, fy, cx, cy };
        let camera: Result<Camera, CameraError> = match self.model.0 {
            KANNALA_BRANDT => {
                // SAFETY: floats, of which all bits are numbers; the model says that the caller set these.
                let CompassKannalaBrandt { k } = unsafe { parameters.kannala_brandt };
                KannalaBrandt::new(intrinsics, k).map(Camera::KannalaBrandt)
            }
            EUCM => {
                // SAFETY: as before.
                let CompassEucm { alpha, beta } = unsafe { parameters.eucm };
                Eucm::new(intrinsics, alpha, beta).map(Camera::Eucm)
            }
            DOUBLE_SPHERE => {
                // SAFETY: as before.
                let CompassDoubleSphere { xi, alpha } = unsafe { parameters.double_sphere };
                DoubleSphere::new(intrinsics, xi, alpha).map(Camera::DoubleSphere)
            }
            OMNI => {
                // SAFETY: as before.
                let CompassOmni { xi, k: [k1, k2, k3], p: [p1, p2] } = unsafe { parameters.omni };
                Omni::new(intrinsics, xi, Radtan { k1, k2, p1, p2, k3 }).map(Camera::Omni)
            }
            _ => return Err(Failure::Model(number)),
        };
        camera.map_err(|error| Failure::Camera(number, error))
    }
}

/// What a camera saw.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassFrame {
    /// Gray levels, row by row without gaps.
    pub gray: *const u8,
    /// Bytes of them: width times height.
    pub gray_bytes: usize,
    /// Exclusion mask, one bit a pixel, set where the image says nothing of the building (the robot's own parts in front of a
    /// window): rows of (width + 7) / 8 bytes, the first pixel in the lowest bit. Null if nothing is to be left out.
    pub excluded: *const u8,
    /// Bytes of it: rows times height; 0 without a mask.
    pub excluded_bytes: usize,
    /// Pixels along x: that of the camera.
    pub width: u16,
    /// Pixels along y: that of the camera.
    pub height: u16,
}

impl CompassFrame {
    /// The frame of this camera, which has this view in the rig, borrowed from the caller.
    ///
    /// # Errors
    /// [`LocateError::Camera`], [`LocateError::Size`], [`Failure::Null`], [`Failure::FrameBytes`].
    ///
    /// # Safety
    /// Pointers that are not null point to as many bytes as the fields beside them say, for the lifetime of the answer.
    pub(crate) unsafe fn borrow<'f>(&self, camera: u8, view: Option<&View>) -> Result<Frame<'f>, Failure> {
        let view = view.ok_or(LocateError::Camera { camera, missing: false })?;
        let [expected, found] =
            [[view.width, view.height], [self.width, self.height]].map(|size| size.map(u32::from));
        let size = LocateError::Size { camera, expected, found };
        if found != expected {
            return Err(size.into());
        }
        if self.gray.is_null() {
            return Err(Failure::Null("frame.gray"));
        }
        let [width, height] = found;
        let check = |part, expected: usize, found: usize| {
            if found == expected {
                Ok(())
            } else {
                Err(Failure::FrameBytes { camera, part, expected, found })
            }
        };
        check("gray levels", width as usize * height as usize, self.gray_bytes)?;
        // SAFETY: not null, the caller vouches for the length, and a camera has at most COMPASS_MAX_PIXELS.
        let gray = unsafe { slice::from_raw_parts(self.gray, self.gray_bytes) };
        let gray = GrayImage::new(gray, width, height).map_err(|_| size)?;
        if self.excluded.is_null() {
            check("exclusion mask", 0, self.excluded_bytes)?;
            return Ok(gray.into());
        }
        check("exclusion mask", BitMask::row_bytes(width) * height as usize, self.excluded_bytes)?;
        // SAFETY: as before.
        let excluded = unsafe { slice::from_raw_parts(self.excluded, self.excluded_bytes) };
        let excluded = BitMask::new(excluded, width, height).map_err(|_| size)?;
        Ok(Frame { gray, excluded: ExclusionMask::Mask(excluded) })
    }
}

/// Range and hit type all around.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassScan {
    /// Ranges in steps of COMPASS_STEP_MM, 1 to 1500.
    pub steps: [u16; COMPASS_BINS],
    /// What is there: 0 nothing within 30 m, 1 glazing, 2 a wall.
    pub hit: [u8; COMPASS_BINS],
}

impl From<&Scan> for CompassScan {
    fn from(scan: &Scan) -> Self {
        Self { steps: scan.steps, hit: scan.hit.map(|hit| hit as u8) }
    }
}

/// A pose on a floor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassPose {
    /// Map coordinate in 1/2^32 m: see compass_metres.
    pub x: i64,
    /// Map coordinate in 1/2^32 m: see compass_metres.
    pub y: i64,
    /// Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x: see compass_degrees.
    pub heading: u32,
    /// Log-likelihood ratio against "nothing known", 1/16 nat.
    pub score: i32,
    /// Number of the floor, in the order in which the sites have them and were added.
    pub floor: u8,
    /// Which layer of the floor fits best: 0 the plan as drawn, 1 its structure alone.
    pub layer: u8,
    /// Name of the floor, with a zero behind it.
    pub floor_name: [c_char; COMPASS_NAME_BYTES],
}

impl CompassPose {
    const NONE: Self =
        Self { x: 0, y: 0, heading: 0, score: 0, floor: 0, layer: 0, floor_name: [0; COMPASS_NAME_BYTES] };

    /// A pose on one of the layers.
    pub(crate) fn new(scored: &ScoredPose, layers: &[Option<FloorLayer<'_>>]) -> Self {
        let [x, y] = [scored.at.x, scored.at.y].map(Metres::to_bits);
        let (heading, score) = (scored.heading.to_bits(), scored.score.to_bits());
        let pose = Self { x, y, heading, score, ..Self::NONE };
        let Some(Some(layer)) = layers.get(usize::from(scored.layer)) else { return pose };
        let mut floor_name = [0; COMPASS_NAME_BYTES];
        // The last place stays zero.
        let (places, _) = floor_name.split_at_mut(MAX_NAME_BYTES);
        places.iter_mut().zip(layer.name.bytes()).for_each(|(place, byte)| *place = byte as c_char);
        Self { floor: layer.floor, layer: layer.number, floor_name, ..pose }
    }
}

/// Where the cameras are.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassFix {
    /// The best pose and its alternatives, best first.
    pub poses: [CompassPose; COMPASS_MAX_POSES],
    /// Of each pose the covariance of its error if it is right, of x, y and heading, row by row: m2, m rad and rad2.
    pub covariances: [[f32; 9]; COMPASS_MAX_POSES],
    /// Number of poses; 0 if none was found.
    pub count: u32,
    /// Probability that the best is within 1 m of the true one, 0 to 1.
    pub probability: f32,
    /// Height of the cameras above the floor, metres, to 3 %: that given, or that found.
    pub camera_height_m: f32,
    /// Height of the ceiling above the floor, metres, to 3 % of the part above the cameras.
    pub ceiling_height_m: f32,
    /// Both as the search counts them: for the next prior.
    pub heights: CompassHeights,
}

impl CompassFix {
    pub(crate) const NONE: Self = Self {
        poses: [CompassPose::NONE; COMPASS_MAX_POSES],
        covariances: [[0.0; 9]; COMPASS_MAX_POSES],
        count: 0,
        probability: 0.0,
        camera_height_m: 0.0,
        ceiling_height_m: 0.0,
        heights: CompassHeights { camera: 0, ceiling: 0 },
    };

    pub(crate) fn new(fix: &Fix<'_>, layers: &[Option<FloorLayer<'_>>]) -> Self {
        let mut poses = [CompassPose::NONE; COMPASS_MAX_POSES];
        poses.iter_mut().zip(fix.poses()).for_each(|(pose, scored)| *pose = CompassPose::new(scored, layers));
        let mut covariances = [[0.0; 9]; COMPASS_MAX_POSES];
        for (values, covariance) in covariances.iter_mut().zip(fix.covariances()) {
            values.iter_mut().zip(covariance.rows().as_flattened()).for_each(|(value, new)| *value = *new);
        }
        let [camera, ceiling] = fix.heights().to_rungs();
        Self {
            poses,
            covariances,
            count: fix.poses().len().min(COMPASS_MAX_POSES) as u32,
            probability: fix.probability(),
            camera_height_m: fix.camera_height_m(),
            ceiling_height_m: fix.ceiling_height_m(),
            heights: CompassHeights { camera, ceiling },
        }
    }
}

/// How the cameras moved since the frames that were tracked before, in the level axes they had then: forward is where
/// camera 0 looked.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassMotion {
    /// Metres.
    pub forward_m: f32,
    /// Metres.
    pub left_m: f32,
    /// Radians, counter-clockwise.
    pub turn: f32,
}

impl CompassMotion {
    /// # Errors
    /// [`Failure::Motion`].
    pub(crate) fn check(&self) -> Result<Motion, Failure> {
        let Self { forward_m, left_m, turn } = *self;
        if [forward_m, left_m, turn].iter().all(|value| value.is_finite()) {
            Ok(Motion { forward_m, left_m, turn })
        } else {
            Err(Failure::Motion("the motion is infinite or not a number"))
        }
    }
}

/// What is believed after a sequence of frames.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CompassEstimate {
    /// The likeliest pose.
    pub pose: CompassPose,
    /// Its probability among the poses that are believed possible, 0 to 1; 0 if there is none.
    pub probability: f32,
    /// Root mean square distance of the possible poses on its floor from it, metres.
    pub spread_m: f32,
}

impl CompassEstimate {
    pub(crate) const NONE: Self = Self { pose: CompassPose::NONE, probability: 0.0, spread_m: 0.0 };

    pub(crate) fn new(estimate: &Estimate, layers: &[Option<FloorLayer<'_>>]) -> Self {
        let Estimate { pose, probability, spread_m } = *estimate;
        Self { pose: CompassPose::new(&pose, layers), probability, spread_m }
    }
}
