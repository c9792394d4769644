//! Which similarity, and what each channel counts in it.

use crate::descriptor::channels::CHANNELS;

/// Which cosine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Similarity {
    /// The paper's: the cosine of the descriptors as they are.
    Plain,
    /// The cosine after each channel's mean is removed.
    #[default]
    Centred,
}

/// Relative weights of the five channels in numerator and norms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Weights(pub [u8; CHANNELS]);

impl Weights {
    /// All channels alike, as in the paper.
    pub const EQUAL: Self = Self([16; CHANNELS]);
    /// Hit type alone.
    pub const HIT_TYPE: Self = Self([0, 16, 0, 0, 0]);
    /// Range alone.
    pub const RANGE: Self = Self([16, 0, 0, 0, 0]);
}

impl Default for Weights {
    fn default() -> Self {
        Self::EQUAL
    }
}
