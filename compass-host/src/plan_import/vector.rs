//! Plans from vector drawings: layers get their roles, walls drawn as lines become solid.

use super::clusters::{self, Cluster};
use super::error::PlanImportError;
use super::ink::{self, Ink};
use super::layers::{LayerRole, LayerRoles};
use super::line_walls::CAVITY_M;
use super::note::{PlanNote, UnknownLayer};
use super::paint::Frame;
use super::painter::Painter;
use super::raster::PlanRaster;
use super::structure::Bearing;
use super::summary::{DrawingOptions, LayerSummary};
use crate::drawing::unit::{Unit, UnitSource};
use crate::drawing::{Drawing, Layer, Shape};
use std::path::Path;

/// Free margin around a drawing in metres: wider than any cavity.
const MARGIN_M: f64 = 1.0;
/// Most pixels of a raster whose resolution nobody told.
const MOST_PIXELS: f64 = 4e8;
/// Most pixels along a side.
const MOST_SIDE: f64 = 65_535.0;
/// Sides in metres outside which the unit of a drawing is doubtful.
const LIKELY_SIDE_M: std::ops::RangeInclusive<f64> = 2.5..=500.0;

/// A drawing as plan.
pub(super) struct Vector {
    pub(super) plan: PlanRaster,
    pub(super) bearing: Option<Bearing>,
    pub(super) layers: Vec<LayerSummary>,
    pub(super) notes: Vec<PlanNote>,
    /// Lines of layers that are no part of the plan, as pixels, if asked for.
    pub(super) left_out: Option<PlanRaster>,
    /// Doors as pixels, where a layer shows them.
    pub(super) doors: Option<PlanRaster>,
}

/// Makes a plan of a drawing. `resolution_m`: `None` chooses; `origin`: where the lower left of the extent lies,
/// `None` keeps the drawing's coordinates.
pub(super) fn import(
    path: &Path,
    mut drawing: Drawing,
    options: &DrawingOptions,
    ink: &Ink,
    resolution_m: Option<f64>,
    origin: Option<[f64; 2]>,
) -> Result<Vector, PlanImportError> {
    let mut notes = Vec::new();
    let Roles { roles, unknown, by_colour } = roles(path, &drawing, &options.layers, ink)?;
    settle_unit(path, &mut drawing, &roles, &mut notes);
    if !unknown.is_empty() {
        let layers = unknown.iter().map(|&at| unknown_layer(&drawing, at)).collect();
        let taken = unknown.iter().all(|&at| roles[at].is_some());
        notes.push(PlanNote::UnknownLayers { path: path.to_path_buf(), layers, taken_for_walls: taken });
    }
    if !drawing.unread.is_empty() {
        let kinds = drawing.unread.iter().map(|(kind, count)| (kind.clone(), *count)).collect();
        notes.push(PlanNote::Unread { path: path.to_path_buf(), kinds });
    }
    let is_plan = |shape: &&Shape| roles[shape.layer].is_some_and(LayerRole::is_plan);
    let all: Vec<&Shape> = drawing.shapes.iter().filter(is_plan).collect();
    let (found, specks) = clusters::of(&all);
    note_clusters(path, &found, specks, &mut notes);
    let kept: Vec<&Shape> =
        found.iter().flat_map(|cluster| cluster.shapes.iter().map(|&at| all[at])).collect();
    let extent = clusters::extent(found.iter().map(|cluster| cluster.extent));
    let frame = frame(path, extent, resolution_m, origin, &mut notes)?;

    let painter = Painter { drawing: &drawing, roles: &roles, frame: &frame, kept };
    // Where colours tell, no layer is known as structure either.
    let (plan, bearing) = if by_colour {
        (painter.in_order(), None)
    } else {
        let panes = painter.panes();
        (painter.solid(&panes, LayerRole::is_wall), painter.bearing(&panes))
    };
    Ok(Vector {
        plan,
        bearing,
        doors: painter.doors(),
        left_out: options.with_left_out.then(|| painter.left_out()),
        layers: summary(&drawing, &roles),
        notes,
    })
}

/// The layers by name and role: those of one name differ in colour.
fn summary(drawing: &Drawing, roles: &[Option<LayerRole>]) -> Vec<LayerSummary> {
    let mut layers: Vec<LayerSummary> = Vec::new();
    for (layer, &role) in drawing.layers.iter().zip(roles) {
        let Layer { name, entities, hidden, annotations, .. } = layer.clone();
        match layers.iter_mut().find(|known| known.name == name && known.role == role) {
            Some(known) => {
                known.entities += entities;
                known.hidden += hidden;
                known.annotations += annotations;
            }
            None => layers.push(LayerSummary { name, entities, hidden, annotations, role }),
        }
    }
    layers
}

/// What the layers are.
struct Roles {
    roles: Vec<Option<LayerRole>>,
    /// Layers with something drawn that nothing tells.
    unknown: Vec<usize>,
    /// Whether colours told, as no name did.
    by_colour: bool,
}

/// The role of each layer. Layers that nothing tells are walls where no other layer is, and left out else.
fn roles(path: &Path, drawing: &Drawing, told: &LayerRoles, ink: &Ink) -> Result<Roles, PlanImportError> {
    let layers = || drawing.layers.iter();
    let mut roles: Vec<Option<LayerRole>> = layers().map(|layer| told.of(&layer.name)).collect();
    let by_colour =
        !roles.iter().flatten().any(|role| role.is_wall()) && layers().any(|layer| layer.colour.is_some());
    if by_colour {
        // No name says wall: colours tell, as in a picture.
        let of_colour = |layer: &Layer| layer.colour.map(|colour| role_of(ink.judge(colour)));
        roles.iter_mut().zip(layers()).for_each(|(role, layer)| *role = role.or_else(|| of_colour(layer)));
    }
    let drawn = |at: &usize| drawing.layers[*at].entities > 0;
    let unknown: Vec<usize> = (0..roles.len()).filter(|at| roles[*at].is_none() && drawn(at)).collect();
    if !(0..roles.len()).any(|at| drawn(&at) && roles[at].is_some_and(LayerRole::is_wall)) {
        if told.tells_walls() || unknown.is_empty() {
            let names = layers().map(|layer| layer.name.clone()).collect();
            return Err(PlanImportError::NoWallLayer { path: path.to_path_buf(), layers: names });
        }
        unknown.iter().for_each(|&at| roles[at] = Some(LayerRole::Wall));
    }
    Ok(Roles { roles, unknown, by_colour })
}

/// What a pixel of the layer's colour would be.
const fn role_of(class: u8) -> LayerRole {
    match class {
        ink::WALL | ink::DOUBTFUL_WALL => LayerRole::Wall,
        ink::WINDOW | ink::FAINT_DARK | ink::FAINT_LIGHT => LayerRole::Glazing,
        _ => LayerRole::Ignored,
    }
}

fn unknown_layer(drawing: &Drawing, at: usize) -> UnknownLayer {
    let shapes = drawing.shapes.iter().filter(|shape| shape.layer == at);
    let [least, most] = clusters::extent(shapes.map(Shape::extent));
    let layer = &drawing.layers[at];
    UnknownLayer {
        name: layer.name.clone(),
        entities: layer.entities,
        sides_m: [most[0] - least[0], most[1] - least[1]],
    }
}

/// Guesses the unit where the file has none, and notes what is doubtful.
fn settle_unit(path: &Path, drawing: &mut Drawing, roles: &[Option<LayerRole>], notes: &mut Vec<PlanNote>) {
    let walls = drawing.shapes.iter().filter(|shape| roles[shape.layer].is_some_and(LayerRole::is_wall));
    let side = likely_side(walls);
    let unit = drawing.unit.unwrap_or_else(|| Unit::guessed(side));
    let side_m = if drawing.unit.is_none() { side * unit.metres } else { side };
    if drawing.unit.is_none() {
        drawing.scale(unit.metres);
        drawing.unit = Some(unit);
    }
    let doubtful = !LIKELY_SIDE_M.contains(&side_m) && unit.source != UnitSource::Told;
    if unit.source == UnitSource::Guessed || doubtful {
        notes.push(PlanNote::Unit { path: path.to_path_buf(), unit, side_m });
    }
}

/// The longer side of what is drawn, without the outermost twentieths of its points: specks far off say nothing.
fn likely_side<'a>(shapes: impl Iterator<Item = &'a Shape>) -> f64 {
    let points: Vec<[f64; 2]> = shapes.flat_map(|shape| shape.contours.iter().flatten().copied()).collect();
    let side = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len() / 20;
        values
            .get(values.len().saturating_sub(cut + 1))
            .zip(values.get(cut))
            .map_or(0.0, |(high, low)| high - low)
    };
    side(0).max(side(1))
}

fn note_clusters(path: &Path, found: &[Cluster], specks: usize, notes: &mut Vec<PlanNote>) {
    if found.len() > 1 || specks > 0 {
        notes.push(PlanNote::SeveralDrawings {
            path: path.to_path_buf(),
            extents_m: found.iter().map(|cluster| cluster.extent).collect(),
            left_out: specks,
        });
    }
}

/// The raster for an extent in metres.
fn frame(
    path: &Path,
    [least, most]: [[f64; 2]; 2],
    told_m: Option<f64>,
    origin: Option<[f64; 2]>,
    notes: &mut Vec<PlanNote>,
) -> Result<Frame, PlanImportError> {
    let sides = [0, 1].map(|axis| most[axis] - least[axis] + 2.0 * MARGIN_M);
    let fits = |resolution: &f64| {
        let pixels = sides.map(|side| (side / resolution).ceil() + 1.0);
        let enough = told_m.is_some() || pixels[0] * pixels[1] <= MOST_PIXELS;
        enough && pixels.iter().all(|pixels| *pixels <= MOST_SIDE)
    };
    let resolutions = match told_m {
        Some(told) => vec![told],
        None => vec![0.01, 0.02, 0.05, 0.1, 0.2],
    };
    let Some(resolution_m) = resolutions.iter().copied().find(fits) else {
        return Err(PlanImportError::DrawingSize { path: path.to_path_buf(), sides_m: sides });
    };
    if told_m.is_none() && resolution_m > resolutions[0] {
        notes.push(PlanNote::Coarser { path: path.to_path_buf(), resolution_m, sides_m: sides });
    }
    // Pixels lie on whole multiples of their side, so that the same drawing gives the same pixels.
    let corner = least.map(|value| ((value - MARGIN_M) / resolution_m).floor() * resolution_m);
    let pixels = [0, 1].map(|axis| ((most[axis] + MARGIN_M - corner[axis]) / resolution_m).ceil() as u32);
    let origin = origin.map_or(corner, |at| [0, 1].map(|axis| at[axis] + corner[axis] - least[axis]));
    Ok(Frame { width: pixels[0], height: pixels[1], resolution_m, corner, origin })
}

const _: () = assert!(MARGIN_M > CAVITY_M);
