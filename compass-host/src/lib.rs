//! The host side of COMPASS: plans and datasets in, site maps, poses, figures and reports out, and the
//! float reference that `compass-core` is checked against.

pub mod calibration;
pub mod clock;
pub mod compare;
pub mod cross_modal;
pub mod dataset;
pub mod evaluate;
pub mod eyes;
pub mod figures;
pub mod frame;
pub mod image_file;
pub mod interior;
pub mod localizer;
pub mod locator;
pub mod noise;
pub mod output;
pub mod paper_finder;
pub mod plan_descriptor;
pub mod plan_import;
pub mod progress;
pub mod reference;
pub mod report;
pub mod sample;
pub mod simulate;
pub mod site;
pub mod site_file;
pub mod up;
pub mod visual_descriptor;
pub mod wall_check;
mod wide;
