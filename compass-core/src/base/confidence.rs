//! How far each bin may be trusted.

use super::num::BINS;

/// How far each bin of a query may be trusted, in sixteenths: 0 unknown, 16 certain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Confidence([u8; BINS]);

impl Confidence {
    /// The value of a bin that is certain.
    pub const FULL: u8 = 16;
    /// Every bin is certain.
    pub const CERTAIN: Self = Self([Self::FULL; BINS]);

    /// Nothing is known of any bin.
    pub const NONE: Self = Self([0; BINS]);

    /// From sixteenths per bin; values above 16 count as 16.
    #[must_use]
    pub fn new(sixteenths: &[u8; BINS]) -> Self {
        Self(sixteenths.map(|c| c.min(Self::FULL)))
    }

    /// Sixteenths per bin.
    #[must_use]
    pub const fn sixteenths(&self) -> &[u8; BINS] {
        &self.0
    }

    /// Whether every bin is certain.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        *self == Self::CERTAIN
    }
}

impl Default for Confidence {
    fn default() -> Self {
        Self::CERTAIN
    }
}
