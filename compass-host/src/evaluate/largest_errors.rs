//! The frames with the largest errors: a list, and pictures of them.

use super::error::Result;
use super::frame_errors::FrameErrors;
use crate::dataset::recording::{Shot, Source};
use crate::frame::Frame;
use crate::output::write_png;
use crate::report::Picture;
use compass_core::vision::camera::Pixel;
use image::{Rgb, RgbImage};
use std::path::Path;

/// Number of frames that are drawn.
const PICTURES: usize = 3;
/// Width of each of the two frames in a picture, pixels.
const WIDTH: u32 = 480;

/// The frames with ground truth, those with the largest single-frame errors first.
#[must_use]
pub fn by_error(frames: &[FrameErrors]) -> Vec<&FrameErrors> {
    let mut frames: Vec<&FrameErrors> = frames.iter().filter(|frame| frame.truth.is_some()).collect();
    frames.sort_by(|a, b| b.metres[0].total_cmp(&a.metres[0]));
    frames
}

/// Writes `worst_1.png` and so on, both cameras side by side.
///
/// # Errors
/// Names the file that cannot be written.
pub fn draw(dir: &Path, frames: &[FrameErrors], shots: &[Shot]) -> Result<Vec<Picture>> {
    let mut pictures = Vec::new();
    for (rank, frame) in by_error(frames).into_iter().take(PICTURES).enumerate() {
        let Some(shot) = shots.iter().find(|shot| shot.timestamp_ns == frame.timestamp_ns) else { continue };
        // A frame that cannot be read is dark.
        let read = |image: &Option<Source>| image.as_ref().and_then(|image| image.read().ok());
        let images: [Option<Frame>; 2] = [read(&shot.images[0]), read(&shot.images[1])];
        let file = format!("worst_{}.png", rank + 1);
        write_png(&dir.join(&file), &beside(&images))?;
        let metres = frame.metres[0];
        let caption = if metres.is_finite() { format!("{metres:.2} m off") } else { "no pose".into() };
        pictures.push(Picture { file, caption: format!("t {}: {caption}", frame.timestamp_ns) });
    }
    Ok(pictures)
}

/// Frames side by side, each [`WIDTH`] wide; a missing camera is dark.
fn beside(images: &[Option<Frame>; 2]) -> RgbImage {
    let height = |frame: &Frame| (WIDTH * frame.height()).div_ceil(frame.width());
    let tallest = images.iter().flatten().map(height).max().unwrap_or(1);
    RgbImage::from_fn(2 * WIDTH, tallest, |x, y| {
        let colour = images[(x / WIDTH) as usize].as_ref().and_then(|frame| {
            let [x, y] = [x % WIDTH, y].map(|pixel| (pixel * frame.width() / WIDTH) as f32);
            frame.colour(Pixel { x, y })
        });
        Rgb(colour.unwrap_or_default())
    })
}
