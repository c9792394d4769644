//! The host side of COMPASS: plans and recordings in, site files, poses, figures and reports out, and the float
//! reference that `compass-core` is checked against.
//!
//! A site of one floor from a plan image, a calibration, and the pose of two frames:
//!
//! ```no_run
//! use compass_host::{
//!     BuildOptions, Calibration, Frame, HeightPrior, Locator, Mount, PackedPlan, PlanOptions, Settings, SiteFile,
//!     floor_bytes, load_plan, localize, write_file,
//! };
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Dark pixels are walls, red ones glazing; 0.01 m per pixel.
//! let raster = load_plan(&PlanOptions::new("floor_1.png"))?;
//! let plan = PackedPlan::new(&raster)?;
//! let bytes = floor_bytes("floor_1", &raster, &plan, None, &BuildOptions::default())?;
//! write_file(Path::new("building.site"), &bytes)?;
//!
//! let calibration = Calibration::load(Path::new("camchain-imucam.yaml"))?;
//! let frames = [Frame::read(Path::new("cam0.png"))?, Frame::read(Path::new("cam1.png"))?];
//! let sizes = frames.each_ref().map(|frame| Some((frame.width(), frame.height())));
//!
//! let site = SiteFile::read(Path::new("building.site"))?;
//! let mut locator = Locator::new(&site.floors(), calibration.rig(sizes)?, Settings::FULL)?;
//! let fix = localize(&mut locator, frames.each_ref().map(Some), Mount::Auto, HeightPrior::UNKNOWN)?;
//! if let Some(pose) = fix.pose() {
//!     println!("x {} m, y {} m, probability {:.2}", pose.at.x, pose.at.y, fix.probability());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The root re-exports what such a program needs; the modules are for callers that measure or rebuild a stage.
//! Lengths are metres, angles degrees, and the map has x to the right and y up, unless a name says otherwise.
//!
//! # Modules, in reading order
//!
//! A module knows those above it, never those below.
//!
//! | module | what it owns |
//! |---|---|
//! | [`progress`], [`clock`] | progress and times of long work |
//! | [`temporary`], [`output`] | temporary files; files that are whole or absent, numbers of results |
//! | [`input`] | which files are read, and how much of them |
//! | [`image_file`], [`frame`] | decoded images, camera frames, their line segments |
//! | [`interior`] | which places of a plan are indoors |
//! | [`plan_import`] | plan files as rasters of walls and glazing |
//! | [`site`], [`site_file`] | packed plans, site maps, files of floors |
//! | [`reference`](mod@reference) | the method once more, in plain floats |
//! | [`calibration`], [`dual_image`], [`dataset`] | lenses and rigs; both lenses in one image; recordings, trajectories, IMU |
//! | [`known_pose`], [`locator`], [`up`], [`localize`](mod@localize), [`doubt`] | from a pair of frames to a pose, or why there is none |
//! | [`visual_descriptor`], [`outline`] | what a pair of frames shows, and where in its images |
//! | [`wall_check`] | which walls of a plan stand |
//! | [`localizer`], [`noise`], [`paper_finder`], [`cross_modal`] | the paper's matching, and what it is tried with |
//! | [`sample`], [`simulate`] | a sample building; frames rendered from a plan |
//! | [`compare`], [`plan_descriptor`] | the core against the float reference, descriptors of places |
//! | [`figures`], [`report`] | pictures and pages |
//! | [`evaluate`] | recordings against the truth |
//! | `ros` | the ROS 2 node |
//! | [`fit`] | constants fitted to what is known to be right |
//!
//! # Features
//!
//! - `bag` (default): ROS 2 bags as recordings; needs a C compiler.
//! - `figures` (default): pictures, and what draws them: [`figures`], [`report`], [`evaluate`].
//! - `drawings` (default): plans in SVG and PDF. `cad` (default): in DXF and DWG.
//! - `ros2`: the ROS 2 node, `compass node`.
//! - `cli` (default): the `compass` command. The library itself neither prints nor parses arguments.

pub mod calibration;
pub mod clock;
pub mod compare;
pub mod cross_modal;
pub mod dataset;
pub mod doubt;
// Without one of the readers some of the model is not used.
#[cfg_attr(not(all(feature = "cad", feature = "drawings")), allow(dead_code))]
mod drawing;
pub mod dual_image;
#[cfg(feature = "figures")]
pub mod evaluate;
#[cfg(feature = "figures")]
pub mod figures;
pub mod fit;
pub mod frame;
mod guard;
pub mod image_file;
pub mod input;
pub mod interior;
pub mod known_pose;
pub mod localize;
pub mod localizer;
pub mod locator;
pub mod noise;
pub mod outline;
pub mod output;
pub mod paper_finder;
pub mod plan_descriptor;
pub mod plan_export;
pub mod plan_import;
pub mod progress;
pub mod reference;
#[cfg(feature = "figures")]
pub mod report;
#[cfg(feature = "ros2")]
pub mod ros;
pub mod sample;
pub mod simulate;
pub mod site;
pub mod site_file;
// Where a file is, only bags ask.
#[cfg_attr(not(feature = "bag"), allow(dead_code))]
pub mod temporary;
pub mod up;
pub mod up_by_plan;
pub mod visual_descriptor;
pub mod wall_check;
mod wide;

pub use calibration::{Calibration, CalibrationError};
pub use compass_core;
pub use compass_core::{Covariance, Fix, HeightPrior, PosePrior, Settings};
pub use dataset::recording::{DatasetError, Recording, Shot};
pub use dataset::trajectory::Trajectory;
pub use frame::Frame;
pub use image_file::ImageFileError;
pub use known_pose::{KnownPose, KnownPoseError};
pub use localize::localize;
pub use locator::{Locator, NoPlan, SeeError};
pub use output::{OutputError, write_file};
pub use plan_descriptor::PlanDescriptor;
pub use plan_import::{PlanImportError, PlanOptions, PlanRaster, load as load_plan};
pub use progress::{Progress, Silent, Steps};
pub use site::{BuildError, BuildOptions, PackError, PackedPlan, ScanError};
pub use site_file::{FloorBuildError, SiteFile, SiteFileError, SiteFloor, floor_bytes};
pub use up::Mount;
pub use visual_descriptor::VisualDescriptor;
