//! `compass node`: the ROS 2 node.

use super::exit::{self, Outcome};
use super::heights::HeightArgs;
use super::notes::note;
use super::plan::finite;
use super::prior::PlaceArgs;
use super::up::MountOption;
use anyhow::{Context as _, Result, bail};
use compass_host::calibration::{Calibration, CameraNames};
use compass_host::locator::{Locator, NoPlan};
use compass_host::ros::{self, Options};
use compass_host::site_file::SiteFile;
use std::path::PathBuf;

/// Frames on topics become poses on topics: ~/pose, ~/candidates, /tf, /diagnostics; ~/relocalize starts anew.
///
/// What ROS passes on works too: --ros-args with -r FROM:=TO (topics, __node, __ns), -p NAME:=VALUE for any option, and
/// --params-file.
#[derive(Debug, clap::Args)]
pub(super) struct Node {
    /// The site file
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// Camera calibration: a camera chain of Kalibr, .yaml, or what Basalt and ROS write
    #[arg(long, value_name = "FILE")]
    calib: PathBuf,
    /// Cameras of the calibration that are cam0 and cam1 [default: cam0,cam1]
    #[arg(long, value_name = "CAM0[,CAM1]")]
    cameras: Option<CameraNames>,
    /// Topic of cam0, compressed images if it ends in /compressed, else raw ones; empty for none
    #[arg(long, value_name = "TOPIC", default_value = "/cam0/image_raw/compressed")]
    cam0_topic: String,
    /// Topic of cam1, likewise
    #[arg(long, value_name = "TOPIC", default_value = "/cam1/image_raw/compressed")]
    cam1_topic: String,
    /// Topic of the odometry; with it the track takes the robot's motion, and map -> odom is said on /tf
    #[arg(long, value_name = "TOPIC")]
    odom_topic: Option<String>,
    /// Largest difference of stamps in a pair, seconds
    #[arg(long, value_name = "S", default_value_t = 0.02, value_parser = finite)]
    pair_within: f64,
    /// Say the first sure pose on /initialpose, as navigation expects it; ~/relocalize says the next one too
    #[arg(long)]
    initialpose: bool,
    /// Say a pose from this probability on
    #[arg(long, value_name = "P", default_value_t = 0.5, value_parser = finite)]
    min_probability: f64,
    /// Which side of cam0's image is up, within 45 degrees
    #[arg(long, value_enum, default_value_t = MountOption::Auto)]
    mount: MountOption,
    #[command(flatten)]
    heights: HeightArgs,
    #[command(flatten)]
    place: PlaceArgs,
    /// Name of the map's axes
    #[arg(long, value_name = "NAME", default_value = "map")]
    map_frame: String,
    /// Name of the node
    #[arg(long, value_name = "NAME", default_value = "compass")]
    name: String,
    /// Namespace of the node
    #[arg(long, value_name = "NAMESPACE", default_value = "/")]
    namespace: String,
    /// Number of the DDS domain [default: what the environment says, else 0]
    #[arg(long, value_name = "N")]
    domain: Option<u16>,
    /// Another name for a topic, FROM:=TO
    #[arg(long, value_name = "FROM:=TO")]
    remap: Vec<String>,
}

impl Node {
    pub(super) fn run(&self) -> Result<Outcome> {
        let file = SiteFile::read(&self.map)?;
        let floors = file.floors();
        if floors.iter().any(|floor| floor.floor.is_none()) {
            return Err(NoPlan).with_context(|| self.map.display().to_string());
        }
        let calibration = Calibration::load_cameras(&self.calib, &self.cameras.clone().unwrap_or_default())?;
        let layers = Locator::without_rig(&floors, compass_core::Settings::BOARD)
            .with_context(|| self.map.display().to_string())?;
        let place = self.place.prior(&self.map, layers.layers())?;
        let options = self.options(place)?;
        let topics: Vec<_> = options.topics.iter().flatten().map(String::as_str).collect();
        note(&format!("{} listens to {}", options.name, topics.join(", ")));
        let stop = exit::stop_when_interrupted();
        ros::run(&options, &floors, &calibration, stop, &|text| note(text))?;
        Ok(Outcome::Done)
    }

    fn options(&self, place: compass_core::PosePrior) -> Result<Options> {
        let topic = |name: &str| (!name.is_empty()).then(|| self.remapped(name));
        let topics = [topic(&self.cam0_topic), topic(&self.cam1_topic)];
        if topics == [None, None] {
            bail!("no topic of frames: name one with --cam0-topic or --cam1-topic");
        }
        if topics[0] == topics[1] {
            bail!("--cam1-topic {}: is that of cam0", self.cam1_topic);
        }
        if !(0.0..=1.0).contains(&self.min_probability) {
            bail!("--min-probability {}: expected 0 to 1", self.min_probability);
        }
        if !(0.0..=10.0).contains(&self.pair_within) {
            bail!("--pair-within {}: expected 0 to 10 s", self.pair_within);
        }
        Ok(Options {
            name: self.special("__node").unwrap_or_else(|| self.name.clone()),
            namespace: self.special("__ns").unwrap_or_else(|| self.namespace.clone()),
            domain: self.domain()?,
            topics,
            odometry: self.odom_topic.as_deref().and_then(topic),
            map_frame: self.map_frame.clone(),
            pair_within_ns: (self.pair_within * 1e9) as u64,
            initial_pose: self.initialpose,
            min_probability: self.min_probability,
            mount: self.mount.into(),
            heights: self.heights.prior(),
            place,
        })
    }

    fn domain(&self) -> Result<u16> {
        let told = || std::env::var("ROS_DOMAIN_ID").ok().filter(|text| !text.is_empty());
        let domain = match (self.domain, told()) {
            (Some(domain), _) => domain,
            (None, Some(text)) => {
                text.parse().with_context(|| format!("ROS_DOMAIN_ID={text}: is no number"))?
            }
            (None, None) => 0,
        };
        // Higher ones have no ports.
        if domain > 232 {
            bail!("domain {domain}: expected 0 to 232");
        }
        Ok(domain)
    }

    /// The name that a topic has outside.
    fn remapped(&self, name: &str) -> String {
        self.special(name).unwrap_or_else(|| name.to_owned())
    }

    fn special(&self, name: &str) -> Option<String> {
        let pairs = self.remap.iter().filter_map(|pair| pair.split_once(":="));
        pairs.filter(|(from, _)| *from == name).map(|(_, to)| to.to_owned()).next_back()
    }
}

/// The arguments with what stands behind `--ros-args` turned into options: `-p name:=value` and the parameters of
/// `--params-file` into `--name value`, `-r from:=to` into `--remap from:=to`.
pub(super) fn from_ros(arguments: impl IntoIterator<Item = String>) -> Result<Vec<String>> {
    let mut arguments = arguments.into_iter();
    let mut plain = Vec::new();
    let mut is_ros = false;
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--ros-args" => is_ros = true,
            "--" if is_ros => is_ros = false,
            _ if !is_ros => plain.push(argument),
            "-r" | "--remap" => plain.extend(["--remap".to_owned(), value(&argument, arguments.next())?]),
            "-p" | "--param" => {
                let pair = value(&argument, arguments.next())?;
                let Some((name, value)) = pair.split_once(":=") else {
                    bail!("{argument} {pair}: expected NAME:=VALUE");
                };
                parameter(name, value, &mut plain);
            }
            "--params-file" => {
                let path = PathBuf::from(value(&argument, arguments.next())?);
                for (name, value) in parameters::read(&path)? {
                    parameter(&name, &value, &mut plain);
                }
            }
            // What is said of logging has no meaning here.
            "--log-level" | "--log-config-file" => drop(arguments.next()),
            "--enable-rosout-logs"
            | "--disable-rosout-logs"
            | "--enable-stdout-logs"
            | "--disable-stdout-logs" => {}
            other => bail!("{other}: is none of the ROS arguments -r, -p, --params-file"),
        }
    }
    Ok(plain)
}

fn value(name: &str, value: Option<String>) -> Result<String> {
    value.with_context(|| format!("{name}: a value is missing"))
}

/// A parameter as an option: of a switch `true` sets it and `false` leaves it.
fn parameter(name: &str, value: &str, plain: &mut Vec<String>) {
    let option = format!("--{}", name.replace('_', "-"));
    match value {
        // Every node has it.
        _ if name == "use_sim_time" => {}
        "true" => plain.push(option),
        "false" => {}
        _ => plain.push(format!("{option}={value}")),
    }
}

/// Files of parameters.
mod parameters {
    use anyhow::{Context as _, Result};
    use compass_host::input;
    use serde::Deserialize;
    use std::collections::BTreeMap;
    use std::path::Path;

    #[derive(Deserialize)]
    struct OfNode {
        #[serde(rename = "ros__parameters")]
        parameters: BTreeMap<String, Value>,
    }

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Value {
        Switch(bool),
        Whole(i64),
        Number(f64),
        Text(String),
    }

    /// Names and values for all nodes that the file names.
    pub(super) fn read(path: &Path) -> Result<Vec<(String, String)>> {
        let name = || path.display().to_string();
        let text = String::from_utf8(input::read_whole(path).with_context(name)?).with_context(name)?;
        let nodes: BTreeMap<String, OfNode> = serde_saphyr::from_str(&text)
            .with_context(|| format!("{}: is no file of ROS parameters", path.display()))?;
        let all = nodes.into_values().flat_map(|node| node.parameters);
        let text = |value| match value {
            Value::Switch(value) => value.to_string(),
            Value::Whole(value) => value.to_string(),
            Value::Number(value) => value.to_string(),
            Value::Text(value) => value,
        };
        Ok(all.map(|(name, value)| (name, text(value))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(line: &str) -> Result<String> {
        from_ros(line.split(' ').map(str::to_owned)).map(|plain| plain.join(" "))
    }

    #[test]
    fn arguments_of_ros_become_options() {
        let line = "compass node --map a --ros-args -r __node:=b -p camera_height:=1.6 -p initialpose:=true -p x:=false --log-level info";
        assert_eq!(
            of(line).unwrap(),
            "compass node --map a --remap __node:=b --camera-height=1.6 --initialpose"
        );
        assert_eq!(
            of("compass node --ros-args -r a:=b -- --map c").unwrap(),
            "compass node --remap a:=b --map c"
        );
        for (line, named) in
            [("n --ros-args -p a=1", "NAME:=VALUE"), ("n --ros-args -r", "-r"), ("n --ros-args -z", "-z")]
        {
            assert!(of(line).unwrap_err().to_string().contains(named), "{line}");
        }
    }

    #[test]
    fn files_of_parameters_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("compass.yaml");
        std::fs::write(
            &path,
            "/**:\n  ros__parameters:\n    map: a.site\n    camera_height: 1.6\n    initialpose: true\n",
        )
        .unwrap();
        let line = format!("compass node --ros-args --params-file {}", path.display());
        assert_eq!(of(&line).unwrap(), "compass node --camera-height=1.6 --initialpose --map=a.site");
        std::fs::write(&path, "just text").unwrap();
        assert!(of(&line).unwrap_err().to_string().contains("is no file of ROS parameters"));
    }
}
