//! The float witness: each stage of `compass-core` again, in plain `f64`, written from the paper.
//!
//! Nothing here is fast or shared with the core; it is what the core is compared with.

pub mod descriptor;
pub mod march;
pub mod segments;
pub mod similarity;

pub use descriptor::descriptor;
pub use march::{Plan, Scan};
