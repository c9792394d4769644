//! Which topics of a bag are the cameras and the IMU.

use crate::calibration::Calibration;
use std::str::FromStr;

/// The topics of cam0, cam1 and the IMU; `None` for one that is not used.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Topics {
    /// Topics of cam0 and cam1.
    pub cameras: [Option<String>; 2],
    /// Topic of the IMU.
    pub imu: Option<String>,
}

impl FromStr for Topics {
    type Err = String;

    /// Parses `CAM0,CAM1,IMU`; an empty or omitted part is not used.
    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<_> = text.split(',').map(str::trim).collect();
        let name = |at: usize| names.get(at).filter(|name| !name.is_empty()).map(|name| (*name).to_owned());
        let topics = Self { cameras: [name(0), name(1)], imu: name(2) };
        match topics.cameras.iter().all(Option::is_none) || names.len() > 3 {
            true => Err("expected CAM0,CAM1 or CAM0,CAM1,IMU; one camera may be left empty".to_owned()),
            false => Ok(topics),
        }
    }
}

impl std::fmt::Display for Topics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let named = ["cam0", "cam1", "IMU"].into_iter().zip(self.cameras.iter().chain([&self.imu]));
        let named = named.filter_map(|(what, topic)| Some(format!("{what} {}", topic.as_ref()?)));
        f.write_str(&named.collect::<Vec<_>>().join(", "))
    }
}

impl From<&Calibration> for Topics {
    /// The topics that a calibration names.
    fn from(calibration: &Calibration) -> Self {
        let camera = |number: usize| calibration.cameras[number].as_ref()?.topic.clone();
        Self { cameras: [camera(0), camera(1)], imu: calibration.imu_topic.clone() }
    }
}
