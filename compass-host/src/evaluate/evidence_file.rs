//! The evidence of a frame as a gray image: one column per azimuth bin.
//!
//! Rows from the top: log-likelihood ratios of floor and ceiling boundaries in the layout of [`BoundaryEvidence`], in 1/16 nat
//! plus 128; a mask of known hit types; the classes of upright edges; the log odds of a window: high byte, then low byte, of the bits of [`LogOdds`]
//! plus 2^15.

use super::error::{EvaluateError, Result};
use super::journal::Fingerprint;
use crate::image_file::{self, Samples};
use crate::input::{self, limits};
use crate::locator::Seen;
use crate::output::{OutputError, write_file};
use compass_core::base::confidence::Confidence;
use compass_core::base::num::{BINS, CellNats, LogOdds};
use compass_core::base::scan::Hit;
use compass_core::vision::boundary::{BoundaryEvidence, CELLS};
use compass_core::vision::windows::WindowEvidence;
use image::ImageEncoder as _;
use std::path::Path;

/// Rows below those of the boundary evidence.
const EXTRA: usize = 4;
/// Rows of the image.
const ROWS: usize = CELLS / BINS + EXTRA;
/// Offset that makes log-likelihood ratios unsigned.
const MIDDLE_OF_CELLS: i16 = 1 << 7;
/// Offset that makes log odds unsigned.
const MIDDLE: i32 = 1 << 15;

/// The evidence of a frame, independent of the heights of camera and ceiling.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Evidence {
    /// [`ROWS`] rows of [`BINS`] bytes.
    rows: Vec<u8>,
    /// The first of them as log-likelihood ratios.
    cells: Vec<CellNats>,
}

impl Evidence {
    /// Copies what the search needs.
    #[must_use]
    pub fn new(boundaries: &BoundaryEvidence<'_>, windows: &WindowEvidence) -> Self {
        let odds = windows.evidence.map(|odds| (i32::from(odds.to_bits()) + MIDDLE) as u16);
        let cells = boundaries.cells().to_vec();
        let byte = |cell: &CellNats| (i16::from(cell.to_bits()) + MIDDLE_OF_CELLS) as u8;
        let mut rows: Vec<u8> = cells.iter().map(byte).collect();
        rows.extend(windows.confidence.sixteenths());
        rows.extend(windows.upright_edges);
        rows.extend(odds.map(|odds| (odds >> 8) as u8));
        rows.extend(odds.map(|odds| odds as u8));
        Self { rows, cells }
    }

    /// The evidence of observed frames.
    ///
    /// # Panics
    /// Never: observed frames have their boundary evidence.
    #[must_use]
    pub fn of(seen: &mut Seen<'_, '_>) -> Self {
        let windows = seen.window_evidence().clone();
        Self::new(&seen.boundaries().expect("frames that were seen have boundaries"), &windows)
    }

    /// The boundary evidence.
    #[must_use]
    pub fn boundaries(&self) -> BoundaryEvidence<'_> {
        BoundaryEvidence::new(&self.cells).expect("the stored rows have the size of the evidence")
    }

    /// The window evidence by bin; the windows themselves are not stored.
    #[must_use]
    pub fn windows(&self) -> WindowEvidence {
        let (high, low) = (self.row(2), self.row(3));
        let evidence = std::array::from_fn(|bin| {
            LogOdds::from_bits((i32::from(high[bin]) * 256 + i32::from(low[bin]) - MIDDLE) as i16)
        });
        WindowEvidence {
            hit: evidence.map(|odds| if odds > LogOdds::ZERO { Hit::Window } else { Hit::Wall }),
            confidence: Confidence::new(&self.row(0)),
            evidence,
            upright_edges: self.row(1),
            ..WindowEvidence::NOTHING
        }
    }

    /// One of the rows below the boundary evidence.
    fn row(&self, number: usize) -> [u8; BINS] {
        let rows = self.rows[CELLS..].as_chunks::<BINS>().0;
        rows[number]
    }

    /// Writes a PNG file, and returns its [`fingerprint`](Self::fingerprint).
    ///
    /// # Errors
    /// Names the file.
    pub fn write(&self, path: &Path) -> Result<String> {
        let mut png = Vec::new();
        image::codecs::png::PngEncoder::new(&mut png)
            .write_image(&self.rows, BINS as u32, ROWS as u32, image::ExtendedColorType::L8)
            .map_err(|source| OutputError::Encode { path: path.to_path_buf(), source })?;
        write_file(path, &png)?;
        Ok(Fingerprint::EMPTY.of(&png).text())
    }

    /// Copies a file that has this fingerprint; `false` if it has another one or cannot be read.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn copy(from: &Path, fingerprint: &str, to: &Path) -> Result<bool> {
        let bytes = input::read(from, limits().image_bytes).unwrap_or_default();
        let is_right = Fingerprint::EMPTY.of(&bytes).text() == fingerprint;
        if is_right {
            write_file(to, &bytes)?;
        }
        Ok(is_right)
    }

    /// The fingerprint of a file that is there.
    #[must_use]
    pub fn fingerprint(path: &Path) -> Option<String> {
        let bytes = input::read(path, limits().image_bytes).ok()?;
        Some(Fingerprint::EMPTY.of(&bytes).text())
    }

    /// Reads a file written by [`Self::write`].
    ///
    /// # Errors
    /// Names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let picture = image_file::read(path, limits().frame_pixels)?;
        let size = (picture.width as usize, picture.height as usize);
        let (Samples::Gray(rows), true) = (picture.samples, size == (BINS, ROWS)) else {
            return Err(EvaluateError::NoEvidence(path.to_path_buf()));
        };
        let cell = |byte: &u8| CellNats::from_bits((i16::from(*byte) - MIDDLE_OF_CELLS) as i8);
        let cells = rows[..CELLS].iter().map(cell).collect();
        Ok(Self { rows, cells })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_seen_round_trips() {
        let cells: Vec<_> = (0..CELLS).map(|at| CellNats::from_bits((at * at / 7) as i8)).collect();
        let boundaries = BoundaryEvidence::new(&cells).unwrap();
        let evidence = std::array::from_fn(|bin| LogOdds::from_bits(bin as i16 * 5 - 1024));
        let windows = WindowEvidence {
            hit: evidence.map(|odds: LogOdds| if odds > LogOdds::ZERO { Hit::Window } else { Hit::Wall }),
            confidence: Confidence::new(&std::array::from_fn(|bin| (bin % 17) as u8)),
            evidence,
            upright_edges: std::array::from_fn(|bin| (bin % 7) as u8),
            ..WindowEvidence::NOTHING
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("1.png");
        Evidence::new(&boundaries, &windows).write(&path).unwrap();
        let back = Evidence::read(&path).unwrap();
        assert_eq!(back.boundaries().cells(), boundaries.cells());
        assert_eq!(back.windows(), windows);
    }
}
