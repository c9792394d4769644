//! A drawing's layers, by their roles, as pixels.

use super::layers::LayerRole;
use super::line_walls;
use super::paint::{self, Frame};
use super::raster::PlanRaster;
use super::structure::Bearing;
use crate::drawing::{Drawing, Paint, Shape};

/// Draws what a drawing shows.
pub(super) struct Painter<'a> {
    pub(super) drawing: &'a Drawing,
    /// The role of each layer.
    pub(super) roles: &'a [Option<LayerRole>],
    pub(super) frame: &'a Frame,
    /// The walls and the glazing, without what is too far off.
    pub(super) kept: Vec<&'a Shape>,
}

impl Painter<'_> {
    /// All glazing, filled between its own lines.
    pub(super) fn panes(&self) -> PlanRaster {
        let mut panes = self.frame.empty();
        paint::glazing(&mut panes, self.frame, &self.of(|role| role == LayerRole::Glazing));
        line_walls::fill(&mut panes);
        panes
    }

    /// The walls that are `wanted`, solid, and the `panes`, which replace a wall that is drawn through them.
    pub(super) fn solid(&self, panes: &PlanRaster, wanted: impl Fn(LayerRole) -> bool) -> PlanRaster {
        let mut raster = self.frame.empty();
        paint::walls(&mut raster, self.frame, &self.of(wanted));
        raster.glaze(panes);
        line_walls::fill(&mut raster);
        let areas = self.door_areas();
        paint::clear(&mut raster, self.frame, &areas.iter().collect::<Vec<_>>());
        raster
    }

    /// All shapes in their order, where colours tell: paper drawn over a wall makes it free. Furniture has the colour of
    /// walls there, so that narrow places between lines are no sign of a wall.
    pub(super) fn in_order(&self) -> PlanRaster {
        let mut raster = self.frame.empty();
        paint::in_order(&mut raster, self.frame, self.drawing.shapes.iter(), |layer| self.roles[layer]);
        raster
    }

    /// What the layers say of the structure, if they do.
    pub(super) fn bearing(&self, panes: &PlanRaster) -> Option<Bearing> {
        let has_structure = self.has(LayerRole::Structure);
        (has_structure || self.has(LayerRole::Partition)).then(|| Bearing {
            certain: has_structure.then(|| self.solid(panes, |role| role == LayerRole::Structure)),
            possible: self.solid(panes, |role| matches!(role, LayerRole::Structure | LayerRole::Wall)),
        })
    }

    /// Lines of doors, if a layer shows them.
    pub(super) fn doors(&self) -> Option<PlanRaster> {
        self.has(LayerRole::Door).then(|| {
            let mut doors = self.frame.empty();
            paint::walls(&mut doors, self.frame, &self.door_shapes().collect::<Vec<_>>());
            doors
        })
    }

    /// Lines of what is neither plan nor door; of areas the outlines alone, as floors are often filled.
    pub(super) fn left_out(&self) -> PlanRaster {
        let is_other =
            |role: Option<LayerRole>| role.is_none_or(|role| !role.is_plan() && role != LayerRole::Door);
        let others = self.drawing.shapes.iter().filter(|shape| is_other(self.role(shape)));
        let outlines: Vec<Shape> =
            others.map(|shape| Shape { paint: Paint::Stroke(0.0), ..shape.clone() }).collect();
        let mut left_out = self.frame.empty();
        paint::walls(&mut left_out, self.frame, &outlines.iter().collect::<Vec<_>>());
        left_out
    }

    fn of(&self, wanted: impl Fn(LayerRole) -> bool) -> Vec<&Shape> {
        self.kept.iter().copied().filter(|shape| self.role(shape).is_some_and(&wanted)).collect()
    }

    fn role(&self, shape: &Shape) -> Option<LayerRole> {
        self.roles[shape.layer]
    }

    fn has(&self, role: LayerRole) -> bool {
        self.roles.contains(&Some(role))
    }

    fn door_shapes(&self) -> impl Iterator<Item = &Shape> {
        self.drawing.shapes.iter().filter(|shape| self.role(shape) == Some(LayerRole::Door))
    }

    /// What doors cover: areas that are filled or closed, as some drawings lay them over a wall that goes on below.
    fn door_areas(&self) -> Vec<Shape> {
        let area = |shape: &Shape| {
            let closed =
                |contour: &&Vec<[f64; 2]>| shape.paint == Paint::Fill || contour.first() == contour.last();
            let contours: Vec<_> = shape.contours.iter().filter(closed).cloned().collect();
            (!contours.is_empty()).then_some(Shape { layer: shape.layer, paint: Paint::Fill, contours })
        };
        self.door_shapes().filter_map(area).collect()
    }
}
