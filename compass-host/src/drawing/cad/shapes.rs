//! One entity as lines or an area, in the units of its block.

use super::super::{Paint, curve};
use acadrust::entities::{
    BoundaryEdge, BoundaryPath, EllipticArcEdge, EntityType, Hatch, LwPolyline, MLine, Polyline2D,
    SplineEdge, VertexFlags,
};
use acadrust::types::{Vector2, Vector3};
use std::f64::consts::TAU;

/// How far the normal of a flat entity may lean.
const MAX_LEAN: f64 = 1e-3;

/// What an entity is for a plan.
pub(super) enum Kind {
    /// Lines or an area.
    Shape(Paint, Vec<Vec<[f64; 2]>>),
    /// Text, a dimension and the like: never a wall.
    Annotation,
    /// An object that may be a wall but is not read, by its name.
    Unread(String),
}

/// 1 where an entity's plane looks up, -1 where it looks down, which mirrors x; `None` where it is tilted.
pub(super) fn flat(normal: Vector3) -> Option<f64> {
    let upright = normal.x.abs().max(normal.y.abs()) < MAX_LEAN * normal.z.abs();
    upright.then_some(normal.z.signum())
}

fn xy(point: Vector3) -> [f64; 2] {
    [point.x, point.y]
}

const fn xy2(point: Vector2) -> [f64; 2] {
    [point.x, point.y]
}

fn line(points: Vec<[f64; 2]>) -> Kind {
    Kind::Shape(Paint::Stroke(0.0), vec![points])
}

/// Reads entities.
pub(super) struct ShapeReader {
    /// Metres of one unit, for the length of chords.
    pub(super) unit_m: f64,
}

impl ShapeReader {
    /// What an entity is.
    pub(super) fn read(&self, entity: &EntityType) -> Kind {
        use EntityType as E;
        match entity {
            // Coordinates of these are those of the drawing, whatever their normal.
            E::Line(e) => line(vec![xy(e.start), xy(e.end)]),
            E::Ellipse(e) => self.ellipse(e),
            E::Spline(e) => line(spline(
                e.degree,
                &e.knots,
                &e.control_points.iter().map(|p| xy(*p)).collect::<Vec<_>>(),
                &e.weights,
                &e.fit_points.iter().map(|p| xy(*p)).collect::<Vec<_>>(),
            )),
            E::Polyline(e) => {
                line(closed(e.vertices.iter().map(|v| xy(v.location)).collect(), e.flags.is_closed()))
            }
            E::Polyline3D(e) => {
                line(closed(e.vertices.iter().map(|v| xy(v.position)).collect(), e.is_closed()))
            }
            E::MLine(e) => mline(e),
            E::Face3D(e) => {
                let corners = [e.first_corner, e.second_corner, e.third_corner, e.fourth_corner];
                line(closed(corners.map(xy).to_vec(), true))
            }
            // Coordinates of these lie in the plane of their normal.
            E::Arc(e) => {
                let sweep = curve::sweep(e.start_angle, e.end_angle);
                flattened(e.normal, || line(self.arc(xy(e.center), e.radius, e.start_angle, sweep)))
            }
            E::Circle(e) => flattened(e.normal, || line(self.arc(xy(e.center), e.radius, 0.0, TAU))),
            E::LwPolyline(e) => flattened(e.normal, || self.lw_polyline(e)),
            E::Polyline2D(e) => flattened(e.normal, || self.polyline(e)),
            E::Solid(e) => flattened(e.normal, || {
                let corners = [e.first_corner, e.second_corner, e.fourth_corner, e.third_corner];
                Kind::Shape(Paint::Fill, vec![corners.map(xy).to_vec()])
            }),
            E::Hatch(e) => flattened(e.normal, || self.hatch(e)),
            E::Solid3D(_) | E::Region(_) | E::Body(_) | E::Surface(_) | E::Mesh(_) => {
                Kind::Unread("solid or surface".into())
            }
            E::PolyfaceMesh(_) | E::PolygonMesh(_) => Kind::Unread("mesh".into()),
            E::RasterImage(_) | E::Underlay(_) | E::Ole2Frame(_) => Kind::Unread("image or underlay".into()),
            E::Unknown(e) => Kind::Unread(e.dxf_name.clone()),
            E::Extended(e) => Kind::Unread(e.class_name().to_owned()),
            _ => Kind::Annotation,
        }
    }

    fn arc(&self, centre: [f64; 2], radius: f64, start: f64, sweep: f64) -> Vec<[f64; 2]> {
        curve::arc(centre, [[radius, 0.0], [0.0, radius]], start, sweep, self.unit_m)
    }

    fn ellipse(&self, e: &acadrust::entities::Ellipse) -> Kind {
        let Some(turn) = flat(e.normal) else { return Kind::Unread("tilted ellipse".into()) };
        let major = xy(e.major_axis);
        let minor = [-major[1] * e.minor_axis_ratio * turn, major[0] * e.minor_axis_ratio * turn];
        let sweep = curve::sweep(e.start_parameter, e.end_parameter);
        line(curve::arc(xy(e.center), [major, minor], e.start_parameter, sweep, self.unit_m))
    }

    fn lw_polyline(&self, e: &LwPolyline) -> Kind {
        let corners: Vec<_> = e.vertices.iter().map(|v| (xy2(v.location), v.bulge)).collect();
        // Widths seldom vary along a wall: the widest counts.
        let widths = e.vertices.iter().flat_map(|v| [v.start_width, v.end_width]);
        let width = widths.fold(e.constant_width, f64::max);
        Kind::Shape(Paint::Stroke(width), vec![curve::polyline(&corners, e.is_closed, self.unit_m)])
    }

    fn polyline(&self, e: &Polyline2D) -> Kind {
        let frame = VertexFlags::SPLINE_CONTROL.bits();
        let drawn = e.vertices.iter().filter(|v| v.flags.bits() & frame == 0);
        let corners: Vec<_> = drawn.clone().map(|v| (xy(v.location), v.bulge)).collect();
        let widths = drawn.flat_map(|v| [v.start_width, v.end_width]);
        let width = widths.fold(e.start_width.max(e.end_width), f64::max);
        let points = curve::polyline(&corners, e.flags.is_closed(), self.unit_m);
        Kind::Shape(Paint::Stroke(width), vec![points])
    }

    /// A hatch as the area that it covers, whatever its pattern: hatched walls are solid.
    fn hatch(&self, e: &Hatch) -> Kind {
        Kind::Shape(Paint::Fill, e.paths.iter().map(|path| self.boundary(path)).collect())
    }

    fn boundary(&self, path: &BoundaryPath) -> Vec<[f64; 2]> {
        let edges = path.edges.iter().map(|edge| match edge {
            BoundaryEdge::Line(e) => vec![xy2(e.start), xy2(e.end)],
            BoundaryEdge::CircularArc(e) => {
                let sweep = oriented(e.start_angle, e.end_angle, e.counter_clockwise);
                self.arc(xy2(e.center), e.radius, e.start_angle, sweep)
            }
            BoundaryEdge::EllipticArc(e) => self.elliptic(e),
            BoundaryEdge::Spline(e) => spline_edge(e),
            BoundaryEdge::Polyline(e) => {
                let corners: Vec<_> = e.vertices.iter().map(|v| (xy(*v), v.z)).collect();
                curve::polyline(&corners, true, self.unit_m)
            }
        });
        edges.flatten().collect()
    }

    fn elliptic(&self, e: &EllipticArcEdge) -> Vec<[f64; 2]> {
        let major = xy2(e.major_axis_endpoint);
        let minor = [-major[1] * e.minor_axis_ratio, major[0] * e.minor_axis_ratio];
        let sweep = oriented(e.start_angle, e.end_angle, e.counter_clockwise);
        curve::arc(xy2(e.center), [major, minor], e.start_angle, sweep, self.unit_m)
    }
}

/// The sweep of an edge of a hatch: its angles count with its direction.
fn oriented(start: f64, end: f64, counter_clockwise: bool) -> f64 {
    if counter_clockwise { curve::sweep(start, end) } else { -curve::sweep(end, start) }
}

fn spline_edge(e: &SplineEdge) -> Vec<[f64; 2]> {
    let control: Vec<_> = e.control_points.iter().map(|p| xy(*p)).collect();
    let weights: Vec<_> =
        if e.rational { e.control_points.iter().map(|p| p.z).collect() } else { Vec::new() };
    let fit: Vec<_> = e.fit_points.iter().map(|p| xy2(*p)).collect();
    spline(e.degree, &e.knots, &control, &weights, &fit)
}

/// A spline by its control points; by its fit points where it has no others.
fn spline(
    degree: i32,
    knots: &[f64],
    control: &[[f64; 2]],
    weights: &[f64],
    fit: &[[f64; 2]],
) -> Vec<[f64; 2]> {
    let points = curve::spline(usize::try_from(degree).unwrap_or(0), knots, control, weights);
    if !points.is_empty() {
        return points;
    }
    if fit.is_empty() { control.to_vec() } else { fit.to_vec() }
}

/// The elements of a multiline; what lies between the outermost is filled.
fn mline(e: &MLine) -> Kind {
    let elements = e.vertices.iter().map(|vertex| vertex.segments.len()).min().unwrap_or(0);
    let along = |element: usize| -> Vec<[f64; 2]> {
        let points = e.vertices.iter().map(|vertex| {
            let offset = vertex.segments[element].parameters.first().copied().unwrap_or(0.0);
            xy(vertex.position + vertex.miter * offset)
        });
        closed(points.collect(), e.is_closed())
    };
    let offset = |element: &usize| {
        let first = e.vertices.first().and_then(|vertex| vertex.segments[*element].parameters.first());
        first.copied().unwrap_or(0.0)
    };
    let by_offset = |a: &usize, b: &usize| offset(a).total_cmp(&offset(b));
    let (Some(low), Some(high)) = ((0..elements).min_by(by_offset), (0..elements).max_by(by_offset)) else {
        return line(closed(e.vertices.iter().map(|vertex| xy(vertex.position)).collect(), e.is_closed()));
    };
    if elements == 1 {
        return line(along(0));
    }
    if e.is_closed() {
        // Even-odd: the ring between both.
        return Kind::Shape(Paint::Fill, vec![along(low), along(high)]);
    }
    let mut around = along(low);
    around.extend(along(high).into_iter().rev());
    Kind::Shape(Paint::Fill, vec![around])
}

/// Points with the first one repeated at the end, if `closed`.
fn closed(mut points: Vec<[f64; 2]>, closed: bool) -> Vec<[f64; 2]> {
    if closed {
        points.extend(points.first().copied());
    }
    points
}

/// An entity of a plane that looks up or, mirrored, down.
fn flattened(normal: Vector3, read: impl FnOnce() -> Kind) -> Kind {
    match (flat(normal), read()) {
        (None, _) => Kind::Unread("tilted entity".into()),
        (Some(turn), Kind::Shape(paint, mut contours)) if turn < 0.0 => {
            contours.iter_mut().flatten().for_each(|point| point[0] = -point[0]);
            Kind::Shape(paint, contours)
        }
        (_, kind) => kind,
    }
}
