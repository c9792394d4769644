//! The host side of COMPASS.

pub mod figures;
pub mod interior;
pub mod plan_import;
pub mod report;
pub mod sample;
