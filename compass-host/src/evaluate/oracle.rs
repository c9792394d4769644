//! Evidence computed from the plan itself.

use compass_core::base::ladder::RANGE_RUNGS;
use compass_core::base::num::Nats;
use compass_core::base::scan::Scan;
use compass_core::pose::evidence::EvidenceTable;
use compass_core::pose::{PLANES, plane_of};

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
