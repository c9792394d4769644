//! A rig of one or two rigidly mounted cameras.

use nalgebra::{Matrix3, Vector3};

use super::{Camera, CameraError, finite};

/// Largest absolute error of an element of R R^T - I for a rotation matrix R.
const ORTHONORMAL: f32 = 1e-4;

/// Largest number of cameras of a rig.
pub const CAMERAS: usize = 2;

/// One value per camera of a rig, by camera number.
///
/// An alias, because arrays have `map`, `zip` and patterns that cover both cameras.
pub type PerCamera<T> = [T; CAMERAS];

/// A camera with its image size and its pose in the rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Pixels along x.
    pub width: u16,
    /// Pixels along y.
    pub height: u16,
    /// Rotates bearings of this camera into the axes of camera 0.
    pub rotation: Matrix3<f32>,
    /// Position of this camera in the axes of camera 0, metres.
    pub position: Vector3<f32>,
}

impl View {
    /// A camera at the pose of camera 0.
    #[must_use]
    pub fn new(camera: Camera, width: u16, height: u16) -> Self {
        Self { camera, width, height, rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    fn check(&self) -> Result<(), CameraError> {
        if self.width == 0 || self.height == 0 {
            return Err(CameraError::Size);
        }
        finite(self.position.as_slice())?;
        finite(self.rotation.as_slice())?;
        let off = self.rotation * self.rotation.transpose() - Matrix3::identity();
        let orthonormal = off.iter().all(|value| value.abs() <= ORTHONORMAL);
        let mirrors =
            self.rotation.column(0).cross(&self.rotation.column(1)).dot(&self.rotation.column(2)) <= 0.0;
        if orthonormal && !mirrors { Ok(()) } else { Err(CameraError::Rotation) }
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for View {
    fn format(&self, f: defmt::Formatter<'_>) {
        let (rotation, position) = (self.rotation.as_slice(), self.position.as_slice());
        defmt::write!(
            f,
            "View {{ {}, {} x {}, rotation by columns {}, position {} }}",
            self.camera,
            self.width,
            self.height,
            rotation,
            position
        );
    }
}

/// The cameras of a robot, in the order of their images; one of them may be missing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rig {
    views: PerCamera<Option<View>>,
}

impl Rig {
    /// A rig without a camera: initial value of workspaces.
    pub(crate) const NONE: Self = Self { views: [None; 2] };

    /// A rig of one or two cameras.
    ///
    /// # Errors
    /// [`CameraError::Empty`] without a camera; [`CameraError::Size`], [`CameraError::NotFinite`] and
    /// [`CameraError::Rotation`] for an invalid view.
    ///
    /// ```
    /// # use compass_core::vision::camera::Equidistant;
    /// # use compass_core::{Camera, CameraError, Intrinsics, Rig, View};
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 200, 200);
    /// assert!(Rig::new([None, Some(view)])?.view(0).is_none());
    /// assert_eq!(Rig::new([None, None]), Err(CameraError::Empty));
    /// # Ok::<(), CameraError>(())
    /// ```
    pub fn new(views: PerCamera<Option<View>>) -> Result<Self, CameraError> {
        if views.iter().flatten().count() == 0 {
            return Err(CameraError::Empty);
        }
        views.iter().flatten().try_for_each(View::check)?;
        Ok(Self { views })
    }

    /// The paper's simplified rig: camera 1 is camera 0 rotated by 180 degrees about the vertical (y) axis, both at the
    /// same position. Ignores rotation and position of the two views.
    ///
    /// # Errors
    /// [`CameraError::Size`].
    ///
    /// ```
    /// # use compass_core::vision::camera::Equidistant;
    /// # use compass_core::{Bearing, Camera, CameraError, Intrinsics, Rig, View};
    /// let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 99.5, cy: 99.5 };
    /// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 200, 200);
    /// let back = *Rig::back_to_back(view, view)?.view(1).unwrap();
    /// assert_eq!(back.rotation * Bearing::z(), -Bearing::z());
    /// # Ok::<(), CameraError>(())
    /// ```
    pub fn back_to_back(front: View, back: View) -> Result<Self, CameraError> {
        let turned = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0));
        let front = View::new(front.camera, front.width, front.height);
        let back = View { rotation: turned, ..View::new(back.camera, back.width, back.height) };
        Self::new([Some(front), Some(back)])
    }

    /// The view of camera `number`, 0 or 1, if the rig has it.
    #[must_use]
    pub fn view(&self, number: usize) -> Option<&View> {
        self.views.get(number)?.as_ref()
    }

    /// Camera numbers and views of the cameras present.
    pub fn views(&self) -> impl Iterator<Item = (usize, &View)> {
        self.views.iter().enumerate().filter_map(|(number, view)| Some((number, view.as_ref()?)))
    }
}
