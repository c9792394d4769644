//! Line segments by edge drawing, after ELSED (Suárez, Buenaposada, Baumela: "ELSED: Enhanced line
//! segment drawing", Pattern Recognition 2022).
//!
//! smoothing -> gradient -> anchors -> drawing (walks along edges, fits lines, extends them at both ends,
//! jumps gaps, starts new lines where one ends) -> validation.
//!
//! All arithmetic is integer, except the ratio of sums in a line fit and the angle tests of gap jumping and
//! validation: these are single IEEE operations on `f32`, the same on every target.
//!
//! The workspace takes 3 bytes per pixel (smoothed image; magnitude, axis and label in 16 bits) and
//! a trail of pixels as long as a few segments. Where a test needs the direction of a gradient, it is computed
//! again from the smoothed image.

mod anchors;
mod cell;
mod draw;
mod gradient;
mod growth;
mod jump;
mod line;
mod parameters;
mod segment;
mod smooth;
mod validate;
mod walk;

pub use parameters::{MAX_SIDE, Parameters};
pub use segment::Segment;

use crate::base::num::saturate_to_u32;
use crate::base::raster::{BitMask, GrayImage};
use core::fmt;

/// Of the segment length that the detector finds, the reference, which is ELSED without changes, finds at least this share
/// within 2 px and 5 degrees, and vice versa, on built-up scenes.
///
/// Differences: smoothed pixels may differ by one level; a long line is refitted each time it has grown by a 64th of its
/// length, not after every pixel; validation samples the gradient across the line at whole pixels along it, before other
/// lines cross it; each attempt to jump a gap is tested on its own pixels alone; walks end at the image border.
pub const SEGMENT_COVERAGE: f32 = 0.9;

/// Elements of [`Workspace::cells`] and of [`Workspace::smoothed`] for an image.
#[must_use]
pub const fn pixels(width: u32, height: u32) -> usize {
    width as usize * height as usize
}

/// Elements of [`Workspace::trail`] for an image: an upper bound of the pixels of its longest segment, and one anchor
/// word per 64 columns of every other row.
#[must_use]
pub const fn trail_len(width: u32, height: u32) -> usize {
    2 * (width as usize + height as usize) + 64 + anchors::words(width as usize, height as usize)
}

/// Bytes of a whole [`Workspace`]: a little above 3 per pixel.
///
/// ```
/// assert!(compass_core::vision::segments::workspace_bytes(368, 360) < 430_000);
/// ```
#[must_use]
pub const fn workspace_bytes(width: u32, height: u32) -> usize {
    3 * pixels(width, height) + 4 * trail_len(width, height)
}

/// Memory lent to the detector; its initial contents are ignored.
#[derive(Debug)]
pub struct Workspace<'a> {
    /// [`pixels`] elements.
    pub cells: &'a mut [u16],
    /// [`pixels`] elements; holds the smoothed image after a detection.
    pub smoothed: &'a mut [u8],
    /// [`trail_len`] elements.
    pub trail: &'a mut [u32],
}

/// Result of a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Detected {
    /// Number of segments written.
    pub count: usize,
    /// Whether a list, a buffer or the step budget was exhausted: segments may be missing.
    pub truncated: bool,
}

/// Error of a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SegmentsError {
    /// Width or height of the image is above [`MAX_SIDE`].
    Size,
    /// Mask and image differ in size.
    Mask,
    /// A buffer of the workspace is too short for the image.
    Workspace,
}

impl fmt::Display for SegmentsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Size => "image side is above 8192 pixels",
            Self::Mask => "mask and image differ in size",
            Self::Workspace => "workspace is too small for the image",
        })
    }
}

impl core::error::Error for SegmentsError {}

/// Detects the line segments of an image, at most as many as `found` holds, in the order of completion.
///
/// No segment is drawn where `mask` is unset. Exclude what is not scene, dilated by 3 pixels: as far as smoothing and
/// gradient reach.
///
/// # Errors
/// [`SegmentsError`] if the image is too large, the mask differs in size, or the workspace is too short.
///
/// # Formats
/// Gray levels to end points in pixels; pixel centres are at integers. Smoothed gray levels are bytes, gradient magnitudes
/// 0 to 2040, sums of line fits exact integers, slopes and offsets of lines Q16.
///
/// # Accuracy
/// [`SEGMENT_COVERAGE`], which `compass compare` checks against the reference. The sides of a rectangle are found within 0.6
/// px (test `a_rectangle_has_four_sides`).
///
/// # Cost
/// A fixed number of passes over all pixels, and at most 16 drawing steps per pixel. Measured as `segments` in
/// `targets/budget.txt`.
///
/// # References
/// I. Suárez, J. M. Buenaposada and L. Baumela, "ELSED: Enhanced line segment drawing", Pattern Recognition 2022.
///
/// ```
/// use compass_core::GrayImage;
/// use compass_core::vision::segments::{Parameters, Segment, Workspace, detect, pixels, trail_len};
///
/// // One vertical edge, on column 7.
/// let row = [50, 50, 50, 50, 50, 50, 50, 125, 200, 200, 200, 200, 200, 200, 200, 200];
/// let image = [row; 16];
/// let mut workspace = Workspace {
///     cells: &mut vec![0; pixels(16, 16)],
///     smoothed: &mut vec![0; pixels(16, 16)],
///     trail: &mut vec![0; trail_len(16, 16)],
/// };
/// let image = GrayImage::new(image.as_flattened(), 16, 16).unwrap();
/// let parameters = Parameters { min_length: 8, ..Parameters::default() };
/// let mut found = [Segment::EMPTY; 4];
/// let detected = detect(&image, None, &parameters, &mut workspace, &mut found)?;
/// assert_eq!((detected.count, detected.truncated), (1, false));
/// assert!((found[0].x1 - 7.0).abs() <= 0.1 && (found[0].y1 - found[0].y2).abs() > 8.0);
/// # Ok::<(), compass_core::vision::segments::SegmentsError>(())
/// ```
// Inlined down to the loops over all pixels, so that they use the vector width of the caller's target features.
#[inline(always)]
pub fn detect(
    image: &GrayImage<'_>,
    mask: Option<&BitMask<'_>>,
    parameters: &Parameters,
    workspace: &mut Workspace<'_>,
    found: &mut [Segment],
) -> Result<Detected, SegmentsError> {
    let (width, height) = (image.width(), image.height());
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(SegmentsError::Size);
    }
    if mask.is_some_and(|mask| mask.width() != width || mask.height() != height) {
        return Err(SegmentsError::Mask);
    }
    let n = pixels(width, height);
    let (Some(cells), Some(smoothed), Some(trail)) = (
        workspace.cells.get_mut(..n),
        workspace.smoothed.get_mut(..n),
        workspace.trail.get_mut(..trail_len(width, height)),
    ) else {
        return Err(SegmentsError::Workspace);
    };
    if width < 3 || height < 3 {
        cells.fill(0);
        return Ok(Detected { count: 0, truncated: false });
    }
    let (anchors, trail) = trail.split_at_mut(anchors::words(width as usize, height as usize));
    prepare(image, mask, parameters, cells, smoothed);
    let mut threshold = parameters.anchor_threshold.min(2040);
    while !anchors::mark(cells, width as usize, threshold, anchors) && threshold > 0 {
        threshold /= 2;
    }
    let cells = walk::Cells { cells, width: width.cast_signed(), height: height.cast_signed() };
    let mut drawing = draw::Drawing::new(cells, smoothed, trail, found, *parameters);
    anchors::visit(&mut drawing, anchors);
    Ok(Detected { count: drawing.count, truncated: drawing.truncated })
}

/// Smooths an image with a Gaussian of 5 x 5 pixels, sigma 1 pixel. `row` is scratch of one row, `out` has the size of the
/// image.
///
/// # Formats
/// Gray levels to gray levels; kernel weights of 1/128 per axis, the border reflected without repeating the edge.
///
/// # Accuracy
/// Within one gray level of the exact, rounded sum (test `is_within_a_level_of_the_exact_sum`).
///
/// # Cost
/// One pass: 3 products per pixel and axis.
///
/// ```
/// use compass_core::GrayImage;
/// use compass_core::vision::segments::smooth;
///
/// let mut image = [0; 25];
/// image[12] = 255;
/// let (mut row, mut out) = ([0; 5], [0; 25]);
/// smooth(&GrayImage::new(&image, 5, 5).unwrap(), &mut row, &mut out);
/// // 255 (52 / 128)^2 in the middle.
/// assert_eq!((out[12], out[11], out[7]), (42, 25, 25));
/// ```
#[inline(never)]
pub fn smooth(image: &GrayImage<'_>, row: &mut [u16], out: &mut [u8]) {
    let width = image.width() as usize;
    let row = row.get_mut(..width).unwrap_or_default();
    for (y, out) in out.chunks_exact_mut(width.max(1)).enumerate() {
        smooth::smooth_row(image, y, row, out);
    }
}

/// Smooths the image and computes the gradient cells.
#[inline(always)]
fn prepare(
    image: &GrayImage<'_>,
    mask: Option<&BitMask<'_>>,
    parameters: &Parameters,
    cells: &mut [u16],
    smoothed: &mut [u8],
) {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let threshold = parameters.gradient_threshold.clamp(1, 2040);
    for y in 0..height {
        // The cells of row y are filled later and serve as scratch here.
        let (Some(column), Some(out)) =
            (cells.get_mut(y * width..(y + 1) * width), smoothed.get_mut(y * width..(y + 1) * width))
        else {
            return;
        };
        smooth::smooth_row(image, y, column, out);
        if y < 2 {
            column.fill(0);
            continue;
        }
        let rows = |k: usize| smoothed.get((y - k) * width..(y + 1 - k) * width).unwrap_or(&[]);
        let row = cells.get_mut((y - 1) * width..y * width).unwrap_or(&mut []);
        gradient::gradient_row([rows(2), rows(1), rows(0)], threshold, row);
        if let Some(mask) = mask {
            gradient::mask_row(mask, saturate_to_u32(y - 1), row);
        }
    }
    if let Some(last) = cells.get_mut((height - 1) * width..) {
        last.fill(0);
    }
}

#[cfg(test)]
mod tests;
