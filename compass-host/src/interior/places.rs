//! Places that the user says are inside, for plans that do not show it: open halls, single rooms, terraces.
//!
//! **Regions** are rectangles. All their free cells are inside, enclosed or not.
//!
//! **Points** stand for all that can be reached from them: the free cells that are 4-connected with the cell of the
//! point. If these reach the edge of the plan, openings of the outline are closed as for the automatic interior: the
//! smallest gap of the ladder whose disc, rolled in from beyond the plan, does not cover the point. Doors between rooms
//! stay open whatever the gap, because the disc does not come from the point. It bulges into the opening that it closes,
//! and what it covers there is not inside: a gate that is nearly as wide as the gap costs as much as half its width.

use super::grid::Grid;

/// Smallest free place around a point, in square metres: less is a duct or a letter.
pub const MIN_PLACE_M2: f64 = 1.0;

/// What the user says is inside, in map metres. Nothing: the plan has to show it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places {
    /// Points `[x, y]`: the free place around each is inside, as far as one can walk.
    pub points: Vec<[f64; 2]>,
    /// Rectangles `[x0, y0, x1, y1]` between opposite corners: their free places are inside, to half a cell.
    pub regions: Vec<[f64; 4]>,
}

impl Places {
    /// Whether nothing is said.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.points.is_empty() && self.regions.is_empty()
    }
}

/// Why a place cannot be inside. Coordinates are map metres.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacesError {
    /// The point is off the plan.
    #[error("inside point {},{} is off the plan, which spans {}", at[0], at[1], span(*plan))]
    PointOffPlan {
        /// The point.
        at: [f64; 2],
        /// The plan: lowest x, lowest y, highest x, highest y.
        plan: [f64; 4],
    },
    /// The point is on something occupied, or in one cell with it.
    #[error("inside point {},{} is on a wall or glazing, or within {cell_m:.2} m of it", at[0], at[1])]
    PointOccupied {
        /// The point.
        at: [f64; 2],
        /// Side of a cell.
        cell_m: f64,
    },
    /// One can walk from the point to the outside, even with the widest opening closed.
    #[error(
        "inside point {},{} is not enclosed: the outside is reached through openings wider than {max_gap_m} m; \
         say with --region X0,Y0,X1,Y1 where candidates are",
        at[0],
        at[1]
    )]
    PointNotEnclosed {
        /// The point.
        at: [f64; 2],
        /// The widest opening that was closed.
        max_gap_m: f64,
    },
    /// The free place around the point is too small.
    #[error(
        "inside point {},{} lies in a free place of {area_m2:.2} m2, expected at least {MIN_PLACE_M2}",
        at[0],
        at[1]
    )]
    PointInSmallPlace {
        /// The point.
        at: [f64; 2],
        /// Area of the place.
        area_m2: f64,
    },
    /// The rectangle has no area, or a corner is no finite number.
    #[error("region {} is not a rectangle between two opposite corners X0,Y0,X1,Y1", list(*region))]
    NoRectangle {
        /// The rectangle.
        region: [f64; 4],
    },
    /// No part of the rectangle is on the plan.
    #[error("region {} is off the plan, which spans {}", list(*region), span(*plan))]
    RegionOffPlan {
        /// The rectangle.
        region: [f64; 4],
        /// The plan: lowest x, lowest y, highest x, highest y.
        plan: [f64; 4],
    },
    /// Nothing in the rectangle is free.
    #[error("region {} has no free place: walls and glazing fill it", list(*region))]
    RegionOccupied {
        /// The rectangle.
        region: [f64; 4],
    },
}

fn list([x0, y0, x1, y1]: [f64; 4]) -> String {
    format!("{x0},{y0},{x1},{y1}")
}

fn span([x0, y0, x1, y1]: [f64; 4]) -> String {
    format!("x {x0:.2} to {x1:.2} m, y {y0:.2} to {y1:.2} m")
}

/// The cells of a plan, and where they lie on the map.
pub(super) struct Ground<'a> {
    pub(super) grid: &'a Grid,
    /// Squared distance of every cell to the nearest occupied one, in cells; 0 is occupied.
    pub(super) distance2: &'a [i32],
    /// Side of a cell, metres.
    pub(super) cell_m: f64,
    /// The plan on the map: lowest x, lowest y, highest x, highest y in metres.
    pub(super) plan: [f64; 4],
}

impl Ground<'_> {
    /// The inside cells, and the widest gap that was closed for them in metres.
    ///
    /// `ladder` has the gaps to try in turn, after none at all.
    pub(super) fn inside(&self, places: &Places, ladder: &[f64]) -> Result<(Vec<bool>, f64), PlacesError> {
        let mut inside = vec![false; self.distance2.len()];
        for &region in &places.regions {
            self.add_region(region, &mut inside)?;
        }
        let cells: Result<Vec<_>, _> = places.points.iter().map(|&at| Ok((at, self.cell_of(at)?))).collect();
        let widest = self.add_points(cells?, ladder, &mut inside)?;
        Ok((inside, widest))
    }

    /// Adds the free cells whose centres are in a rectangle.
    fn add_region(&self, region: [f64; 4], inside: &mut [bool]) -> Result<(), PlacesError> {
        let ([x0, x1], [y0, y1]) = (ordered(region[0], region[2]), ordered(region[1], region[3]));
        if !(region.iter().all(|value| value.is_finite()) && x0 < x1 && y0 < y1) {
            return Err(PlacesError::NoRectangle { region });
        }
        let plan = self.plan;
        if x1 <= plan[0] || y1 <= plan[1] || x0 >= plan[2] || y0 >= plan[3] {
            return Err(PlacesError::RegionOffPlan { region, plan });
        }
        let (columns, rows) = self.grid.plan_size();
        let range = |from: f64, to: f64, lowest: f64, count: usize| {
            let first = |at: f64| (((at - lowest) / self.cell_m - 0.5).ceil().max(0.0) as usize).min(count);
            first(from)..first(to)
        };
        let mut some = false;
        for row in range(y0, y1, plan[1], rows) {
            for column in range(x0, x1, plan[0], columns) {
                let at = self.grid.at(column, row);
                inside[at] |= self.is_free(at);
                some |= self.is_free(at);
            }
        }
        if some { Ok(()) } else { Err(PlacesError::RegionOccupied { region }) }
    }

    /// Adds what is connected with each point; the widest gap that was closed for one.
    fn add_points(
        &self,
        mut points: Vec<([f64; 2], usize)>,
        ladder: &[f64],
        inside: &mut [bool],
    ) -> Result<f64, PlacesError> {
        let mut widest = 0.0;
        for gap in core::iter::once(0.0).chain(ladder.iter().copied()) {
            if points.is_empty() {
                break;
            }
            widest = gap;
            let outside = self.outside(gap);
            let (open, enclosed): (Vec<_>, Vec<_>) = points.into_iter().partition(|&(_, cell)| outside[cell]);
            for (at, cell) in enclosed {
                self.add_place(at, cell, &outside, inside)?;
            }
            points = open;
        }
        let not_enclosed = |&(at, _): &_| Err(PlacesError::PointNotEnclosed { at, max_gap_m: widest });
        points.first().map_or(Ok(widest), not_enclosed)
    }

    /// Adds the free cells that are connected with one and not outside.
    fn add_place(
        &self,
        at: [f64; 2],
        cell: usize,
        outside: &[bool],
        inside: &mut [bool],
    ) -> Result<(), PlacesError> {
        let place = self.grid.flood([cell], |at| self.is_free(at) && !outside[at]);
        let area_m2 = place.iter().filter(|&&reached| reached).count() as f64 * self.cell_m * self.cell_m;
        if area_m2 < MIN_PLACE_M2 {
            return Err(PlacesError::PointInSmallPlace { at, area_m2 });
        }
        inside.iter_mut().zip(place).for_each(|(inside, reached)| *inside |= reached);
        Ok(())
    }

    /// The cells that belong to the outside when openings up to `gap` metres are closed.
    fn outside(&self, gap: f64) -> Vec<bool> {
        if gap == 0.0 {
            self.grid.flood_from_border(|at| self.is_free(at))
        } else {
            self.grid.outside(self.distance2, gap / 2.0 / self.cell_m)
        }
    }

    /// The free cell of a point.
    fn cell_of(&self, at: [f64; 2]) -> Result<usize, PlacesError> {
        let ([x, y], plan) = (at, self.plan);
        if !((plan[0]..plan[2]).contains(&x) && (plan[1]..plan[3]).contains(&y)) {
            return Err(PlacesError::PointOffPlan { at, plan });
        }
        let cell = |from: f64| (from / self.cell_m) as usize;
        let found = self.grid.at(cell(x - plan[0]), cell(y - plan[1]));
        if self.is_free(found) {
            Ok(found)
        } else {
            Err(PlacesError::PointOccupied { at, cell_m: self.cell_m })
        }
    }

    fn is_free(&self, at: usize) -> bool {
        self.distance2[at] > 0
    }
}

fn ordered(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}
