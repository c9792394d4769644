//! The load-bearing part of a plan: what stands on a building site before the fit-out.
//!
//! Plans of a finished building show partitions and interior glazing that do not exist in the shell. This module keeps
//! walls at least as thick as a bound, found by morphological opening with a square of that side, and the glazing of
//! the facade: within [`FACADE_M`] of the outside that [`interior`] finds.
//!
//! A wall at 45 degrees must be 1.4 times as thick to hold the square. Cost: four sweeps over the bits, 64 pixels in a
//! word and log2 of the side steps each, and the interior of the plan.

use super::PlanRaster;
use super::bits::Bits;
use crate::interior::{self, InteriorError, InteriorOptions, Places};
use compass_core::base::raster::BitMask;
use thiserror::Error;

/// Default thickness of the thinnest load-bearing wall, metres.
pub const DEFAULT_THICKNESS_M: f64 = 0.25;
/// Glazing within this distance of the outside belongs to the facade, metres.
pub const FACADE_M: f64 = 0.8;
/// Thickest bound accepted, in metres.
pub const MOST_THICKNESS_M: f64 = 5.0;

/// Why a plan has no load-bearing part.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum StructureError {
    /// The bound is out of range.
    #[error("structure thicker than {0} m was asked for, expected above 0 and at most {MOST_THICKNESS_M}")]
    Thickness(f64),
    /// No wall is that thick.
    #[error("no wall is {0} m thick")]
    NoWalls(f64),
    /// The facade cannot be determined.
    #[error(transparent)]
    Interior(#[from] InteriorError),
}

/// Keeps walls at least `thickness_m` thick, and the glazing of the facade.
///
/// # Errors
/// [`StructureError`]: a bound out of range, a plan without interior, or no wall as thick as the bound.
pub fn keep_structure(raster: &PlanRaster, thickness_m: f64) -> Result<PlanRaster, StructureError> {
    keep_structure_inside(raster, thickness_m, &Places::default())
}

/// [`keep_structure`] of a plan whose inside is at `places`, if they name any: what else is connected with the edge of
/// the plan is outdoors, and glazing beside it belongs to the facade.
///
/// # Errors
/// As [`keep_structure`], and a place that cannot be inside.
pub fn keep_structure_inside(
    raster: &PlanRaster,
    thickness_m: f64,
    places: &Places,
) -> Result<PlanRaster, StructureError> {
    if !(thickness_m > 0.0 && thickness_m <= MOST_THICKNESS_M) {
        return Err(StructureError::Thickness(thickness_m));
    }
    let (walls, windows) = (raster.walls_mask(), raster.windows_mask());
    let options = InteriorOptions::with_places(places.clone(), raster.origin);
    let found = interior::find(&walls, &windows, raster.resolution_m, &options)?;
    let side = (thickness_m / raster.resolution_m).round().max(1.0) as usize;
    let mut bits = Bits::new(&raster.walls, raster.width, raster.height);
    bits.open(side);
    let mut kept = PlanRaster { walls: bits.to_bytes(), ..raster.clone() };
    if kept.walls.iter().all(|&byte| byte == 0) {
        return Err(StructureError::NoWalls(thickness_m));
    }
    let near = found.near_outside(FACADE_M);
    keep_pixels(&mut kept, |x, y| found.cell(x, y).is_some_and(|cell| near[cell]));
    Ok(kept)
}

/// Clears the glazing that is not selected.
fn keep_pixels(raster: &mut PlanRaster, keep: impl Fn(u32, u32) -> bool) {
    let row_bytes = BitMask::row_bytes(raster.width);
    for (y, row) in (0..).zip(raster.windows.chunks_exact_mut(row_bytes)) {
        for (column, byte) in (0..).zip(row).filter(|(_, byte)| **byte != 0) {
            let kept = (0..8).filter(|bit| keep(8 * column + bit, y)).fold(0, |kept, bit| kept | 1_u8 << bit);
            *byte &= kept;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 10 m x 8 m at 0.1 m a pixel with outer walls of 0.3 m, a partition of 0.1 m, and glazing in both.
    fn shell() -> PlanRaster {
        let mut raster = PlanRaster::empty(120, 100, 0.1, [0.0; 2]);
        for (x, y) in (10..90).flat_map(|y| (10..110).map(move |x| (x, y))) {
            if !(13..107).contains(&x) || !(13..87).contains(&y) || x == 60 {
                raster.set_wall(x, y);
            }
        }
        (30..40).for_each(|y| raster.set_window(60, y));
        (30..50).for_each(|x| (10..13).for_each(|y| raster.set_window(x, y)));
        raster
    }

    #[test]
    fn partitions_and_their_glazing_go() {
        let (plan, kept) = (shell(), keep_structure(&shell(), DEFAULT_THICKNESS_M).unwrap());
        assert!(plan.is_wall(60, 20) && plan.is_window(60, 35));
        assert!((14..86).all(|y| !kept.occupied(60, y)));
        assert!((30..50).all(|x| kept.is_window(x, 11)), "glazing of the facade stays");
        assert!((13..87).all(|y| kept.is_wall(11, y) && kept.is_wall(108, y)));
    }

    #[test]
    fn bounds_out_of_reach_are_refused() {
        for thickness in [0.0, -1.0, f64::NAN, 6.0] {
            let refused = keep_structure(&shell(), thickness).unwrap_err();
            assert!(matches!(refused, StructureError::Thickness(_)), "{refused}");
        }
        assert_eq!(keep_structure(&shell(), 1.0).unwrap_err(), StructureError::NoWalls(1.0));
    }
}
