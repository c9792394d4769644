//! Files of strangers: whatever they hold, a command ends soon, with a small memory, and says what is wrong in a line.

#![cfg(unix)]

use compass_host::calibration::NOMINAL_YAML;
use compass_tests::bag::{Bag, Layout};
use compass_tests::{Folder, Ran};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Address space that a command gets, KiB: far more than it needs, far less than a bomb takes.
const MEMORY_KIB: u64 = 1_500_000;

/// Time that a command gets; seconds suffice, but tests share the machine.
const LONGEST: Duration = Duration::from_secs(60);

/// Runs `compass` with little memory; it must end soon, and neither by a panic nor by a signal.
fn run(folder: &Folder, line: &str) -> Ran {
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("ulimit -v {MEMORY_KIB}; exec \"$@\"")).arg("sh");
    command.arg(compass_tests::compass()).args(line.split_whitespace()).current_dir(folder.path(""));
    // A thread's stack and arena count as address space.
    command.env("RAYON_NUM_THREADS", "2").env("MALLOC_ARENA_MAX", "2");
    let started = Instant::now();
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let ran = Ran { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) };
    assert!(started.elapsed() < LONGEST, "{line}: {:?}", started.elapsed());
    assert!(matches!(ran.status, Some(0..=2)), "{line}: {:?}\n{}", output.status, ran.stderr);
    ran
}

/// Input that is refused, in one line that says why.
fn refused(folder: &Folder, line: &str, why: &str) {
    let ran = run(folder, line);
    assert_eq!((ran.status, ran.stderr.lines().count()), (Some(2), 1), "{line}: {}", ran.stderr);
    assert!(ran.stderr.contains(why), "{line}: {}", ran.stderr);
}

/// A PNG that claims a size, with a pixel in it.
fn png_of([width, height]: [u32; 2]) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(1, 1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mut png = png.into_inner();
    // After the signature the chunk of the header: length, name, width, height, five more bytes, checksum.
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&checksum);
    png
}

fn rig(folder: &Folder) {
    folder.write("rig.yaml", NOMINAL_YAML.as_bytes());
    folder.write("truth.tum", b"1.0 13 3 1.4 0 0 0 1\n9.0 13 3 1.4 0 0 0 1\n");
}

const EVALUATE: &str =
    "evaluate --map sample.site --calib rig.yaml --groundtruth truth.tum --out out --dataset";

#[test]
fn the_size_of_an_image_is_known_before_it_is_decoded() {
    let folder = Folder::new();
    folder.write("bomb.png", &png_of([60_000, 60_000]));
    let plan =
        "bomb.png: 60000 x 60000 pixels are more than the limit of 400000000; --raise-limits 9 raises it";
    let frame =
        "bomb.png: 60000 x 60000 pixels are more than the limit of 134217728; --raise-limits 27 raises it";
    refused(&folder, "map build bomb.png --out x.site", plan);
    refused(&folder, "plan bomb.png", plan);
    refused(&folder, "map build sample.png --walls bomb.png --out x.site", plan);
    refused(&folder, "segments bomb.png --csv x.csv", frame);
    folder.write(
        "map.yaml",
        b"image: bomb.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n",
    );
    refused(&folder, "map build map.yaml --out x.site", plan);
    // A limit that is raised is another limit; the file then turns out to be cut off.
    folder.write("less.png", &png_of([25_000, 20_000]));
    refused(&folder, "segments less.png --csv x.csv", "--raise-limits 4 raises it");
    refused(&folder, "--raise-limits 2 segments less.png --csv x.csv", "the limit of 268435456");
}

#[test]
fn what_is_packed_unpacks_to_no_more_than_its_limit() {
    let folder = Folder::new();
    rig(&folder);
    let mut bag = Bag::new();
    let camera = bag.topic("/cam0/image_raw", "sensor_msgs/msg/Image");
    let other = bag.topic("/cam1/image_raw", "sensor_msgs/msg/Image");
    let stamp = 1_000_000_000;
    // Of the shape that the calibration has.
    for topic in [camera, other] {
        bag.push_image(topic, stamp, (92, 90), "mono8", 92, &[9; 92 * 90]);
    }
    // An image of the size that it says, of 300 MB.
    bag.push_image(camera, 2 * stamp, (17_000, 17_000), "mono8", 17_000, &vec![0; 17_000 * 17_000]);
    for (layout, why) in [
        (Layout::SqlitePackedMessages, "it unpacks to more than the limit of 128 MiB"),
        (Layout::SqlitePackedFiles, "more than the limit of 134217728"),
        (Layout::McapZstd, "left out"),
    ] {
        let name = format!("{layout:?}");
        bag.write(&folder.path(&name), layout);
        let ran = run(&folder, &format!("{EVALUATE} {name} --max-left-out 1"));
        assert!(
            format!("{}{}", ran.stdout, ran.stderr).contains(why),
            "{name}: {}{}",
            ran.stdout,
            ran.stderr
        );
        let _ = std::fs::remove_dir_all(folder.path("out"));
    }
}

#[test]
fn a_packed_file_unpacks_to_no_more_than_its_limit() {
    let folder = Folder::new();
    rig(&folder);
    let zeros = std::io::Read::take(std::io::repeat(0), 400 << 20);
    folder.write("bomb.db3.zstd", &zstd::encode_all(zeros, 1).unwrap());
    std::fs::create_dir(folder.path("tmp")).unwrap();
    refused(&folder, &format!("{EVALUATE} bomb.db3.zstd"), "it unpacks to more than the limit of ");
}

#[test]
fn a_database_whose_messages_are_a_query_is_no_bag() {
    let folder = Folder::new();
    rig(&folder);
    let database = rusqlite::Connection::open(folder.path("view.db3")).unwrap();
    let schema = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, qos TEXT);
         INSERT INTO topics VALUES (1, '/cam0', 'sensor_msgs/msg/Image', 'cdr', '');
         CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n)
         SELECT id, 1 AS topic_id, id AS timestamp, x'00010000' AS data FROM n;";
    database.execute_batch(schema).unwrap();
    drop(database);
    refused(&folder, &format!("{EVALUATE} view.db3"), "it lacks a table topics or messages");
}

#[test]
fn a_record_may_claim_any_length() {
    let folder = Folder::new();
    rig(&folder);
    for length in [u64::MAX, u64::MAX - 8, 1 << 63, 1 << 40, 1 << 28] {
        let record = [&[0x06_u8][..], &length.to_le_bytes(), &[0; 64]].concat();
        folder.write("long.mcap", &[b"\x89MCAP0\r\n", &record[..]].concat());
        refused(&folder, &format!("{EVALUATE} long.mcap"), "long.mcap: ");
    }
    // An attachment too short for its checksum was a panic of the reader.
    for opcode in 1..=15_u8 {
        let record = [&[opcode][..], &37_u64.to_le_bytes(), &[0; 37]].concat();
        folder.write("short.mcap", &[b"\x89MCAP0\r\n", &record[..], &record].concat());
        refused(&folder, &format!("{EVALUATE} short.mcap"), "short.mcap: ");
    }
}

#[test]
fn devices_and_pipes_are_no_input() {
    let folder = Folder::new();
    rig(&folder);
    let pipe = folder.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for what in ["/dev/zero", "pipe"] {
        for line in [
            format!("map build {what} --out x.site"),
            format!("map info {what}"),
            format!("localize --map {what} --calib rig.yaml --cam0 sample.png --mount upright"),
            format!("localize --map sample.site --calib {what} --cam0 sample.png --mount upright"),
            format!("localize --map sample.site --calib rig.yaml --cam0 {what} --mount upright"),
            format!("localize --map sample.site --shot {what}"),
            format!("evaluate --map sample.site --calib rig.yaml --groundtruth {what} --dataset . --out out"),
            format!("simulate sample.png --poses {what} --out out"),
            format!("segments {what} --csv x.csv"),
        ] {
            let ran = run(&folder, &line);
            assert_eq!((ran.status, ran.stderr.lines().count()), (Some(2), 1), "{line}: {}", ran.stderr);
        }
    }
    for end in ["svg", "pdf", "dxf", "dwg"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path(&format!("plan.{end}"))).unwrap();
        refused(&folder, &format!("plan plan.{end} --unit m"), "it is a device or a named pipe, not a file");
    }
    // What a shell opens for a command is read like a file.
    let script = format!("'{}' map info <(cat sample.site)", compass_tests::compass().display());
    let ran = Command::new("bash").args(["-c", &script]).current_dir(folder.path("")).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
}

/// `/dev/stdout` is what a shell makes of it, a pipe or a file, and stays.
#[test]
fn descriptors_of_the_process_are_output() {
    let folder = Folder::new();
    let compass = compass_tests::compass().display();
    for (end, kept) in [("| cat", ""), ("> said; cat said", ""), (">> kept; cat kept", "before\n")] {
        folder.write("kept", b"before\n");
        let script =
            format!("'{compass}' describe --plan sample.png --at 13.37,3.68 --json /dev/stdout {end}");
        let ran = Command::new("sh").args(["-c", &script]).current_dir(folder.path("")).output().unwrap();
        let said = String::from_utf8(ran.stdout).unwrap();
        let json = said.strip_prefix(kept).unwrap_or_else(|| panic!("{end}: {said}"));
        assert!(json.starts_with('{') && json.contains("\n}\n"), "{end}: {json}");
    }
}

/// Every command with every fault in every place: an exit status of the documented ones, and soon.
#[test]
fn no_fault_ends_in_a_panic() {
    let folder = Folder::new();
    rig(&folder);
    let png = std::fs::read(folder.path("sample.png")).unwrap();
    let site = std::fs::read(folder.path("sample.site")).unwrap();
    let noise: Vec<u8> = (0..5000_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let deep = "{a: ".repeat(5000);
    let aliases = (1..30).fold("a0: &a0 [x, x]\n".to_owned(), |text, n| {
        let before = n - 1;
        text + &format!("a{n}: &a{n} [*a{before}, *a{before}]\n")
    });
    let faults: [(&str, &[u8]); 9] = [
        ("empty", b""),
        ("noise", &noise),
        ("zeros", &[0; 4096]),
        ("cut_png", &png[..png.len() / 2]),
        ("cut_site", &site[..site.len() / 2]),
        ("deep", deep.as_bytes()),
        ("aliases", aliases.as_bytes()),
        ("numbers", b"1e999,nan,-inf,99999999999999999999999\n"),
        ("escape", b"cam0:\n  camera_model: \"\\e[31m\\u202e\"\n"),
    ];
    for (name, bytes) in faults {
        for end in ["png", "yaml", "csv", "site", "svg", "pdf", "dxf", "dwg", "db3", "mcap"] {
            folder.write(&format!("{name}.{end}"), bytes);
        }
        for line in [
            format!("map build {name}.png --out x.site"),
            format!("plan {name}.yaml"),
            format!("plan {name}.svg --scale 1:100"),
            format!("plan {name}.pdf --scale 1:100"),
            format!("plan {name}.dxf"),
            format!("plan {name}.dwg"),
            format!("map info {name}.site"),
            format!("map join {name}.site sample.site --out x.site"),
            format!("localize --map sample.site --calib {name}.yaml --cam0 sample.png --mount upright"),
            format!("localize --map sample.site --calib rig.yaml --cam0 {name}.png --mount upright"),
            format!("localize --map sample.site --shot {name}.site"),
            format!("simulate sample.png --poses {name}.csv --out out"),
            format!("segments {name}.png --csv x.csv"),
            format!("windows {name}.png --calib rig.yaml"),
            format!("gravity --calib rig.yaml --cam0 {name}.png"),
            format!("{EVALUATE} {name}.db3"),
            format!("{EVALUATE} {name}.mcap"),
        ] {
            let ran = run(&folder, &line);
            assert!(ran.status != Some(0), "{line}: {}", ran.stdout);
            assert!(!ran.stderr.contains(['\u{1b}', '\u{202e}']), "{line}: {:?}", ran.stderr);
        }
    }
    assert!(!Path::new(&folder.path("out")).exists() && !folder.path("x.site").exists());
}
