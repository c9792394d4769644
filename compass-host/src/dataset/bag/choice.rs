//! Which topics of a bag to read.

use super::kind::Kind;
use super::topic::{Topic, list};
use crate::calibration::Calibration;
use crate::dataset::topics::Topics;

/// The ending under which `image_transport` publishes compressed images beside the others.
const COMPRESSED: &str = "/compressed";

/// The role of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The images of cam0 or cam1.
    Camera(usize),
    /// The readings of the IMU.
    Imu,
}

/// The topics to read: the requested ones; else those that the calibration names; else those that their names number.
/// Otherwise an error message.
pub(super) fn choose(
    topics: &[Topic],
    asked: Option<&Topics>,
    calibration: &Calibration,
) -> Result<Vec<(Role, Topic)>, String> {
    let chosen = if let Some(asked) = asked {
        let cameras = [0, 1].map(|number| (number, asked.cameras[number].as_ref()));
        let cameras = cameras.into_iter().filter_map(|(number, name)| Some((Role::Camera(number), name?)));
        let all = cameras.chain(asked.imu.as_ref().map(|name| (Role::Imu, name)));
        all.map(|(role, name)| Ok((role, named(topics, role, name)?))).collect::<Result<Vec<_>, String>>()?
    } else {
        let mut chosen = cameras(topics, calibration)?;
        chosen.extend(imu(topics, calibration.imu_topic.as_deref())?.map(|topic| (Role::Imu, topic)));
        chosen
    };
    match chosen.iter().find(|(_, topic)| topic.format != "cdr") {
        Some((_, topic)) => Err(format!(
            "{} ({}): its messages are serialized as '{}', which is not read, only cdr",
            topic.name, topic.written_kind, topic.format
        )),
        None => Ok(chosen),
    }
}

fn cameras(topics: &[Topic], calibration: &Calibration) -> Result<Vec<(Role, Topic)>, String> {
    let images = images(topics);
    if images.is_empty() {
        return Err(no_images(topics));
    }
    let names = Topics::from(calibration).cameras;
    let calibrated: Vec<usize> = (0..2).filter(|&number| calibration.names[number].is_some()).collect();
    let calibrated: Vec<usize> =
        calibrated.into_iter().filter(|&number| calibration.is_in_file(number)).collect();
    let told =
        |&number: &usize| names[number].as_ref().and_then(|name| find(topics, Role::Camera(number), name));
    let found: Vec<_> =
        calibrated.iter().filter_map(|number| Some((Role::Camera(*number), told(number)?))).collect();
    // If every image topic is assigned by name, a camera without a topic is absent from the recording.
    if found.len() == calibrated.len() || !found.is_empty() && found.len() == images.len() {
        return Ok(found.into_iter().map(|(role, topic)| (role, topic.clone())).collect());
    }
    if found.is_empty() && images.len() == calibrated.len() && are_numbered(&images) {
        let roles = calibrated.into_iter().map(Role::Camera);
        return Ok(roles.zip(images.into_iter().cloned()).collect());
    }
    let names: Vec<_> = names.into_iter().flatten().collect();
    Err(format!(
        "the calibration names {}, which does not tell the cameras' topics; name them with --topics CAM0,CAM1; there \
         are {}",
        if names.is_empty() { "no topic".to_owned() } else { names.join(" and ") },
        list(topics)
    ))
}

/// The image topics by name, those that are there both plain and compressed once.
fn images(topics: &[Topic]) -> Vec<&Topic> {
    let mut images: Vec<&Topic> = topics.iter().filter(|topic| topic.kind().is_image()).collect();
    images.sort_by_cached_key(|topic| in_order_of_numbers(&topic.name));
    // The plain one sorts first.
    images.dedup_by(|later, first| base(&later.name) == base(&first.name));
    images
}

fn base(name: &str) -> &str {
    name.strip_suffix(COMPRESSED).unwrap_or(name)
}

/// Whether topics are in the order of numbers in their names, which are else the same; a single one is. What other
/// names mean, such as front and back, only the user knows.
fn are_numbered(images: &[&Topic]) -> bool {
    images.windows(2).all(|pair| {
        let [a, b] = [pair[0], pair[1]].map(|topic| base(&topic.name).as_bytes());
        let same_start = a.iter().zip(b).take_while(|(a, b)| a == b).count();
        let digits_before = a[..same_start].iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
        let split = |name: &'_ [u8]| {
            let name = &name[same_start - digits_before..];
            let digits = name.iter().take_while(|byte| byte.is_ascii_digit()).count();
            (digits > 0).then(|| name[digits..].to_vec())
        };
        split(a).is_some_and(|rest| split(b) == Some(rest))
    })
}

/// A name with its numbers padded, so that they are in order.
fn in_order_of_numbers(name: &str) -> String {
    let (mut padded, mut digits) = (String::new(), String::new());
    for character in name.chars().chain(std::iter::once('\0')) {
        if character.is_ascii_digit() {
            digits.push(character);
            continue;
        }
        if !digits.is_empty() {
            padded.push_str(&format!("{:0>20}", std::mem::take(&mut digits)));
        }
        padded.push(character);
    }
    padded
}

fn no_images(topics: &[Topic]) -> String {
    let video: Vec<_> = topics.iter().filter(|topic| topic.kind() == Kind::Video).cloned().collect();
    if video.is_empty() {
        return format!("no image topic in the bag; there are {}", list(topics));
    }
    format!(
        "{}: video is not read; decode it to images first, as with 'ros2 run image_transport republish' to 'raw' or \
         'compressed', and record those",
        list(&video)
    )
}

fn imu(topics: &[Topic], name: Option<&str>) -> Result<Option<Topic>, String> {
    let all: Vec<&Topic> = topics.iter().filter(|topic| topic.kind() == Kind::Imu).collect();
    let told = name.and_then(|name| all.iter().find(|topic| topic.name == name));
    match (told, &all[..]) {
        (Some(topic), _) => Ok(Some((*topic).clone())),
        (None, []) => Ok(None),
        (None, [only]) => Ok(Some((*only).clone())),
        (None, _) => Err(format!("several IMUs: name one with --topics; there are {}", list(topics))),
    }
}

/// Whether a topic has this name or, for a camera, is one that `image_transport` publishes beside it.
fn find<'a>(topics: &'a [Topic], role: Role, name: &str) -> Option<&'a Topic> {
    let exact = topics.iter().find(|topic| topic.name == name && topic.serves(role));
    let beside =
        || topics.iter().find(|topic| topic.name == format!("{name}{COMPRESSED}") && topic.serves(role));
    exact.or_else(beside)
}

fn named(topics: &[Topic], role: Role, name: &str) -> Result<Topic, String> {
    find(topics, role, name).cloned().ok_or_else(|| match topics.iter().find(|topic| topic.name == name) {
        Some(topic) if topic.kind() == Kind::Video => no_images(std::slice::from_ref(topic)),
        Some(topic) => format!(
            "{name}: is of type {}; {} is needed",
            topic.written_kind,
            match role {
                Role::Camera(_) => "Image or CompressedImage of sensor_msgs or foxglove_msgs",
                Role::Imu => "sensor_msgs/msg/Imu",
            }
        ),
        None => format!("no topic {name}; there are {}", list(topics)),
    })
}

impl Topic {
    fn serves(&self, role: Role) -> bool {
        match role {
            Role::Camera(_) => self.kind().is_image(),
            Role::Imu => self.kind() == Kind::Imu,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topics(names: &[&str]) -> Vec<Topic> {
        let kind = |name: &str| match name {
            name if name.contains("imu") => "sensor_msgs/msg/Imu",
            name if name.contains("compressed") => "sensor_msgs/CompressedImage",
            name if name.contains("cam") => "sensor_msgs/msg/Image",
            name if name.contains("h264") => "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
            _ => "tf2_msgs/msg/TFMessage",
        };
        let topic = |name: &&str| Topic {
            name: (*name).into(),
            written_kind: kind(name).into(),
            format: "cdr".into(),
            count: 1,
        };
        names.iter().map(topic).collect()
    }

    /// A calibration of two cameras, with these topic names if any.
    fn calibration(cameras: [Option<&str>; 2]) -> Calibration {
        let mut calibration = Calibration::nominal();
        for (camera, name) in calibration.cameras.iter_mut().zip(cameras) {
            camera.as_mut().unwrap().topic = name.map(str::to_owned);
        }
        calibration
    }

    fn chosen(names: &[&str], asked: Option<&str>, calibration: &Calibration) -> Result<String, String> {
        let asked: Option<Topics> = asked.map(|asked| asked.parse().unwrap());
        let chosen = choose(&topics(names), asked.as_ref(), calibration)?;
        Ok(chosen
            .into_iter()
            .map(|(role, topic)| format!("{role:?} {}", topic.name))
            .collect::<Vec<_>>()
            .join(", "))
    }

    #[test]
    fn the_calibration_tells_or_the_names_are_numbered() {
        let (silent, both) = (calibration([None, None]), calibration([Some("/cam/b"), Some("/cam/a")]));
        let all = ["/tf", "/cam/b/compressed", "/imu", "/cam/a", "/cam/c"];
        assert_eq!(
            chosen(&all, None, &both).unwrap(),
            "Camera(0) /cam/b/compressed, Camera(1) /cam/a, Imu /imu"
        );
        for (names, expected) in [
            (&["/cam1/image", "/tf", "/cam0/image"][..], "Camera(0) /cam0/image, Camera(1) /cam1/image"),
            (&["/cam_2", "/cam_1"], "Camera(0) /cam_1, Camera(1) /cam_2"),
            (&["/a12/cam", "/a9/cam"], "Camera(0) /a9/cam, Camera(1) /a12/cam"),
            (&["/cam0/compressed", "/cam0", "/cam1", "/cam1/compressed"], "Camera(0) /cam0, Camera(1) /cam1"),
        ] {
            assert_eq!(chosen(names, None, &silent).unwrap_or_default(), expected);
        }
        assert_eq!(chosen(&["/cam/a"], None, &both).unwrap(), "Camera(1) /cam/a", "one camera alone");
        assert_eq!(chosen(&all, Some("/cam/c,,/imu"), &both).unwrap(), "Camera(0) /cam/c, Imu /imu");
        assert_eq!(chosen(&all, Some(",/cam/c"), &both).unwrap(), "Camera(1) /cam/c");
        let mut imu = both;
        imu.imu_topic = Some("/imu/2".into());
        let two = ["/imu/1", "/imu/2", "/cam/a", "/cam/b"];
        assert_eq!(chosen(&two, None, &imu).unwrap(), "Camera(0) /cam/b, Camera(1) /cam/a, Imu /imu/2");
    }

    #[test]
    fn ambiguous_topics_are_listed() {
        let both = calibration([Some("/cam/b"), Some("/cam/a")]);
        let image = "/cam/c (sensor_msgs/msg/Image)";
        for (names, asked, named) in [
            (&["/cam/c", "/cam/d", "/cam/e"][..], None, image),
            (&["/cam/b", "/cam/c"], None, image),
            (&["/cam/c"], None, image),
            (&["/cam/c", "/cam/d"], None, "--topics CAM0,CAM1"),
            (&["/back/cam", "/front/cam"], None, "--topics CAM0,CAM1"),
            (&["/cam/left", "/cam/right"], None, "--topics CAM0,CAM1"),
            (&[], None, "no image topic in the bag; there are none"),
            (&["/tf"], None, "no image topic in the bag; there are /tf (tf2_msgs/msg/TFMessage)"),
            (
                &["/tf", "/h264"],
                None,
                "/h264 (ffmpeg_image_transport_msgs/msg/FFMPEGPacket): video is not read",
            ),
            (&["/h264"], Some("/h264"), "video is not read"),
            (&["/cam/a", "/cam/b", "/imu/1", "/imu/2"], None, "several IMUs"),
            (&["/cam/c"], Some("/cam/d"), image),
            (&["/cam/c", "/tf"], Some("/tf"), "/tf: is of type tf2_msgs/msg/TFMessage"),
            (&["/cam/c"], Some("/cam/c,,/cam/c"), "sensor_msgs/msg/Imu is needed"),
        ] {
            let problem = chosen(names, asked, &both).unwrap_err();
            assert!(problem.contains(named), "{names:?}: {problem}");
        }
        for bad in ["", ",,/imu", "/a,/b,/c,/d"] {
            assert!(bad.parse::<Topics>().is_err(), "{bad}");
        }
        let mut foreign = topics(&["/cam0", "/cam1"]);
        foreign[1].format = "protobuf".into();
        let problem = choose(&foreign, None, &Calibration::nominal()).unwrap_err();
        assert!(problem.contains("/cam1") && problem.contains("'protobuf'"), "{problem}");
    }
}
