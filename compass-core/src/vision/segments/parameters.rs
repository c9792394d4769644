//! What the detector looks for.

use super::line;

/// What the detector looks for. The defaults are those of ELSED.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Smallest gradient magnitude |dx| + |dy| of a 3 x 3 Sobel filter, 1 to 2040.
    pub gradient_threshold: u16,
    /// How much an anchor's magnitude must exceed those of its neighbours across the edge, 0 to 2040.
    pub anchor_threshold: u16,
    /// Pixels of the first fit of a line, 8 to 15: segments are about as long at least. Small images need
    /// small windows.
    pub min_length: u8,
    /// Whether lines jump gaps of up to 9 pixels.
    pub jump: bool,
    /// Whether segments whose gradients point elsewhere are dropped.
    pub validate: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { gradient_threshold: 30, anchor_threshold: 8, min_length: 15, jump: true, validate: true }
    }
}

impl Parameters {
    pub(super) fn window(&self) -> usize {
        usize::from(self.min_length).clamp(line::LEAST_WINDOW, line::WINDOW)
    }
}
