//! Search over candidates and headings by the score of [`similarity`](crate::descriptor::similarity).
//!
//! - [`exhaustive`] uses an [`Index`] (701 bytes of RAM per candidate). The first 32 harmonics of a candidate bound its
//!   score from above; candidates whose bound reaches the best score so far are scored exactly (branch and bound). The
//!   best match is that of scoring all candidates at all headings.
//! - [`shortlist`] reads the map alone. It ranks candidates by their sketches and scores the best exactly. The best match
//!   can be missed if its sketch ranks low.
//!
//! Both can first reject candidates by the distance of their transition signature from that of the query.

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
