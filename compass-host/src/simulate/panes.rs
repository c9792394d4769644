//! The glazing of a plan as panes: connected pieces of glass, each an opening with sill, lintel, frame and
//! mullions.

use super::style::Look;
use super::texture::{hash, unit};
use crate::plan_import::PlanRaster;
use std::collections::HashMap;

/// One connected piece of glazing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pane {
    /// Direction along the glass on the floor, of length 1.
    pub(super) along: [f32; 2],
    /// Where it begins in that direction, metres.
    from: f32,
    /// Its length, metres.
    length: f32,
    /// Metres between mullions.
    mullions: f32,
    /// Heights above the floor between which there is no wall, metres.
    pub(super) sill: f32,
    pub(super) lintel: f32,
}

impl Pane {
    /// Whether a point of the opening belongs to the frame, `width` wide.
    pub(super) fn is_frame(&self, at: [f32; 2], z: f32, width: f32) -> bool {
        let u = at[0] * self.along[0] + at[1] * self.along[1] - self.from;
        let field = u - (u / self.mullions).floor() * self.mullions;
        let upright = u < width
            || u > self.length - width
            || (field - self.mullions / 2.0).abs() > self.mullions / 2.0 - width / 2.0;
        upright || z < self.sill + width || z > self.lintel - width
    }
}

/// All panes of a plan.
#[derive(Debug, Default)]
pub(super) struct Panes {
    pub(super) list: Vec<Pane>,
    /// Pane of a cell that is glazing.
    cells: HashMap<usize, u32>,
}

impl Panes {
    pub(super) fn new(raster: &PlanRaster, look: &Look) -> Self {
        let mut panes = Self::default();
        for y in 0..raster.height {
            for x in 0..raster.width {
                let at = y as usize * raster.width as usize + x as usize;
                if raster.is_window(x, y) && !panes.cells.contains_key(&at) {
                    let piece = panes.piece(raster, x, y);
                    panes.list.push(pane(raster, &piece, look));
                }
            }
        }
        panes
    }

    /// The number of the pane in a cell; 0 where there is none.
    pub(super) fn number(&self, x: i64, y: i64, width: usize) -> u32 {
        let at = usize::try_from(y).ok().zip(usize::try_from(x).ok()).map(|(y, x)| y * width + x);
        at.and_then(|at| self.cells.get(&at)).copied().unwrap_or(0)
    }

    /// Collects the glazing connected with a cell, and numbers it.
    fn piece(&mut self, raster: &PlanRaster, x: u32, y: u32) -> Vec<[u32; 2]> {
        let number = self.list.len() as u32;
        let index = |x: u32, y: u32| y as usize * raster.width as usize + x as usize;
        let (mut piece, mut open) = (Vec::new(), vec![[x, y]]);
        self.cells.insert(index(x, y), number);
        while let Some([x, y]) = open.pop() {
            piece.push([x, y]);
            for there_y in y.saturating_sub(1)..=y + 1 {
                for there_x in x.saturating_sub(1)..=x + 1 {
                    if raster.is_window(there_x, there_y)
                        && !self.cells.contains_key(&index(there_x, there_y))
                    {
                        self.cells.insert(index(there_x, there_y), number);
                        open.push([there_x, there_y]);
                    }
                }
            }
        }
        piece
    }
}

/// The pane of some cells: its direction is that of their largest spread.
fn pane(raster: &PlanRaster, piece: &[[u32; 2]], look: &Look) -> Pane {
    let metres = |[x, y]: [u32; 2]| {
        let metre = |v: u32, origin: f64| (f64::from(v) + 0.5) * raster.resolution_m + origin;
        [metre(x, raster.origin[0]), metre(y, raster.origin[1])]
    };
    let along = spread(piece.iter().map(|&cell| metres(cell)));
    let (mut from, mut to, mut across) = (f64::MAX, f64::MIN, 0.0);
    for &cell in piece {
        let [x, y] = metres(cell);
        let u = x * along[0] + y * along[1];
        (from, to) = (from.min(u), to.max(u));
        across += y * along[0] - x * along[1];
    }
    let half = raster.resolution_m / 2.0;
    let length = (to - from + 2.0 * half) as f32;
    // Panes of one facade have their sills and lintels at the same height.
    let facade = hash(
        look.seed,
        [
            (along[0] * 4.0).round() as i32,
            (along[1] * 4.0).round() as i32,
            (across / piece.len() as f64 / 2.0).round() as i32,
        ],
    );
    let fields = (length / look.mullions).round().max(1.0);
    Pane {
        along: along.map(|v| v as f32),
        from: (from - half) as f32,
        length,
        mullions: length / fields,
        sill: look.sill(unit(facade)),
        lintel: look.lintel(unit(facade.rotate_left(16))),
    }
}

/// The direction of the largest spread of points, of length 1.
pub(super) fn spread(points: impl Iterator<Item = [f64; 2]> + Clone) -> [f64; 2] {
    let count = points.clone().count().max(1) as f64;
    let sum = points.clone().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
    let mean = sum.map(|v| v / count);
    let [xx, xy, yy] = points.fold([0.0; 3], |s, p| {
        let (x, y) = (p[0] - mean[0], p[1] - mean[1]);
        [s[0] + x * x, s[1] + x * y, s[2] + y * y]
    });
    let angle = 0.5 * libm::atan2(2.0 * xy, xx - yy);
    [libm::cos(angle), libm::sin(angle)]
}
