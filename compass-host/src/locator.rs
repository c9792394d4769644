//! From frames to a pose on a site: the core's search with its buffers.

use crate::site_file::SiteFloor;
use compass_core::pose::evidence::{EvidenceTable, weigh};
use compass_core::pose::locate::{Effort, Fix, HeightPrior, Work, locate};
use compass_core::pose::{Answer, FloorLayer, Rows, ScoredPose, answer, refine, search};
use compass_core::vision::boundary::{BoundaryEvidence, RangeLikelihoods};
use compass_core::vision::windows::WindowEvidence;
use thiserror::Error;

/// Modes that the search may choose from.
const POOL: usize = 512;
/// Headings that the search tries: 180 and 360 found no more on recorded and simulated frames.
const HEADINGS: usize = 90;

/// A floor of a site has no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("has no plan to refine poses on; build it anew with compass map build")]
pub struct NoPlan;

/// All layers of all floors of a site, and buffers for the search.
#[derive(Debug)]
pub struct Locator<'a> {
    layers: Vec<FloorLayer<'a>>,
    ranges: Box<RangeLikelihoods>,
    table: Box<EvidenceTable>,
    rows: Box<Rows<HEADINGS>>,
    pool: Vec<ScoredPose>,
}

impl<'a> Locator<'a> {
    /// For these floors.
    ///
    /// # Errors
    /// [`NoPlan`] if one has no plan to refine poses on, as plain site maps have none.
    pub fn new(storeys: &[SiteFloor<'a>]) -> Result<Self, NoPlan> {
        let mut layers = Vec::new();
        for (floor_number, storey) in (0..).zip(storeys) {
            let floor = storey.floor.ok_or(NoPlan)?;
            for layer in 0..floor.layers() as u8 {
                let plan = floor.plan(usize::from(layer)).ok_or(NoPlan)?;
                layers.push(FloorLayer { map: storey.map, number: layer, plan, floor: floor_number });
            }
        }
        Ok(Self {
            layers,
            ranges: Box::new(RangeLikelihoods::EMPTY),
            table: Box::new(EvidenceTable::EMPTY),
            rows: Box::new(Rows::BLANK),
            pool: vec![ScoredPose::NONE; POOL],
        })
    }

    /// The layers in the order that [`ScoredPose::layer`] counts them.
    #[must_use]
    pub fn layers(&self) -> &[FloorLayer<'a>] {
        &self.layers
    }

    /// Finds the pose that explains best what was seen, with what is known of the room.
    pub fn locate(
        &mut self,
        survey: &BoundaryEvidence<'_>,
        room: HeightPrior,
        sighting: &WindowEvidence,
    ) -> Fix {
        let Self { layers, ranges, table, rows, pool } = self;
        let mut work = Work { ranges, table, rows, pool, effort: Effort::FULL };
        locate(survey, room, sighting, layers, &mut work)
    }

    /// Fills the [table](Self::table) with what was seen, for heights of camera and ceiling in rungs.
    pub fn weigh(
        &mut self,
        survey: &BoundaryEvidence<'_>,
        [height, ceiling]: [i8; 2],
        sighting: &WindowEvidence,
    ) {
        survey.ranges(ceiling, &mut self.ranges);
        weigh(&self.ranges, height, sighting, &mut self.table);
    }

    /// The evidence of the last look.
    #[must_use]
    pub fn table(&self) -> &EvidenceTable {
        &self.table
    }

    /// Finds the pose that explains some evidence best, which `fill` writes into the table.
    pub fn explain(&mut self, fill: impl FnOnce(&mut EvidenceTable)) -> Answer {
        let Self { layers, table, rows, pool, .. } = self;
        fill(table);
        rows.set(table);
        let found = search(rows, layers, |_, _| true, pool);
        let wanted = found.min(Effort::FULL.modes);
        let mut modes: Vec<ScoredPose> = Vec::with_capacity(wanted);
        for mode in &pool[..wanted] {
            modes.extend(layers.get(usize::from(mode.layer)).map(|layer| refine(table, layer, *mode)));
        }
        answer(layers, &mut modes)
    }
}
