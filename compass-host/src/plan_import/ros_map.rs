//! The description file of a ROS `map_server` map.
//!
//! The fields `image`, `resolution`, `origin` (x, y, yaw) and `occupied_thresh` are required, as by `map_server` itself;
//! `negate` is false and `mode` is trinary unless they say otherwise; `free_thresh` and others are ignored: what is not
//! occupied is free here. Occupancy of a pixel whose channels have the mean `v` is `(255 - v) / 255`, in a negated map
//! `v / 255`, in mode raw `v / 100` up to 1; the pixel is occupied when that is above `occupied_thresh`.

use crate::input;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::error::PlanImportError;
use super::ink::Tone;
use crate::image_file::one_line;

/// The contents of a map description.
#[derive(Debug)]
pub(super) struct RosMap {
    /// Path of the image, resolved against the folder of the description.
    pub image: PathBuf,
    /// Metres per pixel, as written.
    pub resolution_m: f64,
    /// Position of the bottom-left pixel's outer corner, metres.
    pub origin: [f64; 2],
    /// Turn about that corner, radians counter-clockwise.
    pub yaw: f64,
    /// How its gray levels are read.
    pub tone: Tone,
    /// The image as it is named, where one beside the description stands for it.
    pub named: Option<PathBuf>,
    /// Whether the image is named outside of the description's folder.
    pub is_elsewhere: bool,
    /// Occupancy above which a pixel is occupied.
    pub occupied_thresh: f64,
}

impl RosMap {
    /// The lowest darkness (value, or 255 - value in a negated map) that is not occupied.
    pub(super) fn dark_below(&self) -> u16 {
        let occupied = |v: &u16| f64::from(255 - *v) / 255.0 > self.occupied_thresh;
        (0..=255_u16).find(|v| !occupied(v)).unwrap_or(256)
    }
}

#[derive(Deserialize)]
struct Fields {
    image: PathBuf,
    resolution: f64,
    origin: Vec<f64>,
    negate: Option<Flag>,
    occupied_thresh: f64,
    mode: Option<String>,
}

/// `map_server` writes 0 or 1; its ROS 2 successor also accepts true or false, and both in quotes.
#[derive(Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(f64),
    Text(String),
    Other(serde::de::IgnoredAny),
}

impl Flag {
    fn is_set(&self) -> Result<bool, String> {
        let shown = match self {
            Self::Bool(value) => return Ok(*value),
            Self::Number(value) => value.to_string(),
            Self::Text(text) => text.to_lowercase(),
            Self::Other(_) => "a list or a mapping".to_owned(),
        };
        match shown.as_str() {
            "0" | "false" => Ok(false),
            "1" | "true" => Ok(true),
            _ => Err(shown),
        }
    }
}

/// Reads the description at `path` without opening the image.
pub(super) fn read(path: &Path) -> Result<RosMap, PlanImportError> {
    let yaml = |reason: String| PlanImportError::Yaml { path: path.to_path_buf(), reason };
    let bytes = input::read(path, input::limits().settings_bytes)
        .map_err(|source| PlanImportError::Read { path: path.to_path_buf(), source })?;
    let text = String::from_utf8(bytes).map_err(|_| yaml("not UTF-8 text".to_owned()))?;
    let fields: Fields = serde_saphyr::from_str(&text)
        .map_err(|error| yaml(one_line(&error.without_snippet().to_string())))?;
    let negate = fields.negate.as_ref().map_or(Ok(false), Flag::is_set);
    let negate = negate.map_err(|other| refused(path, "negate", other, "0 or 1 is needed"))?;
    if !(0.0..1.0).contains(&fields.occupied_thresh) {
        let value = fields.occupied_thresh.to_string();
        return Err(refused(path, "occupied_thresh", value, "at least 0 and less than 1 is needed"));
    }
    let tone = match fields.mode.as_deref() {
        None | Some("trinary" | "scale") if negate => Tone::Negative,
        None | Some("trinary" | "scale") => Tone::Positive,
        Some("raw") => Tone::Raw { from: (100.0 * fields.occupied_thresh).floor() as u8 + 1 },
        Some(other) => {
            return Err(refused(path, "mode", other.to_owned(), "trinary, scale or raw is needed"));
        }
    };
    let [x, y, yaw] = *fields.origin else {
        let value = format!("{:?}", fields.origin);
        return Err(refused(path, "origin", value, "three numbers [x, y, yaw] are needed"));
    };
    if !yaw.is_finite() {
        return Err(refused(path, "yaw of origin", yaw.to_string(), "a finite angle in radians is needed"));
    }
    let is_within = input::is_within(&fields.image);
    let (image, named) = image_of(path, fields.image);
    Ok(RosMap {
        image,
        is_elsewhere: named.is_none() && !is_within,
        named,
        resolution_m: fields.resolution,
        origin: [x, y],
        yaw,
        tone,
        occupied_thresh: fields.occupied_thresh,
    })
}

/// The image, against the folder of the description. A map that was moved may name the image of another machine: then one of
/// that name beside the description stands for it, and the name comes with it.
fn image_of(description: &Path, named: PathBuf) -> (PathBuf, Option<PathBuf>) {
    let folder = description.parent().unwrap_or(Path::new(""));
    let image = folder.join(&named);
    let beside = named.file_name().map(|name| folder.join(name));
    match beside {
        Some(beside) if !input::exists(&image) && input::exists(&beside) => (beside, Some(named)),
        _ => (image, None),
    }
}

fn refused(path: &Path, field: &'static str, value: String, wanted: &'static str) -> PlanImportError {
    PlanImportError::Value { path: path.to_path_buf(), field, value, wanted }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "image: a.pgm\nresolution: 0.05\norigin: [-1.5, 2, 0]\nnegate: 0\n\
                        occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n";

    fn parse(text: &str) -> Result<RosMap, PlanImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.yaml");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    fn complaint(text: &str) -> String {
        let message = parse(text).unwrap_err().to_string();
        assert!(message.contains("map.yaml: ") && !message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn reads_a_map_server_description() {
        let map = parse(GOOD).unwrap();
        assert!(map.image.ends_with("a.pgm") && map.image.is_absolute(), "beside the yaml: {:?}", map.image);
        assert_eq!((map.resolution_m, map.origin, map.yaw), (0.05, [-1.5, 2.0], 0.0));
        assert_eq!(map.dark_below(), 90, "(255 - 89) / 255 > 0.65 >= (255 - 90) / 255");
        assert_eq!(map.tone, Tone::Positive);
        for (negate, tone) in [
            ("true", Tone::Negative),
            ("1", Tone::Negative),
            ("\"1\"", Tone::Negative),
            ("\"0\"", Tone::Positive),
            ("'False'", Tone::Positive),
        ] {
            let text = GOOD.replace("negate: 0", &format!("negate: {negate}"));
            assert_eq!(parse(&text).unwrap().tone, tone, "{negate}");
        }
        assert_eq!(parse(&GOOD.replace("negate: 0\n", "")).unwrap().tone, Tone::Positive);
        assert_eq!(parse(&GOOD.replace("trinary", "raw")).unwrap().tone, Tone::Raw { from: 66 });
        assert_eq!(parse(&GOOD.replace("mode: trinary\n", "")).unwrap().tone, Tone::Positive);
        assert_eq!(parse(&GOOD.replace("0.65", "0")).unwrap().dark_below(), 255, "p = 0 is never above 0");
    }

    #[test]
    fn names_what_is_wrong_in_one_line() {
        assert!(complaint(&GOOD.replace("resolution: 0.05\n", "")).contains("resolution"));
        let message = complaint(&GOOD.replace("0.05", "fine"));
        assert!(message.contains("line 2"), "{message}");
        assert!(complaint(&GOOD.replace("2, 0]", "2]")).contains("origin is [-1.5, 2.0]"));
        assert!(complaint(&GOOD.replace("trinary", "fancy")).contains("mode is fancy"));
        assert!(complaint(&GOOD.replace("negate: 0", "negate: [0]")).contains("negate is a list"));
        assert!(complaint(&GOOD.replace("2, 0]", "2, .nan]")).contains("yaw of origin is NaN"));
        assert!(complaint(&GOOD.replace("0.65", "1.5")).contains("occupied_thresh is 1.5"));
        assert!(complaint(&GOOD.replace("negate: 0", "negate: 7")).contains("negate is 7"));
        complaint("");
        complaint("just words");
        complaint("image: [unclosed");
    }
}
