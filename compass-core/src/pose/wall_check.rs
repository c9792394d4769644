//! What is seen of the walls of the plan: whether they stand where they are drawn.
//!
//! At a pose that is known, the evidence of a direction prefers one range. If that is where the plan has a wall, the wall
//! stands; if it lies beyond, one looks through where the wall should be; if it lies before, something hides it, and
//! nothing can be said. Bins next to each other and frames from one place err together: the figures rank, and many of
//! them should agree before anything is taken down.

use super::evidence::{EvidenceTable, OPEN_PLANE, plane_of};
use crate::base::ladder::RANGE_RUNGS;
use crate::base::num::{BINS, BinNats, CellNats};
use crate::base::scan::{Hit, Scan};

/// Rungs of range, 6.3 % each, by which what is seen may miss the drawn wall and still be it.
const HERE: usize = 2;
/// From so many rungs on it lies before or beyond: 28 %.
const ELSEWHERE: usize = 4;

/// By how much the evidence prefers the drawn wall to anything beyond it: above 0 it stands, below 0 one looks
/// through. 0 where the plan has no wall, where nothing is known and where something nearer hides the wall; windows are
/// looked through in any case.
///
/// `scan` is the plan's at the pose that `table` was seen from.
#[must_use]
pub fn compare(table: &EvidenceTable, scan: &Scan) -> [BinNats; BINS] {
    let mut verdicts = [BinNats::ZERO; BINS];
    let rays = scan.steps.iter().zip(&scan.hit);
    for ((bin, verdict), (steps, hit)) in verdicts.iter_mut().enumerate().zip(rays) {
        if *hit == Hit::Wall {
            let drawn = usize::from(plane_of(*steps, Hit::Wall));
            let before = best(table, bin, 0, drawn.saturating_sub(ELSEWHERE - 1));
            let here = best(table, bin, drawn.saturating_sub(HERE), drawn + HERE + 1);
            let beyond =
                best(table, bin, drawn + ELSEWHERE, RANGE_RUNGS).max(table.get(OPEN_PLANE, bin).into());
            if before <= here.max(beyond) {
                *verdict = here - beyond;
            }
        }
    }
    verdicts
}

/// The most that speaks for a wall or a window at one of some rungs.
fn best(table: &EvidenceTable, bin: usize, from: usize, to: usize) -> BinNats {
    let at = |rung: usize| {
        let [wall, window] = [rung, RANGE_RUNGS + rung].map(|plane| table.get(plane as u8, bin));
        BinNats::from(wall.max(window))
    };
    (from..to.min(RANGE_RUNGS)).map(at).max().unwrap_or(CellNats::MIN.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::num::Nats;
    use std::boxed::Box;

    #[test]
    fn walls_stand_are_looked_through_or_hidden() {
        let mut scan = Scan { steps: [200; BINS], hit: [Hit::Wall; BINS] };
        let drawn = plane_of(200, Hit::Wall);
        let mut table = Box::new(EvidenceTable::EMPTY);
        table.set(drawn + 1, 0, Nats::from_bits(50));
        table.set(drawn + 9, 1, Nats::from_bits(40));
        table.set(RANGE_RUNGS as u8 + drawn + 9, 2, Nats::from_bits(30));
        table.set(drawn - 9, 3, Nats::from_bits(60));
        table.set(drawn + 9, 3, Nats::from_bits(50));
        table.set(OPEN_PLANE, 4, Nats::from_bits(20));
        scan.hit[5] = Hit::Window;
        table.set(drawn + 9, 5, Nats::from_bits(40));
        let verdicts = compare(&table, &scan);
        assert_eq!(verdicts[..6], [50, -40, -30, 0, -20, 0].map(BinNats::from_bits));
        assert_eq!(compare(&table, &Scan::OPEN), [BinNats::ZERO; BINS], "nothing is drawn");
    }

    #[test]
    fn the_ends_of_the_ladder_are_ranges_too() {
        let table = Box::new(EvidenceTable::EMPTY);
        for steps in [1, 20, 1500] {
            let scan = Scan { steps: [steps; BINS], hit: [Hit::Wall; BINS] };
            assert_eq!(compare(&table, &scan), [BinNats::ZERO; BINS], "{steps}");
        }
    }
}
