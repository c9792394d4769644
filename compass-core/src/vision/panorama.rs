//! Geometry of the panorama of both cameras: extent and cell size.

use crate::base::num::index_of;
use crate::vision::camera::View;

/// Elevation of the upper border of row 0, degrees.
pub const TOP_DEG: i32 = 35;
/// Elevation of the lower border of the last row, degrees.
pub const BOTTOM_DEG: i32 = -30;

/// Resolution of a panorama: 2 or 4 cells per degree of azimuth and of elevation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Resolution(PerDegree);

/// The possible values: an enum, so that the compiler knows that divisors are not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum PerDegree {
    Two = 2,
    Four = 4,
}

impl Resolution {
    /// 4 cells per degree: for images of 3 pixels per degree and more.
    pub const FINE: Self = Self(PerDegree::Four);
    /// 2 cells per degree: for images below 3 pixels per degree.
    pub const COARSE: Self = Self(PerDegree::Two);

    /// The resolution for a view, by its pixels per degree on the optical axis.
    ///
    /// ```
    /// # use compass_core::vision::camera::Equidistant;
    /// # use compass_core::{Camera, CameraError, Intrinsics, View};
    /// use compass_core::vision::panorama::Resolution;
    ///
    /// let intrinsics = Intrinsics { fx: 116.0, fy: 116.0, cx: 183.5, cy: 179.5 };
    /// let view = View::new(Camera::Equidistant(Equidistant::new(intrinsics)?), 368, 360);
    /// assert_eq!(Resolution::of(&view), Resolution::COARSE, "2 pixels per degree");
    /// assert_eq!((Resolution::COARSE.columns(), Resolution::COARSE.rows()), (720, 130));
    /// # Ok::<(), CameraError>(())
    /// ```
    #[must_use]
    pub fn of(view: &View) -> Self {
        if pixels_per_degree(view) < 3.0 { Self::COARSE } else { Self::FINE }
    }

    /// Cells per degree.
    #[must_use]
    pub const fn per_degree(self) -> usize {
        self.0 as usize
    }

    /// [`per_degree`](Self::per_degree) as `i32`.
    pub(crate) const fn per_degree_i32(self) -> i32 {
        self.0 as i32
    }

    /// The row whose upper border has an elevation in degrees, at most [`TOP_DEG`].
    pub(crate) const fn row_of(self, elevation: i32) -> usize {
        index_of(TOP_DEG - elevation) * self.per_degree()
    }

    /// Number of columns: azimuth.
    #[must_use]
    pub const fn columns(self) -> usize {
        360 * self.per_degree()
    }

    /// Number of rows: elevation.
    #[must_use]
    pub const fn rows(self) -> usize {
        (TOP_DEG - BOTTOM_DEG) as usize * self.per_degree()
    }

    /// Number of cells.
    #[must_use]
    pub const fn cells(self) -> usize {
        self.columns() * self.rows()
    }
}

/// Pixels per degree on the optical axis of a view.
pub(super) fn pixels_per_degree(view: &View) -> f32 {
    view.camera.intrinsics().fx * (core::f32::consts::PI / 180.0)
}
