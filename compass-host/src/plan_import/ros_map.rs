//! The description file of a ROS `map_server` map.
//!
//! The fields `image`, `resolution`, `origin` (x, y, yaw), `negate` and `occupied_thresh` are required, as by
//! `map_server` itself; `free_thresh`, `mode` and others are ignored: what is not occupied is free here. Occupancy of
//! a pixel of value `v` is `(255 - v) / 255`, in a negated map `v / 255`; the pixel is occupied when that is above
//! `occupied_thresh`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::error::PlanImportError;
use crate::image_file::one_line;

/// Largest yaw treated as zero, in radians: across 100 m it shifts a map by less than 1 mm.
const YAW_SLACK: f64 = 1e-5;

/// The contents of a map description.
#[derive(Debug)]
pub(super) struct RosMap {
    /// Path of the image, resolved against the folder of the description.
    pub image: PathBuf,
    /// Metres per pixel, as written.
    pub resolution_m: f64,
    /// Position of the bottom-left pixel's outer corner, metres.
    pub origin: [f64; 2],
    /// Whether white is occupied.
    pub negate: bool,
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
    negate: Flag,
    occupied_thresh: f64,
}

/// `map_server` writes 0 or 1; its ROS 2 successor also accepts true or false.
#[derive(Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(u8),
}

/// Reads the description at `path` without opening the image.
pub(super) fn read(path: &Path) -> Result<RosMap, PlanImportError> {
    let yaml = |reason: String| PlanImportError::Yaml { path: path.to_path_buf(), reason };
    let bytes =
        std::fs::read(path).map_err(|source| PlanImportError::Read { path: path.to_path_buf(), source })?;
    let text = String::from_utf8(bytes).map_err(|_| yaml("not UTF-8 text".to_owned()))?;
    let fields: Fields = serde_saphyr::from_str(&text)
        .map_err(|error| yaml(one_line(&error.without_snippet().to_string())))?;
    let negate = match fields.negate {
        Flag::Bool(value) => value,
        Flag::Number(0) => false,
        Flag::Number(1) => true,
        Flag::Number(other) => return Err(refused(path, "negate", other.to_string(), "0 or 1 is needed")),
    };
    if !(0.0..1.0).contains(&fields.occupied_thresh) {
        let value = fields.occupied_thresh.to_string();
        return Err(refused(path, "occupied_thresh", value, "at least 0 and less than 1 is needed"));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(RosMap {
        image: folder.join(fields.image),
        resolution_m: fields.resolution,
        origin: position(path, &fields.origin)?,
        negate,
        occupied_thresh: fields.occupied_thresh,
    })
}

/// x and y of `origin`; a rotated map is rejected, since the masks are axis-aligned.
fn position(path: &Path, origin: &[f64]) -> Result<[f64; 2], PlanImportError> {
    let [x, y, yaw] = *origin else {
        return Err(refused(path, "origin", format!("{origin:?}"), "three numbers [x, y, yaw] are needed"));
    };
    // Negated comparison, so that NaN is rejected as well.
    if yaw.abs() <= YAW_SLACK {
        return Ok([x, y]);
    }
    Err(refused(path, "yaw of origin", yaw.to_string(), "only maps that are not turned (yaw 0) can be read"))
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
        assert_eq!((map.resolution_m, map.origin, map.negate), (0.05, [-1.5, 2.0], false));
        assert_eq!(map.dark_below(), 90, "(255 - 89) / 255 > 0.65 >= (255 - 90) / 255");
        assert!(parse(&GOOD.replace("negate: 0", "negate: true")).unwrap().negate);
        assert!(parse(&GOOD.replace("negate: 0", "negate: 1")).unwrap().negate);
        assert_eq!(parse(&GOOD.replace("0.65", "0")).unwrap().dark_below(), 255, "p = 0 is never above 0");
    }

    #[test]
    fn names_what_is_wrong_in_one_line() {
        assert!(complaint(&GOOD.replace("resolution: 0.05\n", "")).contains("resolution"));
        let message = complaint(&GOOD.replace("0.05", "fine"));
        assert!(message.contains("line 2"), "{message}");
        assert!(complaint(&GOOD.replace("2, 0]", "2]")).contains("origin is [-1.5, 2.0]"));
        assert!(complaint(&GOOD.replace("2, 0]", "2, 0.3]")).contains("yaw of origin is 0.3"));
        assert!(complaint(&GOOD.replace("2, 0]", "2, .nan]")).contains("yaw of origin is NaN"));
        assert!(complaint(&GOOD.replace("0.65", "1.5")).contains("occupied_thresh is 1.5"));
        assert!(complaint(&GOOD.replace("negate: 0", "negate: 7")).contains("negate is 7"));
        complaint("");
        complaint("just words");
        complaint("image: [unclosed");
    }
}
