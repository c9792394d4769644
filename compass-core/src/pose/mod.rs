//! Maximum-likelihood localization: the poses of a site that explain an [`EvidenceTable`] best.
//!
//! The table holds log-likelihood ratios by direction, range and hit type. The score of a pose is the sum of the cells
//! that the rays cast from it meet.
//!
//! 1. [`Rows`] and [`search`] score every candidate of every [`FloorLayer`] at every heading.
//! 2. [`refine`] maximizes the score between the candidates, by a pattern search.
//! 3. [`select_alternatives`] keeps the best poses that are separated.
//!
//! [`locate`] runs these steps over unknown heights of camera and ceiling and gives a [`Fix`]; [`track`] filters a
//! sequence of frames; [`wall_check`] compares the evidence at a known pose with the plan.
//!
//! Scores are integers. A direction whose cells are 0 does not change any score.

mod alternatives;
mod blur;
mod covariance;
pub mod evidence;
mod fix;
mod headings;
pub mod heights;
pub mod locate;
mod parallax;
mod prior;
mod refine;
mod rows;
mod search;
pub mod track;
mod upright;
pub mod wall_check;

pub use crate::base::pose::ScoredPose;
pub use alternatives::{Alternatives, select_alternatives};
pub use covariance::Covariance;
pub use evidence::{EvidenceTable, HitEvidence, LIMIT, OPEN_PLANE, PLANES, plane_of};
pub use fix::{Fix, SURE, probability_of};
pub use headings::Headings;
pub use prior::PosePrior;
pub use refine::{MAX_CASTS, refine, refine_coarse, refine_final, refine_fine};
pub use rows::{Rows, Source};
pub use search::{FloorLayer, MAX_POOL, PoolEntry, Query, search};

#[cfg(test)]
pub(crate) mod tests;
