//! SVG: paths by the labels, classes and ids around them, and by colour.
//!
//! `usvg` resolves styles, shapes, transforms and uses; it keeps ids alone. Elements therefore get an id each before it
//! reads them, by which the labels and classes are found again.

use super::curve::Outline;
use super::{Drawing, DrawingError, Paint, Shape};
use crate::input;
use std::collections::HashMap;
use std::path::Path;
use usvg::tiny_skia_path::PathSegment;

/// Prefix of the ids that elements without one get.
const OWN_ID: &str = "compass-";
/// Words that drawing programs number to make ids of: they name nothing.
const GENERATED: [&str; 16] = [
    "path", "rect", "g", "line", "circle", "ellipse", "polygon", "polyline", "use", "svg", "text", "tspan",
    "image", "layer", "group", "xmlid",
];

/// Reads a drawing in user units, y up from the lower edge.
///
/// # Errors
/// [`DrawingError`]: no SVG, or one too large.
pub(crate) fn read(path: &Path) -> Result<Drawing, DrawingError> {
    let syntax = |error: &dyn std::fmt::Display| DrawingError::Syntax(error.to_string());
    let text = input::read_text(path, input::limits().drawing_bytes).map_err(|error| syntax(&error))?;
    let (text, names) = with_ids(&text)?;
    let options = usvg::Options { resources_dir: None, ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(&text, &options).map_err(|error| syntax(&error))?;
    let mut walk = Walk { drawing: Drawing::default(), names, height: f64::from(tree.size().height()) };
    walk.group(tree.root(), &[])?;
    Ok(walk.drawing)
}

/// The text with an id on every element, and the names that belong to the ids.
fn with_ids(text: &str) -> Result<(String, HashMap<String, Vec<String>>), DrawingError> {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| DrawingError::Syntax(error.to_string()))?;
    let (mut names, mut written, mut done) = (HashMap::new(), String::with_capacity(text.len()), 0);
    for (n, element) in document.descendants().filter(roxmltree::Node::is_element).enumerate() {
        let label = element.attributes().find(|a| a.name() == "label").map(|a| a.value());
        let classes = element.attribute("class").into_iter();
        let id = element.attribute("id");
        let called = label.into_iter().chain(classes).chain(id.filter(|id| !is_generated(id)));
        let called: Vec<String> = called.map(str::to_owned).collect();
        if let Some(id) = id {
            names.insert(id.to_owned(), called);
            continue;
        }
        // After the tag's name; an element that an entity brought has no place of its own in the text.
        let start = element.range().start;
        let tag = text.get(start..).filter(|rest| start >= done && rest.starts_with('<'));
        if let Some(end) = tag.and_then(|tag| tag.find(|c: char| c.is_whitespace() || c == '>' || c == '/')) {
            let id = format!("{OWN_ID}{n}");
            written.push_str(&text[done..start + end]);
            written.push_str(&format!(" id=\"{id}\""));
            done = start + end;
            names.insert(id, called);
        }
    }
    written.push_str(&text[done..]);
    Ok((written, names))
}

/// Whether an id is a number that a drawing program gave.
fn is_generated(id: &str) -> bool {
    let word = id.trim_end_matches(|c: char| c.is_ascii_digit() || c == '-' || c == '_').to_ascii_lowercase();
    word.is_empty() || GENERATED.contains(&word.as_str())
}

struct Walk {
    drawing: Drawing,
    names: HashMap<String, Vec<String>>,
    height: f64,
}

impl Walk {
    fn group(&mut self, group: &usvg::Group, around: &[String]) -> Result<(), DrawingError> {
        let mut around = around.to_vec();
        around.extend(self.names.get(group.id()).into_iter().flatten().cloned());
        for node in group.children() {
            match node {
                usvg::Node::Group(inner) => self.group(inner, &around)?,
                usvg::Node::Path(path) if path.is_visible() => self.path(path, &around)?,
                usvg::Node::Image(_) => *self.drawing.unread.entry("image".into()).or_default() += 1,
                usvg::Node::Path(_) | usvg::Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn path(&mut self, path: &usvg::Path, around: &[String]) -> Result<(), DrawingError> {
        let own = self.names.get(path.id()).into_iter().flatten();
        let name: Vec<&str> = around.iter().chain(own).map(String::as_str).collect();
        let name = name.join(" / ");
        let transform = path.abs_transform();
        let contours = contours(path, self.height);
        let (sx, sy) = transform.get_scale();
        let width = |stroke: &usvg::Stroke| f64::from(stroke.width().get() * (sx * sy).abs().sqrt());
        let fill = path.fill().map(|fill| (fill.paint(), Paint::Fill));
        let stroke = path.stroke().map(|stroke| (stroke.paint(), Paint::Stroke(width(stroke))));
        for (colour, paint) in fill.into_iter().chain(stroke) {
            // Gradients and patterns fill rooms and furniture; walls are of one colour.
            let usvg::Paint::Color(colour) = colour else { continue };
            let rgb = [colour.red, colour.green, colour.blue];
            let layer = self.drawing.coloured_layer(&name, rgb);
            self.drawing.layers[layer].entities += 1;
            self.drawing.push(Shape { layer, paint, contours: contours.clone() })?;
        }
        Ok(())
    }
}

/// A path's contours in user units, y up.
fn contours(path: &usvg::Path, height: f64) -> Vec<Vec<[f64; 2]>> {
    let Some(data) = path.data().clone().transform(path.abs_transform()) else { return Vec::new() };
    let at = |point: usvg::tiny_skia_path::Point| [f64::from(point.x), height - f64::from(point.y)];
    let mut outline = Outline::default();
    for segment in data.segments() {
        match segment {
            PathSegment::MoveTo(point) => outline.move_to(at(point)),
            PathSegment::LineTo(point) => outline.line_to(at(point)),
            PathSegment::QuadTo(a, b) => outline.quadratic_to(at(a), at(b)),
            PathSegment::CubicTo(a, b, c) => outline.cubic_to(at(a), at(b), at(c)),
            PathSegment::Close => outline.close(),
        }
    }
    outline.contours
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Drawing {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.svg");
        std::fs::write(&path, text).unwrap();
        read(&path).unwrap()
    }

    #[test]
    fn names_are_those_of_the_elements_around() {
        let drawing = parsed(
            r##"<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
                width="200" height="100"><style>.Wall{fill:#222}</style>
              <g inkscape:label="Ground floor" id="layer1"><g class="Wall External">
                <rect class="Wall" x="10" y="20" width="40" height="5"/>
                <g transform="translate(100 0) scale(2)"><path id="Window" d="M0 0h10" fill="none" stroke="#ff0000" stroke-width="1.5"/></g>
              </g></g>
              <circle id="circle77" r="3" fill="#00f" display="none"/>
            </svg>"##,
        );
        let names: Vec<_> = drawing.layers.iter().map(|layer| (layer.name.as_str(), layer.colour)).collect();
        assert_eq!(
            names,
            [
                ("Ground floor / Wall External / Wall", Some([0x22; 3])),
                ("Ground floor / Wall External / Window", Some([255, 0, 0])),
            ]
        );
        assert_eq!(drawing.shapes[0].extent(), [[10.0, 75.0], [50.0, 80.0]]);
        assert_eq!(drawing.shapes[1].extent(), [[100.0, 100.0], [120.0, 100.0]]);
        assert_eq!(drawing.shapes[1].paint, Paint::Stroke(3.0));
    }

    #[test]
    fn without_names_the_colour_is_the_name() {
        let drawing = parsed(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path id="path12-3" d="M1 1C1 5 5 8 8 8" stroke="black" fill="none"/></svg>"#,
        );
        assert_eq!(drawing.layers[0].name, "#000000");
        let points = &drawing.shapes[0].contours[0];
        assert!(points.len() > 8 && points[0] == [1.0, 8.0] && *points.last().unwrap() == [8.0, 1.0]);
    }

    #[test]
    fn what_is_no_svg_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.svg");
        for bytes in [&b"<svg"[..], b"<html></html>", b"\xff\xfe", b""] {
            std::fs::write(&path, bytes).unwrap();
            assert!(read(&path).is_err(), "{bytes:?}");
        }
    }
}
