//! Vector drawings: lines and filled areas by layer, in metres.
//!
//! A reader of a file format (`cad`, `svg`, `pdf`) makes a [`Drawing`] of it; what its layers mean and how walls become a
//! raster is the business of [`crate::plan_import`].

#[cfg(feature = "cad")]
pub(crate) mod cad;
mod curve;
#[cfg(feature = "drawings")]
pub(crate) mod pdf;
#[cfg(feature = "drawings")]
pub(crate) mod svg;
pub(crate) mod unit;

#[cfg(any(feature = "cad", feature = "drawings"))]
use crate::guard;
use std::collections::BTreeMap;
use unit::Unit;

/// Most points of a drawing. Nested arrays of blocks multiply: a file of a kilobyte may ask for billions.
pub(crate) const MAX_POINTS: usize = 20_000_000;

/// A drawing read from a file.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawing {
    /// Layers by name, in the order of their first entity.
    pub(crate) layers: Vec<Layer>,
    /// What is drawn, in the order of the file.
    pub(crate) shapes: Vec<Shape>,
    /// The unit of the file; `None`: it says none, and coordinates are in that unit.
    pub(crate) unit: Option<Unit>,
    /// Objects that may be walls but are not read, and how many of each kind.
    pub(crate) unread: BTreeMap<String, usize>,
    points: usize,
}

/// A layer, or in a drawing without layers what stands for one: a class, an id, a colour.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layer {
    /// Its name in the file.
    pub(crate) name: String,
    /// Its colour, RGB, where the format has no layers and colours tell what is what.
    pub(crate) colour: Option<[u8; 3]>,
    /// Entities that are drawn.
    pub(crate) entities: usize,
    /// Entities that are not drawn: frozen, switched off or invisible.
    pub(crate) hidden: usize,
    /// Entities that are no lines or areas, such as texts and dimensions.
    pub(crate) annotations: usize,
}

/// Connected lines or a filled area.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Index of the layer.
    pub(crate) layer: usize,
    /// How it is drawn.
    pub(crate) paint: Paint,
    /// Corners in metres (units where the unit is unknown), one list per line or boundary; x right, y up.
    pub(crate) contours: Vec<Vec<[f64; 2]>>,
}

/// How a shape is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Paint {
    /// Lines of this width in metres; 0 is a hairline.
    Stroke(f64),
    /// The area between the contours, even-odd.
    Fill,
}

/// Why a drawing cannot be used although its format was understood.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum DrawingError {
    /// The file is not of its format: the parser's message.
    #[error("{0}")]
    Syntax(String),
    /// Too many points.
    #[error("more than {MAX_POINTS} points once its blocks are inserted")]
    TooLarge,
}

/// What a reader makes of a file; its panic is an error of the file.
#[cfg(any(feature = "cad", feature = "drawings"))]
fn guarded<T>(read: impl FnOnce() -> Result<T, DrawingError>) -> Result<T, DrawingError> {
    guard::guarded(read).unwrap_or_else(|| Err(DrawingError::Syntax(guard::GAVE_UP.into())))
}

impl Drawing {
    /// The index of a layer, made where there is none of that name yet.
    pub(crate) fn layer(&mut self, name: &str) -> usize {
        // Drawings have tens of layers, entities come in runs of one layer: a search from the end is short.
        if let Some(at) = self.layers.iter().rposition(|layer| layer.name == name) {
            return at;
        }
        self.layers.push(Layer { name: name.to_owned(), ..Layer::default() });
        self.layers.len() - 1
    }

    /// The index of the layer of a name and a colour; without a name the colour is the name.
    pub(crate) fn coloured_layer(&mut self, name: &str, colour: [u8; 3]) -> usize {
        let [r, g, b] = colour;
        let name = if name.is_empty() { format!("#{r:02x}{g:02x}{b:02x}") } else { name.to_owned() };
        let known = self.layers.iter().rposition(|layer| layer.name == name && layer.colour == Some(colour));
        known.unwrap_or_else(|| {
            self.layers.push(Layer { name, colour: Some(colour), ..Layer::default() });
            self.layers.len() - 1
        })
    }

    /// Adds a shape, without contours of fewer than two points or with a coordinate that is not finite.
    ///
    /// # Errors
    /// [`DrawingError::TooLarge`].
    pub(crate) fn push(&mut self, mut shape: Shape) -> Result<(), DrawingError> {
        let finite = |contour: &Vec<[f64; 2]>| contour.iter().flatten().all(|value| value.is_finite());
        shape.contours.retain(|contour| contour.len() > 1 && finite(contour));
        self.points += shape.contours.iter().map(Vec::len).sum::<usize>();
        if self.points > MAX_POINTS {
            return Err(DrawingError::TooLarge);
        }
        if !shape.contours.is_empty() {
            self.shapes.push(shape);
        }
        Ok(())
    }
}

impl Drawing {
    /// Makes every coordinate and width `by` times as large.
    pub(crate) fn scale(&mut self, by: f64) {
        for shape in &mut self.shapes {
            shape.contours.iter_mut().flatten().flatten().for_each(|value| *value *= by);
            if let Paint::Stroke(width) = &mut shape.paint {
                *width *= by;
            }
        }
    }
}

impl Shape {
    /// The extent: least and greatest x and y in metres.
    pub(crate) fn extent(&self) -> [[f64; 2]; 2] {
        let points = self.contours.iter().flatten();
        points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[least, most], &[x, y]| {
            [[least[0].min(x), least[1].min(y)], [most[0].max(x), most[1].max(y)]]
        })
    }

    /// The length of all lines and boundaries in metres.
    pub(crate) fn length(&self) -> f64 {
        let length = |contour: &Vec<[f64; 2]>| -> f64 {
            contour.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
        };
        self.contours.iter().map(length).sum()
    }
}
