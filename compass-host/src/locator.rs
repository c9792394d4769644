//! From frames to a pose on a site: the core's search with its buffers.

use crate::site_file::Storey;
use compass_core::boundary::{Ranges, Survey};
use compass_core::likelihood::{Answer, Mode, Rows, Sheet, Table, answer, refine, search};
use compass_core::locate::{Effort, Fix, Room, Work, locate};
use compass_core::sight;
use compass_core::windows::level::Sighting;
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
    sheets: Vec<Sheet<'a>>,
    ranges: Box<Ranges>,
    table: Box<Table>,
    rows: Box<Rows<HEADINGS>>,
    pool: Vec<Mode>,
}

impl<'a> Locator<'a> {
    /// For these floors.
    ///
    /// # Errors
    /// [`NoPlan`] if one has no plan to refine poses on, as plain site maps have none.
    pub fn new(storeys: &[Storey<'a>]) -> Result<Self, NoPlan> {
        let mut sheets = Vec::new();
        for (number, storey) in (0..).zip(storeys) {
            let floor = storey.floor.ok_or(NoPlan)?;
            for layer in 0..floor.layers() as u8 {
                let plan = floor.plan(usize::from(layer)).ok_or(NoPlan)?;
                sheets.push(Sheet { map: storey.map, layer, plan, floor: number });
            }
        }
        Ok(Self {
            sheets,
            ranges: Box::new(Ranges::EMPTY),
            table: Box::new(Table::EMPTY),
            rows: Box::new(Rows::BLANK),
            pool: vec![Mode::NONE; POOL],
        })
    }

    /// The layers in the order that [`Mode::sheet`] counts them.
    #[must_use]
    pub fn sheets(&self) -> &[Sheet<'a>] {
        &self.sheets
    }

    /// Finds the pose that explains best what was seen, with what is known of the room.
    pub fn locate(&mut self, survey: &Survey<'_>, room: Room, sighting: &Sighting) -> Fix {
        let Self { sheets, ranges, table, rows, pool } = self;
        let mut work = Work { ranges, table, rows, pool, effort: Effort::FULL };
        locate(survey, room, sighting, sheets, &mut work)
    }

    /// Fills the [table](Self::table) with what was seen, for heights of camera and ceiling in rungs.
    pub fn weigh(&mut self, survey: &Survey<'_>, [height, ceiling]: [i8; 2], sighting: &Sighting) {
        survey.ranges(ceiling, &mut self.ranges);
        sight::evidence(&self.ranges, height, sighting, &mut self.table);
    }

    /// The evidence of the last look.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Finds the pose that explains some evidence best, which `fill` writes into the table.
    pub fn explain(&mut self, fill: impl FnOnce(&mut Table)) -> Answer {
        let Self { sheets, table, rows, pool, .. } = self;
        fill(table);
        rows.set(table);
        let found = search(rows, sheets, |_, _| true, pool);
        let wanted = found.min(Effort::FULL.modes);
        let mut modes: Vec<Mode> = Vec::with_capacity(wanted);
        for mode in &pool[..wanted] {
            modes.extend(sheets.get(usize::from(mode.sheet)).map(|sheet| refine(table, sheet, *mode)));
        }
        answer(sheets, &mut modes)
    }
}
