//! Where am I in this building?
//!
//! `compass-core` turns an architect's floor plan into compact descriptors and finds, among the
//! descriptors of a whole building, the position and heading that explain what a robot sees. It
//! allocates nothing, contains no `unsafe`, and gives the same bits on every target: integers, and where lenses and
//! directions need them `f32`, through `libm` alone and without fused operations.
//!
//! Modules in reading order, each knowing only those before it:
//!
//! | module | owns |
//! |---|---|
//! | [`num`] | fixed-point vocabulary: levels, metres, binary angles, scores |
//! | [`raster`] | borrowed bit masks, gray and colour images |
//! | [`scan`] | range and hit type of 360 rays |
//! | [`plan`] | the packed floor plan and the ray march |
//! | [`descriptor`] | the 5 x 360 descriptor of a scan |
//! | [`spectrum`] | fixed-point FFT and circular correlation |
//! | [`similarity`] | cosine similarity of descriptors, plain and centred, weighted and masked |
//! | [`signature`] | the rotation-invariant transition signature |
//! | [`site_map`] | the map of candidate positions as bytes |
//! | [`site`] | the file of a site: floors with their site maps and plans |
//! | [`matching`] | search over candidates and headings |
//! | [`likelihood`] | likelihood of a pose under a table of evidence: search and refinement |
//! | [`camera`] | fisheye models, bearing to pixel and back; the rig of two |
//! | [`shot`] | the file of what a rig's cameras took at one moment |
//! | [`segments`] | line segments of an image, by edge drawing |
//! | [`attitude`] | up vector and the building's axes from vanishing points |
//! | [`windows`] | windows and hit type of every direction |
//! | [`boundary`] | likelihood of ranges, from where walls meet floor and ceiling |
//! | [`sight`] | range and hit type put together: evidence, and the descriptor as seen |
//! | [`locate`] | from what is seen to a pose |
//! | [`track`] | the belief over a sequence of frames |
//!
//! Memory is lent by the caller throughout; "nothing found" is `None`; errors are small `Copy` enums.
//!
//! # Reference
//! "COMPASS: `COmpact` Multi-channel Prior-map And Scene Signature", 2026 (*the paper* below).
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

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

/// The README's example, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
