//! A plan furnished for rendering: what was not built, what the surfaces look like, what stands around, and how
//! light comes in.

use super::grid::{FREE, GLASS, Grid, OUTSIDE, WALL};
use super::light::Light;
use super::panes::Panes;
use super::solids::{Shape, Solid};
use super::texture::{hash, unit};
use crate::plan_import::PlanRaster;
use image::{Rgb, RgbImage};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Thinnest and thickest wall that may be missing are below this, in metres.
const PARTITION_M: f64 = 0.2;

/// Side of a patch in which partitions are built or not, in metres.
const PATCH_M: f64 = 2.0;

/// Walls closer to the outdoors than this are facade, in metres.
const FACADE_M: f64 = 0.6;

/// What a scene is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Where clutter stands, who is there, which walls are missing, and the noise.
    pub seed: u64,
    /// Materials, heights of windows, colours, brightness.
    pub style: u64,
    /// Height of the ceiling above the floor, metres.
    pub ceiling_m: f64,
    /// z of the floor in the map, metres.
    pub floor_m: f64,
    /// Boxes per 100 square metres of floor.
    pub clutter: u32,
    /// People around the cameras in each frame.
    pub people: u32,
    /// Whether somebody carries the rig.
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

/// A colour, linear: 1 is white at the exposure of the style.
pub(super) type Colour = [f32; 3];

/// The style: everything that is drawn once for a whole building. Lengths in metres.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub(super) seed: u32,
    pub(super) ceiling: f32,
    pub(super) wall: Colour,
    pub(super) plaster: Colour,
    /// Share of the wall faces that are plastered.
    pub(super) plastered: f32,
    pub(super) floor: Colour,
    pub(super) slab: Colour,
    /// Width and height of a formwork panel, and of the bays of floor and ceiling.
    pub(super) panel: [f32; 2],
    pub(super) floor_bay: [f32; 2],
    pub(super) slab_bay: [f32; 2],
    /// How dark joints are, 0 to 1.
    pub(super) joint: f32,
    pub(super) mottle: f32,
    pub(super) frame: Colour,
    pub(super) frame_width: f32,
    pub(super) mullions: f32,
    sills: [f32; 2],
    lintel_drop: [f32; 2],
    /// Brightness of the sky, and of what grows before it.
    pub(super) outside: f32,
    pub(super) green: Colour,
    /// Share of haze over what is outside.
    pub(super) haze: f32,
    /// A horizontal direction from which walls get more light.
    pub(super) sun: [f32; 2],
    /// Mean brightness that the exposure aims at, and noise.
    pub(super) exposure: f32,
    pub(super) noise: f32,
}

impl Look {
    fn new(style: u64, ceiling_m: f64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(style ^ 0x5eed_0f5c_e7e5);
        let mut draw = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        let gray = |value: f32, warm: f32| [value * (1.0 + warm), value, value * (1.0 - warm)];
        let dark_frame = draw(0.0, 1.0) < 0.5;
        let low_sills = draw(0.0, 1.0) < 0.5;
        let angle = draw(0.0, std::f32::consts::TAU);
        let bay = draw(2.4, 5.0);
        let slab = draw(2.5, 6.0);
        Self {
            seed: style as u32 ^ (style >> 32) as u32,
            ceiling: ceiling_m as f32,
            wall: gray(draw(0.33, 0.48), draw(-0.01, 0.04)),
            plaster: gray(draw(0.58, 0.72), draw(0.0, 0.03)),
            plastered: draw(0.15, 0.6),
            floor: gray(draw(0.22, 0.36), draw(0.0, 0.05)),
            slab: gray(draw(0.32, 0.48), draw(-0.01, 0.04)),
            panel: [draw(1.2, 2.7), draw(1.2, 2.75)],
            floor_bay: [bay, bay * draw(0.8, 1.3)],
            slab_bay: [slab, slab * draw(0.6, 1.4)],
            joint: draw(0.35, 0.75),
            mottle: draw(0.09, 0.2),
            frame: if dark_frame { gray(draw(0.02, 0.07), 0.0) } else { gray(draw(0.45, 0.7), 0.0) },
            frame_width: draw(0.05, 0.08),
            mullions: draw(0.9, 1.6),
            sills: if low_sills { [0.0, 0.15] } else { [0.0, 0.9] },
            lintel_drop: [draw(0.02, 0.1), draw(0.15, 0.45)],
            outside: draw(1.6, 4.0),
            green: [draw(0.14, 0.3), draw(0.34, 0.5), draw(0.08, 0.2)],
            haze: draw(0.0, 0.35),
            sun: [libm::cosf(angle), libm::sinf(angle)],
            exposure: draw(0.17, 0.27),
            noise: draw(0.8, 2.2),
        }
    }

    /// Height of a sill, by a number from 0 to 1.
    pub(super) fn sill(&self, at: f32) -> f32 {
        let sill = self.sills[0] + (self.sills[1] - self.sills[0]) * at;
        if sill < 0.05 { 0.0 } else { sill.min(self.ceiling * 0.4) }
    }

    /// Height of a lintel, by a number from 0 to 1.
    pub(super) fn lintel(&self, at: f32) -> f32 {
        let [least, most] = self.lintel_drop;
        (self.ceiling - least - (most - least) * at).max(self.ceiling * 0.6)
    }
}

/// A furnished plan, ready to be looked at from anywhere.
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
    /// Furnishes a plan.
    #[must_use]
    pub fn new(options: &SceneOptions, raster: &PlanRaster) -> Self {
        let look = Look::new(options.style, options.ceiling_m);
        let panes = Panes::new(raster, &look);
        let mut grid = Grid::new(raster);
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
    // The wall's extent through a cell, in one direction and its opposite; counting ends at `most`.
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

/// Boxes on the floor, at free places of the inside.
fn clutter(grid: &Grid, options: &SceneOptions) -> Vec<Solid> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(options.seed ^ 0xb0_5eed);
    let extent = [grid.width, grid.height].map(|cells| cells as f64 * grid.resolution);
    let tries = extent[0] * extent[1] / 100.0 * f64::from(options.clutter);
    let mut boxes = Vec::new();
    // Places are drawn over the whole plan: those outside or too narrow are left out, so that the
    // density is the one asked for.
    for _ in 0..tries.round() as usize {
        let draw: [f64; 10] = std::array::from_fn(|_| rng.random::<f64>());
        let at = [0, 1].map(|axis| grid.origin[axis] + extent[axis] * draw[axis]);
        let half = [0.15 + 0.45 * draw[2], 0.15 + 0.35 * draw[3]];
        let height = (0.25 + 1.5 * draw[4] * draw[5]).min(options.ceiling_m - 0.1);
        let free = grid.at(at[0], at[1]) >= FREE && grid.room(at[0], at[1]) > half[0].max(half[1]);
        if !free || height <= 0.0 {
            continue;
        }
        // Most things stand along the walls; plans are mostly drawn square.
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
