//! Where am I in this building?
//!
//! `compass-core` turns an architect's floor plan into compact descriptors and finds, among the
//! descriptors of a whole building, the position and heading that explain what a robot sees. It
//! allocates nothing, contains no `unsafe`, and gives the same bits on every target: integers, and `f32` for lenses,
//! directions, heights and probabilities, through `libm` alone and without fused operations.
//!
//! # The door
//! Open a [`Site`], describe the [`Rig`], lend a [`Locator`] its memory, and every pair of frames gives a [`Fix`]: pose,
//! probability, heights, the name of the floor, alternatives. A fix always names the likeliest pose; its probability says
//! whether to believe it. [`Site::verify`] reads a file through, which [`Site::new`] leaves out.
//!
//! ```
//! use compass_core::{Frame, Fix, GrayImage, HeightPrior, Locator, LocateError, Prior, Rig, Settings, Site, UpHint, Bearing};
//!
//! /// Memory for two frames of 368 x 360 pixels: on a board a static.
//! const WORDS: usize = Settings::BOARD.memory_words(368, 360);
//!
//! fn locate<'a>(
//!     site: &Site<'a>,
//!     rig: Rig,
//!     [front, back]: [&[u8]; 2],
//!     memory: &mut [u32; WORDS],
//! ) -> Result<Fix<'a>, LocateError> {
//!     let frame = |pixels| GrayImage::new(pixels, 368, 360).ok().map(Frame::from);
//!     // The rig hangs upside down, 1.6 m above the floor.
//!     let prior = Prior::new(UpHint::Up(Bearing::new(0.0, 1.0, 0.0)), HeightPrior::camera(1.6));
//!     let mut locator: Locator<'_, _> = Locator::new(site, rig, Settings::BOARD, &mut memory[..])?;
//!     locator.locate(&[frame(front), frame(back)], &prior)
//! }
//! use compass_core::{Camera, Intrinsics, KannalaBrandt, View};
//!
//! # const VECTORS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors");
//! // Lenses as calibrated, for frames of this size: focal lengths, centre, distortion.
//! let view = |[fx, fy, cx, cy]: [f32; 4], k| {
//!     let lens = KannalaBrandt::new(Intrinsics { fx, fy, cx, cy }, k).unwrap();
//!     View::new(Camera::KannalaBrandt(lens), 368, 360)
//! };
//! let front = view([116.0, 116.1, 182.95, 179.9], [0.024, -0.0105, -0.0016, 0.000_14]);
//! let mut back = view([116.25, 116.3, 183.65, 179.2], [0.025, -0.0107, -0.001_55, 0.000_13]);
//! // It takes bearings of the back camera into the front camera; written by columns.
//! back.rotation.copy_from_slice(&[
//!     -0.999_975, 0.005, -0.005, //
//!     0.005_025, 0.999_974_7, -0.005, //
//!     0.004_975, -0.005_025, -0.999_974_9,
//! ]);
//! // Where the back camera is, in the axes of the front camera, metres.
//! back.position.copy_from_slice(&[0.0012, -0.0007, -0.038]);
//! let rig = Rig::new([Some(front), Some(back)]).unwrap();
//!
//! # let read = |name: &str| std::fs::read(format!("{VECTORS}/{name}")).unwrap();
//! # let (front, back, bytes) = (read("frame_368x360_cam0.gray"), read("frame_368x360_cam1.gray"), read("sample.site"));
//! # let site = Site::new(&bytes).unwrap();
//! # let mut memory: Box<[u32; WORDS]> = vec![0; WORDS].try_into().unwrap();
//! let fix = locate(&site, rig, [&front, &back], &mut memory)?;
//! let pose = fix.pose().expect("the sample building has candidates");
//! assert_eq!(fix.floor_name(), Some("ground"));
//! // It was taken at x 4.12, y 17.77 m.
//! assert!((pose.at.x.to_num::<f32>() - 4.12).abs() < 0.4 && (pose.at.y.to_num::<f32>() - 17.77).abs() < 0.4);
//! assert!(fix.probability() > 0.5);
//! // Its heading in degrees, counterclockwise from the x axis.
//! assert!((pose.heading.to_microdegrees() as f32 / 1e6 - 288.6).abs() < 3.0);
//! # Ok::<(), LocateError>(())
//! ```
//!
//! A sequence of frames adds up in a [`Track`]. The paper's own way, from a [`Scan`] by its [`Descriptor`] to the places
//! of a map that resemble it, is the wing [`descriptor`].
//!
//! # The wings
//! Everything else is reached by its path, for those who measure or rebuild a stage. A wing knows those above it, and a
//! module those before it.
//!
//! | wing | owns |
//! |---|---|
//! | [`base`] | the vocabulary: fixed-point scales, angles, images, scans, poses |
//! | [`map`] | the building: packed plan and ray march, candidates, the file of a site |
//! | [`vision`] | what is seen: cameras, segments, up vector, windows, boundaries of floor and ceiling |
//! | [`pose`] | where that can be: evidence, search, refinement, track, wall check |
//! | [`descriptor`] | the paper's method, whole and by itself |
//! | [`locator`] | the one pipeline from frames to a pose |
//!
//! Memory is lent by the caller throughout; "nothing found" is `None`; errors are small `Copy` enums.
//!
//! # Glossary
//!
//! | word | meaning |
//! |---|---|
//! | azimuth, bin | direction in the level frame, degrees counter-clockwise from the heading; bin j of 360 looks along heading + j degrees |
//! | bearing | a unit vector in the axes of a camera: x right, y down, z forward |
//! | boundary | where a wall meets the floor or the ceiling |
//! | candidate | a position of the site map, with the scan cast from it |
//! | channel value | a value of a descriptor in fixed point |
//! | descriptor | five channels of 360 bins made of a scan (paper) |
//! | evidence | log-likelihood ratios against "nothing known", by direction, range and hit type |
//! | exclusion mask | pixels that say nothing of the building, as the robot's own parts in front of a window |
//! | fix | a pose with its probability, heights and alternatives |
//! | floor, floor layer | a storey; its plan as drawn (layer 0) or its structure alone (layer 1) |
//! | heading | direction of camera 0's optical axis, projected on the floor: counter-clockwise from +x |
//! | height prior | what is known beforehand of the heights of camera and ceiling |
//! | level frame | the gravity-aligned axes of camera 0: forward, left, up |
//! | nat | unit of a natural logarithm; scores are sums of log-likelihood ratios in nats |
//! | panorama | what both cameras see, by azimuth and elevation |
//! | rung | a step of range or height: 6.3 % |
//! | scan | range and hit type of 360 rays |
//! | segment | a straight line in an image |
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | `draw` | drawing on any `embedded-graphics` display |
//! | `introspect` | what exists for pictures, comparisons and evaluation: evidence and arcs of frames, evidence that was kept |
//! | `paper-windows` | the paper's window finder |
//! | `large-tables` | checksums several times as fast, by tables of 16 KiB in place of 1 KiB |
//! | `defmt` | `defmt::Format` on the public types |
//!
//! # Reference
//! "COMPASS: `COmpact` Multi-channel Prior-map And Scene Signature", 2026 (*the paper* in all docs).
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// Tests may panic and cast as they like.
#![cfg_attr(
    not(test),
    warn(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used,
    )
)]

#[cfg(test)]
extern crate std;

pub mod base;
pub mod descriptor;
#[cfg(feature = "draw")]
pub mod draw;
pub mod locator;
pub mod map;
pub mod pose;
pub mod vision;

pub use base::num::{Metres, Nats, Point, Turn};
pub use base::pose::Pose;
pub use base::raster::{BitMask, GrayImage, RgbImage};
pub use base::scan::{Hit, Scan};
pub use descriptor::Descriptor;
pub use locator::{Error as LocateError, Frame, Frames, Locator, Prior, Settings};
pub use map::plan::Plan;
pub use map::site::{Site, SiteError};
pub use pose::heights::HeightPrior;
pub use pose::track::{Estimate, Motion, Track};
pub use pose::{Covariance, Fix, PosePrior, ScoredPose};
pub use vision::attitude::UpHint;
pub use vision::camera::{
    Bearing, Camera, CameraError, DoubleSphere, Eucm, Intrinsics, KannalaBrandt, Omni, Radtan, Rig, View,
};
pub use vision::sample::ExclusionMask;

/// The README's example, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
