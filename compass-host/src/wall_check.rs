//! Which walls of a plan stand, by what was seen from known poses.
//!
//! Each pose casts the plan as drawn; what was seen there [judges](compare) the walls its rays meet. Judgements are
//! collected on tiles of the map: of each frame a tile takes the mean, and those of frames add up.

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
/// Walls farther away are seen by too few rays.
const FARTHEST_M: f64 = 12.0;
/// What decides a tile, nats.
const DECISIVE_NATS: f64 = 3.0;

/// What is seen of a tile.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tile {
    /// Log-likelihood ratio of the wall standing to one looking through it, nats.
    pub nats: f64,
    /// Frames that saw it.
    pub frames: u32,
}

/// What came of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The wall is there.
    Stands,
    /// One looks through.
    Absent,
    /// Seen, but not clearly.
    Unclear,
}

impl Tile {
    /// What it comes to.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match self.nats {
            nats if nats >= DECISIVE_NATS => Verdict::Stands,
            nats if nats <= -DECISIVE_NATS => Verdict::Absent,
            _ => Verdict::Unclear,
        }
    }
}

/// The walls of a floor in short, for programs.
#[derive(Debug, Serialize)]
pub struct WallSummary {
    standing_m: Decimal,
    absent_m: Decimal,
    unclear_m: Decimal,
    /// Middles of the tiles where one looks through the plan's wall.
    absent: Vec<[Decimal; 2]>,
}

impl WallSummary {
    /// Sums up.
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

/// The walls of one floor that were looked at.
#[derive(Debug, Clone, Default)]
pub struct Walls {
    /// By tile: column and row of the map from its origin.
    tiles: BTreeMap<[i32; 2], Tile>,
    /// Metres.
    seen_from: Vec<[f64; 2]>,
}

impl Walls {
    /// Takes in what was seen from a pose, with the plan as drawn. A pose in a wall says nothing.
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

    /// The positions that were taken in, metres.
    #[must_use]
    pub fn seen_from(&self) -> &[[f64; 2]] {
        &self.seen_from
    }

    /// The tiles that were seen, by their middles in metres.
    pub fn tiles(&self) -> impl Iterator<Item = ([f64; 2], &Tile)> {
        self.tiles.iter().map(|(key, tile)| (key.map(|k| (f64::from(k) + 0.5) * TILE_M), tile))
    }

    /// Metres of wall that came to a verdict, a tile for [`TILE_M`].
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

    /// What is told of the walls as drawn by somebody who sees those of another plan.
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
    fn walls_that_are_not_built_are_looked_through() {
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
