//! The paper's window finder with its buffers, on one camera's unrectified frame: the baseline.

use crate::frame::Frame;
use compass_core::base::raster::RgbImage;
use compass_core::descriptor::windows::{
    self as paper, Edge, Found, ImageWindow, PaperError, Parameters, Proposal, Row, Workspace,
};
use compass_core::vision::segments::Segment;

/// Most edges, proposals and windows of a frame.
const MAX_EDGES: usize = 2048;
const MAX_PROPOSALS: usize = 16_384;
const MAX_WINDOWS: usize = 256;

/// The finder: constructed once, then used for frames of one size without allocating.
#[derive(Debug)]
pub struct PaperFinder {
    rows: Vec<Row>,
    columns: Vec<u16>,
    edges: Vec<Edge>,
    proposals: Vec<Proposal>,
    windows: Vec<ImageWindow>,
    found: Found,
}

impl PaperFinder {
    /// Buffers for frames of `width` x `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            rows: vec![Row::default(); height as usize],
            columns: vec![0; width as usize],
            edges: vec![Edge::default(); MAX_EDGES],
            proposals: vec![Proposal::default(); MAX_PROPOSALS],
            windows: vec![ImageWindow::default(); MAX_WINDOWS],
            found: Found { count: 0, truncated: false, band: (0, 0), edges: 0, proposals: 0 },
        }
    }

    /// Finds the windows of a frame with these segments.
    ///
    /// # Errors
    /// [`PaperError::Workspace`] for a frame larger than the buffers.
    pub fn find(&mut self, frame: &Frame, segments: &[Segment]) -> Result<Found, PaperError> {
        let colour = frame.rgb().and_then(|rgb| RgbImage::new(rgb, frame.width(), frame.height()).ok());
        let Self { rows, columns, edges, proposals, windows, found } = self;
        let mut workspace = Workspace { rows, columns, edges, proposals };
        let parameters = Parameters::default();
        *found = paper::find(&frame.gray(), colour.as_ref(), segments, &parameters, &mut workspace, windows)?;
        Ok(*found)
    }

    /// The windows of the last frame, by descending score.
    #[must_use]
    pub fn windows(&self) -> &[ImageWindow] {
        &self.windows[..self.found.count]
    }

    /// Its edges, from left to right.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges[..self.found.edges]
    }

    /// The proposals with their verdicts.
    #[must_use]
    pub fn proposals(&self) -> &[Proposal] {
        &self.proposals[..self.found.proposals]
    }

    /// First row of the searched band, and one past its last.
    #[must_use]
    pub const fn band(&self) -> (u16, u16) {
        self.found.band
    }
}
