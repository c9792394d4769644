//! Comparison of evidence with the plan at a known pose: which drawn walls are confirmed and which are absent.
//!
//! The evidence of a direction favours one range. At the range of the drawn wall it confirms the wall. At a larger range
//! the line of sight passes through the drawn wall, which speaks against it. At a smaller range the wall is occluded, and
//! the direction is ignored. Errors of neighbouring bins and of frames from nearby positions are correlated: sum the
//! values over many frames before a decision.

use super::evidence::{EvidenceTable, OPEN_PLANE, plane_of};
use crate::base::ladder::RANGE_RUNGS;
use crate::base::num::{BINS, BinNats, CellNats};
use crate::base::scan::{Hit, Scan};

/// Range tolerance of a confirmed wall, in rungs of 6.3 %: 13 %.
const HERE: usize = 2;
/// Smallest range difference, in rungs of 6.3 %, of evidence before or beyond the drawn wall: 28 %.
const ELSEWHERE: usize = 4;

/// Per direction, the log-likelihood ratio of the drawn wall against the best range beyond it: positive where the wall is
/// confirmed, negative where the line of sight passes through it.
///
/// `scan` is cast from the plan at the pose of the cameras; `table` is the evidence in that pose's axes. The value is 0
/// where the plan has no wall (windows are transparent), where the table is 0, and where a nearer range has more evidence
/// than both (occlusion).
///
/// # Formats
/// Values in 1/16 nat, within twice the table's [`LIMIT`](super::LIMIT).
///
/// # Cost
/// At most 3 times [`RANGE_RUNGS`] look-ups per direction.
///
/// ```
/// use compass_core::pose::wall_check::compare;
/// use compass_core::pose::{EvidenceTable, plane_of};
/// use compass_core::{Hit, Nats, Scan};
///
/// // A wall drawn at 3 m in all directions; evidence of it ahead, and of one at 6 m to the left.
/// let scan = Scan { steps: [150; 360], hit: [Hit::Wall; 360] };
/// let mut table = Box::new(EvidenceTable::EMPTY);
/// table.set(plane_of(150, Hit::Wall), 0, Nats::ONE);
/// table.set(plane_of(300, Hit::Wall), 90, Nats::ONE);
/// let values = compare(&table, &scan);
/// assert_eq!([values[0], values[90], values[180]].map(|value| value.to_num::<f32>()), [1.0, -1.0, 0.0]);
/// ```
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

/// The largest value of a wall or a window over the rungs `from..to`.
#[expect(clippy::cast_possible_truncation, reason = "planes are below OPEN_PLANE")]
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
