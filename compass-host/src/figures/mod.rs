//! The plan-side pictures of a report, as PNG files fit for print at page width.
//!
//! Every figure is one function, `draw_…(path, plain data)`. All share one page layout (caption
//! above, legend below, never over the data), one font that is compiled in, and one colour-blind
//! safe palette in which wall, window and open keep their colours from figure to figure.
//! A file appears only when it is complete.

mod axes;
mod canvas;
mod correlation;
mod descriptor;
mod error;
mod errors;
mod hits;
mod overlay;
mod page;
mod panorama;
mod plan;
mod plan_survey;
mod polar;
mod profile;
mod rays;
mod ring;
mod seen;
mod site_map;
mod style;
mod text;
mod timeline;
mod trajectory;
mod wall_check;

pub use correlation::{Curve, Shifts, draw_correlation};
pub use descriptor::{draw_descriptor, draw_descriptors};
pub use error::FigureError;
pub use errors::{ErrorSeries, draw_error_cdf};
pub use hits::{HitComparison, draw_hits_linear, draw_hits_polar};
pub use overlay::{Layer, draw_overlay};
pub use panorama::{PanoramaPicture, draw_panorama};
pub use plan::{PlanPicture, with_packed_plan};
pub use plan_survey::{PlanSurveyPicture, Property, draw_plan_survey};
pub use polar::draw_polar;
pub use profile::draw_profile;
pub use rays::draw_rays;
pub use ring::{RingPicture, draw_ring};
pub use seen::draw_seen;
pub use site_map::{MapPose, Scores, SiteMapPicture, draw_site_map};
pub use style::{AGREE, DISAGREE, OPEN, WALL, WIDTH_PX, WINDOW};
pub use timeline::{ErrorCurve, draw_errors_over_time, draw_reliability};
pub use trajectory::{Fix, TrajectoryPicture, draw_trajectory};
pub use wall_check::draw_wall_check;

#[cfg(test)]
mod tests;
