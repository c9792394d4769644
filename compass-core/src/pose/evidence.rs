//! Evidence of the images: log-likelihood ratios by direction, range and hit type.

use crate::base::ladder::{FRACTION_BITS, RANGE_RUNGS, position_of};
use crate::base::num::{BINS, CastNats, CellNats, LogOdds, Nats, ToFloat as _};
use crate::base::scan::Hit;
use crate::vision::boundary::{BoundaryEvidence, CEILING_SHIFT, rung_of};
use crate::vision::windows::WindowEvidence;
use bytemuck::{Pod, Zeroable};

/// Planes of a table: 72 of walls by range rung, 72 of windows by range rung, one of open directions.
pub const PLANES: usize = 2 * RANGE_RUNGS + 1;
/// The plane of open directions: no wall and no window within the largest range.
#[expect(clippy::cast_possible_truncation, reason = "the value is 144")]
pub const OPEN_PLANE: u8 = 2 * RANGE_RUNGS as u8;
/// Largest magnitude of a cell, 7.94 nats.
pub const LIMIT: CellNats = CellNats::MAX;

/// Log-likelihood ratios of what the plan can have in each direction: 145 planes x 360 bins, 52,200 bytes.
///
/// Bin j is the direction heading + j degrees, counter-clockwise. A direction without evidence is a column of zeros: it
/// does not change any score.
///
/// # Formats
/// Cells are [`CellNats`], 1/16 nat, within +-[`LIMIT`]. Planes 0 to 71 are walls at the rungs of
/// [`RUNG_MM`](crate::base::ladder::RUNG_MM), planes 72 to 143 windows at the same rungs, plane [`OPEN_PLANE`] is an open
/// direction.
///
/// # Accuracy
/// [`EvidenceTable::at`] places a range within 0.0021 rung of its exact logarithm
/// (test `values_between_rungs_are_interpolated_linearly`).
///
/// ```
/// use compass_core::pose::{EvidenceTable, plane_of};
/// use compass_core::{Hit, Nats};
///
/// // Evidence of a wall at 0.4 m, rung 0, straight ahead.
/// let mut table = Box::new(EvidenceTable::EMPTY);
/// table.set(plane_of(20, Hit::Wall), 0, Nats::ONE);
/// assert_eq!(table.at(20, Hit::Wall, 0), Nats::ONE);
/// assert_eq!(table.at(20, Hit::Window, 0), Nats::ZERO);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct EvidenceTable {
    values: [[CellNats; BINS]; PLANES],
}

impl EvidenceTable {
    /// A table of zeros: no evidence.
    pub const EMPTY: Self = Self { values: [[CellNats::ZERO; BINS]; PLANES] };

    /// All directions of one plane; `None` from [`PLANES`] on.
    #[must_use]
    pub fn plane(&self, plane: u8) -> Option<&[CellNats; BINS]> {
        self.values.get(usize::from(plane))
    }

    /// One value; 0 outside the table.
    #[must_use]
    pub fn get(&self, plane: u8, bin: usize) -> CellNats {
        self.plane(plane).and_then(|row| row.get(bin)).copied().unwrap_or(CellNats::ZERO)
    }

    /// Writes one value, clamped to +-[`LIMIT`]. Indices outside the table are ignored.
    pub fn set(&mut self, plane: u8, bin: usize, value: Nats) {
        if let Some(slot) = self.values.get_mut(usize::from(plane)).and_then(|row| row.get_mut(bin)) {
            *slot = clamped(value);
        }
    }

    /// Writes one plane, clamped to +-[`LIMIT`]. Indices outside the table are ignored.
    pub fn set_plane(&mut self, plane: u8, values: &[Nats; BINS]) {
        let Some(row) = self.values.get_mut(usize::from(plane)) else { return };
        for (slot, value) in row.iter_mut().zip(values) {
            *slot = clamped(*value);
        }
    }

    /// The value in a direction at a range in march steps of 0.02 m, interpolated between two rungs linearly in the
    /// logarithm of the range. Ranges below rung 0 (0.4 m) give the value of rung 0.
    #[must_use]
    pub fn at(&self, steps: u16, hit: Hit, bin: usize) -> CastNats {
        CastNats::from_bits(self.between(steps, hit).at(bin))
    }

    /// The two planes around a range.
    pub(super) fn between(&self, steps: u16, hit: Hit) -> Between<'_> {
        let position = position_of(steps);
        let rung = usize::from(position >> FRACTION_BITS);
        let (first, last) = match hit {
            Hit::Wall => (rung, RANGE_RUNGS - 1),
            Hit::Window => (RANGE_RUNGS + rung, 2 * RANGE_RUNGS - 1),
            Hit::Open => (2 * RANGE_RUNGS, 2 * RANGE_RUNGS),
        };
        let row = |plane: usize| self.values.get(plane.min(last)).unwrap_or(&[CellNats::ZERO; BINS]);
        Between {
            rows: [row(first), row(first + 1)],
            fraction: i32::from(position & ((1 << FRACTION_BITS) - 1)),
        }
    }
}

impl Default for EvidenceTable {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// A value clamped to +-[`LIMIT`].
#[expect(clippy::cast_possible_truncation, reason = "clamped to +-LIMIT")]
fn clamped(value: Nats) -> CellNats {
    CellNats::from_bits(value.clamp(-Nats::from(LIMIT), Nats::from(LIMIT)).to_bits() as i8)
}

/// Two neighbouring planes of a table and the interpolation weight of a range between them. Values and sums are the bits
/// of [`CastNats`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Between<'a> {
    rows: [&'a [CellNats; BINS]; 2],
    /// Weight of the second plane, 1/256.
    fraction: i32,
}

impl Between<'_> {
    /// The value in a direction; 0 from bin 360 on.
    #[inline]
    pub(super) fn at(&self, bin: usize) -> i32 {
        let [near, far] = self.rows.map(|row| row.get(bin).copied().unwrap_or(CellNats::ZERO));
        self.mix(near, far)
    }

    /// Adds to each sum the value of one of the directions centred on a bin, in clockwise order.
    #[inline]
    pub(super) fn add_around<const DIRECTIONS: usize>(&self, bin: usize, sums: &mut [i32; DIRECTIONS]) {
        let right = bin.wrapping_sub(DIRECTIONS / 2);
        let part = |row: &[CellNats; BINS]| {
            row.get(right..).and_then(|row| row.first_chunk::<DIRECTIONS>()).copied()
        };
        if let [Some(near), Some(far)] = self.rows.map(part) {
            for (sum, (near, far)) in sums.iter_mut().zip(near.iter().zip(&far).rev()) {
                *sum += self.mix(*near, *far);
            }
            return;
        }
        let mut from = (bin + DIRECTIONS / 2) % BINS;
        for sum in sums {
            *sum += self.at(from);
            from = from.checked_sub(1).unwrap_or(BINS - 1);
        }
    }

    fn mix(&self, near: CellNats, far: CellNats) -> i32 {
        let (near, far) = (i32::from(near.to_bits()), i32::from(far.to_bits()));
        (near << FRACTION_BITS) + (far - near) * self.fraction
    }
}

/// The plane of a ray: hit type, and the rung nearest in the logarithm of the range. Ranges below rung 0 (0.4 m) have
/// rung 0.
///
/// # Accuracy
/// The rung is within 0.504 of the exact position among the rungs (test `a_range_maps_to_the_nearest_rung`).
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "planes are at most OPEN_PLANE")]
pub const fn plane_of(steps: u16, hit: Hit) -> u8 {
    let rung = ((position_of(steps) + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS) as u8;
    match hit {
        Hit::Wall => rung,
        Hit::Window => RANGE_RUNGS as u8 + rung,
        Hit::Open => OPEN_PLANE,
    }
}

/// Outlier share: directions whose classification as window or wall is independent of the plan.
const OUTLIERS: f32 = 0.1;
/// Prior probability of a window in a direction of a plan.
const WINDOWS: f32 = 0.3;
/// Weight of the hit type relative to the range. Below 1 because the bins of one window have correlated errors.
const WEIGHT: f32 = 1.4;

/// Log-likelihood ratios of window and wall, per direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HitEvidence {
    /// Of a wall in the plan; 0 where nothing is known.
    pub wall: [CellNats; BINS],
    /// Of a window in the plan; 0 where nothing is known.
    pub window: [CellNats; BINS],
}

impl HitEvidence {
    /// Log-likelihood ratios from the log odds of windows: of a window in the plan `WEIGHT ln((1 - OUTLIERS) p / WINDOWS +
    /// OUTLIERS)`, with the probability p of a window; that of a wall has 1 - p and 1 - WINDOWS. Bins of confidence 0 have
    /// none.
    #[must_use]
    pub fn new(windows: &WindowEvidence) -> Self {
        let mut hits = Self { wall: [CellNats::ZERO; BINS], window: [CellNats::ZERO; BINS] };
        let known = windows.confidence.sixteenths();
        let cells = hits.window.iter_mut().zip(&mut hits.wall).zip(&windows.evidence).zip(known);
        for (((window, wall), odds), known) in cells {
            if *known > 0 {
                [*window, *wall] = hit_ratios(*odds).map(clamped);
            }
        }
        hits
    }
}

/// Fills a table with the sum of the log-likelihood ratios of floor, ceiling and hit type, for the heights in
/// [rungs](crate::base::ladder::height_rungs) of the camera above the floor and of the ceiling above the camera. The ceiling
/// counts half; [`OPEN_PLANE`] is 0.
///
/// # Formats
/// Sums are rounded to 1/16 nat and clamped to +-[`LIMIT`].
///
/// # Cost
/// One pass over the table: two sums for each of its 144 planes and 360 bins.
///
/// ```
/// use compass_core::base::confidence::Confidence;
/// use compass_core::base::num::{CellNats, LogOdds};
/// use compass_core::pose::evidence::{EvidenceTable, HitEvidence, weigh};
/// use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
/// use compass_core::vision::windows::WindowEvidence;
///
/// // No evidence of ranges; a window with log odds 4 in all directions.
/// let cells = vec![CellNats::ZERO; CELLS];
/// let mut windows = WindowEvidence::NOTHING;
/// windows.confidence = Confidence::CERTAIN;
/// windows.evidence = [LogOdds::from_num(4); 360];
/// let mut table = Box::new(EvidenceTable::EMPTY);
/// weigh(&BoundaryEvidence::new(&cells).unwrap(), [0, 0], &HitEvidence::new(&windows), &mut table);
/// // Planes 0 and 72: wall and window at rung 0.
/// assert!(table.get(0, 0) < 0 && table.get(72, 0) > 0);
/// ```
pub fn weigh(
    boundaries: &BoundaryEvidence<'_>,
    [camera, above]: [i8; 2],
    hits: &HitEvidence,
    table: &mut EvidenceTable,
) {
    let (walls, windows) = table.values.split_at_mut(RANGE_RUNGS);
    for ((rung, walls), windows) in (0..).zip(walls).zip(windows.iter_mut()) {
        let floor = boundaries.rung(0, rung_of(rung, camera.into()));
        let ceiling = boundaries.rung(1, rung_of(rung, above.into()));
        let cells = walls.iter_mut().zip(windows).zip(floor.iter().zip(ceiling));
        for (((wall, window), (floor, ceiling)), (on_wall, on_window)) in
            cells.zip(hits.wall.iter().zip(&hits.window))
        {
            let range = floor.to_bits().saturating_add(ceiling.to_bits() >> CEILING_SHIFT);
            *wall = CellNats::from_bits(range.saturating_add(on_wall.to_bits()));
            *window = CellNats::from_bits(range.saturating_add(on_window.to_bits()));
        }
    }
    if let Some(open) = table.values.last_mut() {
        *open = [CellNats::ZERO; BINS];
    }
}

/// Log-likelihood ratios of a window and of a wall in the plan, from the log odds of a window.
#[expect(clippy::cast_possible_truncation, reason = "a logarithm of 0.1 to 3.1 in 1/16 nat")]
fn hit_ratios(odds: LogOdds) -> [Nats; 2] {
    let window = 1.0 / (1.0 + libm::expf(-odds.to_float()));
    /// Bits of one nat.
    const NAT: f32 = Nats::ONE.to_bits() as f32;
    let ratio = |share: f32, usual: f32| {
        let ratio = (1.0 - OUTLIERS) * share / usual + OUTLIERS;
        Nats::from_bits(libm::roundf(NAT * WEIGHT * libm::logf(ratio)) as i32)
    };
    [ratio(window, WINDOWS), ratio(1.0 - window, 1.0 - WINDOWS)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::scan::MAX_STEPS;

    /// Position of a range in metres among the rungs.
    fn exact(metres: f64) -> f64 {
        71.0 * (metres / 0.4).ln() / 75f64.ln()
    }

    #[test]
    fn a_range_maps_to_the_nearest_rung() {
        let mut before = 0;
        for steps in 0..=MAX_STEPS {
            let plane = plane_of(steps, Hit::Wall);
            assert!(plane >= before, "monotone");
            before = plane;
            let off = f64::from(plane) - exact(f64::from(steps.max(20)) * 0.02);
            assert!(off.abs() <= 0.5 + 1.0 / 256.0, "{steps} steps: {off} rungs off");
            assert_eq!(plane_of(steps, Hit::Window), plane + RANGE_RUNGS as u8);
            assert_eq!(plane_of(steps, Hit::Open), OPEN_PLANE);
        }
        assert_eq!(
            (plane_of(1, Hit::Wall), plane_of(1500, Hit::Wall), plane_of(u16::MAX, Hit::Wall)),
            (0, 71, 71)
        );
    }

    #[test]
    fn values_between_rungs_are_interpolated_linearly() {
        let mut table = EvidenceTable::EMPTY;
        for rung in 0..RANGE_RUNGS as u8 {
            table.set(rung, 7, Nats::from_bits(rung.into()));
            table.set(RANGE_RUNGS as u8 + rung, 7, -Nats::from_bits(rung.into()));
        }
        table.set(OPEN_PLANE, 7, Nats::from_bits(50));
        for steps in 1..=MAX_STEPS {
            let expected = exact(f64::from(steps.max(20)) * 0.02);
            let got = table.at(steps, Hit::Wall, 7).to_num::<f64>() * 16.0;
            assert!((got - expected).abs() < 0.0021, "{steps} steps: {got}, not {expected}");
            assert_eq!(table.at(steps, Hit::Window, 7), -table.at(steps, Hit::Wall, 7));
            assert_eq!(table.at(steps, Hit::Open, 7), CastNats::from_num(50) / 16);
            assert_eq!(table.at(steps, Hit::Wall, 8), CastNats::ZERO);
        }
        assert_eq!(table.at(100, Hit::Wall, BINS), CastNats::ZERO);
    }

    #[test]
    fn values_are_clamped_and_bad_indices_ignored() {
        let mut table = EvidenceTable::EMPTY;
        table.set(3, 4, Nats::from_bits(1000));
        table.set(3, 5, Nats::from_bits(-1000));
        table.set(PLANES as u8, 0, Nats::from_bits(5));
        table.set(0, BINS, Nats::from_bits(5));
        (0..PLANES as u8).for_each(|plane| table.set(plane, BINS, Nats::from_bits(5)));
        assert_eq!((table.get(3, 4), table.get(3, 5), table.get(255, 0)), (LIMIT, -LIMIT, CellNats::ZERO));
        table.set(3, 4, Nats::ZERO);
        table.set(3, 5, Nats::ZERO);
        assert_eq!(table, EvidenceTable::EMPTY);
        let value = |plane: u8| CellNats::from_bits(plane as i8);
        (0..PLANES as u8).for_each(|plane| table.set(plane, 9, value(plane).into()));
        for plane in 0..PLANES as u8 {
            assert_eq!(table.get(plane, 9), value(plane).clamp(-LIMIT, LIMIT));
        }
        assert!(table.plane(OPEN_PLANE).is_some() && table.plane(PLANES as u8).is_none());
    }
}
