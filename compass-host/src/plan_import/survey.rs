//! What a plan holds, measured: for people to judge whether it was understood.

use super::bits::Bits;
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

/// The length of all walls, and of all glazing, in metres, about.
#[must_use]
pub fn lengths_m(plan: &PlanRaster) -> [f64; 2] {
    [&plan.walls, &plan.windows].map(|mask| by_thickness(mask, plan).iter().map(|class| class.length_m).sum())
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
    let is_letter = |piece: &Piece| {
        let [width, height] = piece.sides();
        let filled = f64::from(piece.pixels) / (f64::from(width) * f64::from(height));
        let side = width.max(height);
        side <= most && !(filled >= FILLED && f64::from(side) * plan.resolution_m >= SPECK_M)
    };
    let speck = |piece: Piece| {
        let centre = |axis: usize| {
            let middle = f64::midpoint(f64::from(piece.low[axis]), f64::from(piece.high[axis]) + 1.0);
            plan.origin[axis] + middle * plan.resolution_m
        };
        let [width, height] = piece.sides();
        let radius_m = f64::from(width.max(height)) * plan.resolution_m / 2.0;
        Speck { position: [centre(0), centre(1)], radius_m }
    };
    pieces(plan).into_iter().filter(is_letter).map(speck).collect()
}

/// How many connected pieces of wall and glazing a plan has.
#[must_use]
pub fn piece_count(plan: &PlanRaster) -> usize {
    pieces(plan).len()
}

/// A connected piece of wall and glazing, in pixels.
struct Piece {
    low: [u32; 2],
    high: [u32; 2],
    pixels: u32,
}

impl Piece {
    const fn sides(&self) -> [u32; 2] {
        [self.high[0] - self.low[0] + 1, self.high[1] - self.low[1] + 1]
    }
}

fn pieces(plan: &PlanRaster) -> Vec<Piece> {
    let mut left = Bits::occupied(plan);
    let (mut pieces, mut word, mut stack) = (Vec::new(), 0, Vec::new());
    while let Some((at, start)) = left.first_from(word) {
        word = at;
        let mut piece = Piece { low: start.into(), high: start.into(), pixels: 0 };
        left.take(start);
        stack.push(start);
        while let Some((x, y)) = stack.pop() {
            piece.low = [piece.low[0].min(x), piece.low[1].min(y)];
            piece.high = [piece.high[0].max(x), piece.high[1].max(y)];
            piece.pixels = piece.pixels.saturating_add(1);
            stack.extend(around((x, y), plan).filter(|next| left.take(*next)));
        }
        pieces.push(piece);
    }
    pieces
}

/// The up to eight neighbours of a pixel.
fn around((x, y): (u32, u32), plan: &PlanRaster) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (plan.width, plan.height);
    let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
    rows.flat_map(move |row| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |column| (column, row)))
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
        let [walls, glazing] = lengths_m(&plan);
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
