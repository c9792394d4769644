//! From two frames to a pose on a board: the steps of `compass-core` in one piece of memory.
//!
//! No step needs all memory for long: where the detector of segments had its pixels lies the ring of the windows next,
//! then the raster of ranges, then the search. [`Locator`] keeps what one step hands to another and lays the rest over
//! the [`words`] of its scratch. For frames of 368 x 360 pixels that is 466 KB, and 12 KB of stack; there is no heap.
//!
//! ```
//! use compass_board::{Error, Frame, Locator, layers, words};
//! use compass_core::{attitude::UpHint, camera::Rig, likelihood::FloorLayer, locate::{Effort, Fix, HeightPrior}, windows::level::Resolution};
//!
//! // On a board this is a static.
//! type Eyes = Locator<[u32; words(368, 360, Resolution::COARSE)]>;
//!
//! fn pose(eyes: &mut Eyes, rig: &Rig, frames: &[Option<Frame>; 2], up: UpHint, site: &[FloorLayer]) -> Result<Fix, Error> {
//!     eyes.see(rig, frames, up)?;
//!     eyes.locate(site, HeightPrior::default(), Effort::on_board(&HeightPrior::default()))
//! }
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod locator;
mod scratch;

pub use locator::{Error, Frame, Locator, layers};
pub use scratch::words;
