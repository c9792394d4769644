//! Finds the free places of a floor plan that lie inside the building.
//!
//! A plan shows walls and windows, not which side of them is indoors, and its outline is seldom closed: doors stand
//! open, a garage has no gate. Candidate positions must cover every room and none of the street, so this module closes
//! the outline and checks the closure twice:
//!
//! 1. **Opening by a disc.** The plan is reduced to cells of about [`CELL_M`]. The outside is every
//!    place that a disc as wide as the bridged gap, rolled in from beyond the plan, can cover.
//! 2. **Enclosure.** From a place indoors nearly every ray has a hit; in a yard or in front of a facade many leave the
//!    plan. Of 64 rays, [`MIN_ENCLOSURE`] must have a hit.
//! 3. **Ladder.** The gap is the smallest of [`GAP_LADDER_M`] whose interior has at least
//!    [`ENOUGH`] of the area of the free cells that are enclosed by [`WELL_ENCLOSED`].
//! 4. **Pieces.** Connected pieces below [`MIN_PIECE_M2`] (ducts, hollow piers) are dropped, and those
//!    of which less than half is enclosed by [`WELL_ENCLOSED`]: outer corners that the disc cannot fill.
//!
//! Where this finds nothing, or something else than meant, the user says where the inside is: [`Places`].
//!
//! A walled passage narrower than the bridged gap counts as inside: nothing in the plan distinguishes it from a
//! corridor.
//!
//! Cost: one pass over the pixels, then linear in the cells; the test `real_plans` prints timings.

mod candidates;
mod enclosure;
mod grid;
mod outside;
mod places;
#[cfg(test)]
mod tests;

pub use places::{MIN_PLACE_M2, Places, PlacesError};

use compass_core::base::raster::BitMask;
use enclosure::RAYS;
use grid::Grid;
use places::Ground;

/// Target side of a cell in metres; a cell is a whole number of pixels.
pub const CELL_M: f64 = 0.08;
/// Gaps tried in turn, in metres: cracks, a door, a double door, a gate, a vehicle opening.
pub const GAP_LADDER_M: [f64; 5] = [0.5, 1.5, 3.0, 6.0, 12.0];
/// Least share of the rays of an inside place that have a hit.
pub const MIN_ENCLOSURE: f64 = 0.6;
/// Share of the rays above which a place is expected to be inside.
pub const WELL_ENCLOSED: f64 = 0.9;
/// Share of the well enclosed area that the interior must have for the ladder to stop.
pub const ENOUGH: f64 = 0.8;
/// Smallest connected piece of interior in square metres.
pub const MIN_PIECE_M2: f64 = 1.0;
/// Default distance of a candidate from anything occupied, in metres.
pub const CLEARANCE_M: f64 = 0.2;

/// Widest gap that [`InteriorOptions::max_gap_m`] may ask to bridge, in metres.
const WIDEST_GAP_M: f64 = 100.0;
/// Most cells along a side; larger plans get larger cells.
const MAX_CELLS: u32 = 8192;

/// Options of [`find`].
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct InteriorOptions {
    /// Widest opening of the outline to bridge, in metres; `None` tries [`GAP_LADDER_M`] in turn.
    pub max_gap_m: Option<f64>,
    /// What is inside, in map metres; if anything is named here, nothing else is inside.
    pub places: Places,
    /// Map position in metres of the outer corner of pixel (0, 0); it matters to the places alone.
    pub origin: [f64; 2],
}

impl InteriorOptions {
    /// Options that bridge openings up to `max_gap_m` metres, without the ladder.
    #[must_use]
    pub const fn with_max_gap_m(max_gap_m: f64) -> Self {
        Self {
            max_gap_m: Some(max_gap_m),
            places: Places { points: Vec::new(), regions: Vec::new() },
            origin: [0.0; 2],
        }
    }

    /// Options with the inside at these places of the map, on a plan whose pixel (0, 0) has its outer corner at `origin`.
    #[must_use]
    pub const fn with_places(places: Places, origin: [f64; 2]) -> Self {
        Self { max_gap_m: None, places, origin }
    }
}

/// Why the interior or its candidates could not be found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InteriorError {
    /// No place is inside.
    #[error(
        "plan has no interior: no free place of {MIN_PIECE_M2} m2 is enclosed (gaps up to {max_gap_m} m bridged); \
         say where it is with --inside X,Y or --region X0,Y0,X1,Y1"
    )]
    NoInterior {
        /// The widest bridged gap.
        max_gap_m: f64,
    },
    /// Walls, windows and interior are of different sizes.
    #[error("walls and windows differ in size: {0} x {1} and {2} x {3} pixels")]
    Size(u32, u32, u32, u32),
    /// Metres per pixel is not a positive number.
    #[error("resolution is {0} m per pixel, expected a positive number")]
    Resolution(f64),
    /// The gap is not a positive number of metres, or too wide.
    #[error("gap to bridge is {0} m, expected above 0 and at most {WIDEST_GAP_M}")]
    Gap(f64),
    /// The candidate spacing is below one pixel or not finite.
    #[error("candidate spacing is {0} m, expected at least one pixel")]
    Spacing(f64),
    /// The candidate clearance is negative or not finite.
    #[error("candidate clearance is {0} m, expected a number from 0")]
    Clearance(f64),
    /// A place that the options name cannot be inside.
    #[error(transparent)]
    Places(#[from] PlacesError),
}

/// The inside of a plan, on a grid of cells.
///
/// Cells that hold an occupied pixel are not inside.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Interior {
    /// Pixels along a side of a cell.
    pub cell_px: u32,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Row by row from the south: whether the cell is inside.
    pub inside: Vec<bool>,
    /// Squared distance of every cell to the nearest occupied one, in cells; 0 is occupied.
    distance2: Vec<i32>,
    width_px: u32,
    height_px: u32,
    resolution_m: f64,
    max_gap_m: f64,
}

impl Interior {
    /// Whether pixel `x`, `y` (row 0 southernmost) lies in an inside cell; false off the plan.
    #[must_use]
    pub fn is_inside_px(&self, x: u32, y: u32) -> bool {
        self.cell_of(x, y).is_some_and(|cell| self.inside[cell])
    }

    /// Area of the inside cells in square metres.
    ///
    /// It excludes the cells along walls, so it is below the net floor area by about half a cell per metre of wall.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let side = f64::from(self.cell_px) * self.resolution_m;
        self.inside.iter().filter(|&&inside| inside).count() as f64 * side * side
    }

    /// Widest bridged opening, in metres; 0 where none had to be.
    #[must_use]
    pub const fn max_gap_m(&self) -> f64 {
        self.max_gap_m
    }

    /// Index of the cell of a pixel on the plan.
    fn cell_of(&self, x: u32, y: u32) -> Option<usize> {
        let on_plan = x < self.width_px && y < self.height_px;
        on_plan.then(|| (y / self.cell_px) as usize * self.columns + (x / self.cell_px) as usize)
    }
}

/// Finds the inside of a plan (for the method see the [module](self)).
///
/// `resolution_m` is metres per pixel. Anything set in either mask is occupied; beyond the masks
/// everything is outside.
///
/// # Errors
/// [`InteriorError::NoInterior`] when nothing is enclosed; [`InteriorError::Places`] for a place that cannot be
/// inside; [`InteriorError::Size`], [`InteriorError::Resolution`] and [`InteriorError::Gap`] for unusable input.
pub fn find(
    walls: &BitMask<'_>,
    windows: &BitMask<'_>,
    resolution_m: f64,
    options: &InteriorOptions,
) -> Result<Interior, InteriorError> {
    check_same_size(walls, windows)?;
    if !(resolution_m.is_finite() && resolution_m > 0.0) {
        return Err(InteriorError::Resolution(resolution_m));
    }
    let asked = options.max_gap_m;
    if let Some(gap) = asked.filter(|gap| !(*gap > 0.0 && *gap <= WIDEST_GAP_M)) {
        return Err(InteriorError::Gap(gap));
    }
    let ladder = asked.as_ref().map_or(&GAP_LADDER_M[..], core::slice::from_ref);
    let cell_px = cell_px(walls, resolution_m);
    let cell_m = f64::from(cell_px) * resolution_m;
    let widest = ladder.iter().copied().fold(0.0, f64::max);
    let margin = (widest / 2.0 / cell_m).ceil() as usize + 2;

    let grid = Grid::new(walls, windows, cell_px, margin);
    let distance2 = grid.distance2(&grid.occupied);
    let (inside, max_gap_m) = if options.places.is_empty() {
        enclosed(&grid, &distance2, ladder, cell_m)?
    } else {
        let plan = plan_on_map(walls, resolution_m, options.origin);
        Ground { grid: &grid, distance2: &distance2, cell_m, plan }.inside(&options.places, ladder)?
    };
    let (columns, rows) = grid.plan_size();
    Ok(Interior {
        cell_px,
        columns,
        rows,
        inside: grid.without_margin(&inside),
        distance2: grid.without_margin(&distance2),
        width_px: walls.width(),
        height_px: walls.height(),
        resolution_m,
        max_gap_m,
    })
}

/// Lowest x, lowest y, highest x, highest y of a plan in map metres.
fn plan_on_map(mask: &BitMask<'_>, resolution_m: f64, [x, y]: [f64; 2]) -> [f64; 4] {
    let [width, height] = [mask.width(), mask.height()].map(|side| f64::from(side) * resolution_m);
    [x, y, x + width, y + height]
}

/// The inside cells by the enclosure that the plan shows, and the bridged gap in metres.
fn enclosed(
    grid: &Grid,
    distance2: &[i32],
    ladder: &[f64],
    cell_m: f64,
) -> Result<(Vec<bool>, f64), InteriorError> {
    let hits = enclosure::hits(grid);
    let (mut inside, max_gap_m) = climb(grid, distance2, &hits, ladder, cell_m);
    let least = (MIN_PIECE_M2 / (cell_m * cell_m)).ceil() as usize;
    grid.drop_pieces(&mut inside, least, |at| f64::from(hits[at]) >= WELL_ENCLOSED * f64::from(RAYS));
    if inside.contains(&true) {
        Ok((inside, max_gap_m))
    } else {
        Err(InteriorError::NoInterior { max_gap_m })
    }
}

/// The inside cells for the first gap of the ladder that leaves enough of them, and that gap.
fn climb(grid: &Grid, distance2: &[i32], hits: &[u8], ladder: &[f64], cell_m: f64) -> (Vec<bool>, f64) {
    let rays = f64::from(RAYS);
    let enclosed = |share: f64| move |&(&hits, &d): &(&u8, &i32)| d > 0 && f64::from(hits) >= share * rays;
    let cells = || hits.iter().zip(distance2);
    let wanted = ENOUGH * cells().filter(enclosed(WELL_ENCLOSED)).count() as f64;
    let (mut inside, mut used) = (vec![false; hits.len()], 0.0);
    for &gap in ladder {
        let outside = grid.outside(distance2, gap / 2.0 / cell_m);
        for ((inside, cell), outside) in inside.iter_mut().zip(cells()).zip(outside) {
            *inside = !outside && enclosed(MIN_ENCLOSURE)(&cell);
        }
        used = gap;
        let found = inside.iter().filter(|&&inside| inside).count();
        if found > 0 && found as f64 >= wanted {
            break;
        }
    }
    (inside, used)
}

/// Pixels along a side of a cell.
fn cell_px(mask: &BitMask<'_>, resolution_m: f64) -> u32 {
    let side = mask.width().max(mask.height());
    let wanted = (CELL_M / resolution_m).round().clamp(1.0, f64::from(side)) as u32;
    wanted.max(side.div_ceil(MAX_CELLS))
}

/// Both masks must be of one size.
fn check_same_size(a: &BitMask<'_>, b: &BitMask<'_>) -> Result<(), InteriorError> {
    if (a.width(), a.height()) == (b.width(), b.height()) {
        Ok(())
    } else {
        Err(InteriorError::Size(a.width(), a.height(), b.width(), b.height()))
    }
}
