//! The up vector of a pair of frames: from the image, from an accelerometer, or from both.

use crate::dataset::imu::Gravity;
use crate::locator::{SeeError, Segmented, sky_is_above};
use compass_core::vision::attitude::{UpHint, Vertical};
use compass_core::vision::camera::Bearing;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Largest angle between the up vectors of image and IMU at which they agree, degrees.
const AGREEING_DEG: f64 = 10.0;

/// Smallest support times prior of a further vertical direction that is tried, as a share of those of the first.
const LEAST_SHARE: f32 = 0.5;

/// How cam0 is mounted: which side of its image is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mount {
    /// Not told: a site decides, and without one the windows: the sky is brighter than the ground.
    #[default]
    Auto,
    /// The top of the image is up.
    Upright,
    /// The bottom of the image is up.
    Inverted,
}

impl FromStr for Mount {
    type Err = String;

    /// The mount of a [name](Mount::name).
    fn from_str(name: &str) -> Result<Self, String> {
        let all = [Self::Auto, Self::Upright, Self::Inverted];
        let found = all.into_iter().find(|mount| mount.name() == name);
        found.ok_or_else(|| format!("{name:?} is not 'auto', 'upright' or 'inverted'"))
    }
}

impl Mount {
    /// Its name: `auto`, `upright` or `inverted`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Upright => "upright",
            Self::Inverted => "inverted",
        }
    }

    /// Approximate up vector in the axes of cam0; `None` if it is to be inferred from the windows.
    #[must_use]
    pub fn top(self) -> Option<Bearing> {
        let top = Bearing::new(0.0, -1.0, 0.0);
        match self {
            Self::Auto => None,
            Self::Upright => Some(top),
            Self::Inverted => Some(-top),
        }
    }

    fn hint(self) -> UpHint {
        self.top().map_or(UpHint::Axis(-Bearing::y()), UpHint::Up)
    }

    /// The up vector of frames, searched near the vertical axis of cam0's image.
    ///
    /// # Errors
    /// [`SeeError::NoVertical`] if too few segments agree; [`SeeError::NoSky`].
    pub fn vertical(self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Vertical, SeeError> {
        let mut vertical = segmented.vertical(self.hint())?;
        if self == Self::Auto && !sky_is_above(segmented, &vertical.up)?.ok_or(SeeError::NoSky)? {
            vertical.up = -vertical.up;
        }
        Ok(vertical)
    }

    /// The directions that may be up, for the plan of a site to [choose](crate::up_by_plan::locate_by_plan) from: the
    /// vertical one, others that are nearly as likely, and the opposite of each where the mounting is not told.
    ///
    /// # Errors
    /// [`SeeError::NoVertical`] if too few segments agree.
    pub fn candidates(self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Vec<Bearing>, SeeError> {
        let hint = self.hint();
        let found = segmented.verticals(hint);
        let rank = |vertical: &Vertical| vertical.support * hint.prior(&vertical.up);
        let least = LEAST_SHARE * rank(found.first().ok_or(SeeError::NoVertical)?);
        let likely = found.iter().filter(|vertical| rank(vertical) >= least).map(|vertical| vertical.up);
        if self != Self::Auto {
            return Ok(likely.collect());
        }
        Ok(likely.flat_map(|up| [up, -up]).collect())
    }
}

/// The source of an up vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpFrom {
    /// Vertical lines.
    #[default]
    Image,
    /// The accelerometer.
    Imu,
    /// The vertical lines near where the accelerometer says.
    Both,
}

impl UpFrom {
    /// The name used in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Image => "image",
            Self::Imu => "imu",
            Self::Both => "both",
        }
    }
}

/// How to determine the up vector.
#[derive(Debug, Clone, Copy)]
pub struct UpSources {
    /// Image, IMU or both.
    pub from: UpFrom,
    /// Which side of cam0's image is up; the IMU overrules it.
    pub mount: Mount,
    /// The IMU's up vector in the axes of cam0; without it the image decides.
    pub imu: Option<Gravity>,
}

impl UpSources {
    /// Approximate up vector in cam0, as far as it is known without the image.
    #[must_use]
    pub fn hint(&self) -> Option<Bearing> {
        match (self.from, self.imu) {
            (UpFrom::Imu | UpFrom::Both, Some(gravity)) => Some(gravity.up.cast()),
            _ => self.mount.top(),
        }
    }

    /// The up vector in cam0 of frames, and its source.
    ///
    /// # Errors
    /// [`SeeError::Disagreement`] of image and IMU; from the image alone, as [`Mount::vertical`].
    pub fn resolve(&self, segmented: &mut Segmented<'_, '_, '_>) -> Result<(Bearing, UpFrom), SeeError> {
        match (self.from, self.imu) {
            (UpFrom::Imu, Some(gravity)) => Ok((gravity.up.cast(), UpFrom::Imu)),
            (UpFrom::Both, Some(gravity)) => match self.vertical(segmented) {
                Ok(vertical) => self.check(&vertical).map(|()| (vertical.up, UpFrom::Both)),
                // Without vertical lines in view, gravity still gives the up vector.
                Err(SeeError::NoVertical) => Ok((gravity.up.cast(), UpFrom::Imu)),
                Err(error) => Err(error),
            },
            _ => Ok((self.vertical(segmented)?.up, UpFrom::Image)),
        }
    }

    /// The directions in cam0 that may be up, and their source: one, or from the image alone those of
    /// [`Mount::candidates`].
    ///
    /// # Errors
    /// As [`Self::resolve`], without [`SeeError::NoSky`].
    pub fn candidates(
        &self,
        segmented: &mut Segmented<'_, '_, '_>,
    ) -> Result<(Vec<Bearing>, UpFrom), SeeError> {
        match (self.from, self.imu) {
            (UpFrom::Imu | UpFrom::Both, Some(_)) => {
                self.resolve(segmented).map(|(up, from)| (vec![up], from))
            }
            _ => Ok((self.mount.candidates(segmented)?, UpFrom::Image)),
        }
    }

    /// The image's up vector, searched near the IMU's if both are used.
    ///
    /// # Errors
    /// As [`Mount::vertical`].
    pub fn vertical(&self, segmented: &mut Segmented<'_, '_, '_>) -> Result<Vertical, SeeError> {
        match (self.from, self.imu) {
            (UpFrom::Imu | UpFrom::Both, Some(gravity)) => near(segmented, gravity.up.cast()),
            _ => self.mount.vertical(segmented),
        }
    }

    /// The angle between the up vectors of image and IMU, degrees.
    #[must_use]
    pub fn apart_deg(&self, vertical: &Vertical) -> Option<f64> {
        let imu = self.imu?.up;
        let image = vertical.up.cast::<f64>().normalize();
        Some(imu.cross(&image).norm().atan2(imu.dot(&image)).to_degrees())
    }

    /// Refuses an up vector on which image and IMU disagree, if both are used.
    ///
    /// # Errors
    /// [`SeeError::Disagreement`].
    pub fn check(&self, vertical: &Vertical) -> Result<(), SeeError> {
        let apart =
            self.apart_deg(vertical).filter(|apart| self.from == UpFrom::Both && *apart > AGREEING_DEG);
        apart.map_or(Ok(()), |apart| Err(SeeError::Disagreement(apart)))
    }
}

/// The image's vertical near this direction, or else near the image's own top or bottom, so that a grossly wrong IMU
/// is detected.
fn near(segmented: &mut Segmented<'_, '_, '_>, up: Bearing) -> Result<Vertical, SeeError> {
    segmented.vertical(UpHint::Up(up)).map_err(SeeError::from).or_else(|_| {
        let mut vertical = segmented.vertical(UpHint::Axis(Bearing::y()))?;
        if vertical.up.dot(&up) < 0.0 {
            vertical.up = -vertical.up;
        }
        Ok(vertical)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mount_is_found_by_its_name_alone() {
        for mount in [Mount::Auto, Mount::Upright, Mount::Inverted] {
            assert_eq!(mount.name().parse(), Ok(mount));
        }
        let refused = "Upright".parse::<Mount>();
        assert_eq!(refused, Err("\"Upright\" is not 'auto', 'upright' or 'inverted'".to_owned()));
    }
}
