//! A window as it is found.

use crate::base::num::LogOdds;
use crate::vision::panorama::{Resolution, TOP_DEG};
use bytemuck::{Pod, Zeroable};

/// A window in the panorama.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub struct Window {
    /// First column and the one after the last, clockwise; the latter may exceed the number of columns.
    pub columns: [u16; 2],
    /// First row and the one after the last, downwards.
    pub rows: [u16; 2],
    /// Log odds that the box is a window.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub score: LogOdds,
    /// Number of the camera whose axis is nearest to its middle.
    pub camera: u16,
}

impl Window {
    /// Initial value of buffers.
    pub const EMPTY: Self = Self { columns: [0; 2], rows: [0; 2], score: LogOdds::ZERO, camera: 0 };

    /// Azimuths of the right and the left edge, degrees counter-clockwise from the heading; the first in -180 to 180.
    ///
    /// ```
    /// use compass_core::vision::panorama::Resolution;
    /// use compass_core::vision::windows::Window;
    ///
    /// let window = Window { columns: [340, 380], rows: [50, 70], ..Window::EMPTY };
    /// assert_eq!(window.azimuth_deg(Resolution::COARSE), [-10.0, 10.0]);
    /// ```
    #[must_use]
    pub fn azimuth_deg(&self, resolution: Resolution) -> [f32; 2] {
        let [left, right] = self.columns.map(|c| 180.0 - f32::from(c) / resolution.per_degree() as f32);
        let turn = if right < -180.0 { 360.0 } else { 0.0 };
        [right + turn, left + turn]
    }

    /// Elevations of sill and lintel, degrees.
    ///
    /// ```
    /// use compass_core::vision::panorama::Resolution;
    /// use compass_core::vision::windows::Window;
    ///
    /// let window = Window { columns: [340, 380], rows: [50, 70], ..Window::EMPTY };
    /// assert_eq!(window.elevation_deg(Resolution::COARSE), [0.0, 10.0]);
    /// ```
    #[must_use]
    pub fn elevation_deg(&self, resolution: Resolution) -> [f32; 2] {
        let [top, bottom] = self.rows.map(|r| TOP_DEG as f32 - f32::from(r) / resolution.per_degree() as f32);
        [bottom, top]
    }
}
