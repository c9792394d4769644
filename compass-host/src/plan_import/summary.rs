//! How a drawing is read, and what was understood of its layers.

use super::layers::{LayerRole, LayerRoles};

/// How vector drawings are read; rasters need none of it.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawingOptions {
    /// Which layer is what.
    pub layers: LayerRoles,
    /// Metres of one unit of the drawing, in place of what the file says.
    pub unit_m: Option<f64>,
    /// How many times smaller than the building a drawing on paper (SVG, PDF) is: 100 of 1:100.
    pub scale: Option<f64>,
    /// The page of a PDF; the first is 1.
    pub page: usize,
    /// Whether to draw what is left out as well, for a picture.
    pub with_left_out: bool,
}

impl Default for DrawingOptions {
    fn default() -> Self {
        Self { layers: LayerRoles::default(), unit_m: None, scale: None, page: 1, with_left_out: false }
    }
}

/// What was understood of a layer.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerSummary {
    /// Its name in the file.
    pub name: String,
    /// Entities that are lines or areas and are shown.
    pub entities: usize,
    /// Entities that are not shown: frozen, switched off or invisible.
    pub hidden: usize,
    /// Texts, dimensions and the like.
    pub annotations: usize,
    /// The role that it was given; `None`: not recognised, and left out.
    pub role: Option<LayerRole>,
}
