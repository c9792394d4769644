//! The float reference: each stage of `compass-core` again, in plain `f64`, written from the paper and, for the
//! lenses, from their formulas.
//!
//! It is not optimized and shares nothing with the core, which is compared with it.

pub mod attitude;
pub mod boundary;
pub mod camera;
pub mod descriptor;
pub mod march;
pub mod segments;
pub mod similarity;

pub use descriptor::descriptor;
pub use march::{Plan, Scan};
