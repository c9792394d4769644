//! ROS 2 bags as recordings: every storage, and malformed bags.

use compass_host::calibration::{Calibration, NOMINAL_YAML};
use compass_host::dataset::recording::{Recording, Topics};
use compass_host::dataset::tum::{self, Pose};
use compass_host::progress::{Progress, Steps};
use compass_tests::bag::{Bag, Layout};
use compass_tests::{Folder, compass, number};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const IMAGE: &str = "sensor_msgs/msg/Image";
const COMPRESSED: &str = "sensor_msgs/msg/CompressedImage";
const IMU: &str = "sensor_msgs/msg/Imu";
/// Size of the small images.
const SIZE: (u32, u32) = (40, 30);

/// The pixels of a small image, different for every image.
fn colours(camera: u8, frame: u8) -> Vec<u8> {
    (0..SIZE.0 * SIZE.1 * 3).map(|n| (n % 251) as u8 ^ (16 * frame + camera)).collect()
}

fn stamp(camera: u8, frame: u8) -> u64 {
    3_000_000_000 + 100_000_000 * u64::from(frame) + 1_000_000 * u64::from(camera)
}

/// Five pairs of small images and an IMU lying on its side, beside an unrelated topic.
fn small() -> Bag {
    let mut bag = Bag::new();
    let other = bag.topic("/tf", "tf2_msgs/msg/TFMessage");
    let cameras = [bag.topic("/cam0/image", IMAGE), bag.topic("/cam1/image", IMAGE)];
    let imu = bag.topic("/imu", IMU);
    for frame in 0..5 {
        for camera in [0, 1] {
            let data = colours(camera, frame);
            bag.push_image(
                cameras[usize::from(camera)],
                stamp(camera, frame),
                SIZE,
                "rgb8",
                3 * SIZE.0,
                &data,
            );
        }
        bag.push_imu(imu, stamp(0, frame), [9.8, 0.0, 0.1]);
        bag.push_raw(other, stamp(0, frame), vec![7; 5]);
    }
    bag
}

fn read(folder: &Path) -> Result<Recording, String> {
    let read = Recording::read(folder, None, &Calibration::nominal());
    read.map_err(|error| error.to_string())
}

#[test]
fn all_ways_of_storing_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    let bag = small();
    for (layout, has_metadata) in Layout::ALL.into_iter().flat_map(|layout| [(layout, true), (layout, false)])
    {
        let path = folder.path().join(format!("{layout:?} {has_metadata}"));
        bag.write(&path, layout);
        if !has_metadata {
            std::fs::remove_file(path.join("metadata.yaml")).unwrap();
        }
        let recording = read(&path).unwrap_or_else(|e| panic!("{layout:?}: {e}"));
        let topics = recording.topics.as_ref().unwrap().to_string();
        assert_eq!(topics, "cam0 /cam0/image, cam1 /cam1/image, IMU /imu");
        assert_eq!(recording.shots.len(), 5, "{layout:?}");
        let gravity = recording.imu.as_ref().unwrap().gravity(None).unwrap();
        assert_eq!((gravity.samples, gravity.up.x > 0.99), (5, true), "{layout:?}");
        // Out of order, as with several threads.
        for (frame, shot) in (0..5_u8).zip(&recording.shots).rev() {
            assert_eq!(shot.timestamp_ns, stamp(0, frame), "the header's time, not the recorder's");
            for (camera, image) in (0..2_u8).zip(&shot.images) {
                let image = image.as_ref().unwrap();
                let frame_read = image.read().unwrap();
                assert_eq!((frame_read.width(), frame_read.height()), SIZE);
                assert_eq!(frame_read.rgb().unwrap(), colours(camera, frame), "{layout:?}");
            }
        }
        let all: Vec<_> = recording.shots.iter().flat_map(|shot| shot.images.iter().flatten()).collect();
        let contents: std::collections::BTreeSet<_> =
            all.iter().map(|image| image.contents().unwrap()).collect();
        assert_eq!(contents.len(), 10, "{layout:?}");
    }
}

#[test]
fn topics_are_those_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    small().write(folder.path(), Layout::McapZstd);
    let asked = |topics: &str| {
        let topics: Topics = topics.parse().unwrap();
        let recording = Recording::read(folder.path(), Some(&topics), &Calibration::nominal());
        recording.map_err(|error| error.to_string())
    };
    let swapped = asked("/cam1/image,/cam0/image").unwrap();
    assert!(swapped.imu.is_none(), "it is not asked for");
    let first = swapped.shots[0].images[0].as_ref().unwrap().read().unwrap();
    assert_eq!(first.rgb().unwrap(), colours(1, 0));
    assert!(asked(",/cam0/image").unwrap().shots[0].images[0].is_none());
    assert!(asked("/tf").unwrap_err().contains("/tf: is of type tf2_msgs/msg/TFMessage"));
    assert!(asked("/middle").unwrap_err().contains("no topic /middle; there are /tf (tf2_msgs"));
}

/// A bag is written in each storage, modified by `spoil`, and rejected with all of `named`.
fn refused(bag: &Bag, layouts: &[Layout], spoil: impl Fn(&Path), named: &[&str]) {
    for layout in layouts {
        let folder = tempfile::tempdir().unwrap();
        bag.write(folder.path(), *layout);
        spoil(folder.path());
        let found = read(folder.path()).and_then(|recording| {
            let images = recording.shots.iter().flat_map(|shot| shot.images.iter().flatten());
            images.map(|image| image.read().map_err(|error| error.to_string())).collect::<Result<Vec<_>, _>>()
        });
        let message = found.err().unwrap_or_else(|| panic!("{layout:?}: {named:?} is accepted"));
        let start = folder.path().display().to_string();
        assert!(message.starts_with(&start) && !message.contains('\n'), "{layout:?}: {message}");
        for name in named {
            assert!(message.contains(name), "{layout:?}: no '{name}' in {message}");
        }
    }
}

/// The storage files in a folder, in order.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let files = std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    let mut files: Vec<_> = files.filter(|path| path.to_string_lossy().contains("bag_")).collect();
    files.sort();
    files
}

#[test]
fn files_that_hold_nothing_are_named() {
    let bag = small();
    let foreign = |folder: &Path| {
        for file in files(folder) {
            std::fs::write(file, b"no bag at all ".repeat(90)).unwrap();
        }
    };
    refused(&bag, &Layout::ALL, foreign, &["bag_0.", "neither an MCAP nor an SQLite file"]);
    let gone = |folder: &Path| files(folder).iter().for_each(|file| std::fs::remove_file(file).unwrap());
    refused(&bag, &Layout::ALL, gone, &["bag_0.", "cannot be read"]);
    let alone = |folder: &Path| {
        gone(folder);
        std::fs::write(folder.join("metadata.yaml"), "").unwrap();
    };
    refused(&bag, &[Layout::Sqlite], alone, &["metadata.yaml: no metadata of a ROS 2 bag"]);
}

#[test]
fn metadata_that_cannot_be_read_are_passed_over() {
    for layout in Layout::ALL {
        let folder = tempfile::tempdir().unwrap();
        small().write(folder.path(), layout);
        std::fs::write(folder.path().join("metadata.yaml"), "").unwrap();
        let recording = read(folder.path()).unwrap();
        assert_eq!(recording.shots.len(), 5, "{layout:?}");
        assert!(recording.notes[0].contains("the files beside it are read"), "{:?}", recording.notes);
    }
}

#[test]
fn files_may_be_renamed() {
    let folder = tempfile::tempdir().unwrap();
    small().write(folder.path(), Layout::McapZstd);
    for (number, file) in files(folder.path()).iter().enumerate() {
        std::fs::rename(file, folder.path().join(format!("tour_{number}.mcap"))).unwrap();
    }
    let recording = read(folder.path()).unwrap();
    assert_eq!(recording.shots.len(), 5);
    assert!(recording.notes[0].contains("none of its files is there"), "{:?}", recording.notes);
}

#[test]
fn what_is_whole_of_a_damaged_bag_is_read() {
    let bag = small();
    let damaged = |layout: Layout, spoil: &dyn Fn(&mut Vec<u8>)| {
        let folder = tempfile::tempdir().unwrap();
        bag.write(folder.path(), layout);
        let path = files(folder.path())[0].clone();
        let mut bytes = std::fs::read(&path).unwrap();
        spoil(&mut bytes);
        std::fs::write(path, bytes).unwrap();
        let recording = read(folder.path()).unwrap_or_else(|error| panic!("{layout:?}: {error}"));
        let images = || recording.shots.iter().flat_map(|shot| shot.images.iter().flatten());
        assert!(images().all(|image| image.read().is_ok()), "{layout:?}");
        assert!(recording.notes.iter().any(|note| note.contains("bag_0.")), "{:?}", recording.notes);
        images().count()
    };
    let cut = |bytes: &mut Vec<u8>| bytes.truncate(bytes.len() / 2);
    for layout in Layout::ALL {
        let frames = damaged(layout, &cut);
        println!("{layout:?} cut: {frames} of 10 frames");
        assert!((4..10).contains(&frames), "{layout:?}: {frames}; the second file alone has 4");
    }
    // A byte in the middle of a chunk: its checksum reveals it, and the other chunks are read.
    let flipped = |bytes: &mut Vec<u8>| {
        let middle = bytes.len() / 3;
        bytes[middle] ^= 64;
    };
    for layout in [Layout::McapChunks, Layout::McapZstd, Layout::McapLz4] {
        let frames = damaged(layout, &flipped);
        println!("{layout:?} flipped: {frames} of 10 frames");
        assert!((8..10).contains(&frames), "{layout:?}: {frames}");
    }
}

#[test]
fn a_single_file_is_a_bag() {
    for layout in Layout::ALL {
        let folder = tempfile::tempdir().unwrap();
        small().write(folder.path(), layout);
        let recording = read(&files(folder.path())[1]).unwrap();
        assert!(recording.shots.len() >= 2 && recording.imu.is_some(), "{layout:?}");
        assert_eq!(recording.notes, Vec::<String>::new());
    }
}

#[test]
fn a_database_is_read_without_writing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    small().write(folder.path(), Layout::Sqlite);
    let path = files(folder.path())[0].clone();
    // As the recorder leaves it: in WAL mode, the log merged.
    let database = rusqlite::Connection::open(&path).unwrap();
    let set = |database: &rusqlite::Connection, sql: &str| {
        database.query_row(sql, [], |row| row.get::<_, rusqlite::types::Value>(0)).unwrap()
    };
    set(&database, "PRAGMA journal_mode = WAL");
    database.close().unwrap();
    let names = || {
        let mut names: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    assert_eq!(read(folder.path()).unwrap().shots.len(), 5);
    assert_eq!(names(), before);
    // As a crash leaves it: messages in the log alone.
    let database = rusqlite::Connection::open(&path).unwrap();
    set(&database, "PRAGMA wal_autocheckpoint = 0");
    let last = "INSERT INTO messages (topic_id, timestamp, data) SELECT topic_id, 1, data FROM messages
                WHERE topic_id = (SELECT id FROM topics WHERE name = '/imu')";
    let count = database.execute(last, []).unwrap();
    let crashed = tempfile::tempdir().unwrap();
    for name in names() {
        std::fs::copy(folder.path().join(&name), crashed.path().join(&name)).unwrap();
    }
    let recording = read(crashed.path()).unwrap();
    assert_eq!(recording.imu.unwrap().gravity(None).unwrap().samples, 5 + count);
    assert!(count > 0);
}

#[test]
fn one_bad_message_does_not_end_a_recording() {
    let mut bag = small();
    let [left, right, imu] = [1, 2, 3];
    // By topic: a stamp twice, none, a negative one, a message that ends early, and a reading that is no number.
    bag.push_image_at(left, stamp(0, 2), 9_000_000_000);
    bag.push_image_at(left, 0, 3_050_000_000);
    bag.push_raw(left, 3_060_000_000, [&[0, 1, 0, 0][..], &(-5_i32).to_le_bytes(), &[0; 8]].concat());
    bag.push_raw(right, 3_070_000_000, vec![0, 1, 0, 0, 1]);
    bag.push_imu(imu, 3_080_000_000, [f64::NAN, 0.0, 0.0]);
    for layout in [Layout::Sqlite, Layout::McapZstd] {
        let folder = tempfile::tempdir().unwrap();
        bag.write(folder.path(), layout);
        let recording = read(folder.path()).unwrap();
        assert_eq!(recording.faults.to_string(), "4 of 14 frames, 1 of 6 readings", "{layout:?}");
        let problems: Vec<_> = recording.faults.first().iter().map(|fault| &fault.problem[..]).collect();
        for named in
            ["another frame has the stamp", "its stamp is 0", "-5 s", "within its header", "not finite"]
        {
            assert!(problems.iter().any(|problem| problem.contains(named)), "{named}: {problems:?}");
        }
        assert_eq!(recording.shots.len(), 5);
        let kept = recording.shots[2].images[0].as_ref().unwrap().read().unwrap();
        assert_eq!(kept.rgb().unwrap(), colours(0, 2), "the first of two");
    }
}

#[test]
fn without_stamps_the_times_of_recording_count() {
    let mut bag = Bag::new();
    let cameras = [bag.topic("/cam0", IMAGE), bag.topic("/cam1", IMAGE)];
    let imu = bag.topic("/imu", IMU);
    for frame in 0..3 {
        cameras.iter().for_each(|camera| bag.push_image_at(*camera, 0, stamp(0, frame)));
        bag.push_imu(imu, stamp(0, frame), [0.0, 0.0, 9.81]);
    }
    for layout in [Layout::Sqlite, Layout::McapPlain, Layout::McapZstd] {
        let folder = tempfile::tempdir().unwrap();
        bag.write(folder.path(), layout);
        let recording = read(folder.path()).unwrap();
        let times: Vec<_> = recording.shots.iter().map(|shot| shot.timestamp_ns).collect();
        assert_eq!(times, [0, 1, 2].map(|frame| stamp(0, frame)), "{layout:?}");
        assert_eq!(recording.notes.len(), 2, "{:?}", recording.notes);
        assert!(recording.notes[0].contains("/cam0: all stamps are 0"), "{:?}", recording.notes);
        assert!(recording.faults.is_empty());
    }
}

#[test]
fn types_without_msg_and_of_foxglove_are_read() {
    for (kinds, is_foxglove) in [
        (["sensor_msgs/Image", "sensor_msgs/CompressedImage"], false),
        (["foxglove_msgs/msg/RawImage", "foxglove_msgs/msg/CompressedImage"], true),
    ] {
        let mut bag = Bag::new();
        let [raw, packed] = [bag.topic("/cam0", kinds[0]), bag.topic("/cam1", kinds[1])];
        let pgm = b"P5 2 1 255\n\x05\x06";
        if is_foxglove {
            bag.push(raw, stamp(0, 0), &(2_u32, 1_u32, "mono8", 2_u32, &[3_u8, 4][..]));
            bag.push(packed, stamp(1, 0), &(&pgm[..], "pgm"));
        } else {
            bag.push_image(raw, stamp(0, 0), (2, 1), "mono8", 2, &[3, 4]);
            bag.push_compressed(packed, stamp(1, 0), pgm);
        }
        for layout in [Layout::Sqlite, Layout::McapZstd] {
            let folder = tempfile::tempdir().unwrap();
            bag.write(folder.path(), layout);
            let recording = read(folder.path()).unwrap();
            let [Some(raw), Some(packed)] = &recording.shots[0].images else { panic!("{kinds:?}") };
            assert_eq!(raw.read().unwrap().gray().pixels(), [3, 4]);
            assert_eq!(packed.read().unwrap().gray().pixels(), [5, 6]);
        }
    }
}

#[test]
fn one_topic_may_serve_both_cameras() {
    let mut bag = Bag::new();
    let dual = bag.topic("/dual", IMAGE);
    bag.push_image(dual, stamp(0, 0), SIZE, "rgb8", 3 * SIZE.0, &colours(0, 0));
    let folder = tempfile::tempdir().unwrap();
    bag.write(folder.path(), Layout::McapZstd);
    let topics: Topics = "/dual,/dual".parse().unwrap();
    let recording = Recording::read(folder.path(), Some(&topics), &Calibration::nominal()).unwrap();
    assert!(recording.shots[0].images.iter().all(|image| image.as_ref().unwrap().read().is_ok()));
}

#[test]
fn bad_messages_are_named() {
    let any = [Layout::Sqlite, Layout::McapZstd];
    let mut third = small();
    third.topic("/top", IMAGE);
    refused(&third, &any, |_| {}, &["--topics", "/cam0/image (sensor_msgs/msg/Image)", "/top"]);
    let mut swapped = Bag::new();
    for name in ["/front/image", "/back/image"] {
        let topic = swapped.topic(name, IMAGE);
        swapped.push_image_at(topic, stamp(0, 0), stamp(0, 0));
    }
    refused(&swapped, &any, |_| {}, &["--topics", "/front/image", "/back/image"]);
    let mut blind = Bag::new();
    let odom = blind.topic("/odom", "nav_msgs/msg/Odometry");
    blind.push_raw(odom, 5, vec![7; 5]);
    refused(&blind, &any, |_| {}, &["no image topic in the bag", "/odom (nav_msgs/msg/Odometry)"]);
    let mut empty = Bag::new();
    let [left, _, odom] = [("/cam0", IMAGE), ("/cam1", COMPRESSED), ("/odom", "nav_msgs/msg/Odometry")]
        .map(|(n, k)| empty.topic(n, k));
    empty.push_raw(odom, 5, vec![7; 5]);
    refused(&empty, &any, |_| {}, &["/cam0 and /cam1: no messages"]);
    empty.push_image(left, stamp(0, 0), (1, 1), "mono8", 1, &[1]);
    let folder = tempfile::tempdir().unwrap();
    empty.write(folder.path(), Layout::Sqlite);
    let recording = read(folder.path()).unwrap();
    assert_eq!((recording.shots.len(), &recording.notes[..]), (1, &["/cam1: no frames".to_owned()][..]));
    for (push, named) in [
        (
            (|bag, left| bag.push_raw(left, 5, [&[0, 1, 0, 0][..], &[1; 8]].concat())) as fn(&mut Bag, usize),
            "/cam0 at 16843009.016843009 s: a message is too short",
        ),
        (
            |bag, left| bag.push_image(left, 1_500_000_000, (2, 1), "32FC1", 8, &[0; 8]),
            "/cam0 at 1.500000000 s: encoding '32FC1'",
        ),
        (|bag, left| bag.push_image(left, 1, (2, 1), "rgb8", 6, &[0; 5]), "5 bytes of data are too few"),
        (|bag, left| bag.push_image(left, 1, (0, 1), "rgb8", 6, &[0; 6]), "0 x 1 pixels"),
    ] {
        let mut bag = Bag::new();
        let [left, right] = [bag.topic("/cam0", IMAGE), bag.topic("/cam1", COMPRESSED)];
        push(&mut bag, left);
        bag.push_compressed(right, 9_000_000_000_000_000_000, b"GIF89a");
        refused(&bag, &any, |_| {}, &[named]);
    }
}

/// A folder with two frames of the sample building in `set`, with an IMU aligned with cam0, and its calibration.
fn recording() -> Folder {
    let folder = Folder::new();
    let poses = [0, 1].map(|n| {
        let x = 13.37 + 0.4 * f64::from(n);
        Pose::looking(1_000_000_000 + 500_000_000 * u64::from(n as u8), [x, 3.68, 1.5], 20.0, 0.0, 0.0)
    });
    folder.write("poses.tum", tum::text(&poses).as_bytes());
    let _ = folder
        .json("simulate sample.png --poses poses.tum --size 368x360 --people 0 --no-operator --out set");
    let same = "cam0:\n  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  rostopic: /b";
    folder.write(
        "rig.yaml",
        NOMINAL_YAML.replacen("cam0:", same, 1).replacen("cam1:", "cam1:\n  rostopic: /a", 1).as_bytes(),
    );
    std::fs::create_dir(folder.path("set/imu0")).unwrap();
    let rows: String = readings().map(|(ns, [x, y, z])| format!("{ns},0,0,0,{x},{y},{z}\n")).collect();
    folder.write("set/imu0/data.csv", rows.as_bytes());
    folder
}

/// Upright at the first frame, on its side at the second, and no readings later.
fn readings() -> impl Iterator<Item = (u64, [f64; 3])> {
    (0..60).map(|n| {
        let time = 800_000_000 + 20_000_000 * n;
        (time, if time < 1_250_000_000 { [0.0, -9.81, 0.2] } else { [9.81, 0.0, 0.0] })
    })
}

/// The same recording as a bag: images unchanged, or as blue, green, red with padding.
fn bag_of(folder: &Folder, is_compressed: bool) -> Bag {
    let mut bag = Bag::new();
    let kind = if is_compressed { COMPRESSED } else { IMAGE };
    for (camera, name) in ["/b", "/a"].into_iter().enumerate() {
        let name = if is_compressed { format!("{name}/compressed") } else { name.to_owned() };
        let topic = bag.topic(&name, kind);
        for stamp in [1_000_000_000, 1_500_000_000] {
            let file = folder.read(&format!("set/cam{camera}/data/{stamp}.jpg"));
            if is_compressed {
                bag.push_compressed(topic, stamp, &file);
                continue;
            }
            let image = image::load_from_memory(&file).unwrap().into_rgb8();
            let row = |row: &[u8]| {
                let pixels = row.chunks_exact(3).flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]);
                pixels.chain([99; 5]).collect::<Vec<u8>>()
            };
            let step = 3 * image.width() + 5;
            let data: Vec<u8> = image.chunks_exact(3 * image.width() as usize).flat_map(row).collect();
            bag.push_image(topic, stamp, image.dimensions(), "bgr8", step, &data);
        }
    }
    let imu = bag.topic("/imu", IMU);
    readings().for_each(|(time, acceleration)| bag.push_imu(imu, time, acceleration));
    bag
}

#[test]
fn a_bag_is_evaluated_as_its_frames_in_a_folder() {
    let folder = recording();
    bag_of(&folder, false).write(&folder.path("sqlite"), Layout::Sqlite);
    bag_of(&folder, true).write(&folder.path("mcap"), Layout::McapZstd);
    // Only the IMU determines which way is up.
    let line = |set: &str, out: &str| {
        format!(
            "evaluate --map sample.site --calib rig.yaml --groundtruth poses.tum --dataset {set} --out {out}"
        )
    };
    let [set, sqlite, mcap] =
        ["set", "sqlite", "mcap"].map(|set| folder.json(&line(set, &format!("{set}_out"))));
    the_imu_counts(&set);
    assert_eq!(sqlite["topics"], "cam0 /b, cam1 /a, IMU /imu");
    assert_eq!(mcap["topics"], "cam0 /b/compressed, cam1 /a/compressed, IMU /imu");
    for (name, bag) in [("sqlite", &sqlite), ("mcap", &mcap)] {
        assert_eq!((&bag["rows"], &bag["results"]), (&set["rows"], &set["results"]), "{name}");
        for trajectory in ["single.tum", "track.tum"] {
            let [ours, theirs] = [name, "set"].map(|set| folder.read(&format!("{set}_out/{trajectory}")));
            assert!(ours == theirs, "{name}: {trajectory}");
        }
    }
    let again = folder.json(&line("mcap", "mcap_out"));
    assert_eq!(number(&again["resumed"]), 2.0);
    let before = folder.names();
    for (set, topics, named) in [
        ("mcap", "/c,/a", "mcap: no topic /c;"),
        ("set", "/b,/a", "set: no ROS 2 bag"),
        ("sqlite", "/imu", "sqlite: /imu: is of type sensor_msgs/msg/Imu"),
    ] {
        let line = format!("{} --topics {topics}", line(set, "x"));
        let ran = folder.run(&line);
        assert_eq!((ran.status, ran.stderr.lines().count()), (Some(2), 1), "{line}: {}", ran.stderr);
        assert!(ran.stderr.contains(named), "{line}: {}", ran.stderr);
    }
    assert_eq!(folder.names(), before);
}

/// Parts of a recording, each in a folder of its own as on machines of a cluster, join to what one run finds.
#[test]
fn parts_join_to_the_whole() {
    let folder = recording();
    let line = "evaluate --map sample.site --calib rig.yaml --groundtruth poses.tum --dataset set --out";
    let whole = folder.json(&format!("{line} whole"));
    for part in 1..=2 {
        let told = folder.json(&format!("{line} part{part} --shard {part}/2"));
        assert_eq!((number(&told["frames"]), number(&told["resumed"])), (1.0, 0.0), "{told}");
        assert!(!folder.path(&format!("part{part}/report.html")).exists());
    }
    let none = folder.json(&format!("{line} none --shard 5/5"));
    assert_eq!(number(&none["frames"]), 0.0, "there are more parts than frames");
    let joined = folder.json(&format!("{line} joined --merge part1,part2"));
    assert_eq!(number(&joined["resumed"]), 2.0);
    assert_eq!((&joined["rows"], &joined["results"]), (&whole["rows"], &whole["results"]));
    for name in ["single.tum", "track.tum"] {
        assert!(folder.read(&format!("joined/{name}")) == folder.read(&format!("whole/{name}")), "{name}");
    }
    // Evidence that is damaged is not taken over, here or there; the frame is localized anew.
    let damaged = std::fs::read_dir(folder.path("part1/evidence")).unwrap().next().unwrap().unwrap().path();
    std::fs::write(&damaged, b"cut off").unwrap();
    let ran = folder.run(&format!("{line} again --merge part1,part2"));
    assert!(ran.status == Some(0) && ran.stderr.contains("part1: 0 of 1 frames"), "{}", ran.stderr);
    std::fs::write(folder.path("joined/evidence").join(damaged.file_name().unwrap()), b"").unwrap();
    let mended = folder.json(&format!("{line} joined"));
    assert_eq!((number(&mended["resumed"]), &mended["results"]), (1.0, &whole["results"]));
    // A frame whose picture changed is another frame.
    let images = ["1000000000", "1500000000"].map(|stamp| folder.path(&format!("set/cam0/data/{stamp}.jpg")));
    std::fs::copy(&images[1], &images[0]).unwrap();
    assert_eq!(number(&folder.json(&format!("{line} joined"))["resumed"]), 1.0);
    for (wrong, named) in [("3/2", "I/N"), ("0/2", "I/N"), ("x", "I/N")] {
        let ran = folder.run(&format!("{line} x --shard {wrong}"));
        assert!(ran.status == Some(2) && ran.stderr.contains(named), "{}", ran.stderr);
    }
}

/// A run that is killed anywhere continues to what an undisturbed one finds.
#[test]
fn a_killed_run_continues() {
    let folder = recording();
    let line =
        "evaluate --map sample.site --calib rig.yaml --groundtruth poses.tum --dataset set --jobs 1 --out";
    let whole = folder.json(&format!("{line} whole"));
    for milliseconds in [20, 100, 300, 600, 1000, 1500] {
        let mut command = std::process::Command::new(compass());
        command.args(line.split_whitespace()).arg("out").current_dir(folder.path(""));
        command.stdout(std::process::Stdio::null());
        let mut running = command.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        // It may have ended; what it left is then whole.
        let _ = running.kill();
        running.wait().unwrap();
        let found = folder.json(&format!("{line} out"));
        assert_eq!(
            (&found["rows"], &found["results"]),
            (&whole["rows"], &whole["results"]),
            "{milliseconds} ms"
        );
        assert!(folder.read("out/track.tum") == folder.read("whole/track.tum"), "{milliseconds} ms");
        std::fs::remove_dir_all(folder.path("out")).unwrap();
    }
}

/// A map is whole or absent, whenever its making is killed.
#[test]
fn a_killed_build_leaves_no_half_a_map() {
    let folder = Folder::new();
    let mut whole = 0;
    for milliseconds in [1, 10, 30, 60, 120, 250, 500, 5000] {
        let mut command = std::process::Command::new(compass());
        command.args("map build sample.png --out made.site".split_whitespace()).current_dir(folder.path(""));
        command.stdout(std::process::Stdio::null());
        let mut running = command.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        let _ = running.kill();
        running.wait().unwrap();
        if folder.path("made.site").exists() {
            let _ = folder.json("map info made.site");
            whole += 1;
            std::fs::remove_file(folder.path("made.site")).unwrap();
        }
    }
    assert!(whole > 0, "it was never made");
}

/// Ctrl-C ends a run with the status that shells use for it, and leaves no copy of a packed bag behind.
#[test]
#[cfg(unix)]
fn an_interrupted_run_leaves_no_copies() {
    let folder = recording();
    bag_of(&folder, false).write(&folder.path("bag"), Layout::SqlitePackedFiles);
    std::fs::create_dir(folder.path("tmp")).unwrap();
    let copies = || std::fs::read_dir(folder.path("tmp")).unwrap().count();
    let line = "evaluate --map sample.site --calib rig.yaml --groundtruth poses.tum --dataset bag --out out --jobs 1";
    let mut command = std::process::Command::new(compass());
    command.args(line.split_whitespace()).current_dir(folder.path("")).env("TMPDIR", folder.path("tmp"));
    let mut running = command.spawn().unwrap();
    while copies() == 0 {
        assert!(running.try_wait().unwrap().is_none(), "it ended without a copy");
        std::thread::yield_now();
    }
    let kill = ["-INT".to_owned(), running.id().to_string()];
    assert!(std::process::Command::new("kill").args(kill).status().unwrap().success());
    assert_eq!((running.wait().unwrap().code(), copies()), (Some(130), 0));
}

/// Progress is of as many messages as there are, with metadata and without.
#[test]
fn progress_reaches_its_end() {
    let folder = tempfile::tempdir().unwrap();
    for (layout, has_metadata) in [(Layout::Sqlite, true), (Layout::Sqlite, false), (Layout::McapZstd, false)]
    {
        let path = folder.path().join(format!("{layout:?} {has_metadata}"));
        small().write(&path, layout);
        if !has_metadata {
            std::fs::remove_file(path.join("metadata.yaml")).unwrap();
        }
        let counted = Counted::default();
        Recording::read_with_progress(&path, None, &Calibration::nominal(), &counted).unwrap();
        let Counted { total, done } = counted;
        assert_eq!((total.into_inner(), done.load(Ordering::Relaxed)), (15, 15), "{layout:?} {has_metadata}");
    }
}

/// Counts the steps of the work that it is told of.
#[derive(Default)]
struct Counted {
    total: AtomicUsize,
    done: Arc<AtomicUsize>,
}

impl Progress for Counted {
    fn begin(&self, total: usize, _: &'static str) -> Box<dyn Steps> {
        self.total.store(total, Ordering::Relaxed);
        Box::new(Counter(Arc::clone(&self.done)))
    }
}

struct Counter(Arc<AtomicUsize>);

impl Steps for Counter {
    fn step(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// On its side the IMU disagrees with the image, which the frame reports.
fn the_imu_counts(result: &Value) {
    let frames = result["results"].as_array().unwrap();
    assert_eq!(result["up_from"], serde_json::json!({ "both": 1 }), "{result}");
    assert_eq!((&frames[0]["up_from"], &frames[0]["problem"]), (&Value::from("both"), &Value::Null));
    let problem = frames[1]["problem"].as_str().unwrap();
    assert!(
        problem.starts_with("image and IMU disagree on up by ") && frames[1]["up_from"].is_null(),
        "{problem}"
    );
    assert_eq!((number(&result["unseen"]), frames[1]["single"].is_null()), (1.0, true));
}
