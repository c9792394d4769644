//! The index of the exhaustive search: per candidate, 32 harmonics and bounds of the residual.

use super::lanes::{LANES, Lane};
use crate::base::num::BINS;
use crate::base::scan::Scan;
use crate::descriptor::harmonics::{HARMONICS, Pair, harmonics};
use crate::descriptor::similarity::Candidate;
use crate::descriptor::{BINS_I32, BINS_I64, CHANNELS, Descriptor};
use crate::map::site_map::SiteMap;

/// Number of candidates in a group: two per lane.
pub const GROUP: usize = 2 * LANES;

/// Harmonics and moments of 64 candidates: 44,864 bytes, 701 per candidate.
#[derive(Debug, Clone)]
pub struct Group {
    /// Harmonic k + 1 of a channel, in units of 2^-16 of the value 1 and shifted left per candidate:
    /// `[channel][k][half of the group][re, im][lane]`.
    pub(super) coefficients: [[[[Lane; 2]; 2]; HARMONICS]; CHANNELS],
    /// Left shift of the coefficients, per candidate.
    pub(super) shift: [u8; GROUP],
    /// Sum of the values, Q10.
    pub(super) sums: [[i32; GROUP]; CHANNELS],
    /// Sum of the squared values, Q20.
    pub(super) squares: [[i32; GROUP]; CHANNELS],
    /// Upper bound of the norm of the harmonics above the 32nd, Q10.
    pub(super) residual: [[u16; GROUP]; CHANNELS],
    /// Upper bound of the norm of the derivative (per radian) of the first 32 harmonics, Q10 / 8.
    pub(super) slope: [[u16; GROUP]; CHANNELS],
}

/// Upper bound of the norm of the harmonics of a candidate, so that products fit 16 bits: square root of half the largest
/// variances of the channels, in units of 2^-16.
pub(super) const LARGEST_NORM: u64 = 57_900;
/// One unit of a coefficient (2^-16) in units of [`harmonics`]: 360 x 2^10 x 2^14 / 2^16.
const UNIT: i64 = 92_160;

impl Group {
    /// A group of zeros: candidates whose score is 0.
    pub const EMPTY: Self = Self {
        coefficients: [[[[[0; LANES]; 2]; 2]; HARMONICS]; CHANNELS],
        shift: [0; GROUP],
        sums: [[0; GROUP]; CHANNELS],
        squares: [[0; GROUP]; CHANNELS],
        residual: [[0; GROUP]; CHANNELS],
        slope: [[0; GROUP]; CHANNELS],
    };

    /// Fills group `number` of a map: the candidates from 64 `number` on. Groups are independent and can be filled in any
    /// order and on any thread.
    ///
    /// # Cost
    /// Per candidate 320 dot products of 360 bins. Cortex-M7: `index` in `targets/budget.txt`.
    pub fn fill(&mut self, map: &SiteMap<'_>, number: usize) {
        *self = Self::EMPTY;
        let (mut scan, mut descriptor, mut candidate) = (Scan::OPEN, Descriptor::ZERO, Candidate::ZERO);
        for place in 0..GROUP {
            let Some(record) = map.get(number * GROUP + place) else { return };
            record.scan(&mut scan);
            descriptor.fill(&scan);
            candidate.fill(&descriptor);
            self.set(place, &candidate);
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::indexing_slicing,
        reason = "coefficients fit 16 bits by the choice of the shift, norms are clamped; places are below GROUP"
    )]
    fn set(&mut self, place: usize, candidate: &Candidate) {
        let spectrum = candidate.profile().values.each_ref().map(spectrum);
        let shift = headroom(&spectrum);
        let (half, lane) = (place / LANES, place % LANES);
        for (channel, harmonics) in spectrum.iter().enumerate() {
            for (slot, pair) in self.coefficients[channel].iter_mut().zip(harmonics) {
                for (part, &value) in slot[half].iter_mut().zip(pair) {
                    part[lane] = rounded_quotient(value << shift, UNIT) as i16;
                }
            }
            let (sum, square) = (candidate.sums()[channel], candidate.squares()[channel]);
            self.sums[channel][place] = sum;
            self.squares[channel][place] = square;
            let rest = Rest::of(harmonics, sum, square);
            self.residual[channel][place] = rest.residual.min(u32::from(u16::MAX)) as u16;
            self.slope[channel][place] = (rest.slope / 8 + 1).min(u32::from(u16::MAX)) as u16;
        }
        self.shift[place] = shift;
    }
}

/// The harmonics of a channel without its mean.
#[expect(clippy::cast_possible_truncation, reason = "means of 16-bit values")]
pub(super) fn spectrum(values: &[i16; BINS]) -> [Pair<i64>; HARMONICS] {
    let sum: i32 = values.iter().map(|&v| i32::from(v)).sum();
    let mean = (sum / BINS_I32) as i16;
    harmonics(&values.map(|v| v - mean))
}

/// Left shift of the coefficients for which none exceeds 16 bits and the norm does not exceed [`LARGEST_NORM`].
#[expect(clippy::cast_possible_truncation, reason = "at most 12")]
fn headroom(spectrum: &[[Pair<i64>; HARMONICS]; CHANNELS]) -> u8 {
    let parts = || spectrum.as_flattened().as_flattened().iter().map(|v| v.unsigned_abs());
    let largest = parts().max().unwrap_or(0);
    let energy: u64 = parts().map(|v| ((v >> 8) + 1).pow(2)).sum();
    let norm = energy.isqrt() + 1;
    let unit = UNIT.unsigned_abs();
    let fits = |bits: u32| (largest << bits) / unit < 32_767 && (norm << (bits + 8)) / unit <= LARGEST_NORM;
    // Twelve bits suffice: a candidate with less contrast has no match.
    (1..=12).take_while(|&bits| fits(bits)).last().unwrap_or(0) as u8
}

pub(super) fn rounded_quotient(value: i64, by: i64) -> i64 {
    (value + value.signum() * (by / 2)) / by
}

/// Bounds of the part of a channel that the harmonics leave.
pub(super) struct Rest {
    /// Upper bound of the norm of the higher harmonics, Q10.
    pub(super) residual: u32,
    /// Upper bound of the norm of the derivative of the lower harmonics, Q10.
    pub(super) slope: u32,
}

impl Rest {
    /// From the harmonics of a channel, its sum (Q10) and sum of squares (Q20).
    #[expect(clippy::cast_possible_truncation, reason = "square roots of 64-bit values fit 32 bits")]
    pub(super) fn of(harmonics: &[Pair<i64>; HARMONICS], sum: i32, square: i32) -> Self {
        // sum_k 2 |R|^2 / (360 2^28), with R shifted down by 8 bits.
        const ENERGY_UNIT: u64 = 180 << 12;
        let (mut kept, mut slope) = (0_u64, 0_u64);
        for (k, pair) in (1_u64..).zip(harmonics) {
            for part in pair {
                let down = part.unsigned_abs() >> 8;
                kept += down * down;
                slope += (k * (down + 1)).pow(2);
            }
        }
        let sum = i64::from(sum);
        let energy = (i64::from(square) - sum * sum / BINS_I64 + 1).max(0).unsigned_abs();
        // The rounding of the basis changes the kept energy by less than 2^-11 of the whole.
        let left = energy.saturating_sub(kept / ENERGY_UNIT) + (energy >> 11) + 2;
        Self { residual: left.isqrt() as u32 + 1, slope: (slope / ENERGY_UNIT + 1).isqrt() as u32 + 1 }
    }
}

/// The index of a site map: its groups.
#[derive(Debug, Clone, Copy)]
pub struct Index<'a> {
    groups: &'a [Group],
    len: usize,
}

impl<'a> Index<'a> {
    /// Number of groups of a map.
    #[must_use]
    pub const fn groups(map: &SiteMap<'_>) -> usize {
        map.len().div_ceil(GROUP)
    }

    /// A view of groups that were [filled](Group::fill) from this map; `None` if their number differs from
    /// [`Index::groups`].
    #[must_use]
    pub fn new(groups: &'a [Group], map: &SiteMap<'_>) -> Option<Self> {
        (groups.len() == Self::groups(map)).then_some(Self { groups, len: map.len() })
    }

    /// Number of candidates.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no candidate.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub(super) const fn as_groups(&self) -> &'a [Group] {
        self.groups
    }
}
