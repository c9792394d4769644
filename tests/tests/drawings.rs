//! SVG and PDF drawings as plans, from end to end: names, colours, scales.

use compass_tests::{Folder, Ran, numbers};
use serde_json::Value;

/// A room of 8 m x 6 m in units of a centimetre with walls of 0.2 m, a window in the west and a door in the east,
/// and a table. `order` are the elements' attributes: walls, window, door, table.
fn room(walls: &str, window: &str, door: &str, table: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 800" width="1000" height="800">
          <g {walls}><path d="M100 100H900V700H100Z M120 120V680H880V120Z" fill-rule="evenodd"/></g>
          <g {window}><rect x="100" y="300" width="20" height="200"/></g>
          <g {door}><rect x="880" y="400" width="20" height="90"/></g>
          <g {table}><rect x="300" y="350" width="150" height="80"/></g>
        </svg>"#
    )
}

fn cross(folder: &Folder, plan: &str, at: &str) -> [(f64, String); 4] {
    let line = format!("describe {plan} --at={at} --json -");
    let Ran { status, stdout, stderr } = folder.run(&line);
    assert_eq!(status, Some(0), "{line}: {stderr}");
    let found: Value = serde_json::from_str(&stdout).unwrap();
    let range = numbers(&found["range_m"]);
    [0, 90, 180, 270].map(|bin| (range[bin], found["hit"][bin].as_str().unwrap().to_owned()))
}

fn assert_cross(found: &[(f64, String); 4], wanted: [(f64, &str); 4]) {
    for ((range, hit), (wanted_range, wanted_hit)) in found.iter().zip(wanted) {
        assert!((range - wanted_range).abs() < 0.04 && hit == wanted_hit, "{found:?}");
    }
}

/// From (6, 3.5), level with window and door: the map's y goes up from the lower edge of the page.
const SEEN: [(f64, &str); 4] = [(30.0, "open"), (3.3, "wall"), (4.8, "window"), (2.3, "wall")];

#[test]
fn names_say_what_is_what() {
    let folder = Folder::new();
    let drawn = room(
        r#"class="Wall External""#,
        r#"id="window-3""#,
        r#"class="Door Swing""#,
        r#"class="Furniture" fill="black""#,
    );
    folder.write("a.svg", drawn.as_bytes());
    assert_cross(&cross(&folder, "a.svg --unit cm", "6,3.5"), SEEN);
    // Nothing but the resolution: as of a picture, it says how large a unit is.
    assert_cross(&cross(&folder, "a.svg --resolution 0.01", "6,3.5"), SEEN);
    assert_cross(&cross(&folder, "a.svg --scale-points 100,0,900,0,8", "6,3.5"), SEEN);
    let unscaled = folder.run("describe a.svg --at=6,3.5 --json -");
    assert!(unscaled.stderr.contains("nothing tells its scale"), "{}", unscaled.stderr);
}

#[test]
fn without_names_colours_say_it_in_the_order_of_the_drawing() {
    let folder = Folder::new();
    // The door is paper over the wall, the window red over it, the table pale.
    let drawn = room(r##"fill="#333""##, r##"fill="#f00""##, r#"fill="white""#, r##"fill="#ddd""##);
    folder.write("a.svg", drawn.as_bytes());
    assert_cross(&cross(&folder, "a.svg --unit cm", "6,3.5"), SEEN);
    // Another colour for glazing.
    let blue = room(r##"fill="#333""##, r##"fill="#00f""##, r#"fill="white""#, r##"fill="#ddd""##);
    folder.write("b.svg", blue.as_bytes());
    assert_cross(&cross(&folder, "b.svg --unit cm --glazing-color 0000ff", "6,3.5"), SEEN);
    // Patterns of names replace the colours.
    let named = room(r##"id="grau" fill="#ddd""##, r#"id="rot""#, r#"id="t""#, r#"id="tisch""#);
    folder.write("c.svg", named.as_bytes());
    let told = "c.svg --unit cm --layers-wall grau --layers-glazing rot --layers-ignore t,tisch";
    let found = cross(&folder, told, "6,3.5");
    assert_eq!(found[2].1, "window", "{found:?}");
}

/// A page of 300 x 200 points: a room of 200 x 100 points with lines of 2, its west side red.
fn pdf() -> Vec<u8> {
    let content = "2 w 50 50 m 250 50 l 250 150 l 50 150 l S 1 0 0 RG 50 50 m 50 150 l S \
                   BT /F1 12 Tf 100 100 Td (Room) Tj ET";
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 300 200] /Contents 4 0 R /Resources << >> >>".to_owned(),
        format!("<< /Length {} >>\nstream\n{content}\nendstream", content.len()),
    ];
    let mut text = String::from("%PDF-1.4\n");
    let mut offsets = Vec::new();
    for (n, object) in objects.iter().enumerate() {
        offsets.push(text.len());
        text += &format!("{} 0 obj\n{object}\nendobj\n", n + 1);
    }
    let start = text.len();
    text += "xref\n0 5\n0000000000 65535 f \n";
    offsets.iter().for_each(|offset| text += &format!("{offset:010} 00000 n \n"));
    (text + &format!("trailer << /Size 5 /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n")).into_bytes()
}

#[test]
fn a_page_has_the_scale_that_is_told() {
    let folder = Folder::new();
    folder.write("a.pdf", &pdf());
    // A point at 1:100 is 0.0254 / 72 x 100 m.
    let point = 2.54 / 72.0;
    let half_line = point;
    let at = format!("{},{}", 150.0 * point, 100.0 * point);
    let found = cross(&folder, "a.pdf --scale 1:100", &at);
    let wanted = [
        (100.0 * point - half_line, "wall"),
        (50.0 * point - half_line, "wall"),
        (100.0 * point - half_line, "window"),
        (50.0 * point - half_line, "wall"),
    ];
    assert_cross(&found, wanted);
    for (options, says) in [
        ("", "nothing tells its scale"),
        ("--scale 1:100 --page 2", "not page 2"),
        ("--scale 100", "1:100"),
        ("--scale 1:100 --unit cm", "--unit and --scale say the same of PDF"),
        ("--scale 1:100 --scale-points 1,1,9,9,3", "--scale-points and --scale say the same of PDF"),
    ] {
        let ran = folder.run(&format!("plan a.pdf {options}"));
        assert_eq!(ran.status, Some(2), "{options}");
        assert!(ran.stderr.contains(says), "{options}: {}", ran.stderr);
    }
}

#[test]
fn options_of_another_format_are_refused() {
    let folder = Folder::new();
    folder.write("a.pdf", &pdf());
    folder.write("a.svg", room("class='wall'", "", "", "").as_bytes());
    for (plan, option) in [
        ("sample.png", "--unit mm"),
        ("sample.png", "--layers-wall a*"),
        ("sample.png", "--scale 1:50"),
        ("a.svg", "--page 2"),
        ("a.pdf", "--scale 1:50 --walls sample.png"),
        ("sample.png", "--page 2"),
    ] {
        let ran = folder.run(&format!("plan {plan} {option}"));
        assert_eq!(ran.status, Some(2), "{plan} {option}");
        assert!(ran.stderr.contains("does not apply to"), "{}", ran.stderr);
    }
}

#[test]
fn files_of_another_kind_are_named() {
    let folder = Folder::new();
    folder.write("a.svg", b"<svg");
    folder.write("b.svg", b"<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'/>");
    folder.write("c.pdf", b"%PDF-1.4 but no more");
    for name in ["a.svg", "b.svg", "c.pdf --scale 1:100"] {
        let ran = folder.run(&format!("plan {name} --export out"));
        let file = name.split(' ').next().unwrap();
        assert_eq!(ran.status, Some(2), "{name}");
        assert!(ran.stderr.contains(file) && ran.stderr.lines().count() == 1, "{}", ran.stderr);
        assert!(!folder.path("out").exists());
    }
}
