//! Units of drawings.

use std::fmt;

/// The unit of a drawing's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unit {
    /// Metres of one unit.
    pub metres: f64,
    /// How it is known.
    pub source: UnitSource,
}

/// How the unit of a drawing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum UnitSource {
    /// The caller said so.
    Told,
    /// The file says so.
    #[default]
    File,
    /// The file says nothing: taken from the size of what is drawn.
    Guessed,
}

/// Names of units that a caller may tell, and their metres.
pub const NAMED_UNITS: [(&str, f64); 6] =
    [("mm", 0.001), ("cm", 0.01), ("dm", 0.1), ("m", 1.0), ("in", 0.0254), ("ft", 0.3048)];

impl Unit {
    /// The unit of `$INSUNITS`, group code 70 of the DXF header; `None`: unitless, or none on Earth.
    pub(crate) fn of_insertion_units(code: i16) -> Option<Self> {
        let metres = match code {
            1 => 0.0254,
            2 => 0.3048,
            3 => 1609.344,
            4 => 1e-3,
            5 => 1e-2,
            6 => 1.0,
            7 => 1e3,
            8 => 0.0254e-6,
            9 => 0.0254e-3,
            10 => 0.9144,
            11 => 1e-10,
            12 => 1e-9,
            13 => 1e-6,
            14 => 0.1,
            15 => 10.0,
            16 => 100.0,
            17 => 1e9,
            21 => 1200.0 / 3937.0,
            _ => return None,
        };
        Some(Self { metres, source: UnitSource::File })
    }

    /// The unit of a unitless drawing by the larger side of its extent: millimetres, as most are drawn, unless the
    /// building would be smaller than a room.
    pub(crate) fn guessed(side: f64) -> Self {
        let metres = if side >= 2000.0 { 1e-3 } else { 1.0 };
        Self { metres, source: UnitSource::Guessed }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMED_UNITS.iter().find(|(_, metres)| *metres == self.metres) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "{} m", self.metres),
        }
    }
}
