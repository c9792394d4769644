//! The paper's method, whole and by itself: a scan as a descriptor of five channels, and where on a site map it fits best.
//!
//! | module | owns |
//! |---|---|
//! | [`channels`] | the 5 x 360 descriptor of a scan |
//! | [`spectrum`] | fixed-point FFT and circular cross-correlation |
//! | [`similarity`] | cosine similarity of descriptors: plain and centred, weighted and masked |
//! | [`signature`] | the rotation-invariant transition signature |
//! | [`sketch`] | a low-pass descriptor of 24 bytes |
//! | [`matching`] | search over candidates and headings |
//! | [`windows`] | the paper's window finder, on one image |

pub mod channels;
mod harmonics;
pub mod matching;
pub mod signature;
pub mod similarity;
pub mod sketch;
pub mod spectrum;
pub mod windows;

pub use channels::{CHANNELS, Channel, Descriptor};

use crate::base::scan::Scan;
use crate::map::site_map::{Layer, PackedScan};
use signature::Signature;
use similarity::Candidate;
use sketch::Sketch;

/// A scan cast with heading 0 as a site map stores it: packed, with its signature and its sketch.
#[must_use]
pub fn layer_of(scan: &Scan) -> Layer {
    let packed = PackedScan::new(scan);
    // Everything is derived from what a reader will see.
    let mut kept = Scan::OPEN;
    packed.unpack(&mut kept);
    let sketch = Sketch::new(&Candidate::from(&Descriptor::from(&kept)));
    Layer::new(&packed, &Signature::new(&kept).0, &sketch.0.map(i8::cast_unsigned))
}
