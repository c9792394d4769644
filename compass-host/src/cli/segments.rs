//! `compass segments`: the line segments of one image.

use super::debug;
use super::exit::Outcome;
use crate::cli::json::JsonOption;
use anyhow::{Context as _, Result};
use compass_core::vision::segments::{Detected, Parameters, Segment};
use compass_host::frame::{Frame, SegmentDetector};
use compass_host::output::{Decimal, write_file};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct Segments {
    /// The image
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Write the segments to FILE, one a line: x1,y1,x2,y2,score
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Detect N times and report the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeat: u32,
    /// Keep lines from jumping gaps of a few pixels
    #[arg(long)]
    no_jump: bool,
    /// Keep segments whose gradients point elsewhere
    #[arg(long)]
    no_validation: bool,
    /// Write the image with its segments in green into DIR: segments.png
    #[arg(long, value_name = "DIR")]
    debug_dir: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    width: u32,
    height: u32,
    count: usize,
    /// Whether a list overflowed.
    truncated: bool,
    milliseconds: Decimal,
}

impl Segments {
    pub(super) fn run(&self) -> Result<Outcome> {
        let frame = Frame::read(&self.image)?;
        let mut detector = SegmentDetector::new(frame.width(), frame.height());
        let (segments, detected, milliseconds) =
            self.detect(&frame, &mut detector).with_context(|| self.image.display().to_string())?;
        if let Some(path) = &self.csv {
            write_file(path, csv(segments).as_bytes())?;
        }
        if let Some(dir) = &self.debug_dir {
            debug::segments(dir, &frame, segments)?;
        }
        let Detected { count, truncated } = detected;
        let (width, height) = (frame.width(), frame.height());
        let more = if truncated { " (truncated: a list overflowed)" } else { "" };
        let summary = format!("{count} segments{more} in {width} x {height} pixels, {milliseconds:.2} ms\n");
        let output = Output { width, height, count, truncated, milliseconds: Decimal(milliseconds) };
        self.json.emit(&output, &summary)?;
        Ok(Outcome::Done)
    }

    /// The segments, and the median time of a detection in milliseconds.
    fn detect<'a>(
        &self,
        frame: &Frame,
        detector: &'a mut SegmentDetector,
    ) -> Result<(&'a [Segment], Detected, f64)> {
        let parameters =
            Parameters { jump: !self.no_jump, validate: !self.no_validation, ..Parameters::default() };
        let mut detected = Detected { count: 0, truncated: false };
        let mut times = Vec::with_capacity(self.repeat as usize);
        for _ in 0..self.repeat {
            let start = Instant::now();
            (_, detected) = detector.detect(&frame.gray(), None, &parameters)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        times.sort_by(f64::total_cmp);
        Ok((detector.segments(&detected), detected, times[times.len() / 2]))
    }
}

fn csv(segments: &[Segment]) -> String {
    let mut text = String::from("x1,y1,x2,y2,score\n");
    for s in segments {
        let _ = writeln!(text, "{:.3},{:.3},{:.3},{:.3},{}", s.x1, s.y1, s.x2, s.y2, s.score);
    }
    text
}
