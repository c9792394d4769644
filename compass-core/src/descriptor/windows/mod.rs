//! The paper's window finder (paper: window detection), in pixels of the fisheye image as it is.
//!
//! 1. band: the rows that are bright and dense in upright segments;
//! 2. edges: upright segments of the band, clustered along x;
//! 3. proposals: pairs of edges, checked for brightness, contrast to the wall beside them and texture;
//! 4. suppression: proposals at the rim or dominated by red go, then those a better one overlaps.
//!
//! The image's own columns serve as verticals, so up and down do not matter, and a lens or pose that tilts
//! windows loses them. Every threshold on brightness is relative to the frame. Lengths are stated for an image
//! 1472 pixels wide ([`REFERENCE_WIDTH`]) and scaled to the width of the image.
//!
//! All integer. One pass over the pixels; a proposal is sampled at no more than 24 x 24 points of itself
//! and of either strip of wall beside it.

mod band;
mod edges;
mod proposals;
mod sample;
mod suppress;

use crate::base::raster::{GrayImage, RgbImage};
use crate::vision::segments::Segment;
pub use band::Row;
use core::fmt;
pub use edges::Edge;

/// Width in pixels of the image for which lengths are stated.
pub const REFERENCE_WIDTH: u16 = 1472;

/// Pixels up to this level are not scene but the black around the lens's image.
pub const BLACK: u8 = 12;

/// What the finder looks for. Lengths in pixels of an image [`REFERENCE_WIDTH`] wide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Percentile of the rows' scores above which a row may belong to the band.
    pub band_percentile: u8,
    /// Least slope |dy| / |dx| of an upright segment, 1/1024: by default the tangent of 30 degrees.
    pub slope: u16,
    /// Shortest segment.
    pub min_length: u16,
    /// Farthest that segments of one edge lie apart along x.
    pub gap: u16,
    /// Narrowest window.
    pub min_width: u16,
    /// Widest window.
    pub max_width: u16,
    /// Height the two edges of a window share, in percent of the shorter one.
    pub shared_percent: u8,
    /// Percentile of the band's pixels above which the mean of a window lies.
    pub brightness_percentile: u8,
    /// Narrowest strip of wall beside a window; otherwise a quarter of the window's width.
    pub min_flank: u16,
    /// By how much a window outshines the wall beside it, in percent of the wall's brightness.
    pub contrast_percent: u8,
    /// Intersection over union in percent above which the worse of two proposals goes.
    pub overlap_percent: u8,
    /// Share of red pixels in percent above which a proposal goes.
    pub red_percent: u8,
    /// Radius in percent of the lens's image beyond which there are no windows.
    pub radius_percent: u8,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            band_percentile: 50,
            slope: 591,
            min_length: 29,
            gap: 8,
            min_width: 12,
            max_width: 400,
            shared_percent: 50,
            brightness_percentile: 60,
            min_flank: 6,
            contrast_percent: 10,
            overlap_percent: 30,
            red_percent: 15,
            radius_percent: 95,
        }
    }
}

impl Parameters {
    /// The same with lengths in pixels of an image of `width`, none below 1.
    fn scaled(self, width: u32) -> Self {
        let scale = |length: u16| {
            let length = u64::from(length) * u64::from(width) / u64::from(REFERENCE_WIDTH);
            length.clamp(1, u64::from(u16::MAX)) as u16
        };
        Self {
            min_length: scale(self.min_length),
            gap: scale(self.gap),
            min_width: scale(self.min_width),
            max_width: scale(self.max_width),
            min_flank: scale(self.min_flank),
            ..self
        }
    }
}

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

/// Memory lent to the finder; what it holds before does not matter.
#[derive(Debug)]
pub struct Workspace<'a> {
    /// As many elements as the image has rows.
    pub rows: &'a mut [Row],
    /// As many elements as the image has columns.
    pub columns: &'a mut [u16],
    /// One element per upright segment of the band; afterwards the edges, from left to right.
    pub edges: &'a mut [Edge],
    /// The proposals; afterwards first those bright, contrasted and textured enough, then as many of the others
    /// as fit. For pictures of what was considered.
    pub proposals: &'a mut [Proposal],
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// Number of windows written.
    pub count: usize,
    /// Whether a buffer overflowed: more could have been found. Proposals rejected by the first three checks
    /// do not count.
    pub truncated: bool,
    /// First row of the band and one past the last.
    pub band: (u16, u16),
    /// Number of edges left in [`Workspace::edges`].
    pub edges: usize,
    /// Number of proposals left in [`Workspace::proposals`].
    pub proposals: usize,
}

/// Why nothing was looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PaperError {
    /// The colour image is not of the gray image's size.
    Colour,
    /// [`Workspace::rows`] or [`Workspace::columns`] is too short.
    Workspace,
}

impl fmt::Display for PaperError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Colour => "colour and gray image differ in size",
            Self::Workspace => "workspace is too small for the image",
        })
    }
}

impl core::error::Error for PaperError {}

/// Finds windows, at most as many as `windows` holds, by falling score.
///
/// `segments` are those of the image, in its pixels. Without `colour` nothing is rejected as red.
///
/// # Errors
/// [`PaperError`] for a colour image of another size, rows or columns too short.
pub fn find(
    image: &GrayImage<'_>,
    colour: Option<&RgbImage<'_>>,
    segments: &[Segment],
    parameters: &Parameters,
    workspace: &mut Workspace<'_>,
    windows: &mut [ImageWindow],
) -> Result<Found, PaperError> {
    let (width, height) = (image.width(), image.height());
    if colour.is_some_and(|colour| colour.width() != width || colour.height() != height) {
        return Err(PaperError::Colour);
    }
    let (Some(rows), Some(columns)) =
        (workspace.rows.get_mut(..height as usize), workspace.columns.get_mut(..width as usize))
    else {
        return Err(PaperError::Workspace);
    };
    let parameters = &parameters.scaled(width);
    let lens = band::lens(image, rows, columns);
    let band = band::find(&lens, segments, parameters, rows);
    let (edges, edges_cut) = edges::cluster(segments, band, parameters, workspace.edges);
    let edges = workspace.edges.get(..edges).unwrap_or(&[]);

    let levels = proposals::Levels::new(image, &lens, band, parameters);
    let mut list = proposals::List::new(workspace.proposals);
    proposals::pair(image, edges, &levels, parameters, &mut list);
    let passed = list.passed();
    suppress::reject(image, colour, &lens, parameters, passed);
    suppress::suppress(parameters, passed);

    let mut accepted = passed.iter().filter(|p| p.rejection.is_none()).map(|p| p.window);
    let mut count = 0;
    for (slot, window) in windows.iter_mut().zip(&mut accepted) {
        *slot = window;
        count += 1;
    }
    let windows_cut = accepted.next().is_some();
    let (proposals, list_cut) = list.end();
    Ok(Found { count, truncated: edges_cut || list_cut || windows_cut, band, edges: edges.len(), proposals })
}

#[cfg(test)]
mod tests;
