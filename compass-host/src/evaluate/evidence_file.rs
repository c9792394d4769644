//! The evidence of a frame for every height of the camera, as a gray picture: a column per direction, 128 where nothing
//! is known.
//!
//! Tables for two heights differ by a shift along the ladder of ranges. The rows are walls along the whole ladder, windows
//! likewise, and what speaks for nothing there at each height.

use crate::image_file::{self, Samples};
use crate::output::write_file;
use anyhow::{Context as _, Result, bail};
use compass_core::boundary::{HEIGHTS_M, RUNGS, height_rungs};
use compass_core::likelihood::{OPEN_PLANE, RANGES, Table};
use compass_core::num::BINS;
use image::ImageEncoder as _;
use std::ops::RangeInclusive;
use std::path::Path;

/// What stands for 0.
const MIDDLE: i32 = 128;
/// The ladder reaches as many rungs beyond that of a table at the nominal height, to either side.
const BEYOND: i8 = ((RUNGS - RANGES) / 2) as i8;

/// A row of a table.
type Row = [i8; BINS];

/// What was seen in a frame, for all heights of the camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Evidence {
    rows: Vec<Row>,
}

/// The heights that can be told apart, rungs.
fn heights() -> RangeInclusive<i8> {
    height_rungs(HEIGHTS_M[0])..=height_rungs(HEIGHTS_M[1])
}

impl Evidence {
    /// Takes the evidence from `fill`, which writes the table for a height in rungs.
    pub fn new(mut fill: impl FnMut(i8, &mut Table)) -> Self {
        let mut table = Box::new(Table::EMPTY);
        let mut far = Box::new(Table::EMPTY);
        fill(BEYOND, &mut table);
        fill(-BEYOND, &mut far);
        let row = |of: &Table, plane: usize| of.plane(plane as u8).copied().unwrap_or([0; BINS]);
        let mut rows = Vec::new();
        for first in [0, RANGES] {
            rows.extend((0..RANGES).map(|rung| row(&table, first + rung)));
            rows.extend((2 * RANGES - RUNGS..RANGES).map(|rung| row(&far, first + rung)));
        }
        for height in heights() {
            fill(height, &mut table);
            rows.push(row(&table, usize::from(OPEN_PLANE)));
        }
        Self { rows }
    }

    /// Writes the table for a height in rungs.
    pub fn table(&self, height: i8, table: &mut Table) {
        let mut set = |plane: usize, row: usize| {
            if let Some(row) = self.rows.get(row) {
                table.set_plane(plane as u8, &row.map(i32::from));
            }
        };
        for rung in 0..RANGES {
            let at = (rung as isize + isize::from(BEYOND - height)).clamp(0, RUNGS as isize - 1) as usize;
            set(rung, at);
            set(RANGES + rung, RUNGS + at);
        }
        let (least, most) = heights().into_inner();
        let nth = usize::try_from(height.clamp(least, most) - least).unwrap_or(0);
        set(usize::from(OPEN_PLANE), 2 * RUNGS + nth);
    }

    /// Writes it as a PNG file.
    ///
    /// # Errors
    /// Names the file.
    pub fn write(&self, path: &Path) -> Result<()> {
        let values = self.rows.as_flattened().iter();
        let pixels: Vec<u8> = values.map(|&value| (i32::from(value) + MIDDLE) as u8).collect();
        let mut png = Vec::new();
        image::codecs::png::PngEncoder::new(&mut png)
            .write_image(&pixels, BINS as u32, self.rows.len() as u32, image::ExtendedColorType::L8)
            .with_context(|| path.display().to_string())?;
        write_file(path, &png)
    }

    /// Reads what was written so.
    ///
    /// # Errors
    /// Names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let picture = image_file::read(path)?;
        let height = 2 * RUNGS + heights().count();
        let size = (picture.width as usize, picture.height as usize);
        let (Samples::Gray(pixels), true) = (picture.samples, size == (BINS, height)) else {
            bail!("{}: no evidence", path.display());
        };
        let rows = pixels.as_chunks::<BINS>().0.iter();
        Ok(Self { rows: rows.map(|row| row.map(|value| (i32::from(value) - MIDDLE) as i8)).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use compass_core::likelihood::PLANES;

    /// As if from ranges on a ladder of their own.
    fn fill(height: i8, table: &mut Table) {
        for plane in 0..PLANES {
            let rung = if plane == usize::from(OPEN_PLANE) { RANGES - 1 } else { plane % RANGES };
            let at = (rung as i32 + i32::from(BEYOND) - i32::from(height)).clamp(0, RUNGS as i32 - 1);
            for bin in 0..BINS {
                let hit = (plane / RANGES) as i32 * (bin % 5) as i32;
                table.set(plane as u8, bin, at - 45 + hit);
            }
        }
    }

    #[test]
    fn every_height_round_trips() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("1.png");
        Evidence::new(fill).write(&path).unwrap();
        let back = Evidence::read(&path).unwrap();
        let (mut table, mut expected) = (Box::new(Table::EMPTY), Box::new(Table::EMPTY));
        for height in heights() {
            fill(height, &mut expected);
            back.table(height, &mut table);
            assert!(table == expected, "height {height}");
        }
    }
}
