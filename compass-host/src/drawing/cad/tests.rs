//! A drawing with one of each kind, written by hand, read as DXF and, through the writers of the crate, as binary DXF
//! and DWG.

use super::*;
use crate::drawing::{Paint, Shape};
use acadrust::types::DxfVersion;
use acadrust::{DwgWriter, DxfWriter};

/// Pairs of group codes and values, separated by blanks; `~` in a value stands for a blank.
fn dxf(pairs: &str) -> String {
    let mut words = pairs.split_whitespace();
    let mut text = String::new();
    while let (Some(code), Some(value)) = (words.next(), words.next()) {
        text += &format!("{code:>3}\n{}\n", value.replace('~', " "));
    }
    text
}

/// A document with these blocks and entities; lengths are millimetres.
fn document(blocks: &str, entities: &str) -> String {
    let layers: String =
        (0..ENTITIES.len()).map(|n| format!("0 LAYER 2 L{n} 70 0 62 7 6 CONTINUOUS ")).collect();
    dxf(&format!(
        "0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC
         0 SECTION 2 TABLES 0 TABLE 2 LAYER 70 18
         0 LAYER 2 0 70 0 62 7 6 CONTINUOUS
         0 LAYER 2 A-WALL 70 0 62 7 6 CONTINUOUS
         0 LAYER 2 FROZEN 70 1 62 7 6 CONTINUOUS
         0 LAYER 2 OFF 70 0 62 -7 6 CONTINUOUS {layers}
         0 ENDTAB 0 ENDSEC
         0 SECTION 2 BLOCKS {blocks} 0 ENDSEC
         0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
    ))
}

fn parsed(text: &str) -> Drawing {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.dxf");
    std::fs::write(&path, text).unwrap();
    read(&path, None).unwrap()
}

/// The extent of everything on a layer, in whole millimetres.
fn extent(drawing: &Drawing, layer: &str) -> [[i64; 2]; 2] {
    let at =
        drawing.layers.iter().position(|known| known.name == layer).unwrap_or_else(|| panic!("no {layer}"));
    let shapes = drawing.shapes.iter().filter(|shape| shape.layer == at).map(Shape::extent);
    let all = shapes.reduce(|a, b| {
        [[a[0][0].min(b[0][0]), a[0][1].min(b[0][1])], [a[1][0].max(b[1][0]), a[1][1].max(b[1][1])]]
    });
    all.unwrap().map(|corner| corner.map(|value| (value * 1000.0).round() as i64))
}

/// Every kind of entity on a layer of its own, and the extent that it must have.
const ENTITIES: [(&str, &str, [[i64; 2]; 2]); 14] = [
    ("LINE", "10 100 20 200 11 4100 21 200", [[100, 200], [4100, 200]]),
    ("ARC", "10 0 20 0 40 1000 50 350 51 100", [[-174, -174], [1000, 1000]]),
    ("CIRCLE", "10 500 20 500 40 250", [[250, 250], [750, 750]]),
    // Seen from below: x is mirrored.
    ("CIRCLE", "10 500 20 500 40 250 210 0 220 0 230 -1", [[-750, 250], [-250, 750]]),
    ("ELLIPSE", "10 0 20 0 11 0 21 2000 40 0.25 41 0 42 6.283185307179586", [[-500, -2000], [500, 2000]]),
    // Half a circle by its bulge, counter-clockwise: it swings to the right.
    ("LWPOLYLINE", "90 2 70 0 10 0 20 0 42 1 10 0 20 1000", [[0, 0], [500, 1000]]),
    ("LWPOLYLINE", "90 3 70 1 10 0 20 0 10 3000 20 0 10 3000 20 800", [[0, 0], [3000, 800]]),
    ("SOLID", "10 0 20 0 11 400 21 0 12 0 22 300 13 400 23 300", [[0, 0], [400, 300]]),
    (
        "SPLINE",
        "70 8 71 1 72 4 73 2 40 0 40 0 40 1 40 1 10 0 20 0 10 700 20 900",
        [[0, 0], [700, 900]],
    ),
    (
        "HATCH",
        "10 0 20 0 30 0 2 ANSI31 70 0 71 0 91 1 92 2 72 0 73 1 93 4 10 0 20 0 10 600 20 0 10 600 20 200 10 0 20 200
         97 0 75 0 76 1 52 0 41 1 77 0 78 0 98 0",
        [[0, 0], [600, 200]],
    ),
    (
        "HATCH",
        "10 0 20 0 30 0 2 SOLID 70 1 71 0 91 1 92 1 93 2 72 2 10 0 20 0 40 500 50 0 51 180 73 1
         72 1 10 -500 20 0 11 500 21 0 97 0 75 0 76 1 98 0",
        [[-500, 0], [500, 500]],
    ),
    ("3DFACE", "10 0 20 0 11 900 21 0 12 900 22 100 13 0 23 100", [[0, 0], [900, 100]]),
    ("INSERT", "2 PIER 10 1000 20 0 41 2 42 1 50 90", [[700, 0], [1000, 800]]),
    // Mirrored, in two columns and three rows.
    ("INSERT", "2 PIER 10 0 20 0 41 -1 70 2 71 3 44 5000 45 7000", [[-400, 0], [5000, 14300]]),
];

const PIER: &str = "0 BLOCK 8 0 2 PIER 70 0 10 50 20 0 30 0 3 PIER 1 ~
                    0 SOLID 8 0 10 50 20 0 11 450 21 0 12 50 22 300 13 450 23 300 0 ENDBLK 8 0";

fn one_of_each() -> String {
    let entities = ENTITIES.iter().enumerate().map(|(n, (kind, pairs, _))| {
        // Entities without a normal look up.
        let normal = if pairs.contains("230 ") { "" } else { "210 0 220 0 230 1" };
        format!("0 {kind} 8 L{n} {pairs} {normal} ")
    });
    document(PIER, &entities.collect::<String>())
}

#[test]
fn every_kind_of_entity_lies_where_it_is_drawn() {
    let drawing = parsed(&one_of_each());
    for (n, (kind, pairs, wanted)) in ENTITIES.iter().enumerate() {
        let found = extent(&drawing, &format!("L{n}"));
        // Chords cut curves short by up to two millimetres.
        let near = found
            .as_flattened()
            .iter()
            .zip(wanted.as_flattened())
            .all(|(found, wanted)| (found - wanted).abs() <= 2);
        assert!(near, "{kind} {pairs}: {found:?}");
    }
    assert!(drawing.unread.is_empty(), "{:?}", drawing.unread);
    assert_eq!(drawing.unit.map(|unit| unit.metres), Some(0.001));
}

#[test]
fn binary_files_and_dwg_of_all_versions_hold_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (text, binary, dwg) =
        (folder.path().join("a.dxf"), folder.path().join("b.DXF"), folder.path().join("c.dwg"));
    std::fs::write(&text, one_of_each()).unwrap();
    let wanted = read(&text, None).unwrap();
    let mut document = parse(&text).unwrap();
    DxfWriter::new_binary(&document).write_to_file(&binary).unwrap();
    let mut others = vec![(binary.clone(), "binary".to_owned(), read(&binary, None).unwrap())];
    for version in [DxfVersion::AC1015, DxfVersion::AC1018, DxfVersion::AC1024, DxfVersion::AC1032] {
        document.version = version;
        DwgWriter::write_to_file(&dwg, &document).unwrap();
        others.push((dwg.clone(), format!("{version:?}"), read(&dwg, None).unwrap()));
    }
    for (path, what, other) in others {
        for n in 0..ENTITIES.len() {
            let layer = format!("L{n}");
            assert_eq!(extent(&other, &layer), extent(&wanted, &layer), "{what} {} {layer}", path.display());
        }
    }
}

#[test]
fn what_is_frozen_off_or_in_paper_space_is_left_out() {
    let line = |layer: &str, more: &str| format!("0 LINE 8 {layer} {more} 10 0 20 0 11 1000 21 0 ");
    let blocks = "0 BLOCK 8 0 2 B 70 0 10 0 20 0 30 0 3 B 1 ~
                  0 LINE 8 0 10 0 20 0 11 1000 21 0 0 LINE 8 A-WALL 10 0 20 0 11 1000 21 0 0 ENDBLK 8 0";
    let drawing = parsed(&document(
        blocks,
        &[
            line("A-WALL", ""),
            line("A-WALL", "67 1"),
            line("A-WALL", "60 1"),
            line("FROZEN", ""),
            line("OFF", ""),
            "0 INSERT 8 FROZEN 2 B 10 0 20 0 0 INSERT 8 OFF 2 B 10 0 20 0 0 TEXT 8 A-WALL 10 0 20 0 40 5 1 Room ".into(),
        ]
        .concat(),
    ));
    let layer = |name: &str| {
        let found = drawing.layers.iter().find(|layer| layer.name == name);
        found.map(|layer| [layer.entities, layer.hidden, layer.annotations])
    };
    // The line itself, and of the insert on a switched-off layer what has a layer of its own.
    assert_eq!(layer("A-WALL"), Some([2, 1, 1]));
    assert_eq!(layer("FROZEN"), Some([0, 2, 0]));
    assert_eq!(layer("OFF"), Some([0, 2, 0]));
}

#[test]
fn blocks_nest_and_never_without_end() {
    let block = |name: &str, inner: &str| {
        format!("0 BLOCK 8 0 2 {name} 70 0 10 0 20 0 30 0 3 {name} 1 ~ {inner} 0 ENDBLK 8 0 ")
    };
    let outer = block("IN", "0 LINE 8 0 10 0 20 0 11 1000 21 0")
        + &block("OUT", "0 INSERT 8 0 2 IN 10 2000 20 0 50 90 0 INSERT 8 0 2 IN 10 0 20 0");
    let drawing = parsed(&document(&outer, "0 INSERT 8 A-WALL 2 OUT 10 100 20 0 43 1 41 2 42 2"));
    assert_eq!(extent(&drawing, "A-WALL"), [[100, 0], [4100, 2000]]);

    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, blocks: &str, entities: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, document(blocks, entities)).unwrap();
        read(&path, None).unwrap_err().to_string()
    };
    let itself = block("SELF", "0 LINE 8 0 10 0 20 0 11 9 21 0 0 INSERT 8 0 2 SELF 10 1 20 0");
    assert!(refused("self.dxf", &itself, "0 INSERT 8 A-WALL 2 SELF 10 0 20 0").contains("nested"));
    let array = "0 INSERT 8 A-WALL 2 IN 10 0 20 0 70 30000 71 30000 44 10 45 10";
    assert!(refused("array.dxf", &outer, array).contains("points"));
}

#[test]
fn widths_follow_the_scale() {
    let drawing = parsed(&document(
        "0 BLOCK 8 0 2 W 70 0 10 0 20 0 30 0 3 W 1 ~ 0 LWPOLYLINE 8 0 90 2 70 0 43 120 10 0 20 0 10 1000 20 0 0 ENDBLK 8 0",
        "0 INSERT 8 A-WALL 2 W 10 0 20 0 41 2 42 2 43 2",
    ));
    let Paint::Stroke(width) = drawing.shapes[0].paint else { panic!("a line") };
    assert!((width - 0.24).abs() < 1e-12, "{width}");
}

#[test]
fn files_of_another_kind_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("a.dwg", &b"AC1032"[..]),
        ("b.dwg", b"\x89PNG\r\n\x1a\n-------------------------------------------------------------------"),
        ("c.dxf", b"\x00\x01\x02\x03 nothing"),
        ("d.dxf", b""),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        match read(&path, None) {
            Err(error) => assert!(!error.to_string().is_empty(), "{name}"),
            Ok(drawing) => assert!(drawing.shapes.is_empty(), "{name}"),
        }
    }
}
