//! Rendered frames as a dataset in the `EuRoC` layout: `cam0/data.csv` with `cam0/data/…`, likewise `cam1`, and
//! `groundtruth.txt`.

use super::Renderer;
use crate::dataset::tum::{self, Pose};
use crate::output::{OutputError, create_dir, write_file};
use crate::progress::Progress;
use image::{ImageEncoder as _, ImageError, RgbImage};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::Path;

/// How frames are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// JPEG of a quality from 1 to 100.
    Jpeg(u8),
    /// PNG.
    Png,
}

impl Format {
    const fn extension(self) -> &'static str {
        match self {
            Self::Jpeg(_) => "jpg",
            Self::Png => "png",
        }
    }

    fn encode(self, frame: &RgbImage) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        let (width, height, colour) = (frame.width(), frame.height(), image::ExtendedColorType::Rgb8);
        let encoded = match self {
            Self::Jpeg(quality) => image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality)
                .write_image(frame, width, height, colour),
            Self::Png => {
                image::codecs::png::PngEncoder::new(&mut bytes).write_image(frame, width, height, colour)
            }
        };
        encoded?;
        Ok(bytes)
    }
}

/// Renders all poses and writes them as a dataset. The lists are written after the frames: an interrupted dataset has
/// no `data.csv`.
///
/// # Errors
/// Names the file or directory that could not be written.
pub fn write(
    dir: &Path,
    renderer: &Renderer<'_>,
    poses: &[Pose],
    format: Format,
    progress: &dyn Progress,
) -> Result<(), OutputError> {
    let cameras: Vec<usize> = renderer.cameras().collect();
    for camera in &cameras {
        create_dir(&dir.join(format!("cam{camera}/data")))?;
    }
    let steps = progress.begin(poses.len(), "rendering frames");
    poses.par_iter().try_for_each(|pose| {
        for (camera, frame) in renderer.render(pose).iter().enumerate() {
            let Some(frame) = frame else { continue };
            let path = dir.join(format!("cam{camera}/data")).join(file_name(pose, format));
            let bytes =
                format.encode(frame).map_err(|source| OutputError::Encode { path: path.clone(), source })?;
            write_file(&path, &bytes)?;
        }
        steps.step();
        Ok(())
    })?;
    drop(steps);
    let mut list = String::from("#timestamp [ns],filename\n");
    for pose in poses {
        let _ = writeln!(list, "{},{}", pose.timestamp_ns, file_name(pose, format));
    }
    for camera in cameras {
        write_file(&dir.join(format!("cam{camera}/data.csv")), list.as_bytes())?;
    }
    write_file(&dir.join("groundtruth.txt"), tum::text(poses).as_bytes())
}

fn file_name(pose: &Pose, format: Format) -> String {
    format!("{}.{}", pose.timestamp_ns, format.extension())
}
