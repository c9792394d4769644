//! Search over candidates and headings.
//!
//! Two ways to the same score ([`crate::descriptor::similarity`]):
//!
//! - [`exhaustive`] on an [`Index`] (701 bytes of RAM per candidate): every candidate is bounded from
//!   above by its first 32 harmonics, and only what could still win is scored exactly. The answer is
//!   the one that scoring everything would give.
//! - [`shortlist`] straight from the map in flash: candidates are ranked by their sketches and the
//!   best are scored exactly. The answer may miss what its sketch hides.
//!
//! Both can leave out candidates beforehand whose transition signature is far from the query's.

mod answer;
mod exact;
mod index;
mod lanes;
mod prefilter;
mod shortlist;

pub use answer::{Answer, MAX_ALTERNATIVES, Match};
pub use exact::{Exact, exhaustive};
pub use index::{GROUP, Group, Index};
pub use prefilter::nearest_signatures;
pub use shortlist::{Board, shortlist};
