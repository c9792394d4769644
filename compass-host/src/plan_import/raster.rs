//! A plan as two masks.

use compass_core::base::raster::BitMask;

/// Walls and glazing of a plan as two disjoint masks in the layout of [`BitMask`].
///
/// Row 0 is the southernmost row. The fields are public for callers that store or compare them; a caller that changes
/// one must keep the others consistent.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanRaster {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Wall pixels: rows of whole bytes, least significant bit first, south row first.
    pub walls: Vec<u8>,
    /// Glazing pixels, in the same layout; no pixel is in both.
    pub windows: Vec<u8>,
    /// Metres per pixel.
    pub resolution_m: f64,
    /// Map position in metres of the outer corner of pixel (0, 0).
    pub origin: [f64; 2],
}

impl PlanRaster {
    /// A plan without walls or glazing; [`Self::set_wall`] and [`Self::set_window`] draw into it.
    #[must_use]
    pub fn empty(width: u32, height: u32, resolution_m: f64, origin: [f64; 2]) -> Self {
        let bytes = BitMask::row_bytes(width) * height as usize;
        Self { width, height, walls: vec![0; bytes], windows: vec![0; bytes], resolution_m, origin }
    }

    /// The walls as a mask of the core.
    ///
    /// # Panics
    /// When the fields were changed inconsistently, or [`Self::empty`] was given a side of 0
    /// or above [`MAX_SIDE`](compass_core::base::raster::MAX_SIDE); never for what [`load`](super::load) returns.
    #[must_use]
    pub fn walls_mask(&self) -> BitMask<'_> {
        self.mask(&self.walls)
    }

    /// The glazing as a mask of the core.
    ///
    /// # Panics
    /// When the fields were changed inconsistently, or [`Self::empty`] was given a side of 0
    /// or above [`MAX_SIDE`](compass_core::base::raster::MAX_SIDE); never for what [`load`](super::load) returns.
    #[must_use]
    pub fn windows_mask(&self) -> BitMask<'_> {
        self.mask(&self.windows)
    }

    /// Whether pixel (x, y) is wall; outside the plan it is not.
    #[must_use]
    pub fn is_wall(&self, x: u32, y: u32) -> bool {
        self.bit(x, y).is_some_and(|(at, bit)| self.walls.get(at).is_some_and(|byte| byte & bit != 0))
    }

    /// Whether pixel (x, y) is glazing; outside the plan it is not.
    #[must_use]
    pub fn is_window(&self, x: u32, y: u32) -> bool {
        self.bit(x, y).is_some_and(|(at, bit)| self.windows.get(at).is_some_and(|byte| byte & bit != 0))
    }

    /// Whether pixel (x, y) is wall or glazing.
    #[must_use]
    pub fn occupied(&self, x: u32, y: u32) -> bool {
        self.is_wall(x, y) || self.is_window(x, y)
    }

    /// Makes pixel (x, y) wall and no longer glazing; outside the plan nothing happens.
    pub fn set_wall(&mut self, x: u32, y: u32) {
        let at = self.bit(x, y);
        put(&mut self.walls, &mut self.windows, at);
    }

    /// Makes pixel (x, y) glazing and no longer wall; outside the plan nothing happens.
    pub fn set_window(&mut self, x: u32, y: u32) {
        let at = self.bit(x, y);
        put(&mut self.windows, &mut self.walls, at);
    }

    /// Makes pixel (x, y) neither wall nor glazing; outside the plan nothing happens.
    pub(super) fn set_free(&mut self, x: u32, y: u32) {
        if let Some((at, bit)) = self.bit(x, y) {
            self.walls[at] &= !bit;
            self.windows[at] &= !bit;
        }
    }

    /// Makes the glazing of `other`, a plan of the same size, glazing here, over walls.
    pub(super) fn glaze(&mut self, other: &Self) {
        let here = self.walls.iter_mut().zip(&mut self.windows);
        for ((walls, windows), other) in here.zip(&other.windows) {
            *windows |= other;
            *walls &= !other;
        }
    }

    /// Makes the walls of `other`, a plan of the same size, walls here, over glazing.
    pub(super) fn wall_up(&mut self, other: &Self) {
        let here = self.walls.iter_mut().zip(&mut self.windows);
        for ((walls, windows), other) in here.zip(&other.walls) {
            *walls |= other;
            *windows &= !other;
        }
    }

    /// Nanometres per pixel, rounded to nearest; a resolution outside `u32` saturates, NaN is 0.
    #[must_use]
    pub fn resolution_nm(&self) -> u32 {
        // A float-to-integer `as` saturates; the value is already whole.
        (self.resolution_m * 1e9).round() as u32
    }

    fn bit(&self, x: u32, y: u32) -> Option<(usize, u8)> {
        let inside = x < self.width && y < self.height;
        inside.then(|| (y as usize * BitMask::row_bytes(self.width) + x as usize / 8, 1 << (x % 8)))
    }

    fn mask<'a>(&self, bits: &'a [u8]) -> BitMask<'a> {
        let (width, height) = (self.width, self.height);
        match BitMask::new(bits, width, height) {
            Ok(mask) => mask,
            Err(error) => panic!("plan of {width} x {height} pixels in {} bytes: {error}", bits.len()),
        }
    }
}

fn put(mask: &mut [u8], other: &mut [u8], at: Option<(usize, u8)>) {
    let Some((at, bit)) = at else { return };
    if let Some(byte) = mask.get_mut(at) {
        *byte |= bit;
    }
    if let Some(byte) = other.get_mut(at) {
        *byte &= !bit;
    }
}
