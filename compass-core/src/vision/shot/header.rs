//! What a shot says beside its images.

use super::error::ShotError;
use crate::base::ladder::HEIGHTS_M;
use crate::vision::camera::{Bearing, Camera, Rig, View};

/// Metadata of a shot: all but its images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// Time stamp, nanoseconds since an arbitrary epoch.
    pub time_ns: i64,
    /// The cameras, at the resolution of the images.
    pub rig: Rig,
    /// Approximate up vector in camera 0, of any length above 0.
    pub up: Bearing,
    /// Height of camera 0 above the floor in metres, within [`HEIGHTS_M`], if it is known.
    pub height_m: Option<f32>,
}

impl Header {
    pub(super) fn check(&self) -> Result<(), ShotError> {
        let length = self.up.norm_squared();
        if !(length > 0.0 && length.is_finite()) {
            return Err(ShotError::Up);
        }
        let has_omni = |(_, view): &(usize, &View)| matches!(view.camera, Camera::Omni(_));
        if let Some((camera, _)) = self.rig.views().find(has_omni) {
            return Err(ShotError::LensParameters(camera));
        }
        let [least, most] = HEIGHTS_M;
        let good = self.height_m.is_none_or(|height| (least..=most).contains(&height));
        if good { Ok(()) } else { Err(ShotError::Height) }
    }
}
