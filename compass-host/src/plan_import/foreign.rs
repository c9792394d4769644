//! Plan files of another format than their name says, or of one that is not read.

use crate::input;
use std::path::Path;

/// First bytes that are looked at.
const HEAD_BYTES: usize = 256;

/// What a file is by its first bytes, and what to do with it.
const KNOWN: [(&[u8], &str); 12] = [
    (b"ISO-10303-21", "this is an IFC or STEP model; export the storey as a DXF, SVG or PDF drawing"),
    (b"%PDF-", "this is a PDF; give it a name that ends in .pdf"),
    (b"AC10", "this is a DWG drawing; give it a name that ends in .dwg"),
    (b"AutoCAD Binary DXF", "this is a DXF drawing; give it a name that ends in .dxf"),
    (b"<svg", "this is an SVG drawing; give it a name that ends in .svg"),
    (b"GIF8", "this is a GIF image; save it as PNG"),
    (b"PK\x03\x04", "this is a ZIP archive; unpack it first"),
    (b"\x1f\x8b", "this is packed with gzip; unpack it first"),
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "this is a Revit model or an office document; export the plan as a DXF or PDF drawing",
    ),
    (b"SQLite format 3\0", "this is an SQLite database, not a plan"),
    (b"\x89MCAP0\r\n", "this is a recording, not a plan"),
    (b"#ROSBAG V", "this is a recording, not a plan"),
];

/// What a file that is no image is instead, where that is known.
pub(super) fn recognise(path: &Path) -> Option<&'static str> {
    of_head(&input::read_head(path, HEAD_BYTES).ok()?)
}

fn of_head(head: &[u8]) -> Option<&'static str> {
    let start = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let known =
        |start: &[u8]| KNOWN.iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, what)| *what);
    if let Some(what) = known(start) {
        return Some(what);
    }
    let text = std::str::from_utf8(start).unwrap_or_default();
    let mut lines = text.lines().map(str::trim);
    // A DXF in text opens with its first section, an SVG often with an XML declaration.
    if lines.next() == Some("0") && lines.next() == Some("SECTION") {
        return known(b"AutoCAD Binary DXF");
    }
    (text.starts_with("<?xml") && text.contains("<svg")).then(|| known(b"<svg")).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_formats_are_recognised() {
        let named = |head: &[u8], word: &str| {
            let what = of_head(head).unwrap_or_default();
            assert!(what.contains(word), "{word}: {what}");
        };
        named(b"ISO-10303-21;\nHEADER;\n", "IFC");
        named(b"\xef\xbb\xbfISO-10303-21;", "IFC");
        named(b"%PDF-1.7\n", ".pdf");
        named(b"AC1032\0\0", ".dwg");
        named(b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", ".dxf");
        named(b"AutoCAD Binary DXF\r\n\x1a\0", ".dxf");
        named(b"<?xml version=\"1.0\"?>\n<!-- made by hand -->\n<svg width=\"3\">", ".svg");
        named(b"\n<svg xmlns=", ".svg");
        named(b"GIF89a", "GIF");
        for unknown in
            [&b"hello, this is text"[..], b"", b"0\n", b"<?xml version=\"1.0\"?><kml>", b"\xff\xfe"]
        {
            assert_eq!(of_head(unknown), None, "{unknown:?}");
        }
    }
}
