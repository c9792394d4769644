//! What a plan holds, measured: for people to judge whether it was understood.

use super::bits::Bits;
use super::pieces::{Piece, Pieces, Touch};
use super::raster::PlanRaster;

/// Bounds of the classes of wall thickness, in metres.
pub const THICKNESS_M: [f64; 9] = [0.03, 0.06, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6];
/// A piece of wall is suspicious below this size in metres, if little of its extent is filled.
const LETTER_M: f64 = 0.5;
/// A piece of wall is suspicious below this size in metres.
const SPECK_M: f64 = 0.1;
/// Share of its extent that a column fills at least.
const FILLED: f64 = 0.6;

/// Walls of similar thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThicknessClass {
    /// Thickness from here, in metres; 0 is a hairline.
    pub from_m: f64,
    /// Thickness below this, in metres; infinite for the last class.
    pub to_m: f64,
    /// Length of such walls in metres, about: their area over their mean thickness, in the last class half their outline.
    pub length_m: f64,
}

/// A small piece of wall that stands alone, such as a letter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speck {
    /// Its centre on the map in metres.
    pub position: [f64; 2],
    /// Half the larger side of its extent in metres.
    pub radius_m: f64,
}

/// Walls by thickness, thinnest first.
#[must_use]
pub fn wall_thickness(plan: &PlanRaster) -> Vec<ThicknessClass> {
    by_thickness(&plan.walls, plan)
}

/// Glazing by thickness, thinnest first.
#[must_use]
pub fn glazing_thickness(plan: &PlanRaster) -> Vec<ThicknessClass> {
    by_thickness(&plan.windows, plan)
}

/// The length of all classes together, in metres, about.
#[must_use]
pub fn length_m(classes: &[ThicknessClass]) -> f64 {
    classes.iter().map(|class| class.length_m).sum()
}

fn by_thickness(mask: &[u8], plan: &PlanRaster) -> Vec<ThicknessClass> {
    let pixel_m2 = plan.resolution_m * plan.resolution_m;
    let mut opened = Bits::new(mask, plan.width, plan.height);
    let area = |bits: &Bits| bits.count() as f64 * pixel_m2;
    let mut classes = Vec::new();
    let (mut from_m, mut left) = (0.0, area(&opened));
    for to_m in THICKNESS_M.into_iter().chain([f64::INFINITY]) {
        let side = (to_m / plan.resolution_m).round() as usize;
        // A bound below two pixels tells nothing from nothing.
        if to_m.is_finite() && side < 2 {
            continue;
        }
        if !to_m.is_finite() {
            // Solid ground of no thickness: half its outline.
            let length_m = opened.outline() as f64 * plan.resolution_m / 2.0;
            classes.push(ThicknessClass { from_m, to_m, length_m });
            break;
        }
        opened.open(side);
        let beyond = area(&opened);
        let mean = f64::midpoint(f64::max(from_m, plan.resolution_m), to_m);
        classes.push(ThicknessClass { from_m, to_m, length_m: (left - beyond) / mean });
        (from_m, left) = (to_m, beyond);
    }
    classes
}

/// Small pieces of wall that stand alone: most are letters, numbers and marks.
#[must_use]
pub fn specks(plan: &PlanRaster) -> Vec<Speck> {
    let most = (LETTER_M / plan.resolution_m).ceil() as u32;
    let is_letter = |piece: &&Piece| {
        let [long, short] = piece.sides();
        let filled = piece.area as f64 / (f64::from(long) * f64::from(short));
        let is_column = filled >= FILLED && f64::from(long) * plan.resolution_m >= SPECK_M;
        long <= most && !is_column
    };
    let speck = |piece: &Piece| {
        let middle = |[from, to]: [u32; 2]| f64::midpoint(f64::from(from), f64::from(to)) * plan.resolution_m;
        Speck {
            position: [plan.origin[0] + middle(piece.x), plan.origin[1] + middle(piece.y)],
            radius_m: f64::from(piece.sides()[0]) * plan.resolution_m / 2.0,
        }
    };
    pieces(plan).iter().filter(is_letter).map(speck).collect()
}

/// How many connected pieces of wall and glazing a plan has.
#[must_use]
pub fn piece_count(plan: &PlanRaster) -> usize {
    pieces(plan).len()
}

fn pieces(plan: &PlanRaster) -> Vec<Piece> {
    Pieces::of(&Bits::occupied(plan), Touch::Corners).pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(plan: &mut PlanRaster, x: std::ops::Range<u32>, y: std::ops::Range<u32>) {
        y.flat_map(|y| x.clone().map(move |x| (x, y))).for_each(|(x, y)| plan.set_wall(x, y));
    }

    #[test]
    fn walls_are_told_by_thickness() {
        let mut plan = PlanRaster::empty(1000, 300, 0.01, [0.0; 2]);
        block(&mut plan, 10..910, 10..34);
        block(&mut plan, 10..710, 100..112);
        block(&mut plan, 10..510, 200..202);
        let classes = wall_thickness(&plan);
        let length = |at: f64| classes.iter().find(|c| c.from_m <= at && at < c.to_m).unwrap().length_m;
        for (thickness, metres) in [(0.24, 9.0), (0.12, 7.0), (0.02, 5.0)] {
            assert!((length(thickness) / metres - 1.0).abs() < 0.25, "{thickness}: {}", length(thickness));
        }
        assert_eq!(length(0.5), 0.0);
        let [walls, glazing] =
            [wall_thickness(&plan), glazing_thickness(&plan)].map(|classes| length_m(&classes));
        assert!((walls - 21.0).abs() < 4.0 && glazing == 0.0, "{walls}");
    }

    #[test]
    fn letters_are_specks_and_columns_are_none() {
        let mut plan = PlanRaster::empty(400, 400, 0.01, [5.0, 7.0]);
        // A column, an L of thin strokes, a dot, a wall.
        block(&mut plan, 20..50, 20..50);
        block(&mut plan, 100..103, 100..130);
        block(&mut plan, 100..120, 100..103);
        block(&mut plan, 200..204, 200..204);
        block(&mut plan, 10..390, 300..310);
        let found = specks(&plan);
        assert_eq!(found.len(), 2);
        assert!((found[0].position[0] - 6.1).abs() < 1e-9 && (found[0].position[1] - 8.15).abs() < 1e-9);
        assert!((found[0].radius_m - 0.15).abs() < 1e-9);
        assert_eq!(piece_count(&plan), 4);
    }
}
