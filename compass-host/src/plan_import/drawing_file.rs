//! Opens vector drawings by their format, and tells their scale.

use super::error::PlanImportError;
use super::note::PlanNote;
use super::summary::DrawingOptions;
#[cfg(any(feature = "cad", feature = "drawings"))]
use crate::drawing::unit::{Unit, UnitSource};
use crate::drawing::{Drawing, DrawingError};
use std::path::Path;

/// Metres of a user unit of SVG on paper: CSS has 96 to the inch.
const SVG_PAPER_M: f64 = 0.0254 / 96.0;
/// Metres of a point of PDF on paper.
const PDF_PAPER_M: f64 = 0.0254 / 72.0;
/// Metres of a unit of a drawing of which nothing is known: those of a pixel of a picture.
const UNKNOWN_UNIT_M: f64 = 0.01;

/// The format of a vector drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DrawingFormat {
    Dxf,
    Dwg,
    Svg,
    Pdf,
}

impl DrawingFormat {
    /// The format by a file's name; `None` for anything but a vector drawing.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?.to_ascii_lowercase();
        match end.as_str() {
            "dxf" => Some(Self::Dxf),
            "dwg" => Some(Self::Dwg),
            "svg" => Some(Self::Svg),
            "pdf" => Some(Self::Pdf),
            _ => None,
        }
    }

    /// Whether it is drawn on paper, at a scale.
    pub(super) const fn is_page(self) -> bool {
        matches!(self, Self::Svg | Self::Pdf)
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Dxf => "DXF",
            Self::Dwg => "DWG",
            Self::Svg => "SVG",
            Self::Pdf => "PDF",
        }
    }
}

/// What the caller tells of scales.
#[derive(Debug, Clone, Copy)]
pub(super) struct Told {
    /// Metres of one unit of the drawing.
    pub(super) unit_m: Option<f64>,
    /// Metres per pixel.
    pub(super) resolution_m: Option<f64>,
}

/// A drawing in metres.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) drawing: Drawing,
    /// Metres per pixel that are asked for.
    pub(super) resolution_m: Option<f64>,
    pub(super) note: Option<PlanNote>,
}

/// Opens a drawing.
pub(super) fn open(
    path: &Path,
    format: DrawingFormat,
    options: &DrawingOptions,
    told: &Told,
) -> Result<Opened, PlanImportError> {
    match format {
        DrawingFormat::Dxf | DrawingFormat::Dwg => cad(path, format, told),
        DrawingFormat::Svg | DrawingFormat::Pdf => page(path, format, options, told),
    }
}

#[cfg(feature = "cad")]
fn cad(path: &Path, format: DrawingFormat, told: &Told) -> Result<Opened, PlanImportError> {
    let unit = told.unit_m.map(|metres| Unit { metres, source: UnitSource::Told });
    let drawing = crate::drawing::cad::read(path, unit).map_err(|error| unreadable(path, format, &error))?;
    Ok(Opened { drawing, resolution_m: told.resolution_m, note: None })
}

#[cfg(not(feature = "cad"))]
fn cad(path: &Path, format: DrawingFormat, _: &Told) -> Result<Opened, PlanImportError> {
    Err(PlanImportError::Feature { path: path.to_path_buf(), format: format.name(), feature: "cad" })
}

/// A drawing on paper: its scale is told, or a unit counts as a pixel of a picture.
#[cfg(feature = "drawings")]
fn page(
    path: &Path,
    format: DrawingFormat,
    options: &DrawingOptions,
    told: &Told,
) -> Result<Opened, PlanImportError> {
    let (read, paper_m) = if format == DrawingFormat::Svg {
        (crate::drawing::svg::read(path), SVG_PAPER_M)
    } else {
        (crate::drawing::pdf::read(path, options.page), PDF_PAPER_M)
    };
    let mut drawing = read.map_err(|error| unreadable(path, format, &error))?;
    let told_m = options.scale.map(|scale| scale * paper_m).or(told.unit_m);
    if told_m.is_none() && format == DrawingFormat::Pdf {
        return Err(PlanImportError::Scale { path: path.to_path_buf() });
    }
    // Where nothing else tells the scale, the resolution says how large a unit is, as it does of a pixel of a picture.
    let unit_m = told_m.or(told.resolution_m).unwrap_or(UNKNOWN_UNIT_M);
    drawing.scale(unit_m);
    drawing.unit = Some(Unit { metres: unit_m, source: UnitSource::Told });
    let resolution_m = told_m.and(told.resolution_m);
    let is_guess = told_m.is_none() && told.resolution_m.is_none();
    let note = is_guess.then(|| PlanNote::Scale { path: path.to_path_buf(), unit_m });
    Ok(Opened { drawing, resolution_m, note })
}

#[cfg(not(feature = "drawings"))]
fn page(path: &Path, format: DrawingFormat, _: &DrawingOptions, _: &Told) -> Result<Opened, PlanImportError> {
    Err(PlanImportError::Feature { path: path.to_path_buf(), format: format.name(), feature: "drawings" })
}

fn unreadable(path: &Path, format: DrawingFormat, error: &DrawingError) -> PlanImportError {
    PlanImportError::Drawing { path: path.to_path_buf(), format: format.name(), reason: error.to_string() }
}
