//! From a plan raster to the core's input: the packed plan and the site map.

mod build;
mod packed_plan;
mod place;

pub use build::{BuildError, BuildOptions, build, build_with_progress};
pub use packed_plan::{PackError, PackedPlan, ScanError};
pub use place::{metres, point, turn, wrapped};
