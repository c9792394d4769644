//! `compass pack`: packs the frames of a rig in the board's input format.

use super::cameras::{CameraArgs, Taken};
use super::exit::Outcome;
use super::plan::size;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result, bail};
use compass_core::base::raster::BitMask;
use compass_core::vision::shot::{Header, Writer};
use compass_host::frame::Frame;
use compass_host::output::{Bytes, Decimal, check_file, write_file};
use image::RgbImage;
use image::imageops::thumbnail;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Pack {
    #[command(flatten)]
    cameras: CameraArgs,
    /// Size to shrink the frames to; lenses are scaled with them
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "368x360")]
    size: (u32, u32),
    /// When the frames were taken, nanoseconds since anything: a track wants to know
    #[arg(long, value_name = "NS", default_value_t = 0, allow_negative_numbers = true)]
    time_ns: i64,
    /// The file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    cameras: usize,
    width: u32,
    height: u32,
    bytes: usize,
    up_in_cam0: [Decimal; 3],
}

impl Pack {
    pub(super) fn run(&self) -> Result<Outcome> {
        check_file(&self.out)?;
        let taken = self.cameras.read()?;
        let Some(up) = taken.up.hint() else {
            bail!(
                "a board does not guess which side of cam0's image is up: tell with --mount, --up or --imu"
            );
        };
        // Frames of another aspect ratio than the calibrated one are rejected before resizing would distort them.
        taken.rig()?;
        let [cam0, cam1] =
            taken.frames.each_ref().map(|frame| frame.as_ref().map(|f| self.shrink(&taken, f)));
        let small = [cam0.transpose()?, cam1.transpose()?];
        let rig = taken.calibration.rig(small.each_ref().map(|small| small.as_ref().map(|_| self.size)))?;
        let header = Header { time_ns: self.time_ns, rig, up, height_m: taken.heights.camera_m() };
        let bytes = self.bytes(&header, &small)?;
        write_file(&self.out, &bytes)?;
        let (width, height) = self.size;
        let output = Output {
            cameras: small.iter().flatten().count(),
            width,
            height,
            bytes: bytes.len(),
            up_in_cam0: [up.x, up.y, up.z].map(|v| Decimal(f64::from(v))),
        };
        let summary = format!(
            "{}: {} camera(s) of {width} x {height} pixels, {} bytes\n",
            self.out.display(),
            output.cameras,
            output.bytes
        );
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }

    fn bytes(&self, header: &Header, small: &[Option<Frame>; 2]) -> Result<Vec<u8>> {
        let (width, height) = self.size;
        let none_excluded = vec![0; BitMask::row_bytes(width) * height as usize];
        let none_excluded = BitMask::new(&none_excluded, width, height)?;
        let images = small.each_ref().map(|frame| frame.as_ref().map(|f| (f.gray(), none_excluded)));
        let writer = Writer::new(header, images).with_context(|| self.out.display().to_string())?;
        let Ok(Bytes(bytes)) = writer.write(Bytes(Vec::with_capacity(writer.shot_bytes())));
        Ok(bytes)
    }

    /// Box-filter means over the pixels that become one.
    fn shrink(&self, taken: &Taken, frame: &Frame) -> Result<Frame> {
        let (width, height) = self.size;
        if width > frame.width() || height > frame.height() {
            let (w, h) = (frame.width(), frame.height());
            bail!("{}: frames of {w} x {h} pixels cannot shrink to {width} x {height}", taken.name);
        }
        let rgb = frame.rgb().map_or_else(
            || frame.gray().pixels().iter().flat_map(|gray| [*gray; 3]).collect(),
            <[u8]>::to_vec,
        );
        let image = RgbImage::from_raw(frame.width(), frame.height(), rgb);
        let image = thumbnail(&image.context("frames have the pixels of their size")?, width, height);
        Frame::from_rgb(image).with_context(|| format!("{}: no pixels", taken.name))
    }
}
