//! Ray march by uniform steps (paper: 360 rays, step 0.02 m, `r_max` 30 m).

use compass_core::base::raster::BitMask;
use compass_core::base::scan::Hit;

/// March step in metres.
pub const STEP_M: f64 = 0.02;
/// Largest range in metres.
pub const R_MAX_M: f64 = 30.0;

/// A plan as one byte per cell; row 0 is the southernmost.
#[derive(Debug, Clone)]
pub struct Plan {
    cells: Vec<u8>,
    width: usize,
    height: usize,
    resolution_m: f64,
    origin: [f64; 2],
}

/// Range and hit type of 360 rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Metres to the first hit, 30 without one.
    pub range_m: [f64; 360],
    /// The hit type.
    pub hit: [Hit; 360],
}

impl Plan {
    /// Unpacks two masks; a cell in both is a wall.
    #[must_use]
    pub fn new(walls: &BitMask<'_>, windows: &BitMask<'_>, resolution_m: f64, origin: [f64; 2]) -> Self {
        let (width, height) = (walls.width(), walls.height());
        let cell = |x, y| match (walls.get(x, y), windows.get(x, y)) {
            (true, _) => 2,
            (false, true) => 1,
            (false, false) => 0,
        };
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| cell(x, y))).collect();
        Self { cells, width: width as usize, height: height as usize, resolution_m, origin }
    }

    /// What is at a point in metres; `None` outside the plan.
    #[must_use]
    pub fn hit_at(&self, x: f64, y: f64) -> Option<Hit> {
        let column = ((x - self.origin[0]) / self.resolution_m).floor();
        let row = ((y - self.origin[1]) / self.resolution_m).floor();
        if column < 0.0 || row < 0.0 || column >= self.width as f64 || row >= self.height as f64 {
            return None;
        }
        Some(match self.cells[row as usize * self.width + column as usize] {
            2 => Hit::Wall,
            1 => Hit::Window,
            _ => Hit::Open,
        })
    }

    /// Casts 360 rays; `None` when the position is outside the plan or occupied.
    #[must_use]
    pub fn scan(&self, x: f64, y: f64, heading_deg: f64) -> Option<Scan> {
        if self.hit_at(x, y) != Some(Hit::Open) {
            return None;
        }
        let mut scan = Scan { range_m: [R_MAX_M; 360], hit: [Hit::Open; 360] };
        for bin in 0..360 {
            let theta = (heading_deg + bin as f64).to_radians();
            (scan.range_m[bin], scan.hit[bin]) = self.ray(x, y, theta.cos(), theta.sin());
        }
        Some(scan)
    }

    fn ray(&self, x: f64, y: f64, cos: f64, sin: f64) -> (f64, Hit) {
        let samples = (R_MAX_M / STEP_M).round() as u32;
        for k in 1..=samples {
            let r = f64::from(k) * STEP_M;
            match self.hit_at(x + r * cos, y + r * sin) {
                None => break,
                Some(Hit::Open) => {}
                Some(hit) => return (r, hit),
            }
        }
        (R_MAX_M, Hit::Open)
    }
}
