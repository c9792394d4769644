//! Evidence computed from the plan itself.

use super::Evidence;
use compass_core::base::confidence::Confidence;
use compass_core::base::ladder::RANGE_RUNGS;
use compass_core::base::num::{BINS, CellNats, LogOdds, Nats};
use compass_core::base::scan::{Hit, Scan};
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::{PLANES, plane_of};
use compass_core::vision::boundary::{BoundaryEvidence, CELLS, NOMINAL_RUNG, RUNGS};
use compass_core::vision::windows::WindowEvidence;

/// Evidence of the right hit type at the right rung, its decrease per rung, and its minimum, nats.
const RIGHT: Nats = Nats::lit("2.5");
const PER_RUNG: Nats = Nats::lit("0.75");
const WRONG: Nats = Nats::lit("-1");

/// Writes the evidence of an ideal observer of a scan: 2.5 nat for the right hit type at the right rung, decreasing
/// with the distance in rungs, -1 nat for everything else.
pub fn sharp(scan: &Scan, table: &mut EvidenceTable) {
    for (bin, (&steps, &hit)) in scan.steps.iter().zip(&scan.hit).enumerate() {
        let seen = plane_of(steps, hit);
        for plane in 0..PLANES as u8 {
            let same = usize::from(plane) / RANGE_RUNGS == usize::from(seen) / RANGE_RUNGS;
            let off = if same { i32::from(plane.abs_diff(seen)) } else { i32::from(u8::MAX) };
            table.set(plane, bin, (RIGHT - PER_RUNG * off).max(WRONG));
        }
    }
}

/// The evidence of an ideal observer of a scan from a camera 1.5 m above the floor: 2.5 nats for the boundary of the floor
/// at the right rung, decreasing with the distance in rungs, -1 nat elsewhere; and log odds of +-4 of the right hit type.
#[must_use]
pub fn perfect(scan: &Scan) -> Evidence {
    let mut cells = vec![CellNats::ZERO; CELLS];
    let mut windows = WindowEvidence { hit: scan.hit, ..WindowEvidence::NOTHING };
    let mut confidence = [0; BINS];
    for (bin, (&steps, &hit)) in scan.steps.iter().zip(&scan.hit).enumerate() {
        if hit == Hit::Open {
            continue;
        }
        let seen = NOMINAL_RUNG + usize::from(plane_of(steps, Hit::Wall));
        for rung in 0..RUNGS {
            let value = (RIGHT - PER_RUNG * rung.abs_diff(seen) as i32).max(WRONG);
            cells[rung * BINS + bin] = CellNats::from_num(value);
        }
        confidence[bin] = 16;
        windows.evidence[bin] = LogOdds::from_num(if hit == Hit::Window { 4 } else { -4 });
    }
    windows.confidence = Confidence::new(&confidence);
    let boundaries = BoundaryEvidence::new(&cells).expect("as many cells as evidence has");
    Evidence::new(&boundaries, &windows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::base::num::CellNats;
    use compass_core::base::scan::Hit;

    #[test]
    fn the_right_plane_is_best() {
        let mut scan = Scan::OPEN;
        (scan.steps[5], scan.hit[5]) = (100, Hit::Window);
        let mut table = Box::new(EvidenceTable::EMPTY);
        sharp(&scan, &mut table);
        let best = |bin: usize| (0..PLANES as u8).max_by_key(|&plane| table.get(plane, bin)).unwrap();
        assert_eq!((best(5), best(6)), (plane_of(100, Hit::Window), plane_of(1500, Hit::Open)));
        assert_eq!(table.get(plane_of(100, Hit::Wall), 5), CellNats::from_num(WRONG));
    }
}
