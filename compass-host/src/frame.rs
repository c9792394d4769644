//! Camera frames: image files as the gray and colour rasters that the core processes.

use crate::image_file::{self, ImageFileError, Pixels, Samples};
use crate::input::limits;
use crate::wide::wide;
use compass_core::base::raster::{BitMask, GrayImage};
use compass_core::vision::camera::Pixel;
use compass_core::vision::segments::{self, Detected, Parameters, Segment, SegmentsError, Workspace};
use std::path::Path;

/// A decoded frame, top row first.
#[derive(Debug, Clone)]
pub struct Frame {
    width: u32,
    height: u32,
    gray: Vec<u8>,
    /// Three bytes a pixel; `None` for an image without colour.
    rgb: Option<Vec<u8>>,
}

impl Frame {
    /// Reads an image file: PNG, JPEG, PGM, BMP or TIFF, gray or colour, 8 or 16 bits, with or without alpha.
    ///
    /// # Errors
    /// [`ImageFileError`] for a file that is missing, not an image, damaged, truncated or too large.
    pub fn read(path: &Path) -> Result<Self, ImageFileError> {
        image_file::read(path, limits().frame_pixels).map(Self::from)
    }

    /// A frame of samples in memory; `None` when a side is 0 or above 65535.
    #[must_use]
    pub fn from_rgb(image: image::RgbImage) -> Option<Self> {
        let (width, height) = image.dimensions();
        let sides = 1..=image_file::MAX_SIDE;
        let rgb = image.into_raw();
        let good = sides.contains(&width) && sides.contains(&height);
        good.then(|| Self::from(Pixels { width, height, samples: Samples::Rgb(rgb) }))
    }

    /// A frame of gray levels in memory, row by row; `None` when a side is 0 or above 65535, or the length is not that of
    /// the sides.
    #[must_use]
    pub fn from_gray(width: u32, height: u32, gray: Vec<u8>) -> Option<Self> {
        let sides = 1..=image_file::MAX_SIDE;
        let good = sides.contains(&width)
            && sides.contains(&height)
            && gray.len() as u64 == u64::from(width) * u64::from(height);
        good.then(|| Self::from(Pixels { width, height, samples: Samples::Gray(gray) }))
    }

    /// Pixels along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Pixels along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The frame in gray.
    ///
    /// # Panics
    /// Never: both sides were checked by the constructor.
    #[must_use]
    pub fn gray(&self) -> GrayImage<'_> {
        GrayImage::new(&self.gray, self.width, self.height).expect("sides were checked")
    }

    /// The colour of the nearest pixel; `None` outside the frame.
    #[must_use]
    pub fn colour(&self, at: Pixel) -> Option<[u8; 3]> {
        let inside = |v: f32, side: u32| (v > -0.5 && v < side as f32 - 0.5).then(|| v.round() as usize);
        let (x, y) = (inside(at.x, self.width)?, inside(at.y, self.height)?);
        let index = y * self.width as usize + x;
        match &self.rgb {
            Some(rgb) => rgb.as_chunks::<3>().0.get(index).copied(),
            None => self.gray.get(index).map(|gray| [*gray; 3]),
        }
    }

    /// Interleaved RGB, if the frame has colour.
    #[must_use]
    pub fn rgb(&self) -> Option<&[u8]> {
        self.rgb.as_deref()
    }

    /// The part of the frame from a corner on, both in pixels; what lies outside the frame is left out.
    ///
    /// # Panics
    /// Never: rows are cut within the frame.
    #[must_use]
    pub(crate) fn cropped(&self, [left, top]: [u32; 2], [width, height]: [u32; 2]) -> Self {
        let (left, top) = (left.min(self.width - 1), top.min(self.height - 1));
        let (width, height) = (width.clamp(1, self.width - left), height.clamp(1, self.height - top));
        let cut = |samples: &[u8], count: usize| {
            let [left, width, full] = [left, width, self.width].map(|pixels| pixels as usize * count);
            let rows = samples.chunks_exact(full).skip(top as usize).take(height as usize);
            rows.flat_map(|row| &row[left..left + width]).copied().collect::<Vec<u8>>()
        };
        Self { width, height, gray: cut(&self.gray, 1), rgb: self.rgb.as_ref().map(|rgb| cut(rgb, 3)) }
    }
}

impl From<Pixels> for Frame {
    fn from(Pixels { width, height, samples }: Pixels) -> Self {
        match samples {
            Samples::Gray(gray) => Self { width, height, gray, rgb: None },
            Samples::Rgb(rgb) => Self { width, height, gray: to_gray(&rgb), rgb: Some(rgb) },
        }
    }
}

/// ITU-R BT.601 luma in 1/256, rounded.
fn to_gray(rgb: &[u8]) -> Vec<u8> {
    let luma =
        |[r, g, b]: &[u8; 3]| (77 * u32::from(*r) + 150 * u32::from(*g) + 29 * u32::from(*b) + 128) >> 8;
    rgb.as_chunks::<3>().0.iter().map(|pixel| luma(pixel) as u8).collect()
}

/// Most segments kept of a frame.
pub const MAX_SEGMENTS: usize = 8192;

/// A segment detector with its buffers, constructed once for frames of one size and reused.
#[derive(Debug)]
pub struct SegmentDetector {
    cells: Vec<u16>,
    smoothed: Vec<u8>,
    trail: Vec<u32>,
    found: Vec<Segment>,
}

impl SegmentDetector {
    /// Buffers for images of `width` x `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = segments::pixels(width, height);
        Self {
            cells: vec![0; pixels],
            smoothed: vec![0; pixels],
            trail: vec![0; segments::trail_len(width, height)],
            found: vec![Segment::default(); MAX_SEGMENTS],
        }
    }

    /// The segments of the last detection.
    #[must_use]
    pub fn segments(&self, detected: &Detected) -> &[Segment] {
        &self.found[..detected.count.min(self.found.len())]
    }

    /// The smoothed image of the last detection, which was of `image`.
    #[must_use]
    pub fn smoothed<'a>(&'a self, image: &GrayImage<'a>) -> GrayImage<'a> {
        GrayImage::new(&self.smoothed, image.width(), image.height()).unwrap_or(*image)
    }

    /// Finds the segments of an image. Nothing is allocated.
    ///
    /// # Errors
    /// As [`segments::detect`]: an image above its size, or larger than the buffers.
    pub fn detect(
        &mut self,
        image: &GrayImage<'_>,
        mask: Option<&BitMask<'_>>,
        parameters: &Parameters,
    ) -> Result<(&[Segment], Detected), SegmentsError> {
        let Self { cells, smoothed, trail, found } = self;
        let detected = detect(image, mask, parameters, &mut Workspace { cells, smoothed, trail }, found)?;
        Ok((&self.found[..detected.count], detected))
    }
}

wide! {
    /// [`segments::detect`] with the widest SIMD of this machine; the result is the same.
    fn detect(
        image: &GrayImage<'_>,
        mask: Option<&BitMask<'_>>,
        parameters: &Parameters,
        workspace: &mut Workspace<'_>,
        found: &mut [Segment],
    ) -> Result<Detected, SegmentsError> {
        segments::detect(image, mask, parameters, workspace, found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_levels_keep_black_and_white() {
        assert_eq!(to_gray(&[0, 0, 0, 255, 255, 255, 255, 0, 0]), [0, 255, 77]);
    }
}
