//! The paper's method: a scan as a descriptor of five channels, and its matching against a site map.
//!
//! | module | owns |
//! |---|---|
//! | [`channels`] | the 5 x 360 descriptor of a scan |
//! | [`spectrum`] | fixed-point FFT and circular cross-correlation |
//! | [`similarity`] | cosine similarity of descriptors: plain and centred, weighted and masked |
//! | [`signature`] | the rotation-invariant transition signature |
//! | [`sketch`] | a low-pass descriptor of 24 bytes |
//! | [`matching`] | search over candidates and headings |
//! | `windows` | the paper's window finder in one image (feature `paper-windows`) |

pub mod channels;
mod harmonics;
pub mod matching;
pub mod signature;
pub mod similarity;
pub mod sketch;
pub mod spectrum;
#[cfg(feature = "paper-windows")]
pub mod windows;

/// [`BINS`] as a factor of sums.
#[expect(clippy::cast_possible_wrap, reason = "the value is 360")]
const BINS_I64: i64 = BINS as i64;
/// [`BINS`] as a factor of values.
#[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "the value is 360")]
const BINS_I32: i32 = BINS as i32;

pub use channels::{CHANNELS, Channel, Descriptor};

use crate::base::num::BINS;
use crate::base::scan::Scan;
use crate::map::site_map::{Layer, PackedScan};
use signature::Signature;
use similarity::Candidate;
use sketch::Sketch;

/// The layer of a site map for a scan cast with heading 0: packed scan, signature and sketch.
///
/// Signature and sketch are computed from the packed scan, so that they agree with what a reader unpacks.
///
/// ```
/// use compass_core::descriptor::layer_of;
/// use compass_core::descriptor::signature::Signature;
/// use compass_core::map::site_map::Layer;
/// use compass_core::{Hit, Scan};
///
/// let near = layer_of(&Scan { steps: [50; 360], hit: [Hit::Wall; 360] });
/// assert_ne!(near, layer_of(&Scan::OPEN));
/// ```
#[must_use]
pub fn layer_of(scan: &Scan) -> Layer {
    let packed = PackedScan::new(scan);
    let mut kept = Scan::OPEN;
    packed.unpack(&mut kept);
    let sketch = Sketch::new(&Candidate::from(&Descriptor::from(&kept)));
    Layer::new(&packed, &Signature::new(&kept).0, &sketch.0.map(i8::cast_unsigned))
}
