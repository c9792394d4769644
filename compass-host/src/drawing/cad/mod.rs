//! DXF and DWG: model space as shapes by layer.
//!
//! Blocks are inserted with their scale, rotation, mirroring and arrays; what a block draws on layer 0 takes the
//! layer of the insert. Frozen and switched-off layers, invisible entities and paper space are left out. Heights are
//! dropped: a drawing is seen from above.

mod shapes;
mod walk;

use super::unit::Unit;
use super::{Drawing, DrawingError, guarded};
use crate::input;
use acadrust::{CadDocument, DwgReadOptions, DwgReader, DxfReader};
use std::io::Read as _;
use std::path::Path;
use walk::Walk;

/// Most bytes that the sections of a DWG may unpack to.
const MAX_UNPACKED_BYTES: usize = 2 << 30;

/// Reads a drawing whose name ends in `.dxf` or `.dwg`; `told` replaces the unit of the file.
///
/// # Errors
/// [`DrawingError`]: a file that is not of its format, or one too large.
pub(crate) fn read(path: &Path, told: Option<Unit>) -> Result<Drawing, DrawingError> {
    let document = guarded(|| parse(path))?;
    let unit = told.or_else(|| Unit::of_insertion_units(document.header.insertion_units));
    let mut walk = Walk::new(&document, unit);
    walk.model_space()?;
    Ok(walk.finish())
}

fn parse(path: &Path) -> Result<CadDocument, DrawingError> {
    input::check(path, input::limits().drawing_bytes)
        .map_err(|error| DrawingError::Syntax(error.to_string()))?;
    let is_dwg = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("dwg"));
    let document = if is_dwg {
        check_magic(path)?;
        let options = DwgReadOptions::failsafe().with_max_decompressed_bytes(MAX_UNPACKED_BYTES);
        DwgReader::from_file_with_options(path, options).and_then(|mut reader| reader.read())
    } else {
        DxfReader::from_file(path).and_then(DxfReader::read)
    };
    document.map_err(|error| DrawingError::Syntax(error.to_string()))
}

/// Whether a file begins as every DWG does, with `AC` and its version: the reader makes an empty drawing of any other.
fn check_magic(path: &Path) -> Result<(), DrawingError> {
    let syntax = |reason: String| DrawingError::Syntax(reason);
    let mut magic = [0; 4];
    let mut file = std::fs::File::open(path).map_err(|error| syntax(error.to_string()))?;
    let read = file.read_exact(&mut magic);
    if read.is_ok() && (magic.starts_with(b"AC1") || magic == *b"MC0." || magic.starts_with(b"AC2")) {
        return Ok(());
    }
    Err(syntax("it does not begin with the version of a DWG, such as AC1032".into()))
}

#[cfg(test)]
mod tests;
