//! The options that say what of a plan is inside.

use compass_host::interior::Places;

/// Where candidates are, if the plan does not show it.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct PlacesArgs {
    /// A point inside, in map metres: inside is what one can reach from it, and nothing else; may be repeated [default: the enclosed part of the plan]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    inside: Vec<[f64; 2]>,
    /// A rectangle in map metres: all that is free in it is inside, enclosed or not; may be repeated
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = rectangle, allow_hyphen_values = true)]
    region: Vec<[f64; 4]>,
}

impl PlacesArgs {
    pub(super) fn places(&self) -> Places {
        Places { points: self.inside.clone(), regions: self.region.clone() }
    }
}

/// Parses two finite numbers, `X,Y`.
pub(super) fn pair(text: &str) -> Result<[f64; 2], String> {
    numbers(text).ok_or_else(|| format!("'{text}' is not two numbers X,Y"))
}

/// Parses two opposite corners, `X0,Y0,X1,Y1`.
fn rectangle(text: &str) -> Result<[f64; 4], String> {
    numbers(text).ok_or_else(|| format!("'{text}' is not two opposite corners X0,Y0,X1,Y1"))
}

/// Exactly `N` finite numbers with commas between them.
pub(super) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |value: &str| value.trim().parse().ok().filter(|value: &f64| value.is_finite());
    let values: Option<Vec<f64>> = text.split(',').map(number).collect();
    values?.try_into().ok()
}
