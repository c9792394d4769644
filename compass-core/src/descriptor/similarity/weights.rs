//! The kind of cosine and the weights of the channels.

use crate::descriptor::channels::CHANNELS;

/// The kind of cosine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Similarity {
    /// The cosine of the descriptors themselves: the score of the paper.
    Plain,
    /// The cosine after subtraction of the mean of each channel.
    #[default]
    Centred,
}

/// Relative weights of the five channels in numerator and norms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Weights(pub [u8; CHANNELS]);

impl Weights {
    /// Equal weights, as in the paper.
    pub const EQUAL: Self = Self([16; CHANNELS]);
    /// Hit type only.
    pub const HIT_TYPE: Self = Self([0, 16, 0, 0, 0]);
    /// Range only.
    pub const RANGE: Self = Self([16, 0, 0, 0, 0]);
}

impl Default for Weights {
    fn default() -> Self {
        Self::EQUAL
    }
}
