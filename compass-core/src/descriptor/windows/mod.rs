//! The paper's window finder (paper: window detection), in pixels of the unrectified fisheye image. Needs the feature
//! `paper-windows`.
//!
//! 1. Band: the rows that are bright and dense in upright segments.
//! 2. Edges: upright segments of the band, clustered along x.
//! 3. Proposals: pairs of edges, tested for brightness, contrast to the adjacent wall, and texture.
//! 4. Suppression: rejection of proposals at the rim or dominated by red, then non-maximum suppression.
//!
//! The columns of the image are taken as vertical. The result does not depend on which side is up, and windows that lens or
//! pose tilt are missed. Brightness thresholds are relative to the frame. Lengths are stated for an image
//! [`REFERENCE_WIDTH`] = 1472 pixels wide and scaled to the width of the image. All arithmetic is in integers.

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

/// Memory lent to the finder. Its former contents do not matter.
#[derive(Debug)]
pub struct Workspace<'a> {
    /// One element per row of the image.
    pub rows: &'a mut [Row],
    /// One element per column of the image.
    pub columns: &'a mut [u16],
    /// One element per upright segment of the band. Holds the edges afterwards, from left to right.
    pub edges: &'a mut [Edge],
    /// Holds the proposals afterwards: first those that passed the tests of brightness, contrast and texture, then as many
    /// of the others as fit, for debug images.
    pub proposals: &'a mut [Proposal],
}

/// Counts of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// Number of windows written.
    pub count: usize,
    /// Whether a buffer was full, so that windows can be missing. Proposals rejected by the first three tests do not count.
    pub truncated: bool,
    /// Rows of the band: the first, and one past the last.
    pub band: (u16, u16),
    /// Number of edges in [`Workspace::edges`].
    pub edges: usize,
    /// Number of proposals in [`Workspace::proposals`].
    pub proposals: usize,
}

/// Errors of [`find`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PaperError {
    /// Colour image and gray image differ in size.
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

/// Finds at most `windows.len()` windows, by descending score.
///
/// `segments` are those of the image, in its pixels. Without `colour` no proposal is rejected as red.
///
/// # Formats
/// Windows are half-open boxes in whole pixels, column from the left, row from the top.
///
/// # Errors
/// [`PaperError::Colour`] for a colour image of another size, [`PaperError::Workspace`] for too few rows or columns.
///
/// # Cost
/// One pass over the pixels; quadratic in the edges within the largest width. A proposal is sampled at no more than
/// 24 x 24 points, as is each strip of wall beside it.
///
/// # References
/// The paper's window detection.
///
/// ```
/// use compass_core::GrayImage;
/// use compass_core::descriptor::windows::{Edge, ImageWindow, Parameters, Proposal, Row, Workspace, find};
///
/// // A bright image of 8 x 6 pixels without segments has no windows, and a band of all its rows.
/// let image = GrayImage::new(&[200; 48], 8, 6)?;
/// let (mut rows, mut columns) = ([Row::default(); 6], [0; 8]);
/// let (mut edges, mut proposals) = ([Edge::default(); 4], [Proposal::default(); 4]);
/// let mut workspace =
///     Workspace { rows: &mut rows, columns: &mut columns, edges: &mut edges, proposals: &mut proposals };
/// let mut windows = [ImageWindow::default(); 4];
/// let found = find(&image, None, &[], &Parameters::default(), &mut workspace, &mut windows)?;
/// assert_eq!((found.count, found.band, found.truncated), (0, (0, 6), false));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
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
