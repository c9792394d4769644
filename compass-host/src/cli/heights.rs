//! What is known of the heights of camera and ceiling, as options.

use super::plan::{finite, pair};
use compass_core::HeightPrior;
use compass_core::base::ladder::HEIGHTS_M;

/// Least and greatest height of a ceiling above the floor, metres.
const CEILINGS_M: [f64; 2] = [1.0, 12.0];

/// What is known of the heights.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct HeightArgs {
    /// Height of cam0 above the floor in metres [default: estimated]
    #[arg(long, value_name = "M", value_parser = height, allow_hyphen_values = true)]
    pub(super) camera_height: Option<f32>,
    /// The ceiling is from A to B metres above the floor: for halls and garages, or a storey of known height [default:
    /// 2.15,3.7]
    #[arg(long, value_name = "A,B", value_parser = ceilings, allow_hyphen_values = true)]
    ceiling_between: Option<[f64; 2]>,
}

impl HeightArgs {
    /// The prior of the heights.
    pub(super) fn prior(&self) -> HeightPrior {
        let camera = self.camera_height.map_or(HeightPrior::UNKNOWN, HeightPrior::camera);
        match self.ceiling_between {
            Some(bounds) => camera.with_ceiling_between(bounds.map(|bound| bound as f32)),
            None => camera,
        }
    }
}

/// Parses a camera height within the supported range.
pub(super) fn height(text: &str) -> Result<f32, String> {
    let [least, most] = HEIGHTS_M;
    let metres = finite(text)? as f32;
    let good = (least..=most).contains(&metres);
    if good { Ok(metres) } else { Err(format!("expected {least} to {most} metres")) }
}

/// Parses bounds of the ceiling's height.
fn ceilings(text: &str) -> Result<[f64; 2], String> {
    let [least, most] = CEILINGS_M;
    let bounds = pair(text)?;
    let good = bounds[0] <= bounds[1] && bounds.iter().all(|bound| (least..=most).contains(bound));
    good.then_some(bounds)
        .ok_or_else(|| format!("'{text}' is not A,B of {least} to {most} m with A at most B"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_ordered_and_within_reach() {
        assert_eq!(ceilings("2.5, 6"), Ok([2.5, 6.0]));
        for wrong in ["6,2.5", "0.5,3", "2,13", "3", "a,b", "nan,3"] {
            assert!(ceilings(wrong).is_err(), "{wrong}");
        }
    }
}
