//! Visits what model space shows, through inserted blocks.

use super::super::{Drawing, DrawingError, Paint, Shape, unit::Unit};
use super::shapes::{Kind, ShapeReader};
use acadrust::CadDocument;
use acadrust::entities::{EntityCommon, EntityType, Insert};
use nalgebra::{Matrix3, Point2, Vector2};
use std::collections::HashSet;

/// Deepest nesting of blocks.
const MAX_DEPTH: usize = 16;
/// Layer whose entities in a block take the layer of the insert.
const INHERITING_LAYER: &str = "0";
/// The block of model space.
const MODEL_SPACE: &str = "*Model_Space";

/// A visit of a document.
pub(super) struct Walk<'a> {
    document: &'a CadDocument,
    frozen: HashSet<&'a str>,
    off: HashSet<&'a str>,
    drawing: Drawing,
    /// Metres of one unit; 1 where the unit is unknown.
    unit_m: f64,
}

/// Where a block is inserted.
#[derive(Clone, Copy)]
struct Place<'a> {
    /// From coordinates of the block to those of model space.
    to_model: Matrix3<f64>,
    /// The layer of what the block draws on [`INHERITING_LAYER`].
    layer: &'a str,
    depth: usize,
}

impl<'a> Walk<'a> {
    pub(super) fn new(document: &'a CadDocument, unit: Option<Unit>) -> Self {
        let layers = || document.layers.iter();
        Self {
            document,
            frozen: layers().filter(|layer| layer.flags.frozen).map(|layer| layer.name.as_str()).collect(),
            off: layers().filter(|layer| layer.flags.off).map(|layer| layer.name.as_str()).collect(),
            drawing: Drawing { unit, ..Drawing::default() },
            unit_m: unit.map_or(1.0, |unit| unit.metres),
        }
    }

    pub(super) fn finish(self) -> Drawing {
        self.drawing
    }

    /// Visits model space.
    pub(super) fn model_space(&mut self) -> Result<(), DrawingError> {
        let place = Place { to_model: Matrix3::identity(), layer: INHERITING_LAYER, depth: 0 };
        self.block(MODEL_SPACE, &place)
    }

    fn block(&mut self, name: &str, place: &Place<'a>) -> Result<(), DrawingError> {
        let document = self.document;
        document.entities_in_block(name).try_for_each(|entity| self.entity(entity, place))
    }

    fn entity(&mut self, entity: &'a EntityType, place: &Place<'a>) -> Result<(), DrawingError> {
        let common = entity.common();
        let layer = match common.layer.as_str() {
            INHERITING_LAYER => place.layer,
            own => own,
        };
        if let EntityType::Insert(insert) = entity {
            // A switched-off layer hides an insert's own entities alone, a frozen one all that it brings.
            return if self.frozen.contains(layer) || common.invisible {
                self.hide(layer);
                Ok(())
            } else {
                self.insert(insert, layer, place)
            };
        }
        if self.is_hidden(common, layer) {
            self.hide(layer);
            return Ok(());
        }
        // The size of one unit of the block decides how finely its curves are cut.
        let size = place.to_model.column(0).norm().max(place.to_model.column(1).norm());
        match (ShapeReader { unit_m: self.unit_m * size }).read(entity) {
            Kind::Shape(paint, contours) => self.shape(layer, place, paint, contours),
            Kind::Annotation => {
                let at = self.drawing.layer(layer);
                self.drawing.layers[at].annotations += 1;
                Ok(())
            }
            Kind::Unread(kind) => {
                *self.drawing.unread.entry(kind).or_default() += 1;
                Ok(())
            }
        }
    }

    fn shape(
        &mut self,
        layer: &str,
        place: &Place<'_>,
        paint: Paint,
        mut contours: Vec<Vec<[f64; 2]>>,
    ) -> Result<(), DrawingError> {
        let to_metres = place.to_model * self.unit_m;
        for point in contours.iter_mut().flatten() {
            let moved = to_metres * Point2::from(*point).to_homogeneous();
            *point = [moved.x, moved.y];
        }
        // A width follows the mean scale: a stretched line has no one width.
        let scale = to_metres.fixed_view::<2, 2>(0, 0).determinant().abs().sqrt();
        let paint = if let Paint::Stroke(width) = paint { Paint::Stroke(width * scale) } else { paint };
        let layer = self.drawing.layer(layer);
        self.drawing.layers[layer].entities += 1;
        self.drawing.push(Shape { layer, paint, contours })
    }

    fn insert(&mut self, insert: &'a Insert, layer: &'a str, place: &Place<'a>) -> Result<(), DrawingError> {
        let Some(block) = self.document.block_records.get(&insert.block_name) else { return Ok(()) };
        if block.entity_handles.is_empty() && !block.xref_path.is_empty() {
            *self.drawing.unread.entry(format!("external reference {}", block.xref_path)).or_default() += 1;
            return Ok(());
        }
        let Some(mirror) = super::shapes::flat(insert.normal) else {
            *self.drawing.unread.entry("tilted insert".into()).or_default() += 1;
            return Ok(());
        };
        if place.depth == MAX_DEPTH {
            return Err(DrawingError::Syntax(format!("blocks are nested more than {MAX_DEPTH} deep")));
        }
        let turn = nalgebra::Rotation2::new(insert.rotation);
        let scale = Vector2::new(insert.x_scale(), insert.y_scale());
        let base = Vector2::new(block.base_point.x, block.base_point.y);
        for row in 0..insert.row_count.max(1) {
            for column in 0..insert.column_count.max(1) {
                let step = Vector2::new(
                    f64::from(column) * insert.column_spacing,
                    f64::from(row) * insert.row_spacing,
                );
                let at = Vector2::new(insert.insert_point.x, insert.insert_point.y) + turn * step;
                let own = Matrix3::new_nonuniform_scaling(&Vector2::new(mirror, 1.0))
                    * Matrix3::new_translation(&at)
                    * turn.to_homogeneous()
                    * Matrix3::new_nonuniform_scaling(&scale)
                    * Matrix3::new_translation(&-base);
                let inner = Place { to_model: place.to_model * own, layer, depth: place.depth + 1 };
                self.block(&insert.block_name, &inner)?;
            }
        }
        Ok(())
    }

    fn is_hidden(&self, common: &EntityCommon, layer: &str) -> bool {
        common.invisible || self.frozen.contains(layer) || self.off.contains(layer)
    }

    fn hide(&mut self, layer: &str) {
        let at = self.drawing.layer(layer);
        self.drawing.layers[at].hidden += 1;
    }
}
