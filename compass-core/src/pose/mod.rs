//! Which pose of the plan explains best what was seen: likelihood under a table of evidence.
//!
//! Whatever looks at the surroundings writes into a [`EvidenceTable`] how much, in each direction, it speaks for
//! a wall or a window at each range, or for nothing there. The likelihood of a pose is the sum over
//! its rays. Then
//!
//! 1. [`Rows`] and [`search`] score every candidate of every [`FloorLayer`] at every heading,
//! 2. [`refine`] climbs from the best of them to where between candidates the likelihood is highest,
//! 3. [`Answer`] keeps the best poses that lie apart.
//!
//! All of it is integer arithmetic; directions of which nothing is known change nothing.

mod answer;
pub mod evidence;
mod fix;
mod headings;
pub mod heights;
pub mod locate;
mod parallax;
mod refine;
mod rows;
mod search;
pub mod track;
pub mod wall_check;

pub use crate::base::pose::ScoredPose;
pub use answer::{Answer, answer};
pub use evidence::{EvidenceTable, LIMIT, OPEN_PLANE, PLANES, plane_of};
pub use fix::{Fix, SURE};
pub use headings::Headings;
pub use refine::{MAX_CASTS, refine, refine_coarse, refine_final, refine_fine};
pub use rows::Rows;
pub use search::{FloorLayer, MAX_POOL, PoolEntry, search};

#[cfg(test)]
pub(crate) mod tests;
