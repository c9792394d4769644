//! Which cameras of a calibration are used, in which role.

use std::str::FromStr;

/// The cameras of a file in the roles of cam0 and cam1; `None` for a role without one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraNames(pub [Option<String>; 2]);

impl Default for CameraNames {
    fn default() -> Self {
        Self(["cam0", "cam1"].map(|name| Some(name.to_owned())))
    }
}

impl FromStr for CameraNames {
    type Err = String;

    /// Parses `CAMERA` or `CAMERA,CAMERA`; one may be left empty.
    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<_> = text.split(',').map(str::trim).collect();
        let name = |at: usize| names.get(at).filter(|name| !name.is_empty()).map(|name| (*name).to_owned());
        let pair = [name(0), name(1)];
        match pair.iter().all(Option::is_none) || names.len() > 2 || pair[0].is_some() && pair[0] == pair[1] {
            true => Err("expected one or two cameras of the calibration, such as cam0,cam2".to_owned()),
            false => Ok(Self(pair)),
        }
    }
}
