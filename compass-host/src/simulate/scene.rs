//! A plan furnished for rendering: missing walls, surface materials, clutter, and light.

use super::grid::{FREE, GLASS, Grid, OUTSIDE, WALL};
use super::light::Light;
use super::panes::Panes;
use super::solids::{Shape, Solid};
use super::style::{Colour, Look};
use super::texture::{hash, unit};
use crate::interior::{self, Interior, InteriorError, InteriorOptions, Places};
use crate::plan_import::PlanRaster;
use image::{Rgb, RgbImage};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Walls below this thickness may be missing, in metres.
const PARTITION_M: f64 = 0.2;

/// Side of a patch in which partitions are built or not, in metres.
const PATCH_M: f64 = 2.0;

/// Walls closer to the outdoors than this are facade, in metres.
const FACADE_M: f64 = 0.6;

/// The parameters of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Seed of the clutter, the people, the missing walls and the noise.
    pub seed: u64,
    /// Seed of materials, window heights, colours and brightness.
    pub style: u64,
    /// Height of the ceiling above the floor, metres.
    pub ceiling_m: f64,
    /// z of the floor in the map, metres.
    pub floor_m: f64,
    /// Boxes per 100 square metres of floor.
    pub clutter: u32,
    /// People around the cameras in each frame.
    pub people: u32,
    /// Whether a person carries the rig.
    pub operator: bool,
    /// Share of the interior walls below 0.2 m that is not built, 0 to 1.
    pub missing: f64,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            style: 1,
            ceiling_m: 2.75,
            floor_m: 0.0,
            clutter: 2,
            people: 1,
            operator: true,
            missing: 0.0,
        }
    }
}

fn interior_of(raster: &PlanRaster, places: &Places) -> Result<Interior, InteriorError> {
    let options = InteriorOptions::with_places(places.clone(), raster.origin);
    interior::find(&raster.walls_mask(), &raster.windows_mask(), raster.resolution_m, &options)
}

/// A furnished plan, ready to be rendered from any place.
#[derive(Debug)]
pub struct Scene {
    pub(super) options: SceneOptions,
    pub(super) look: Look,
    pub(super) grid: Grid,
    pub(super) panes: Panes,
    pub(super) light: Light,
    pub(super) boxes: Vec<Solid>,
}

impl Scene {
    /// Furnishes a plan. Where no interior is found, all that is free is inside.
    #[must_use]
    pub fn new(options: &SceneOptions, raster: &PlanRaster) -> Self {
        Self::with_interior(options, raster, interior_of(raster, &Places::default()).ok().as_ref())
    }

    /// [`Self::new`] with the inside at `places`, if they name any.
    ///
    /// # Errors
    /// [`InteriorError::Places`]: a place that cannot be inside.
    pub fn in_places(
        options: &SceneOptions,
        raster: &PlanRaster,
        places: &Places,
    ) -> Result<Self, InteriorError> {
        if places.is_empty() {
            return Ok(Self::new(options, raster));
        }
        Ok(Self::with_interior(options, raster, Some(&interior_of(raster, places)?)))
    }

    fn with_interior(options: &SceneOptions, raster: &PlanRaster, inside: Option<&Interior>) -> Self {
        let look = Look::new(options.style, options.ceiling_m);
        let panes = Panes::new(raster, &look);
        let mut grid = Grid::new(raster, inside);
        if options.missing > 0.0 {
            tear_down(&mut grid, options);
        }
        grid.measure();
        let light = Light::new(&grid);
        let boxes = clutter(&grid, options);
        Self { options: *options, look, grid, panes, light, boxes }
    }

    /// The plan as it was built, without the walls that are missing: walls black, glazing red. Row 0 is the northernmost.
    #[must_use]
    pub fn as_built(&self) -> RgbImage {
        let grid = &self.grid;
        RgbImage::from_fn(grid.width as u32, grid.height as u32, |x, row| {
            match grid.cell(i64::from(x), grid.height as i64 - 1 - i64::from(row)) {
                WALL => Rgb([0; 3]),
                GLASS => Rgb([255, 0, 0]),
                _ => Rgb([255; 3]),
            }
        })
    }

    /// Height of the ceiling above the floor, metres.
    #[must_use]
    pub const fn ceiling_m(&self) -> f64 {
        self.options.ceiling_m
    }
}

/// Leaves out patches of thin interior walls.
fn tear_down(grid: &mut Grid, options: &SceneOptions) {
    let cells = |metres: f64| (metres / grid.resolution).round() as i64;
    let (most, facade, patch) = (cells(PARTITION_M), cells(FACADE_M), cells(PATCH_M).max(1));
    // The wall's extent through a cell, in one direction and its opposite; counting stops at `most`.
    let extent = |x: i64, y: i64, [dx, dy]: [i64; 2]| {
        let run = |sign: i64| {
            (1..=most).take_while(|k| grid.cell(x + sign * k * dx, y + sign * k * dy) == WALL).count()
        };
        run(1) + run(-1) + 1
    };
    let mut gone = Vec::new();
    for y in 0..grid.height as i64 {
        for x in 0..grid.width as i64 {
            let missing = || {
                let share = unit(hash(options.seed as u32, [(x / patch) as i32, (y / patch) as i32, 7]));
                f64::from(share) < options.missing
            };
            if grid.cell(x, y) != WALL || !missing() {
                continue;
            }
            let around = [[1, 0], [0, 1], [-1, 0], [0, -1]];
            let outer =
                || around.iter().any(|[dx, dy]| grid.cell(x + facade * dx, y + facade * dy) == OUTSIDE);
            let thin = || [[1, 0], [0, 1]].iter().any(|&d| extent(x, y, d) as i64 <= most);
            if thin() && !outer() {
                gone.push((x as usize, y as usize));
            }
        }
    }
    for (x, y) in gone {
        grid.clear(x, y);
    }
}

/// Boxes on the floor, at free places of the interior.
fn clutter(grid: &Grid, options: &SceneOptions) -> Vec<Solid> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(options.seed ^ 0xb0_5eed);
    let extent = [grid.width, grid.height].map(|cells| cells as f64 * grid.resolution);
    let tries = extent[0] * extent[1] / 100.0 * f64::from(options.clutter);
    let mut boxes = Vec::new();
    // Places are drawn over the whole plan, and those outside or too narrow are dropped, so that the density is the
    // requested one.
    for _ in 0..tries.round() as usize {
        let draw: [f64; 10] = std::array::from_fn(|_| rng.random::<f64>());
        let at = [0, 1].map(|axis| grid.origin[axis] + extent[axis] * draw[axis]);
        let half = [0.15 + 0.45 * draw[2], 0.15 + 0.35 * draw[3]];
        let height = (0.25 + 1.5 * draw[4] * draw[5]).min(options.ceiling_m - 0.1);
        let free = grid.at(at[0], at[1]) >= FREE && grid.room(at[0], at[1]) > half[0].max(half[1]);
        if !free || height <= 0.0 {
            continue;
        }
        // Most boxes are aligned with the axes of the plan, as most walls are.
        let angle = if draw[6] < 0.7 { 0.0 } else { std::f64::consts::PI * draw[7] };
        boxes.push(Solid {
            shape: Shape::Box,
            centre: [at[0] as f32, at[1] as f32, height as f32 / 2.0],
            half: [half[0] as f32, half[1] as f32, height as f32 / 2.0],
            turn: [libm::cos(angle) as f32, libm::sin(angle) as f32],
            colour: box_colour(draw[8], draw[9]),
        });
    }
    boxes
}

/// Cardboard, wrapped goods, wood, metal and plastic.
fn box_colour(kind: f64, shade: f64) -> Colour {
    let colours =
        [[0.36, 0.24, 0.14], [0.6, 0.6, 0.6], [0.42, 0.3, 0.17], [0.12, 0.13, 0.14], [0.06, 0.13, 0.3]];
    let picked: Colour = colours[((kind * 5.0) as usize).min(4)];
    picked.map(|v| v * (0.7 + 0.6 * shade as f32))
}
