//! Which pose of the plan explains best what was seen: likelihood under a table of evidence.
//!
//! Whatever looks at the surroundings writes into a [`Table`] how much, in each direction, it speaks for
//! a wall or a window at each range, or for nothing there. The likelihood of a pose is the sum over
//! its rays. Then
//!
//! 1. [`Rows`] and [`search`] score every candidate of every [`Sheet`] at every heading,
//! 2. [`refine`] climbs from the best of them to where between candidates the likelihood is highest,
//! 3. [`Answer`] keeps the best poses that lie apart.
//!
//! All of it is integer arithmetic; directions of which nothing is known change nothing.

mod answer;
mod parallax;
mod refine;
mod rows;
mod search;
mod table;

pub use answer::{Answer, answer};
pub use refine::{MAX_CASTS, approach, polish, refine, settle};
pub use rows::Rows;
pub use search::{Mode, Sheet, search};
pub use table::{LIMIT, OPEN_PLANE, PLANES, RANGES, RUNG_MM, Table, plane_of};

#[cfg(test)]
pub(crate) mod tests;
