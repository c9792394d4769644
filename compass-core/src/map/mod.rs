//! The building: packed floor plans, candidate positions, and the file of a site.

pub mod plan;
pub mod site;
pub mod site_map;
