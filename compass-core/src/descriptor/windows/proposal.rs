//! Windows in an image, and proposals of windows.

/// A window: columns `x0` to below `x1`, rows `y0` to below `y1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageWindow {
    /// Leftmost column.
    pub x0: u16,
    /// Topmost row.
    pub y0: u16,
    /// One past the rightmost column.
    pub x1: u16,
    /// One past the lowest row.
    pub y1: u16,
    /// Score: contrast and texture in gray levels, plus the support of the edges, up to 64.
    pub score: i16,
}

/// Reason of the rejection of a proposal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Rejection {
    /// The mean is not above the brightness percentile of the band.
    Dark,
    /// The contrast to the wall beside it is too low.
    LowContrast,
    /// The texture does not exceed that of a wall.
    Texture,
    /// At the rim of the image circle or at the border of the image.
    Periphery,
    /// Dominated by red: people in safety gear.
    Red,
    /// Overlapped by a better proposal.
    Suppressed,
}

/// A pair of edges that can be a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Proposal {
    /// The box; its score is 0 if it was rejected before scoring.
    pub window: ImageWindow,
    /// Reason of the rejection; `None` for a window.
    pub rejection: Option<Rejection>,
}
