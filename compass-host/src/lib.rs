//! The host side of COMPASS.

pub mod figures;
pub mod report;
