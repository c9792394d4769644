//! Bad input, from end to end: exit status 2, one line on standard error that names the fault, and no files left
//! behind.

use compass_core::map::site::Site;
use compass_core::map::site_map::SiteMap;
use compass_host::calibration::NOMINAL_YAML;
use compass_host::site_file::SiteFile;
use compass_tests::{Folder, POSE, Ran, sample_map, sample_site};
use image::{GrayImage, Luma};

const LOCALIZE: &str = "localize --from-plan sample.png --at 13.37,3.68 --heading 74 --map";

/// Runs `line`, which must be rejected with a reason that contains all of `named`, and must leave the folder
/// unchanged.
fn refused(folder: &Folder, line: &str, named: &[&str]) {
    let (ran, left) = run(folder, line);
    assert!(left.is_empty(), "{line}: left {left:?}");
    assert_refused(&ran, line, named);
}

fn assert_refused(ran: &Ran, line: &str, named: &[&str]) {
    let Ran { status, stdout, stderr } = ran;
    assert_eq!(*status, Some(2), "{line}: {stdout}{stderr}");
    assert_eq!(stdout, "", "{line}");
    assert!(stderr.starts_with("compass: ") && stderr.ends_with('\n'), "{line}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{line}: {stderr}");
    for name in named {
        assert!(stderr.contains(name), "{line}: no '{name}' in {stderr}");
    }
}

/// Runs `line`, which the command line parser must reject; its message may have several lines.
fn misused(folder: &Folder, line: &str, named: &str) {
    let (Ran { status, stdout, stderr }, left) = run(folder, line);
    assert_eq!((status, stdout.as_str()), (Some(2), ""), "{line}: {stderr}");
    assert!(stderr.contains(named), "{line}: no '{named}' in {stderr}");
    assert!(left.is_empty(), "{line}: left {left:?}");
}

fn run(folder: &Folder, line: &str) -> (Ran, Vec<String>) {
    let before = folder.names();
    let ran = folder.run(line);
    assert!(!ran.stderr.contains("panicked"), "{line}: {}", ran.stderr);
    let left = folder.names().symmetric_difference(&before).map(|p| p.display().to_string()).collect();
    (ran, left)
}

/// A raster of 8 m x 6 m, dark where `dark` says (in pixels from the top left).
fn draw(folder: &Folder, name: &str, dark: impl Fn(u32, u32) -> bool) {
    let pixel = |x, y| Luma([if dark(x, y) { 0 } else { 255 }]);
    GrayImage::from_fn(800, 600, pixel).save(folder.path(name)).unwrap();
}

#[test]
fn what_is_no_image() {
    let folder = Folder::new();
    let png = folder.read("sample.png");
    folder.write("text.png", b"dark walls, red glazing\n");
    folder.write("empty.png", b"");
    folder.write("half.png", &png[..png.len() / 2]);
    folder.write("header.png", &png[..30]);
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    for file in
        ["text.png", "empty.png", "half.png", "header.png", "folder.png", "missing.png", "no/such.png"]
    {
        refused(&folder, &format!("describe {file} {POSE}"), &[file]);
        refused(&folder, &format!("map build {file} --out new.map"), &[file]);
        refused(&folder, &format!("compare {file}"), &[file]);
        let localize = "localize --map sample.map --at 13.37,3.68 --heading 74 --from-plan";
        refused(&folder, &format!("{localize} {file}"), &[file]);
        refused(&folder, &format!("describe sample.png --walls {file} {POSE}"), &[file]);
    }
}

#[test]
fn what_is_no_map_description() {
    let folder = Folder::new();
    let good = "image: sample.png\nresolution: 0.01\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n";
    folder.write("map.yaml", good.as_bytes());
    let ran = folder.run(&format!("describe map.yaml {POSE}"));
    assert_eq!(ran.status, Some(0), "the one that the others are made from: {}", ran.stderr);
    for (from, to, named) in [
        ("image: sample.png\n", "", "image"),
        ("sample.png", "missing.png", "missing.png"),
        ("resolution: 0.01", "resolution: 0", "resolution"),
        ("resolution: 0.01", "resolution: -0.01", "resolution"),
        ("resolution: 0.01", "resolution: .nan", "resolution"),
        ("resolution: 0.01", "resolution: fine", "bad.yaml"),
        ("[0, 0, 0]", "[0]", "bad.yaml"),
        ("[0, 0, 0]", "[0, .inf, 0]", "origin"),
        ("image:", "image", "bad.yaml"),
    ] {
        assert!(good.contains(from));
        folder.write("bad.yaml", good.replace(from, to).as_bytes());
        refused(&folder, &format!("describe bad.yaml {POSE}"), &[named]);
    }
    folder.write("bad.yaml", &[0xff, 0xfe, 0, 1]);
    refused(&folder, &format!("describe bad.yaml {POSE}"), &["bad.yaml"]);
}

#[test]
fn images_without_a_plan_in_them() {
    let folder = Folder::new();
    draw(&folder, "white.png", |_, _| false);
    draw(&folder, "black.png", |_, _| true);
    let pale = GrayImage::from_fn(800, 600, |x, _| Luma([if x < 400 { 255 } else { 200 }]));
    pale.save(folder.path("pale.png")).unwrap();
    draw(&folder, "line.png", |x, y| y == 300 && (100..700).contains(&x));
    for file in ["white.png", "black.png"] {
        refused(&folder, &format!("describe {file} --at 1,1"), &[file, "every pixel"]);
        refused(&folder, &format!("map build {file} --out new.map"), &[file, "every pixel"]);
    }
    refused(&folder, "describe pale.png --at 1,1", &["pale.png", "no walls"]);
    refused(&folder, "map build pale.png --out new.map", &["pale.png", "no walls"]);
    // A single wall is valid input, but encloses nothing.
    assert_eq!(folder.run("describe line.png --at 1,1").status, Some(0));
    refused(&folder, "map build line.png --out new.map", &["line.png"]);
    refused(&folder, "compare line.png", &["line.png"]);
}

#[test]
fn walls_of_another_size() {
    let folder = Folder::new();
    draw(&folder, "small.png", |x, _| x < 9);
    let named = ["small.png", "sample.png", "800 x 600", "3200 x 2200"];
    refused(&folder, &format!("describe sample.png --walls small.png {POSE}"), &named);
    refused(&folder, "map build sample.png --walls small.png --out new.map", &named);
}

#[test]
fn numbers_out_of_range() {
    let folder = Folder::new();
    for value in ["0", "-0.01", "nan", "inf", "-inf", "1e-9", "1e9"] {
        let named = ["sample.png", "resolution"];
        refused(&folder, &format!("describe sample.png {POSE} --resolution {value}"), &named);
        refused(&folder, &format!("map build sample.png --out new.map --resolution {value}"), &named);
    }
    misused(&folder, &format!("describe sample.png {POSE} --resolution fine"), "resolution");
    for value in ["0", "-1", "0.001", "1e300"] {
        refused(&folder, &format!("map build sample.png --out new.map --spacing {value}"), &["spacing"]);
    }
    refused(&folder, "map build sample.png --out new.map --clearance -1", &["clearance"]);
    refused(&folder, "map build sample.png --out new.map --clearance 50", &["clearance"]);
    for value in ["0", "-1", "1e9"] {
        refused(&folder, &format!("map build sample.png --out new.map --max-gap {value}"), &["gap"]);
    }
    for value in ["0", "-1", "6"] {
        let named = ["sample.png", "structure thicker than"];
        refused(&folder, &format!("map build sample.png --out new.map --thickness {value}"), &named);
    }
    for option in ["spacing", "clearance", "max-gap", "thickness"] {
        for value in ["nan", "inf", "wide"] {
            misused(&folder, &format!("map build sample.png --out new.map --{option} {value}"), option);
        }
    }
    refused(&folder, "describe sample.png --at 1,1 --origin 1e300,0", &["origin"]);
}

#[test]
fn positions_where_nobody_can_stand() {
    let folder = Folder::new();
    for at in ["-5,3", "100,3", "5,-0.001", "5,22.001", "1e300,0", "3000000000,0"] {
        for engine in ["fixed", "float"] {
            refused(
                &folder,
                &format!("describe sample.png --at {at} --engine {engine}"),
                &["position", "outside"],
            );
        }
        refused(
            &folder,
            &format!("localize --map sample.map --from-plan sample.png --heading 0 --at {at}"),
            &["position", "outside"],
        );
    }
    // In the facade: the building begins 1 m inside the image.
    for engine in ["fixed", "float"] {
        let line = format!("describe sample.png --at 1.2,1.2 --engine {engine} --figures pictures");
        refused(&folder, &line, &["sample.png", "1.2,1.2", "inside a wall"]);
    }
}

#[test]
fn words_that_are_no_options() {
    let folder = Folder::new();
    for at in ["5", "5,", ",5", "a,b", "nan,1", "1,inf", "1,2,3"] {
        misused(&folder, &format!("describe sample.png --at {at}"), "--at");
    }
    for heading in ["nan", "inf", "north"] {
        misused(&folder, &format!("describe sample.png --at 13.37,3.68 --heading {heading}"), "--heading");
    }
    for (line, named) in [
        ("", "Usage"),
        ("find", "find"),
        ("describe sample.png", "--at"),
        ("describe sample.png --plan sample.png --at 1,1", "--plan"),
        ("describe sample.png --at 1,1 --engine steam", "steam"),
        ("describe sample.png --at 1,1 --depth 3", "--depth"),
        ("map", "build"),
        ("map build sample.png", "--out"),
        ("map build sample.png --out new.map --layers 3", "--layers"),
        ("map build sample.png --out new.map --name=", "--name"),
        ("map build sample.png --out new.map --name a_name_of_above_23_bytes", "--name"),
        ("map info", "FILE"),
        ("map join --out new.map", "FILE"),
        ("map join sample.site", "--out"),
        ("compare --poses 0", "--poses"),
        ("localize --map sample.map --at 1,1 --heading 0", "--from-plan"),
    ] {
        misused(&folder, line, named);
    }
    for (option, values) in [
        ("noise", ["-1", "nan", "1e9"]),
        ("seed", ["-1", "x", "1.5"]),
        ("weights", ["1,2,3", "0,0,0,0,0", "1,2,3,4,256"]),
        ("similarity", ["cosine", "-", "1"]),
        ("prefilter", ["-1", "some", "0.5"]),
    ] {
        for value in values {
            misused(&folder, &format!("{LOCALIZE} sample.map --{option}={value}"), option);
        }
    }
    refused(&folder, &format!("describe {POSE}"), &["no plan"]);
    refused(&folder, "map build --out new.map", &["no plan"]);
}

/// CRC-32 as in zip and PNG.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    })
}

/// Changes the header of a map and updates both checksums.
fn with_header(change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let mut bytes = sample_map().to_vec();
    change(&mut bytes[..52]);
    let header = crc32(&bytes[..52]);
    bytes[52..56].copy_from_slice(&header.to_le_bytes());
    let end = bytes.len() - 4;
    let whole = crc32(&bytes[..end]);
    bytes[end..].copy_from_slice(&whole.to_le_bytes());
    bytes
}

#[test]
fn maps_of_another_kind_or_version() {
    let folder = Folder::new();
    assert!(with_header(|_| ()) == sample_map(), "checksums are those of the format");
    folder.write("next.map", &with_header(|h| h[8] = 2));
    refused(&folder, "map info next.map", &["next.map", "version is 2"]);
    refused(&folder, &format!("{LOCALIZE} next.map"), &["next.map", "version is 2"]);
    for (name, bytes, field) in [
        ("magic", with_header(|h| h[0] = b'X'), "magic"),
        ("layers", with_header(|h| h[10] = 3), "layer"),
        ("none", with_header(|h| h[12..16].fill(0)), "candidate"),
        ("many", with_header(|h| h[12..16].fill(0xff)), "length"),
        ("fewer", with_header(|h| h[12] ^= 1), "length"),
        ("resolution", with_header(|h| h[16..20].fill(0)), "resolution"),
        ("image", folder.read("sample.png"), "not a site map"),
        ("empty", Vec::new(), "length"),
    ] {
        folder.write(name, &bytes);
        refused(&folder, &format!("map info {name}"), &[&format!("{name}: "), field]);
    }
    for file in ["missing.map", "."] {
        refused(&folder, &format!("map info {file}"), &[file]);
        refused(&folder, &format!("{LOCALIZE} {file}"), &[file]);
    }
}

#[test]
fn maps_cut_short_or_with_more_behind() {
    let folder = Folder::new();
    let map = sample_map();
    let lengths = (0..80).chain((80..map.len()).step_by(4_999)).chain(map.len() - 5..map.len());
    for (number, length) in lengths.enumerate() {
        folder.write("cut.map", &map[..length]);
        let error = SiteFile::read(&folder.path("cut.map")).unwrap_err().to_string();
        assert!(error.contains("cut.map: ") && !error.contains('\n'), "{length}: {error}");
        if number % 40 == 0 {
            refused(&folder, "map info cut.map", &["cut.map", "length"]);
            refused(&folder, &format!("{LOCALIZE} cut.map"), &["cut.map", "length"]);
        }
    }
    folder.write("long.map", &[map, &[0]].concat());
    refused(&folder, "map info long.map", &["long.map", "length"]);
}

#[test]
fn maps_with_one_byte_flipped() {
    let folder = Folder::new();
    let mut map = sample_map().to_vec();
    let end = map.len();
    let places = (0..64).chain((64..end).step_by(end / 150)).chain(end - 4..end);
    for (number, at) in places.enumerate() {
        for flip in [0xff, 1 << (number % 8)] {
            map[at] ^= flip;
            // Data used in place must be rejected as well as data read from a file.
            assert!(SiteMap::new(&map).and_then(|m| m.verify()).is_err(), "byte {at} ^ {flip:#x}");
            if flip == 0xff {
                folder.write("flipped.map", &map);
                let error = SiteFile::read(&folder.path("flipped.map")).unwrap_err().to_string();
                assert!(error.contains("flipped.map: ") && !error.contains('\n'), "{at}: {error}");
            }
            if flip == 0xff && number % 45 == 0 {
                refused(&folder, "map info flipped.map", &["flipped.map"]);
                refused(&folder, &format!("{LOCALIZE} flipped.map"), &["flipped.map"]);
            }
            map[at] ^= flip;
        }
    }
    assert!(map == sample_map());
}

/// The message of every command that reads a site for a damaged one.
fn refused_by_all(folder: &Folder, file: &str, field: &str) {
    refused(folder, &format!("map info {file}"), &[&format!("{file}: "), field]);
    refused(folder, &format!("{LOCALIZE} {file}"), &[&format!("{file}: "), field]);
    refused(folder, &format!("map join sample.site {file} --out new.site"), &[&format!("{file}: "), field]);
}

#[test]
fn sites_damaged_or_cut_short() {
    let folder = Folder::new();
    let site = sample_site();
    let lengths = (0..120).chain((120..site.len()).step_by(19_999)).chain(site.len() - 5..site.len());
    for (number, length) in lengths.enumerate() {
        folder.write("cut.site", &site[..length]);
        let error = SiteFile::read(&folder.path("cut.site")).unwrap_err().to_string();
        assert!(error.contains("cut.site: ") && !error.contains('\n'), "{length}: {error}");
        if number % 60 == 0 {
            refused_by_all(&folder, "cut.site", "length");
        }
    }
    folder.write("long.site", &[site, &[0]].concat());
    refused_by_all(&folder, "long.site", "length");

    let flipped = |at: usize| [&site[..at], &[!site[at]], &site[at + 1..]].concat();
    for at in (0..120).chain((120..site.len()).step_by(site.len() / 80)) {
        folder.write("flipped.site", &flipped(at));
        let error = SiteFile::read(&folder.path("flipped.site")).unwrap_err().to_string();
        assert!(error.contains("flipped.site: ") && !error.contains('\n'), "{at}: {error}");
    }
    let plan = Site::new(site).unwrap().floor(0).unwrap().plan(1).unwrap().as_bytes();
    let plan_at = plan.as_ptr().addr() - site.as_ptr().addr();
    for (at, field) in [
        (0, "not a site map"),
        (8, "site version"),
        (10, "floor count"),
        (20, "header checksum"),
        (1000, "site map checksum"),
        (plan_at + 10_000, "layer 1: plan checksum"),
        (site.len() - 1, "site checksum"),
    ] {
        folder.write("flipped.site", &flipped(at));
        refused_by_all(&folder, "flipped.site", field);
    }
}

#[test]
fn sites_that_cannot_be_joined() {
    let folder = Folder::new();
    folder.write("other.site", sample_site());
    let named = ["sample.site and other.site", "'sample'"];
    refused(&folder, "map join sample.site other.site --out new.site", &named);
    refused(&folder, "map join sample.site sample.map --out new.site", &["sample.map: ", "no plan"]);
    refused(&folder, "map join sample.site missing.site --out new.site", &["missing.site"]);
    refused(&folder, "map join sample.site sample.png --out new.site", &["sample.png: ", "not a site map"]);
    // The existing file is unchanged.
    refused(&folder, "map join sample.site other.site --out other.site", &named);
    assert!(folder.read("other.site") == sample_site());
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = Folder::new();
    folder.write("file", b"kept");
    std::fs::create_dir(folder.path("folder")).unwrap();
    // Below a file, in a missing folder, over a folder.
    for target in ["file/result", "no/result", "folder"] {
        for command in [
            format!("describe sample.png {POSE}"),
            "map info sample.map".into(),
            format!("{LOCALIZE} sample.map"),
            "compare --poses 2".into(),
        ] {
            refused(&folder, &format!("{command} --json {target}"), &[target]);
        }
        refused(&folder, &format!("map build sample.png --spacing 2 --out {target}"), &[target]);
        refused(&folder, &format!("map join sample.site --out {target}"), &[target]);
    }
    for target in ["file", "file/pictures"] {
        refused(&folder, &format!("describe sample.png {POSE} --figures {target}"), &[target]);
        refused(&folder, &format!("demo --out {target}"), &[target]);
    }
    assert_eq!(folder.read("file"), b"kept");

    // An existing map is unchanged when a new one cannot be made.
    draw(&folder, "line.png", |x, y| y == 300 && (100..700).contains(&x));
    refused(&folder, "map build line.png --out sample.map", &["line.png"]);
    assert!(folder.read("sample.map") == sample_map());
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::new();
    let mut command = std::process::Command::new(compass_tests::compass());
    command.args(["describe", "sample.png", "--at", "13.37,3.68", "--json", "-"]);
    command.current_dir(folder.path("")).stdout(std::process::Stdio::piped());
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

#[test]
fn frames_that_cannot_be_packed() {
    let folder = Folder::new();
    draw(&folder, "frame.png", |x, _| x < 9);
    folder.write("rig.yaml", NOMINAL_YAML.as_bytes());
    let pack = "pack --calib rig.yaml --cam0 frame.png --out new.shot";
    refused(&folder, pack, &["--mount", "up"]);
    refused(&folder, &format!("{pack} --mount upright"), &["rig.yaml", "cam0", "800 x 600", "736 x 720"]);
    GrayImage::from_pixel(184, 180, Luma([90])).save(folder.path("frame.png")).unwrap();
    refused(&folder, &format!("{pack} --mount upright"), &["frame.png", "184 x 180", "368 x 360"]);
    refused(&folder, &format!("{pack} --mount upright --size 90x92"), &["rig.yaml", "90 x 92", "swapped"]);
    refused(&folder, &format!("{pack} --mount upright --size 92x90 --cam1 no.png"), &["no.png"]);
    misused(&folder, &format!("{pack} --mount upright --size 92"), "--size");
    misused(&folder, &format!("{pack} --mount upright --camera-height 0.2"), "--camera-height");
    assert_eq!(folder.run(&format!("{pack} --mount upright --size 92x90")).status, Some(0), "the good one");
}
