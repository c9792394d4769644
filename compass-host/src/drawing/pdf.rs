//! PDF: lines and areas of a page by optional-content layer, else by colour. Text and images are left out.

use super::curve::Outline;
use super::{Drawing, DrawingError, Paint, Shape, guarded};
use crate::input;
use hayro_interpret::hayro_syntax::Pdf;
use hayro_interpret::hayro_syntax::object::{Dict, String as PdfString};
use hayro_interpret::kurbo::{Affine, BezPath, PathEl, Point, Rect};
use hayro_interpret::{
    BlendMode, ClipPath, Context, Device, DrawMode, DrawProps, Image, ImageDrawProps, InterpreterCache,
    InterpreterSettings, Paint as PdfPaint, SoftMask, TransformExt, font::GlyphRun, interpret_page,
};
use std::path::Path;

/// Reads a page, the first is 1, in points (1/72 inch), y up from the lower edge.
///
/// # Errors
/// [`DrawingError`]: no PDF, one too large, or without that page.
pub(crate) fn read(path: &Path, page: usize) -> Result<Drawing, DrawingError> {
    guarded(|| interpret(path, page))
}

fn interpret(path: &Path, number: usize) -> Result<Drawing, DrawingError> {
    let syntax = |reason: String| DrawingError::Syntax(reason);
    let data = input::read(path, input::limits().drawing_bytes).map_err(|error| syntax(error.to_string()))?;
    let pdf = Pdf::new(data).map_err(|error| syntax(format!("{error:?}")))?;
    let pages = pdf.pages();
    let page = number.checked_sub(1).and_then(|at| pages.get(at));
    let page = page.ok_or_else(|| syntax(format!("it has {} pages, not page {number}", pages.len())))?;
    let (width, height) = page.render_dimensions();
    let mut lines = Lines { drawing: Drawing::default(), layers: Vec::new(), error: None };
    let cache = InterpreterCache::new();
    let place = page.initial_transform(false).to_kurbo();
    let area = Rect::new(0.0, 0.0, f64::from(width), f64::from(height));
    let mut context = Context::new(place, area, &cache, page.xref(), InterpreterSettings::default());
    interpret_page(page, &mut context, &mut lines);
    match lines.error {
        Some(error) => Err(error),
        None => Ok(lines.drawing),
    }
}

/// A device that collects lines and areas.
struct Lines {
    drawing: Drawing,
    /// The layer of each open marked content, if it has one.
    layers: Vec<Option<String>>,
    error: Option<DrawingError>,
}

impl Lines {
    fn add(&mut self, paint: Paint, rgb: [u8; 3], contours: Vec<Vec<[f64; 2]>>) {
        if self.error.is_some() {
            return;
        }
        let name = self.layers.iter().rev().flatten().next().cloned().unwrap_or_default();
        let layer = self.drawing.coloured_layer(&name, rgb);
        self.drawing.layers[layer].entities += 1;
        self.error = self.drawing.push(Shape { layer, paint, contours }).err();
    }
}

impl<'a> Device<'a> for Lines {
    fn draw_path(&mut self, path: &BezPath, props: DrawProps<'a>, mode: &DrawMode) {
        // Patterns and shadings fill rooms and furniture; walls are of one colour.
        let PdfPaint::Color(colour) = &props.paint else { return };
        let [r, g, b, alpha] = colour.to_rgba().to_rgba8();
        if alpha < 128 {
            return;
        }
        let contours = contours(path, props.transform);
        let scale = props.transform.determinant().abs().sqrt();
        if matches!(mode, DrawMode::Fill(_) | DrawMode::FillAndStroke(..)) {
            self.add(Paint::Fill, [r, g, b], contours.clone());
        }
        if let DrawMode::Stroke(stroke) | DrawMode::FillAndStroke(_, stroke) = mode {
            self.add(Paint::Stroke(f64::from(stroke.line_width) * scale), [r, g, b], contours);
        }
    }

    fn begin_marked_content(&mut self, tag: &[u8], properties: Option<&Dict<'_>>) {
        let name = properties.filter(|_| tag == b"OC").and_then(|group| group.get::<PdfString<'_>>("Name"));
        self.layers.push(name.map(|name| text(name.as_bytes())));
    }

    fn end_marked_content(&mut self) {
        self.layers.pop();
    }

    fn draw_image(&mut self, _: Image<'a, '_>, _: ImageDrawProps<'a>) {
        *self.drawing.unread.entry("image".into()).or_default() += 1;
    }

    fn push_clip_path(&mut self, _: &ClipPath) {}
    fn push_transparency_group(&mut self, _: f32, _: Option<SoftMask<'a>>, _: BlendMode) {}
    fn draw_glyph_run(&mut self, _: &GlyphRun<'_, 'a>, _: DrawProps<'a>, _: &DrawMode) {}
    fn pop_clip(&mut self) {}
    fn pop_transparency_group(&mut self) {}
}

/// A text string: UTF-16 with a mark, UTF-8 with a mark, else about Latin 1.
fn text(bytes: &[u8]) -> String {
    match bytes {
        [0xfe, 0xff, rest @ ..] => {
            let units: Vec<u16> =
                rest.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
            String::from_utf16_lossy(&units)
        }
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

fn contours(path: &BezPath, transform: Affine) -> Vec<Vec<[f64; 2]>> {
    let at = |point: Point| {
        let point = transform * point;
        [point.x, point.y]
    };
    let mut outline = Outline::default();
    for element in path.elements() {
        match *element {
            PathEl::MoveTo(point) => outline.move_to(at(point)),
            PathEl::LineTo(point) => outline.line_to(at(point)),
            PathEl::QuadTo(a, b) => outline.quadratic_to(at(a), at(b)),
            PathEl::CurveTo(a, b, c) => outline.cubic_to(at(a), at(b), at(c)),
            PathEl::ClosePath => outline.close(),
        }
    }
    outline.contours
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page of 300 x 200 points with a layer, written by hand.
    fn pdf(content: &str) -> Vec<u8> {
        let objects = [
            "<< /Type /Catalog /Pages 2 0 R /OCProperties << /OCGs [5 0 R] /D << /Order [5 0 R] >> >> >>"
                .to_owned(),
            "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
            "<< /Type /Page /Parent 2 0 R /MediaBox [10 20 310 220] /Contents 4 0 R \
             /Resources << /Properties << /MC0 5 0 R >> >> >>"
                .to_owned(),
            format!("<< /Length {} >>\nstream\n{content}\nendstream", content.len()),
            "<< /Type /OCG /Name (A-WALL) >>".to_owned(),
        ];
        let mut text = String::from("%PDF-1.7\n");
        let mut offsets = Vec::new();
        for (n, object) in objects.iter().enumerate() {
            offsets.push(text.len());
            text += &format!("{} 0 obj\n{object}\nendobj\n", n + 1);
        }
        let start = text.len();
        text += &format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
        offsets.iter().for_each(|offset| text += &format!("{offset:010} 00000 n \n"));
        text +=
            &format!("trailer << /Size {} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n", objects.len() + 1);
        text.into_bytes()
    }

    fn read_bytes(bytes: &[u8], page: usize) -> Result<Drawing, DrawingError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pdf");
        std::fs::write(&path, bytes).unwrap();
        read(&path, page)
    }

    #[test]
    fn lines_lie_on_the_page_with_layer_and_colour() {
        let content =
            "/OC /MC0 BDC 2 w 20 30 m 120 30 l S EMC 1 0 0 RG 0.5 0 0 0.5 10 20 cm 20 20 100 50 re S";
        let drawing = read_bytes(&pdf(content), 1).unwrap();
        let names: Vec<_> = drawing.layers.iter().map(|layer| (layer.name.as_str(), layer.colour)).collect();
        assert_eq!(names, [("A-WALL", Some([0; 3])), ("#ff0000", Some([255, 0, 0]))]);
        assert_eq!(drawing.shapes[0].extent(), [[10.0, 10.0], [110.0, 10.0]]);
        assert_eq!(drawing.shapes[0].paint, Paint::Stroke(2.0));
        assert_eq!(drawing.shapes[1].extent(), [[10.0, 10.0], [60.0, 35.0]]);
        assert_eq!(drawing.shapes[1].paint, Paint::Stroke(1.0));
    }

    #[test]
    fn pages_that_are_not_there_and_files_of_another_kind_are_errors() {
        let whole = pdf("0 0 m 9 9 l S");
        let missing = read_bytes(&whole, 2).unwrap_err().to_string();
        assert!(missing.contains("1 pages, not page 2"), "{missing}");
        assert!(read_bytes(&whole, 0).is_err());
        for bytes in [&b"not a page"[..], b"", b"%PDF-1.7\n"] {
            assert!(read_bytes(bytes, 1).is_err());
        }
    }
}
