//! A window in an image, and what may be one.

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
    /// Gray levels of contrast and of texture, and up to 64 for edges seen along the whole height.
    pub score: i16,
}

/// Why a proposal is not a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Rejection {
    /// Not brighter than most of the band.
    Dark,
    /// Hardly brighter than the wall beside it.
    LowContrast,
    /// As even as a wall.
    Texture,
    /// At the rim of the lens's image or at the border.
    Periphery,
    /// Dominated by red: people in safety gear.
    Red,
    /// A better proposal overlaps it.
    Suppressed,
}

/// A pair of edges that may be a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Proposal {
    /// Where; its score is 0 if rejected before it was scored.
    pub window: ImageWindow,
    /// Why it is no window; none: it is one.
    pub rejection: Option<Rejection>,
}
