//! The panorama of both cameras: its extent and the size of its cells.

use crate::vision::camera::View;

/// Elevation of the upper border of row 0, degrees.
pub const TOP_DEG: i32 = 35;
/// Elevation of the lower border of the last row, degrees.
pub const BOTTOM_DEG: i32 = -30;

/// Size of a ring's cells: their number in a degree, 2 or 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Resolution(PerDegree);

/// The numbers there can be: whatever is divided by one of them is not divided by 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum PerDegree {
    Two = 2,
    Four = 4,
}

impl Resolution {
    /// Quarters of a degree: for lenses of 4 pixels and more a degree.
    pub const FINE: Self = Self(PerDegree::Four);
    /// Halves of a degree: for lenses of 2 pixels a degree.
    pub const COARSE: Self = Self(PerDegree::Two);

    /// The resolution that does not ask more of a camera than its image holds.
    #[must_use]
    pub fn of(view: &View) -> Self {
        if pixels_per_degree(view) < 3.0 { Self::COARSE } else { Self::FINE }
    }

    /// Cells in a degree.
    #[must_use]
    pub const fn per_degree(self) -> usize {
        self.0 as usize
    }

    /// Columns of a ring.
    #[must_use]
    pub const fn columns(self) -> usize {
        360 * self.per_degree()
    }

    /// Rows of a ring.
    #[must_use]
    pub const fn rows(self) -> usize {
        (TOP_DEG - BOTTOM_DEG) as usize * self.per_degree()
    }

    /// Cells of a ring.
    #[must_use]
    pub const fn cells(self) -> usize {
        self.columns() * self.rows()
    }
}

/// Pixels in a degree at the middle of a view.
pub(super) fn pixels_per_degree(view: &View) -> f32 {
    view.camera.intrinsics().fx * (core::f32::consts::PI / 180.0)
}
