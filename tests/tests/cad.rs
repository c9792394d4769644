//! CAD drawings as plans, from end to end: layers, units, openings, several drawings, what is not recognised.

use compass_tests::{Folder, Ran, number, numbers};
use serde_json::Value;

/// A line on a layer, in the drawing's units.
fn line(layer: &str, [x0, y0, x1, y1]: [f64; 4]) -> String {
    format!("0\nLINE\n8\n{layer}\n10\n{x0}\n20\n{y0}\n11\n{x1}\n21\n{y1}\n")
}

/// The outline of a rectangle as four lines.
fn rectangle(layer: &str, [x0, y0, x1, y1]: [f64; 4]) -> String {
    [[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]]
        .map(|side| line(layer, side))
        .concat()
}

/// A drawing with a unit by its code in `$INSUNITS`.
fn dxf(unit: u8, entities: &str) -> String {
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

/// A house of 8 m x 6 m from (1, 2), in millimetres: outer walls of 0.4 m as two lines with a window of 2 m in the
/// south and a door of 1 m in the north, a partition of 0.1 m with a doorway, a text and a piece of furniture.
fn house(walls: &str, partitions: &str, glazing: &str) -> String {
    let outer = [
        // South wall west and east of the window, north wall west and east of the door, with their caps.
        rectangle(walls, [1000.0, 2000.0, 4000.0, 2400.0]),
        rectangle(walls, [6000.0, 2000.0, 9000.0, 2400.0]),
        rectangle(walls, [1000.0, 7600.0, 3000.0, 8000.0]),
        rectangle(walls, [4000.0, 7600.0, 9000.0, 8000.0]),
        rectangle(walls, [1000.0, 2400.0, 1400.0, 7600.0]),
        rectangle(walls, [8600.0, 2400.0, 9000.0, 7600.0]),
    ];
    let window = [2000.0, 2180.0, 2220.0, 2400.0].map(|y| line(glazing, [4000.0, y, 6000.0, y]));
    let partition = rectangle(partitions, [5000.0, 2400.0, 5100.0, 5000.0])
        + &rectangle(partitions, [5000.0, 6000.0, 5100.0, 7600.0]);
    let door = "0\nARC\n8\nDOORS\n10\n3000\n20\n7600\n40\n1000\n50\n270\n51\n360\n";
    let text = "0\nTEXT\n8\nNOTES\n10\n3000\n20\n5000\n40\n200\n1\nKitchen\n";
    outer.concat()
        + &window.concat()
        + &partition
        + door
        + text
        + &rectangle("FURNITURE", [2000.0, 4000.0, 3500.0, 5000.0])
}

/// The result of a command and its notes.
fn shown(folder: &Folder, line: &str) -> (Value, String) {
    let Ran { status, stdout, stderr } = folder.run(line);
    assert_eq!(status, Some(0), "{line}: {stderr}");
    (serde_json::from_str(&stdout).unwrap(), stderr)
}

fn ranges(folder: &Folder, plan: &str, at: &str) -> (Vec<f64>, Vec<String>) {
    let (result, _) = shown(folder, &format!("describe {plan} --at={at} --json -"));
    let hits = result["hit"].as_array().unwrap().iter().map(|hit| hit.as_str().unwrap().to_owned());
    (numbers(&result["range_m"]), hits.collect())
}

/// Range and hit type towards east, north, west and south from a point.
fn cross(folder: &Folder, plan: &str, at: &str) -> [(f64, String); 4] {
    let (range, hit) = ranges(folder, plan, at);
    [0, 90, 180, 270].map(|bin| (range[bin], hit[bin].clone()))
}

fn assert_cross(found: &[(f64, String); 4], wanted: [(f64, &str); 4]) {
    for ((range, hit), (wanted_range, wanted_hit)) in found.iter().zip(wanted) {
        assert!((range - wanted_range).abs() < 0.04 && hit == wanted_hit, "{found:?}");
    }
}

#[test]
fn a_drawing_keeps_its_coordinates_and_layers_say_what_is_what() {
    let folder = Folder::new();
    folder.write("house.dxf", dxf(4, &house("S-WALL-EXTR", "Trockenbau", "A-GLAZ")).as_bytes());
    // West of the partition, level with its doorway: east through it to the outer wall, north and west walls, furniture
    // is no wall.
    let found = cross(&folder, "house.dxf", "4.5,5.5");
    assert_cross(&found, [(4.1, "wall"), (2.1, "wall"), (3.1, "wall"), (3.1, "window")]);
    // Through the open door.
    let found = cross(&folder, "house.dxf", "3.5,6.5");
    assert_eq!(found[1].1, "open");

    let (shown, notes) = shown(&folder, "plan house.dxf --picture p.png --export out --json -");
    assert_eq!(notes, "");
    assert_eq!(shown["door_count"], 1);
    assert_eq!(shown["structure"], true);
    let role = |name: &str| {
        let layers = shown["layers"].as_array().unwrap();
        layers.iter().find(|layer| layer["name"] == name).unwrap()["role"].clone()
    };
    for (layer, wanted) in [
        ("S-WALL-EXTR", "structure"),
        ("Trockenbau", "partition"),
        ("A-GLAZ", "glazing"),
        ("DOORS", "door"),
        ("NOTES", "ignored"),
        ("FURNITURE", "ignored"),
    ] {
        assert_eq!(role(layer), wanted, "{layer}");
    }
    // 8 m and 6 m with the margin of 1 m around.
    assert!(
        (number(&shown["width_m"]) - 10.0).abs() < 0.05 && (number(&shown["height_m"]) - 8.0).abs() < 0.05
    );
    let area = number(&shown["area_m2"]);
    assert!((30.0..38.0).contains(&area), "7.2 m x 5.2 m less the cells along walls: {area}");
    assert!((number(&shown["glazing_m"]) - 2.0).abs() < 0.4, "{}", shown["glazing_m"]);
    assert!(folder.path("p.png").is_file());

    // The exported map is the same plan.
    assert_cross(
        &cross(&folder, "out/map.yaml", "4.5,5.5"),
        [(4.1, "wall"), (2.1, "wall"), (3.1, "wall"), (3.1, "window")],
    );
}

#[test]
fn layers_give_the_structure_without_a_thickness() {
    let folder = Folder::new();
    folder.write("house.dxf", dxf(4, &house("Rohbau", "Ausbau", "Fenster")).as_bytes());
    let through = cross(&folder, "house.dxf --structure 2", "4.5,4.0");
    assert_cross(&through, [(4.1, "wall"), (3.6, "wall"), (3.1, "wall"), (1.6, "window")]);
    let (built, _) = shown(&folder, "map build house.dxf --spacing 0.5 --out a.site --json -");
    assert_eq!(built["layers"], 2);
    // Layers whose names say no more than wall fall back on their thickness.
    folder.write("plain.dxf", dxf(4, &house("walls", "walls", "windows")).as_bytes());
    let partition = cross(&folder, "plain.dxf", "4.5,4.0");
    assert!((partition[0].0 - 0.5).abs() < 0.04);
    let thick = cross(&folder, "plain.dxf --structure", "4.5,4.0");
    assert!((thick[0].0 - 4.1).abs() < 0.04);
}

#[test]
fn units_and_origin_are_taken_as_told() {
    let folder = Folder::new();
    let drawn = house("WALLS", "WALLS", "GLASS");
    folder.write("mm.dxf", dxf(4, &drawn).as_bytes());
    folder.write("unitless.dxf", dxf(0, &drawn).as_bytes());
    folder.write("inch.dxf", dxf(1, &drawn).as_bytes());
    let wanted = ranges(&folder, "mm.dxf", "4.5,5.5");
    let ran = folder.run("describe unitless.dxf --at=4.5,5.5 --json -");
    assert!(ran.stderr.contains("names no unit") && ran.stderr.contains("1 mm"), "{}", ran.stderr);
    let found: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(numbers(&found["range_m"]), wanted.0);
    let told = folder.run("describe unitless.dxf --unit mm --at=4.5,5.5 --json -");
    assert_eq!(told.stderr, "");
    // Inches say 200 m of house: no error, but with the right unit told it is the same plan.
    assert_eq!(ranges(&folder, "inch.dxf --unit mm", "4.5,5.5"), wanted);
    // The lower left of the extent, (1, 2), comes to lie at the origin, however far off.
    assert_eq!(ranges(&folder, "mm.dxf --origin=-10,20", "-6.5,23.5"), wanted);
    assert_eq!(ranges(&folder, "mm.dxf --origin=431000,5411000", "431003.5,5411003.5"), wanted);
}

#[test]
fn what_nobody_names_is_listed() {
    let folder = Folder::new();
    let drawn = house("WALLS", "Layer7", "GLASS");
    folder.write("some.dxf", dxf(4, &drawn).as_bytes());
    let ran = folder.run("plan some.dxf --json -");
    assert!(
        ran.stderr.contains("left out") && ran.stderr.contains("'Layer7' (8 entities, 0.1 x 5.2 m)"),
        "{}",
        ran.stderr
    );
    let (named, notes) = shown(&folder, "plan some.dxf --layers-wall layer*,walls --json -");
    assert!(notes.is_empty() && named["warnings"].as_array().unwrap().is_empty());
    // Where no name says wall, all that is unknown is taken.
    folder.write("none.dxf", dxf(4, &house("0", "0", "0")).as_bytes());
    let ran = folder.run("plan none.dxf --json -");
    assert!(ran.stderr.contains("taken for walls"), "{}", ran.stderr);
    // Patterns that match nothing are an error that lists the layers.
    let ran = folder.run("plan some.dxf --layers-wall nosuch* --layers-ignore walls");
    assert_eq!(ran.status, Some(2));
    assert!(ran.stderr.contains("no layer shows walls") && ran.stderr.contains("Layer7"), "{}", ran.stderr);
    assert_eq!(folder.run("plan some.dxf --layers-wall=").status, Some(2));
}

#[test]
fn drawings_far_from_each_other_are_said() {
    let folder = Folder::new();
    let second = rectangle("WALLS", [40_000.0, 0.0, 48_000.0, 6000.0]);
    let speck = line("WALLS", [9e8, 9e8, 900_001_000.0, 9e8]);
    let drawn = house("WALLS", "WALLS", "GLASS") + &second + &speck;
    folder.write("two.dxf", dxf(4, &drawn).as_bytes());
    let ran = folder.run("plan two.dxf --json -");
    assert_eq!(ran.status, Some(0), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("2 drawings apart") && ran.stderr.contains("1 small ones left out"),
        "{}",
        ran.stderr
    );
    let found: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!((number(&found["width_m"]) - 49.0).abs() < 0.1, "{}", found["width_m"]);
}

#[test]
fn files_that_are_no_drawings_are_named() {
    let folder = Folder::new();
    folder.write("a.dwg", b"not a drawing");
    folder.write("b.dxf", b"solid cube\nfacet normal 0 0 0\n");
    folder.write("c.dxf", dxf(4, "").as_bytes());
    for (name, says) in
        [("a.dwg", "DWG"), ("b.dxf", "b.dxf"), ("c.dxf", "no layer shows walls"), ("gone.dxf", "gone.dxf")]
    {
        let ran = folder.run(&format!("map build {name} --out x.site"));
        assert_eq!(ran.status, Some(2), "{name}: {}", ran.stderr);
        assert!(ran.stderr.contains(says) && ran.stderr.lines().count() == 1, "{name}: {}", ran.stderr);
        assert!(!folder.path("x.site").exists(), "{name}");
    }
    folder.write("house.dxf", dxf(4, &house("WALLS", "WALLS", "GLASS")).as_bytes());
    let ran = folder.run("plan house.dxf --resolution 0.0001");
    assert_eq!(ran.status, Some(2), "{}", ran.stderr);
}
