//! What is known of the pose before the frames are looked at, as options.

use super::plan::finite;
use anyhow::{Result, anyhow};
use compass_core::PosePrior;
use compass_core::pose::FloorLayer;
use compass_host::output::Decimal;
use compass_host::{KnownPose, KnownPoseError};
use serde::Serialize;
use std::path::Path;

/// What is known of the pose. It restricts the search of `localize`; other commands with frames take and ignore it.
#[derive(Debug, Clone, Default, clap::Args)]
pub(super) struct PlaceArgs {
    /// The position is at most RADIUS metres from X,Y [default: anywhere on the site]
    #[arg(long, value_name = "X,Y,RADIUS", value_parser = disc, allow_hyphen_values = true)]
    near: Option<[f64; 3]>,
    /// The heading is at most WIDTH degrees from DEG, to either side [default: any]
    #[arg(long, value_name = "DEG,WIDTH", value_parser = sector, allow_hyphen_values = true)]
    heading_near: Option<[f64; 2]>,
    /// The pose is on this floor of the site [default: any]
    #[arg(long, value_name = "NAME")]
    floor: Option<String>,
}

/// The same in the JSON result.
#[derive(Debug, Serialize)]
pub(super) struct PriorOutput {
    #[serde(skip_serializing_if = "Option::is_none")]
    near: Option<[Decimal; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading_near: Option<[Decimal; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    floor: Option<String>,
}

impl PlaceArgs {
    /// The prior on the layers of a site.
    pub(super) fn prior(&self, map: &Path, layers: &[FloorLayer<'_>]) -> Result<PosePrior> {
        let Self { near, heading_near, floor } = self;
        let known = KnownPose { near: *near, heading_near: *heading_near, floor: floor.clone() };
        known.prior(layers).map_err(|error| match (&error, near, floor) {
            (KnownPoseError::Near, Some([x, y, radius]), _) => {
                anyhow!("--near {x},{y},{radius}: beyond the range of map coordinates")
            }
            (KnownPoseError::Floor { there }, _, Some(name)) => {
                anyhow!("--floor {name}: {} has no floor of this name, but {there}", map.display())
            }
            _ => anyhow!("--heading-near: {error}"),
        })
    }

    /// For the result; `None` if nothing is known.
    pub(super) fn output(&self) -> Option<PriorOutput> {
        let Self { near, heading_near, floor } = self;
        let is_known = near.is_some() || heading_near.is_some() || floor.is_some();
        is_known.then(|| PriorOutput {
            near: near.map(|values| values.map(Decimal)),
            heading_near: heading_near.map(|values| values.map(Decimal)),
            floor: floor.clone(),
        })
    }

    /// In words, for the summary and the reason of "I don't know"; `None` if nothing is known.
    pub(super) fn words(&self) -> Option<String> {
        let near = self.near.map(|[x, y, radius]| format!("within {radius} m of {x}, {y}"));
        let heading = self.heading_near.map(|[middle, width]| format!("heading {middle} +- {width} degrees"));
        let floor = self.floor.as_ref().map(|name| format!("on floor {name}"));
        let parts: Vec<_> = [near, heading, floor].into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// Parses `X,Y,RADIUS`.
fn disc(text: &str) -> Result<[f64; 3], String> {
    match numbers(text)[..] {
        [x, y, radius] if radius > 0.0 => Ok([x, y, radius]),
        _ => Err(format!("'{text}' is not X,Y,RADIUS in metres with a RADIUS above 0")),
    }
}

/// Parses `DEG,WIDTH`.
fn sector(text: &str) -> Result<[f64; 2], String> {
    match numbers(text)[..] {
        [middle, width] if width > 0.0 => Ok([middle, width]),
        _ => Err(format!("'{text}' is not DEG,WIDTH in degrees with a WIDTH above 0")),
    }
}

/// Finite numbers between commas; empty if one is none.
fn numbers(text: &str) -> Vec<f64> {
    text.split(',').map(|part| finite(part.trim())).collect::<Result<_, _>>().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_and_a_sector_have_a_size() {
        assert_eq!(disc("1, -2,3"), Ok([1.0, -2.0, 3.0]));
        assert_eq!(sector("-90,20"), Ok([-90.0, 20.0]));
        for wrong in ["1,2", "1,2,0", "1,2,-3", "1,2,nan", "a,b,c", ""] {
            assert!(disc(wrong).unwrap_err().contains("X,Y,RADIUS"), "{wrong}");
        }
        for wrong in ["1", "1,0", "1,2,3", "inf,1"] {
            assert!(sector(wrong).unwrap_err().contains("DEG,WIDTH"), "{wrong}");
        }
    }
}
