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
mod parameters;
mod proposal;
mod proposals;
mod sample;
mod suppress;

use crate::base::raster::{GrayImage, RgbImage};
use crate::vision::segments::Segment;
pub use band::Row;
use core::fmt;
pub use edges::Edge;
pub use parameters::{BLACK, Parameters, REFERENCE_WIDTH};
pub use proposal::{ImageWindow, Proposal, Rejection};

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
