//! What is known of the pose before the frames are looked at, as people say it: metres, degrees and the name of a floor.

use crate::site::{metres, point, turn};
use compass_core::pose::FloorLayer;
use compass_core::{PosePrior, Turn};
use thiserror::Error;

/// What is known of the pose; it restricts the search.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KnownPose {
    /// The position is at most a radius from x, y: metres.
    pub near: Option<[f64; 3]>,
    /// The heading is at most a width from this one, to either side: degrees.
    pub heading_near: Option<[f64; 2]>,
    /// The pose is on the floor of this name.
    pub floor: Option<String>,
}

/// Why nothing can be searched with what is known.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum KnownPoseError {
    /// A position is no place of a map, or its radius is none.
    #[error("not x, y and a radius above 0, in metres within the range of map coordinates")]
    Near,
    /// A heading or a width is no angle.
    #[error("not a heading and a width above 0, in degrees")]
    HeadingNear,
    /// The site has no such floor.
    #[error("no floor of this name, but {there}")]
    Floor {
        /// The floors that it has.
        there: String,
    },
}

impl KnownPose {
    /// The prior on the layers of a site.
    ///
    /// # Errors
    /// [`KnownPoseError`] names the field that is wrong.
    pub fn prior(&self, layers: &[FloorLayer<'_>]) -> Result<PosePrior, KnownPoseError> {
        let mut prior = PosePrior::UNKNOWN;
        if let Some([x, y, radius]) = self.near {
            let place = point(x, y).zip(metres(radius).filter(|_| radius > 0.0));
            let (at, radius) = place.ok_or(KnownPoseError::Near)?;
            prior = prior.near(at, radius);
        }
        if let Some([degrees, width]) = self.heading_near {
            if !(degrees.is_finite() && width.is_finite() && width > 0.0) {
                return Err(KnownPoseError::HeadingNear);
            }
            // From 180 degrees on it is no restriction.
            let width = if width < 180.0 { turn(width) } else { Turn::from_bits(u32::MAX) };
            prior = prior.heading_near(turn(degrees), width);
        }
        if let Some(name) = &self.floor {
            let found = layers.iter().find(|layer| layer.name == name);
            let missing = || {
                let mut names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
                names.dedup();
                KnownPoseError::Floor { there: names.join(", ") }
            };
            prior = prior.on_floor(found.ok_or_else(missing)?.floor);
        }
        Ok(prior)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_place_and_no_angle_is_refused() {
        let of = |near, heading_near| KnownPose { near, heading_near, floor: None }.prior(&[]);
        assert_eq!(of(None, None), Ok(PosePrior::UNKNOWN));
        assert!(of(Some([1.0, -2.0, 3.0]), Some([-90.0, 200.0])).is_ok());
        for near in [[1e300, 2.0, 3.0], [f64::NAN, 2.0, 3.0], [1.0, 2.0, 0.0], [1.0, 2.0, f64::INFINITY]] {
            assert_eq!(of(Some(near), None), Err(KnownPoseError::Near), "{near:?}");
        }
        for heading in [[f64::NAN, 2.0], [1.0, 0.0], [1.0, -2.0], [f64::INFINITY, 2.0]] {
            assert_eq!(of(None, Some(heading)), Err(KnownPoseError::HeadingNear), "{heading:?}");
        }
        let attic = KnownPose { floor: Some("attic".to_owned()), ..KnownPose::default() };
        assert_eq!(attic.prior(&[]), Err(KnownPoseError::Floor { there: String::new() }));
    }
}
