//! Parameters of the detector.

use super::line;

/// Longest side of an image, in pixels.
pub const MAX_SIDE: u32 = 8192;

/// Parameters of the detector. The defaults are those of ELSED.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Smallest gradient magnitude |dx| + |dy| of a 3 x 3 Sobel filter that is an edge, 1 to 2040.
    pub gradient_threshold: u16,
    /// Smallest difference between an anchor's magnitude and those of its neighbours across the edge, 0 to 2040.
    pub anchor_threshold: u16,
    /// Window of the first line fit, 8 to 15 pixels: about the smallest segment length. Small images need small windows.
    pub min_length: u8,
    /// Whether lines jump gaps of up to 9 pixels.
    pub jump: bool,
    /// Whether segments are dropped whose gradients do not point across them.
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
