//! Checks which walls of a plan exist, by the evidence of frames at known poses.
//!
//! Rays are cast in the plan as drawn; the evidence of the frame is [compared](compare) with the wall hit by each ray.
//! Log-likelihood ratios are accumulated on tiles of the map: each frame adds its mean to a tile.

use crate::output::{Decimal, OutputError, write_file};
use compass_core::base::num::Nats;
use compass_core::base::scan::{STEPS_PER_METRE, Scan};
use compass_core::map::plan::Plan;
use compass_core::pose::ScoredPose;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::wall_check::compare;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Side of a tile, metres.
pub const TILE_M: f64 = 0.2;
/// Largest distance of a wall, metres: farther ones are hit by too few rays.
const FARTHEST_M: f64 = 12.0;
/// Log-likelihood ratio from which a tile has a verdict, nats.
const DECISIVE_NATS: f64 = 3.0;

/// The evidence on a tile.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tile {
    /// Log-likelihood ratio of the wall being present to it being absent, nats.
    pub nats: f64,
    /// Number of frames that observed it.
    pub frames: u32,
}

/// The verdict on a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The wall is present.
    Stands,
    /// The cameras see through it: it is absent.
    Absent,
    /// The evidence does not decide.
    Unclear,
}

impl Tile {
    /// The verdict that the evidence gives.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match self.nats {
            nats if nats >= DECISIVE_NATS => Verdict::Stands,
            nats if nats <= -DECISIVE_NATS => Verdict::Absent,
            _ => Verdict::Unclear,
        }
    }
}

/// The verdicts on the walls of a floor, for machine-readable results.
#[derive(Debug, Serialize)]
pub struct WallSummary {
    standing_m: Decimal,
    absent_m: Decimal,
    unclear_m: Decimal,
    /// Centres of the tiles without the wall that the plan draws.
    absent: Vec<[Decimal; 2]>,
}

impl WallSummary {
    /// Sums the tiles by verdict.
    #[must_use]
    pub fn of(walls: &Walls) -> Self {
        let absent = walls.tiles().filter(|(_, tile)| tile.verdict() == Verdict::Absent);
        Self {
            standing_m: Decimal(walls.metres(Verdict::Stands)),
            absent_m: Decimal(walls.metres(Verdict::Absent)),
            unclear_m: Decimal(walls.metres(Verdict::Unclear)),
            absent: absent.map(|(at, _)| at.map(Decimal)).collect(),
        }
    }
}

/// The evidence on the walls of one floor.
#[derive(Debug, Clone, Default)]
pub struct Walls {
    /// The evidence by tile: column and row of the map from its origin.
    tiles: BTreeMap<[i32; 2], Tile>,
    /// Positions of the frames, metres.
    seen_from: Vec<[f64; 2]>,
}

impl Walls {
    /// Adds the evidence of a frame at a pose, with the plan as drawn. A pose inside a wall adds nothing.
    pub fn add(&mut self, plan: &Plan<'_>, pose: &ScoredPose, table: &EvidenceTable) {
        let mut scan = Scan::OPEN;
        if plan.scan(pose.at, pose.heading, &mut scan).is_err() {
            return;
        }
        let at: [f64; 2] = [pose.at.x.to_num(), pose.at.y.to_num()];
        self.seen_from.push(at);
        let heading = f64::from(pose.heading.to_microdegrees()) / 1e6;
        let mut seen: BTreeMap<[i32; 2], (Nats, i32)> = BTreeMap::new();
        for ((bin, steps), verdict) in scan.steps.iter().enumerate().zip(compare(table, &scan)) {
            let range = f64::from(*steps) / f64::from(STEPS_PER_METRE);
            if verdict != 0 && range <= FARTHEST_M {
                let (sin, cos) = libm::sincos((heading + bin as f64).to_radians());
                let tile = [at[0] + range * cos, at[1] + range * sin].map(|m| (m / TILE_M).floor() as i32);
                let (sum, count) = seen.entry(tile).or_default();
                (*sum, *count) = (*sum + Nats::from(verdict), *count + 1);
            }
        }
        for (key, (sum, count)) in seen {
            let tile = self.tiles.entry(key).or_default();
            tile.nats += f64::from(sum) / f64::from(count);
            tile.frames += 1;
        }
    }

    /// The positions of the frames that were added, metres.
    #[must_use]
    pub fn seen_from(&self) -> &[[f64; 2]] {
        &self.seen_from
    }

    /// The tiles with evidence, by their centres in metres.
    pub fn tiles(&self) -> impl Iterator<Item = ([f64; 2], &Tile)> {
        self.tiles.iter().map(|(key, tile)| (key.map(|k| (f64::from(k) + 0.5) * TILE_M), tile))
    }

    /// Metres of wall with this verdict; a tile counts [`TILE_M`].
    #[must_use]
    pub fn metres(&self, verdict: Verdict) -> f64 {
        self.tiles.values().filter(|tile| tile.verdict() == verdict).count() as f64 * TILE_M
    }

    /// Writes the tiles as lines `x,y,nats,frames`.
    ///
    /// # Errors
    /// Names the file.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = String::from("#x [m],y [m],nats for the wall standing,frames\n");
        for ([x, y], Tile { nats, frames }) in self.tiles() {
            let _ = writeln!(text, "{x:.1},{y:.1},{nats:.2},{frames}");
        }
        write_file(path, text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::sharp;
    use crate::plan_import::PlanRaster;
    use crate::plan_import::structure::{DEFAULT_THICKNESS_M, keep_structure};
    use crate::sample::{FRAME_POSE, building};
    use crate::site::{PackedPlan, point, turn};

    /// The check of the walls as drawn, by ideal evidence of another plan.
    fn checked(drawn: &PackedPlan, built: &PlanRaster) -> Walls {
        let ([x, y], heading) = FRAME_POSE;
        let (at, heading_deg) = (point(x, y).unwrap(), turn(heading));
        let pose = ScoredPose { at, heading: heading_deg, ..ScoredPose::NONE };
        let mut table = Box::new(EvidenceTable::EMPTY);
        sharp(&PackedPlan::new(built).unwrap().scan([x, y], heading).unwrap(), &mut table);
        let mut walls = Walls::default();
        walls.add(&drawn.view(), &pose, &table);
        walls
    }

    #[test]
    fn unbuilt_walls_are_found_absent() {
        let drawn = PlanRaster::from(building());
        let plan = PackedPlan::new(&drawn).unwrap();
        let as_drawn = checked(&plan, &drawn);
        let [stands, absent] = [Verdict::Stands, Verdict::Absent].map(|verdict| as_drawn.metres(verdict));
        assert!(stands > 5.0 && absent == 0.0, "{stands} m stand, {absent} m are absent");
        assert_eq!(as_drawn.seen_from().len(), 1);

        let shell = checked(&plan, &keep_structure(&drawn, DEFAULT_THICKNESS_M).unwrap());
        let absent: Vec<_> = shell.tiles().filter(|(_, tile)| tile.verdict() == Verdict::Absent).collect();
        assert!(absent.len() > 5, "{} tiles", absent.len());
        let stood = |at: &[f64; 2]| {
            as_drawn.tiles().any(|(other, tile)| other == *at && tile.verdict() == Verdict::Stands)
        };
        assert!(absent.iter().all(|(at, _)| stood(at)), "what is absent was drawn");
    }
}
