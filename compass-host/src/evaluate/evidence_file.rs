//! Tables of evidence as gray pictures: a column per direction, a row per plane, 128 where nothing is known.

use crate::image_file::{self, Samples};
use crate::output::write_file;
use anyhow::{Context as _, Result, bail};
use compass_core::likelihood::{PLANES, Table};
use compass_core::num::BINS;
use image::ImageEncoder as _;
use std::path::Path;

/// What stands for 0.
const MIDDLE: i32 = 128;

/// Writes a table as a PNG file.
///
/// # Errors
/// Names the file.
pub fn write(path: &Path, table: &Table) -> Result<()> {
    let pixels: Vec<u8> = (0..PLANES as u8)
        .filter_map(|plane| table.plane(plane))
        .flatten()
        .map(|&value| (i32::from(value) + MIDDLE) as u8)
        .collect();
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(&pixels, BINS as u32, PLANES as u32, image::ExtendedColorType::L8)
        .with_context(|| path.display().to_string())?;
    write_file(path, &png)
}

/// Reads a table that was written so.
///
/// # Errors
/// Names the file.
pub fn read(path: &Path, table: &mut Table) -> Result<()> {
    let picture = image_file::read(path)?;
    let size = [picture.width as usize, picture.height as usize];
    let (Samples::Gray(pixels), [BINS, PLANES]) = (picture.samples, size) else {
        bail!("{}: no table of evidence", path.display());
    };
    for (plane, row) in (0..).zip(pixels.as_chunks::<BINS>().0) {
        table.set_plane(plane, &row.map(|value| i32::from(value) - MIDDLE));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("1.png");
        let mut table = Box::new(Table::EMPTY);
        for plane in 0..PLANES as u8 {
            for bin in 0..BINS {
                table.set(plane, bin, (i32::from(plane) * 7 + bin as i32) % 177 - 88);
            }
        }
        write(&path, &table).unwrap();
        let mut back = Box::new(Table::EMPTY);
        read(&path, &mut back).unwrap();
        assert!(table == back);
    }
}
