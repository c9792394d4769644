//! The float witness: each stage of `compass-core` again, in plain `f64`, written from the paper
//! and, for the lenses, from their formulas.
//!
//! Nothing here is fast or shared with the core; it is what the core is compared with.

pub mod attitude;
pub mod boundary;
pub mod camera;
pub mod descriptor;
pub mod march;
pub mod segments;
pub mod similarity;

pub use descriptor::descriptor;
pub use march::{Plan, Scan};
