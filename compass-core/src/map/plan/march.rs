//! The ray march: the sample points p + k step of the paper, with empty tiles skipped.
//!
//! A sample belongs to the cell whose half-open square [i, i + 1) contains it: a ray along a cell border belongs to the
//! cell above and to the right of it. Coordinates have 32 fractional bits, so that a sample is within 1e-5 cells of the
//! exact point at 0.01 m per cell.

use super::{OCCUPIED, Plan, TILE};
use crate::base::num::{BINS, Point, Turn};
use crate::base::scan::{Hit, MAX_STEPS, Scan};
use core::fmt;

/// Accuracy of [`Plan::scan`]: the smallest number of rays in a million with the hit type of exact sampling and a range
/// within one step of it.
pub const AGREEING_RAYS_PPM: u32 = 999_000;

/// Errors of [`Plan::scan`] and [`Plan::rays`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MarchError {
    /// The position lies outside the plan.
    Outside,
    /// The position lies in a wall or window.
    Occupied,
}

impl fmt::Display for MarchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Outside => "position is outside the plan",
            Self::Occupied => "position is inside a wall or glazing",
        })
    }
}

impl core::error::Error for MarchError {}

/// A ray: current sample and step along both axes.
struct Ray {
    x: Axis,
    y: Axis,
}

/// One coordinate of a ray, with the constants of skipping.
struct Axis {
    /// The current sample, cells, Q32.
    at: i64,
    /// Cells per march step, Q32.
    step: i64,
    /// March steps per cell, Q16, rounded down.
    inverse: u32,
    /// All ones for a step towards larger coordinates: turns the offset in a tile into the distance to its far side.
    flip: u32,
}

/// 8 cells in Q16, less one: the offset within a tile.
const TILE_MASK: u32 = (TILE << 16) - 1;

impl Axis {
    #[expect(clippy::cast_possible_truncation, reason = "march steps are at most 20 cells, Q16")]
    fn new(start: i64, step: i64) -> Self {
        // Rounded up, so that the inverse is rounded down.
        let magnitude = (step.unsigned_abs() >> 16) as u32 + 1;
        Self {
            at: start + step,
            step,
            inverse: u32::MAX / magnitude,
            flip: if step > 0 { u32::MAX } else { 0 },
        }
    }

    fn tile(&self) -> u32 {
        // A negative coordinate becomes a tile number above that of any plan.
        ((self.at >> 35) as i32).cast_unsigned()
    }

    /// Cell within the tile, 0..8.
    #[expect(clippy::cast_sign_loss, reason = "masked to 3 bits")]
    fn cell(&self) -> u32 {
        (self.at >> 32) as u32 & (TILE - 1)
    }

    /// Lower bound of the number of steps that stay within this tile and `tiles` further ones.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "masked to the offset within a tile"
    )]
    fn steps_within(&self, tiles: u32) -> u32 {
        let offset = ((self.at >> 16) as u32 ^ self.flip) & TILE_MASK;
        let cells = offset + tiles * (TILE << 16);
        ((u64::from(cells) * u64::from(self.inverse)) >> 32) as u32
    }

    fn advance(&mut self, steps: u32) {
        self.at += i64::from(steps) * self.step;
    }
}

impl Plan<'_> {
    /// Type of the cell at a point in metres: wall, window or free ([`Hit::Open`]); `None` outside the plan.
    ///
    /// # Cost
    /// Constant: two or three table look-ups.
    ///
    /// ```
    /// # use compass_core::map::plan::{PlanGrid, pack};
    /// # use compass_core::{BitMask, Point};
    /// # let (walls, windows) = ([0b11111, 0b10001, 0b00001, 0b10001, 0b11111], [0, 0, 0b10000, 0, 0]);
    /// # let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
    /// # let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
    /// # let mut bytes = [0; 256];
    /// # let plan = pack(&walls, &windows, grid, &mut bytes)?;
    /// use compass_core::Hit;
    ///
    /// assert_eq!(plan.hit_at(plan.cell_centre(0, 0)), Some(Hit::Wall));
    /// assert_eq!(plan.hit_at(plan.cell_centre(2, 2)), Some(Hit::Open));
    /// assert_eq!(plan.hit_at(plan.cell_centre(5, 2)), None);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    #[must_use]
    pub fn hit_at(&self, at: Point) -> Option<Hit> {
        let (x, y) = self.cells(at);
        let (column, row) = (u32::try_from(x >> 32).ok()?, u32::try_from(y >> 32).ok()?);
        if column >= self.width || row >= self.height {
            return None;
        }
        let entry = self.entry(column / TILE, row / TILE)?;
        Some(self.occupied_hit(entry, row / TILE, column % TILE, row % TILE).unwrap_or(Hit::Open))
    }

    /// Casts 360 rays from a position: bin j has the direction `heading` + j degrees, counter-clockwise.
    ///
    /// # Formats
    /// Ranges are whole march steps of 0.02 m, 1 to 1500. A ray without a hit is [`Hit::Open`] with 1500 steps.
    ///
    /// # Accuracy
    /// [`AGREEING_RAYS_PPM`] of a million rays have the hit type of exact sampling and a range within one step.
    ///
    /// # Errors
    /// [`MarchError`] if the position is outside the plan or occupied; `out` is then unchanged.
    ///
    /// # Cost
    /// At most 1500 samples per ray; about 10 in a furnished storey, because empty tiles are skipped. Cortex-M7: `scan` in
    /// `targets/budget.txt`.
    ///
    /// # References
    /// The paper's ray march: step 0.02 m, largest range 30 m.
    ///
    /// ```
    /// # use compass_core::map::plan::{PlanGrid, pack};
    /// # use compass_core::{BitMask, Point};
    /// # let (walls, windows) = ([0b11111, 0b10001, 0b00001, 0b10001, 0b11111], [0, 0, 0b10000, 0, 0]);
    /// # let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
    /// # let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
    /// # let mut bytes = [0; 256];
    /// # let plan = pack(&walls, &windows, grid, &mut bytes)?;
    /// use compass_core::{Hit, Scan, Turn};
    ///
    /// // In the middle of 5 x 5 cells of 0.1 m: walls around, a window in the east.
    /// let mut scan = Scan::OPEN;
    /// plan.scan(plan.cell_centre(2, 2), Turn::ZERO, &mut scan)?;
    /// assert_eq!((scan.hit[0], scan.steps[0]), (Hit::Window, 8), "east, 0.16 m");
    /// assert_eq!((scan.hit[90], scan.steps[90]), (Hit::Wall, 8), "north");
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn scan(&self, at: Point, heading: Turn, out: &mut Scan) -> Result<(), MarchError> {
        let rays = self.rays(at, heading, 1)?;
        for (ray, (steps, hit)) in rays.zip(out.steps.iter_mut().zip(&mut out.hit)) {
            (*steps, *hit) = ray;
        }
        Ok(())
    }

    /// Casts every `stride`-th ray of [`Plan::scan`] lazily: an iterator over range in march steps and hit type of the bins
    /// 0, `stride`, 2 `stride`, ... below 360. A stride of 0 counts as 1.
    ///
    /// # Errors
    /// [`MarchError`] if the position is outside the plan or occupied.
    ///
    /// # Cost
    /// Per ray that of [`Plan::scan`].
    ///
    /// ```
    /// # use compass_core::map::plan::{PlanGrid, pack};
    /// # use compass_core::{BitMask, Point};
    /// # let (walls, windows) = ([0b11111, 0b10001, 0b00001, 0b10001, 0b11111], [0, 0, 0b10000, 0, 0]);
    /// # let (walls, windows) = (BitMask::new(&walls, 5, 5)?, BitMask::new(&windows, 5, 5)?);
    /// # let grid = PlanGrid { resolution_nm: 100_000_000, origin: Point::default() };
    /// # let mut bytes = [0; 256];
    /// # let plan = pack(&walls, &windows, grid, &mut bytes)?;
    /// use compass_core::{Hit, Turn};
    ///
    /// let rays = plan.rays(plan.cell_centre(2, 2), Turn::ZERO, 90)?;
    /// assert!(rays.map(|(_, hit)| hit).eq([Hit::Window, Hit::Wall, Hit::Wall, Hit::Wall]));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    #[inline]
    pub fn rays(
        &self,
        at: Point,
        heading: Turn,
        stride: usize,
    ) -> Result<impl Iterator<Item = (u16, Hit)>, MarchError> {
        match self.hit_at(at) {
            None => return Err(MarchError::Outside),
            Some(Hit::Open) => {}
            Some(_) => return Err(MarchError::Occupied),
        }
        let (x, y) = self.cells(at);
        let fan = heading.fan();
        Ok((0..BINS).step_by(stride.max(1)).map(move |bin| {
            let (cos, sin) = fan.cos_sin(bin);
            // Q28 cells (at most 2^32.4) x Q30 gives Q58, to Q32.
            let step = |unit: i32| (self.step * i64::from(unit) + (1 << 25)) >> 26;
            self.march(Ray { x: Axis::new(x, step(cos.to_bits())), y: Axis::new(y, step(sin.to_bits())) })
        }))
    }

    /// Follows one ray to its first occupied sample.
    #[expect(clippy::cast_possible_truncation, reason = "samples are at most MAX_STEPS")]
    fn march(&self, mut ray: Ray) -> (u16, Hit) {
        let mut sample = 1_u32;
        while sample <= u32::from(MAX_STEPS) {
            let (tx, ty) = (ray.x.tile(), ray.y.tile());
            let Some(entry) = self.entry(tx, ty) else { break };
            let advance = if entry < OCCUPIED {
                // All tiles closer than `entry` are empty: samples in them are skipped.
                let tiles = u32::from(entry.saturating_sub(1));
                ray.x.steps_within(tiles).min(ray.y.steps_within(tiles)) + 1
            } else {
                if let Some(hit) = self.occupied_hit(entry, ty, ray.x.cell(), ray.y.cell()) {
                    return (sample as u16, hit);
                }
                1
            };
            // `steps_within` can exceed the end of the ray: bounded, no coordinate overflows.
            let advance = advance.min(u32::from(MAX_STEPS));
            sample += advance;
            ray.x.advance(advance);
            ray.y.advance(advance);
        }
        (MAX_STEPS, Hit::Open)
    }

    fn entry(&self, tx: u32, ty: u32) -> Option<u16> {
        if tx >= self.tiles_x || ty >= self.tiles_y {
            return None;
        }
        self.tiles.get((ty * self.tiles_x + tx) as usize).map(|e| u16::from_le_bytes(*e))
    }

    /// Hit type of a cell of a tile; `None` if the cell is free or the tile empty.
    fn occupied_hit(&self, entry: u16, ty: u32, cell_x: u32, cell_y: u32) -> Option<Hit> {
        let number = entry.checked_sub(OCCUPIED)?;
        let first = u32::from_le_bytes(*self.rows.get(ty as usize)?);
        let pair = (first.wrapping_add(u32::from(number)) as usize).wrapping_mul(TILE as usize);
        let bits = u16::from_le_bytes(*self.patterns.get(pair.wrapping_add(cell_y as usize))?) >> cell_x;
        match bits & 0x0101 {
            0 => None,
            0x0100 => Some(Hit::Window),
            _ => Some(Hit::Wall),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::num::Metres;
    use crate::base::raster::BitMask;
    use crate::map::plan::{PlanError, PlanGrid, pack, packed_len};
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    const CENTIMETRE: u32 = 10_000_000;

    /// A raster drawn by hand; row 0 is the last line: '#' wall, '=' window.
    #[derive(Debug)]
    struct Drawing {
        width: u32,
        height: u32,
        walls: Vec<u8>,
        windows: Vec<u8>,
    }

    impl Drawing {
        fn new(width: u32, height: u32) -> Self {
            let len = BitMask::row_bytes(width) * height as usize;
            Self { width, height, walls: vec![0; len], windows: vec![0; len] }
        }

        fn set(&mut self, x: u32, y: u32, hit: Hit) {
            let at = y as usize * BitMask::row_bytes(self.width) + x as usize / 8;
            let mask = if hit == Hit::Wall { &mut self.walls } else { &mut self.windows };
            mask[at] |= 1 << (x % 8);
        }

        fn parse(rows: &[&str]) -> Self {
            let mut drawing = Self::new(rows[0].len() as u32, rows.len() as u32);
            for (y, row) in rows.iter().rev().enumerate() {
                for (x, c) in row.bytes().enumerate().filter(|(_, c)| *c != b' ') {
                    drawing.set(x as u32, y as u32, if c == b'#' { Hit::Wall } else { Hit::Window });
                }
            }
            drawing
        }

        fn masks(&self) -> (BitMask<'_>, BitMask<'_>) {
            (
                BitMask::new(&self.walls, self.width, self.height).unwrap(),
                BitMask::new(&self.windows, self.width, self.height).unwrap(),
            )
        }

        fn pack(&self, resolution_nm: u32) -> Vec<u8> {
            let (walls, windows) = self.masks();
            let mut bytes = vec![0; packed_len(&walls, &windows).unwrap()];
            let grid = PlanGrid { resolution_nm, origin: point(-1.0, 2.0) };
            pack(&walls, &windows, grid, &mut bytes).unwrap().verify().unwrap();
            bytes
        }

        fn at(&self, x: i64, y: i64) -> Option<Hit> {
            let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
            let (walls, windows) = self.masks();
            if x >= self.width || y >= self.height {
                return None;
            }
            Some(match (walls.get(x, y), windows.get(x, y)) {
                (true, _) => Hit::Wall,
                (_, true) => Hit::Window,
                _ => Hit::Open,
            })
        }

        /// The same march sample by sample, without skipping.
        fn step(&self, plan: &Plan<'_>, at: Point, heading: Turn, bin: usize) -> (u16, Hit) {
            let (x, y) = plan.cells(at);
            let (cos, sin) = heading.fan().cos_sin(bin);
            let step = |unit: i32| (plan.step * i64::from(unit) + (1 << 25)) >> 26;
            let (dx, dy) = (step(cos.to_bits()), step(sin.to_bits()));
            for k in 1..=MAX_STEPS {
                let k64 = i64::from(k);
                match self.at((x + k64 * dx) >> 32, (y + k64 * dy) >> 32) {
                    None => break,
                    Some(Hit::Open) => {}
                    Some(hit) => return (k, hit),
                }
            }
            (MAX_STEPS, Hit::Open)
        }
    }

    fn point(x: f64, y: f64) -> Point {
        Point::new(Metres::from_num(x), Metres::from_num(y))
    }

    #[test]
    fn rays_in_a_drawn_room_have_known_ranges() {
        // 10 cm cells; the origin is at (-1, 2).
        let drawing =
            Drawing::parse(&["########", "#      #", "#      =", "#      =", "#      #", "########"]);
        let bytes = drawing.pack(100_000_000);
        let plan = Plan::new(&bytes).unwrap();
        let mut scan = Scan::OPEN;
        plan.scan(point(-0.61, 2.31), Turn::ZERO, &mut scan).unwrap();
        assert_eq!((scan.steps[0], scan.hit[0]), (16, Hit::Window), "0.31 m to the window at x = -0.3");
        assert_eq!((scan.steps[180], scan.hit[180]), (15, Hit::Wall), "0.29 m to the wall at x = -0.9");
        assert_eq!((scan.steps[90], scan.hit[90]), (10, Hit::Wall));
        assert_eq!(scan.count(Hit::Open), 0);
        assert_eq!(plan.hit_at(point(-0.25, 2.35)), Some(Hit::Window));
        assert_eq!(plan.hit_at(point(-1.01, 2.3)), None);
        assert_eq!(plan.scan(point(-0.95, 2.3), Turn::ZERO, &mut scan), Err(MarchError::Occupied));
        assert_eq!(plan.scan(point(-1.01, 2.3), Turn::ZERO, &mut scan), Err(MarchError::Outside));
        assert_eq!(plan.scan(point(1e9, -1e9), Turn::ZERO, &mut scan), Err(MarchError::Outside));
    }

    #[test]
    fn rays_without_a_hit_are_open() {
        let mut drawing = Drawing::new(300, 300);
        drawing.set(299, 0, Hit::Wall);
        let bytes = drawing.pack(CENTIMETRE);
        let mut scan = Scan::OPEN;
        Plan::new(&bytes).unwrap().scan(point(0.5, 3.5), Turn::ZERO, &mut scan).unwrap();
        assert!(scan.count(Hit::Open) >= 359);
        assert!(scan.steps.iter().zip(&scan.hit).all(|(&s, &h)| h != Hit::Open || s == MAX_STEPS));
    }

    #[test]
    fn packing_rejects_invalid_input() {
        let drawing = Drawing::new(20, 20);
        let (walls, windows) = drawing.masks();
        let small = Drawing::new(20, 19);
        let grid = PlanGrid { resolution_nm: CENTIMETRE, origin: point(0.0, 0.0) };
        assert_eq!(packed_len(&walls, &small.masks().1), Err(PlanError::MaskSize));
        assert_eq!(pack(&walls, &windows, grid, &mut [0; 50]).unwrap_err(), PlanError::Buffer);
        let coarse = PlanGrid { resolution_nm: 999_999, ..grid };
        let mut out = vec![0; packed_len(&walls, &windows).unwrap()];
        assert_eq!(pack(&walls, &windows, coarse, &mut out).unwrap_err(), PlanError::Resolution);
    }

    #[test]
    fn damaged_bytes_do_not_panic() {
        let drawing = Drawing::parse(&["########", "#      #", "#      =", "########"]);
        let bytes = drawing.pack(CENTIMETRE);
        for len in 0..bytes.len() {
            assert!(Plan::new(&bytes[..len]).is_err());
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x5a;
            if let Ok(plan) = Plan::new(&damaged) {
                assert_eq!(plan.verify(), Err(PlanError::Checksum), "byte {at}");
                let _ = plan.scan(point(-0.95, 2.015), Turn::ZERO, &mut Scan::default());
            }
        }
    }

    /// Random drawings of thin lines, single cells and blocks.
    fn drawings() -> impl Strategy<Value = Drawing> {
        let block = (0u32..400, 0u32..300, 1u32..60, 1u32..12, any::<bool>(), any::<bool>());
        (300u32..400, 200u32..300, proptest::collection::vec(block, 0..25)).prop_map(
            |(width, height, blocks)| {
                let mut drawing = Drawing::new(width, height);
                for (x0, y0, long, short, upright, glass) in blocks {
                    let (dx, dy) = if upright { (short, long) } else { (long, short) };
                    for x in x0..(x0 + dx).min(width) {
                        for y in y0..(y0 + dy).min(height) {
                            drawing.set(x, y, if glass { Hit::Window } else { Hit::Wall });
                        }
                    }
                }
                drawing
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn skipping_never_changes_a_hit(
            drawing in drawings(),
            at in (0.0f64..1.0, 0.0f64..1.0),
            turn: u32,
            resolution in prop_oneof![Just(CENTIMETRE), Just(50_000_000), 1_000_000u32..2_000_000_000],
        ) {
            let bytes = drawing.pack(resolution);
            let plan = Plan::new(&bytes).unwrap();
            let metres = f64::from(resolution) * 1e-9;
            let at = point(
                -1.0 + at.0 * f64::from(drawing.width) * metres,
                2.0 + at.1 * f64::from(drawing.height) * metres,
            );
            let mut scan = Scan::OPEN;
            let heading = Turn::from_bits(turn);
            if plan.scan(at, heading, &mut scan).is_ok() {
                for bin in 0..BINS {
                    let expected = drawing.step(&plan, at, heading, bin);
                    prop_assert_eq!((scan.steps[bin], scan.hit[bin]), expected, "bin {}", bin);
                }
                let rays = plan.rays(at, heading, 7).unwrap().zip((0..BINS).step_by(7));
                for (ray, bin) in rays {
                    prop_assert_eq!(ray, (scan.steps[bin], scan.hit[bin]), "bin {}", bin);
                }
            }
        }
    }
}
