//! Descriptors in the precision of matching: 16-bit values with 10 fractional bits.

use crate::base::num::BINS;
use crate::descriptor::{CHANNELS, Descriptor};

/// A descriptor rounded to 2^-10. The sum of 360 products of two values fits 32 bits: 360 x 1.5^2 x 2^20 < 2^30.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Profile {
    /// `values[channel][bin]` in units of 2^-10, 0..=1536.
    pub values: [[i16; BINS]; CHANNELS],
}

impl Profile {
    /// All zero.
    pub const ZERO: Self = Self { values: [[0; BINS]; CHANNELS] };

    /// Sets the values of a descriptor, rounded to the nearest.
    pub fn fill(&mut self, descriptor: &Descriptor) {
        for (values, levels) in self.values.iter_mut().zip(&descriptor.levels) {
            for (value, level) in values.iter_mut().zip(levels) {
                // 14 to 10 fractional bits; channel values are at most 1.5.
                *value = (level.to_bits().clamp(0, 3 << 13) + 8) >> 4;
            }
        }
    }
}

impl Default for Profile {
    fn default() -> Self {
        Self::ZERO
    }
}

impl From<&Descriptor> for Profile {
    fn from(descriptor: &Descriptor) -> Self {
        let mut profile = Self::ZERO;
        profile.fill(descriptor);
        profile
    }
}

/// A candidate prepared for scoring: its profile, and sums per channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    pub(super) profile: Profile,
    pub(super) sums: [i32; CHANNELS],
    pub(super) squares: [i32; CHANNELS],
}

impl Candidate {
    /// All zero, to be filled.
    pub const ZERO: Self = Self { profile: Profile::ZERO, sums: [0; CHANNELS], squares: [0; CHANNELS] };

    /// Sets the values of a descriptor.
    pub fn fill(&mut self, descriptor: &Descriptor) {
        self.profile.fill(descriptor);
        for ((values, sum), square) in self.profile.values.iter().zip(&mut self.sums).zip(&mut self.squares) {
            *sum = values.iter().map(|&v| i32::from(v)).sum();
            *square = values.iter().map(|&v| i32::from(v) * i32::from(v)).sum();
        }
    }

    /// The profile.
    #[must_use]
    pub const fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Sum of the values per channel, in units of 2^-10.
    #[must_use]
    pub const fn sums(&self) -> &[i32; CHANNELS] {
        &self.sums
    }

    /// Sum of the squared values per channel, in units of 2^-20.
    #[must_use]
    pub const fn squares(&self) -> &[i32; CHANNELS] {
        &self.squares
    }
}

impl Default for Candidate {
    fn default() -> Self {
        Self::ZERO
    }
}

impl From<&Descriptor> for Candidate {
    fn from(descriptor: &Descriptor) -> Self {
        let mut candidate = Self::ZERO;
        candidate.fill(descriptor);
        candidate
    }
}
