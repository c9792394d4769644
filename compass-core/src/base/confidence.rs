//! Confidence per bin.

use super::num::BINS;

/// Confidence of each bin of a scan in sixteenths: 0 is unknown, 16 certain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Confidence([u8; BINS]);

impl Confidence {
    /// Confidence of a certain bin.
    pub const FULL: u8 = 16;
    /// Every bin is certain.
    pub const CERTAIN: Self = Self([Self::FULL; BINS]);

    /// Every bin is unknown.
    pub const NONE: Self = Self([0; BINS]);

    /// Takes sixteenths per bin; clamps values above 16 to 16.
    ///
    /// ```
    /// use compass_core::base::confidence::Confidence;
    ///
    /// assert_eq!(Confidence::new(&[99; 360]), Confidence::CERTAIN);
    /// ```
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
