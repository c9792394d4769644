//! A scan packed into 405 bytes.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 360 | range code per bin; 255 for an open bin |
//! | 360 | 45 | one bit per bin, lowest first: 1 for a window |
//!
//! Codes 0..=254 stand for ranges of 1 to 1500 steps: single steps up to 1.2 m, then a geometric ladder of 1.6 %. The
//! rounding error is at most half a rung: 0.8 % or half a step.

use crate::base::num::BINS;
use crate::base::scan::{Hit, MAX_STEPS, Scan};

/// Length of a packed scan.
pub const PACKED_SCAN_BYTES: usize = BINS + BINS / 8;

/// Code of an open bin.
const OPEN: u8 = 255;
/// Number of codes that stand for a range.
const RUNGS: usize = 255;

/// Steps per code: `next = this + max(1, this / GROWTH)`, the rung of code 254 being 1500.
#[expect(
    clippy::cast_possible_truncation,
    clippy::indexing_slicing,
    reason = "evaluated at compile time, at most MAX_STEPS"
)]
pub(crate) const LADDER: [u16; RUNGS] = {
    // In 1/1024 steps, so that rounding errors do not accumulate.
    const GROWTH: u32 = 60;
    let mut ladder = [0; RUNGS];
    let mut at = 1024_u32;
    let mut code = 0;
    while code < RUNGS {
        let steps = (at + 512) / 1024;
        ladder[code] = if steps > MAX_STEPS as u32 { MAX_STEPS } else { steps as u16 };
        let growth = at / GROWTH;
        at += if growth > 1024 { growth } else { 1024 };
        code += 1;
    }
    assert!(ladder[RUNGS - 1] == MAX_STEPS, "the ladder must reach the largest range");
    assert!(ladder[RUNGS - 3] < MAX_STEPS, "no code may be wasted");
    ladder
};

/// A scan in the format of a site map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PackedScan(pub [u8; PACKED_SCAN_BYTES]);

impl PackedScan {
    /// Packs a scan; ranges are rounded to the nearest rung of the ladder.
    ///
    /// # Accuracy
    /// Ranges up to 60 steps (1.2 m) are exact, larger ones within 0.83 % and half a step
    /// (test `ranges_are_kept_within_half_a_rung`).
    ///
    /// ```
    /// use compass_core::map::site_map::PackedScan;
    /// use compass_core::{Hit, Scan};
    ///
    /// let scan = Scan { steps: [50; 360], hit: [Hit::Wall; 360] };
    /// let mut unpacked = Scan::OPEN;
    /// PackedScan::new(&scan).unpack(&mut unpacked);
    /// assert_eq!(unpacked, scan, "1 m is exact");
    /// ```
    #[must_use]
    pub fn new(scan: &Scan) -> Self {
        let mut bytes = [0; PACKED_SCAN_BYTES];
        let (codes, windows) = bytes.split_at_mut(BINS);
        for (code, (&steps, &hit)) in codes.iter_mut().zip(scan.steps.iter().zip(&scan.hit)) {
            *code = if hit == Hit::Open { OPEN } else { ladder_code(steps) };
        }
        for (byte, hits) in windows.iter_mut().zip(scan.hit.as_chunks::<8>().0) {
            for (bit, &hit) in hits.iter().enumerate() {
                *byte |= u8::from(hit == Hit::Window) << bit;
            }
        }
        Self(bytes)
    }

    /// Unpacks into `scan`. Any bytes give a valid scan.
    pub fn unpack(&self, scan: &mut Scan) {
        unpack(&self.0, scan);
    }
}

/// Unpacks bytes into `scan`.
pub(crate) fn unpack(bytes: &[u8; PACKED_SCAN_BYTES], scan: &mut Scan) {
    let (codes, windows) = bytes.split_at(BINS);
    for (steps, &code) in scan.steps.iter_mut().zip(codes) {
        *steps = LADDER.get(usize::from(code)).copied().unwrap_or(MAX_STEPS);
    }
    for ((hits, codes), &byte) in
        scan.hit.as_chunks_mut::<8>().0.iter_mut().zip(codes.as_chunks::<8>().0).zip(windows)
    {
        for (bit, (hit, &code)) in hits.iter_mut().zip(codes).enumerate() {
            *hit = match (code, byte >> bit & 1) {
                (OPEN, _) => Hit::Open,
                (_, 1) => Hit::Window,
                _ => Hit::Wall,
            };
        }
    }
}

/// The code of the nearest rung; of two rungs at the same distance the lower one.
#[expect(clippy::cast_possible_truncation, reason = "codes of ranges are at most 254")]
pub(crate) fn ladder_code(steps: u16) -> u8 {
    let above = LADDER.partition_point(|&rung| rung < steps);
    let rung = |code: usize| LADDER.get(code).copied();
    let code = match (above.checked_sub(1).and_then(rung), rung(above)) {
        (Some(low), Some(high)) if steps - low <= high - steps => above - 1,
        (_, Some(_)) => above,
        _ => RUNGS - 1,
    };
    code as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_kept_within_half_a_rung() {
        for steps in 1..=MAX_STEPS {
            let kept = LADDER[usize::from(ladder_code(steps))];
            let error = f64::from(kept.abs_diff(steps));
            assert!(error <= 0.5 + 0.0083 * f64::from(steps), "{steps} became {kept}");
            assert!(steps > 60 || error == 0.0, "{steps} became {kept}");
        }
        assert!(LADDER.windows(2).all(|w| w[0] < w[1] || w[1] == MAX_STEPS));
    }

    #[test]
    fn packing_keeps_hits_and_is_idempotent() {
        let mut scan = Scan::OPEN;
        for j in 0..BINS {
            scan.hit[j] = [Hit::Open, Hit::Window, Hit::Wall][(j * j) % 3];
            if scan.hit[j] != Hit::Open {
                scan.steps[j] = (1 + (j * 37) % 1500) as u16;
            }
        }
        let mut once = Scan::OPEN;
        PackedScan::new(&scan).unpack(&mut once);
        assert_eq!(scan.hit, once.hit);
        let mut twice = Scan::OPEN;
        PackedScan::new(&once).unpack(&mut twice);
        assert_eq!(once, twice);
    }

    #[test]
    fn any_bytes_unpack_to_a_valid_scan() {
        let mut scan = Scan::OPEN;
        for byte in [0, 1, 254, 255] {
            PackedScan([byte; PACKED_SCAN_BYTES]).unpack(&mut scan);
            assert!(scan.steps.iter().all(|s| (1..=MAX_STEPS).contains(s)));
        }
    }
}
