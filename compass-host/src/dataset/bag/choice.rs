//! Which topics of a bag to read.

use super::metadata::Topic;
use crate::calibration::Calibration;
use crate::dataset::topics::Topics;

/// The role of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The images of cam0 or cam1.
    Camera(usize),
    /// The readings of the IMU.
    Imu,
}

/// The topics to read: the requested ones; else those that the calibration names; else, sorted by name, the only
/// candidates. Otherwise an error message.
pub(super) fn choose(
    topics: &[Topic],
    asked: Option<&Topics>,
    calibration: &Calibration,
) -> Result<Vec<(Role, Topic)>, String> {
    if let Some(asked) = asked {
        let cameras = [0, 1].map(|number| (number, asked.cameras[number].as_ref()));
        let cameras = cameras.into_iter().filter_map(|(number, name)| Some((Role::Camera(number), name?)));
        let all = cameras.chain(asked.imu.as_ref().map(|name| (Role::Imu, name)));
        return all.map(|(role, name)| Ok((role, named(topics, role, name)?))).collect();
    }
    let mut chosen = cameras(topics, calibration)?;
    chosen.extend(imu(topics, calibration.imu_topic.as_deref())?.map(|topic| (Role::Imu, topic)));
    Ok(chosen)
}

fn cameras(topics: &[Topic], calibration: &Calibration) -> Result<Vec<(Role, Topic)>, String> {
    let calibrated: Vec<usize> = (0..2).filter(|&number| calibration.cameras[number].is_some()).collect();
    let names = Topics::from(calibration).cameras;
    let told =
        |&number: &usize| names[number].as_ref().and_then(|name| find(topics, Role::Camera(number), name));
    let found: Vec<_> =
        calibrated.iter().filter_map(|number| Some((Role::Camera(*number), told(number)?))).collect();
    let mut images: Vec<&Topic> = topics.iter().filter(|topic| topic.is_image()).collect();
    images.sort_by(|a, b| a.name.cmp(&b.name));
    // If every image topic is assigned by name, a camera without a topic is absent from the recording.
    if found.len() == calibrated.len() || !found.is_empty() && found.len() == images.len() {
        return Ok(found.into_iter().map(|(role, topic)| (role, topic.clone())).collect());
    }
    if found.is_empty() && images.len() == calibrated.len() {
        let roles = calibrated.into_iter().map(Role::Camera);
        return Ok(roles.zip(images.into_iter().cloned()).collect());
    }
    let names: Vec<_> = names.into_iter().flatten().collect();
    Err(format!(
        "the calibration names {}, which does not tell the cameras' topics; name them with --topics; there are {}",
        if names.is_empty() { "no topic".to_owned() } else { names.join(" and ") },
        list(topics)
    ))
}

fn imu(topics: &[Topic], name: Option<&str>) -> Result<Option<Topic>, String> {
    let all: Vec<&Topic> = topics.iter().filter(|topic| topic.is_imu()).collect();
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
        || topics.iter().find(|topic| topic.name == format!("{name}/compressed") && topic.serves(role));
    exact.or_else(beside)
}

fn named(topics: &[Topic], role: Role, name: &str) -> Result<Topic, String> {
    find(topics, role, name).cloned().ok_or_else(|| match topics.iter().find(|topic| topic.name == name) {
        Some(topic) => format!(
            "{name}: is of type {}; {} is needed",
            topic.kind,
            match role {
                Role::Camera(_) => "sensor_msgs/msg/Image or CompressedImage",
                Role::Imu => "sensor_msgs/msg/Imu",
            }
        ),
        None => format!("no topic {name}; there are {}", list(topics)),
    })
}

/// All topics with their types.
fn list(topics: &[Topic]) -> String {
    let texts: Vec<_> = topics.iter().map(|topic| format!("{} ({})", topic.name, topic.kind)).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

impl Topic {
    fn serves(&self, role: Role) -> bool {
        match role {
            Role::Camera(_) => self.is_image(),
            Role::Imu => self.is_imu(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topics(names: &[&str]) -> Vec<Topic> {
        let kind = |name: &str| match name {
            name if name.contains("imu") => "sensor_msgs/msg/Imu",
            name if name.contains("compressed") => "sensor_msgs/msg/CompressedImage",
            name if name.contains("cam") => "sensor_msgs/msg/Image",
            _ => "tf2_msgs/msg/TFMessage",
        };
        names.iter().map(|name| Topic { name: (*name).into(), kind: kind(name).into(), count: 1 }).collect()
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
    fn the_calibration_tells_or_there_is_no_choice() {
        let (silent, both) = (calibration([None, None]), calibration([Some("/cam/b"), Some("/cam/a")]));
        let all = ["/tf", "/cam/b/compressed", "/imu", "/cam/a", "/cam/c"];
        assert_eq!(
            chosen(&all, None, &both).unwrap(),
            "Camera(0) /cam/b/compressed, Camera(1) /cam/a, Imu /imu"
        );
        assert_eq!(
            chosen(&["/cam/x", "/tf", "/cam/w"], None, &both).unwrap(),
            "Camera(0) /cam/w, Camera(1) /cam/x"
        );
        assert_eq!(
            chosen(&["/cam/x", "/cam/w"], None, &silent).unwrap(),
            "Camera(0) /cam/w, Camera(1) /cam/x"
        );
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
            (&[], None, "there are none"),
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
    }
}
