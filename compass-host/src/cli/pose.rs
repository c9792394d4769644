//! Poses and times in the JSON results.

use compass_core::descriptor::matching::Match;
use compass_core::map::site_map::SiteMap;
use compass_host::clock::Clock;
use compass_host::output::{Decimal, Variance};
use compass_host::site::wrapped;
use serde::Serialize;
use std::collections::BTreeMap;

/// A pose with its score.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Pose<'a> {
    /// Name of the floor, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) floor: Option<&'a str>,
    pub(super) x: Decimal,
    pub(super) y: Decimal,
    pub(super) heading_deg: Decimal,
    pub(super) score: Decimal,
    /// Of x, y and heading: m2, m rad and rad2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) covariance: Option<[[Variance; 3]; 3]>,
}

/// A covariance in the JSON result.
pub(super) fn covariance(rows: [[f32; 3]; 3]) -> [[Variance; 3]; 3] {
    rows.map(|row| row.map(|value| Variance(f64::from(value))))
}

impl<'a> Pose<'a> {
    pub(super) fn of(found: &Match, map: &SiteMap<'_>, floor: Option<&'a str>) -> Self {
        let at = map.position(found.candidate as usize).unwrap_or_default();
        Self {
            floor,
            x: Decimal(at.x.to_num()),
            y: Decimal(at.y.to_num()),
            heading_deg: Decimal(f64::from(found.peak.shift)),
            score: Decimal(found.peak.score().to_num()),
            covariance: None,
        }
    }

    /// Distance in metres and angle in degrees from a true pose.
    pub(super) fn error(&self, at: [f64; 2], heading_deg: f64) -> (f64, f64) {
        let turn = wrapped(self.heading_deg.0 - heading_deg);
        ((self.x.0 - at[0]).hypot(self.y.0 - at[1]), turn.abs())
    }
}

/// Milliseconds by stage.
pub(super) fn milliseconds(clock: &Clock) -> BTreeMap<&'static str, Decimal> {
    clock.stages().iter().map(|(stage, ms)| (*stage, Decimal(*ms))).collect()
}
