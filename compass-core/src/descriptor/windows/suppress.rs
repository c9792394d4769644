//! Step 4: rejection of proposals at the rim and of red ones, then non-maximum suppression.

use super::band::Lens;
use super::parameters::Parameters;
use super::proposal::{ImageWindow, Proposal, Rejection};
use super::sample::grid;
use crate::base::order;
use crate::base::raster::{GrayImage, RgbImage, is_red};
use core::cmp::Reverse;

/// Width of the border of the image that excludes windows, pixels.
const BORDER: u16 = 2;

/// Rejects proposals at the rim or dominated by red.
pub(super) fn reject(
    image: &GrayImage<'_>,
    colour: Option<&RgbImage<'_>>,
    lens: &Lens,
    parameters: &Parameters,
    proposals: &mut [Proposal],
) {
    for proposal in proposals {
        let window = &proposal.window;
        if at_rim(image, lens, window, parameters.radius_percent) {
            proposal.rejection = Some(Rejection::Periphery);
        } else if colour.is_some_and(|colour| too_red(colour, window, parameters.red_percent)) {
            proposal.rejection = Some(Rejection::Red);
        }
    }
}

/// Sorts the proposals by descending score and rejects those that overlap a better one.
pub(super) fn suppress(parameters: &Parameters, proposals: &mut [Proposal]) {
    order::sort_by_key(proposals, |p| {
        let w = &p.window;
        (p.rejection.is_some(), Reverse(w.score), w.x0, w.y0, w.x1, w.y1)
    });
    for i in 0..proposals.len() {
        let Some((better, [proposal, ..])) = proposals.split_at_mut_checked(i) else { return };
        let window = proposal.window;
        let worse =
            |p: &Proposal| p.rejection.is_none() && overlap(&p.window, &window, parameters.overlap_percent);
        if proposal.rejection.is_none() && better.iter().any(worse) {
            proposal.rejection = Some(Rejection::Suppressed);
        }
    }
}

/// Whether the middle of the left or right side is outside the radius, or the box touches the border.
fn at_rim(image: &GrayImage<'_>, lens: &Lens, window: &ImageWindow, percent: u8) -> bool {
    let &ImageWindow { x0, y0, x1, y1, .. } = window;
    let middle = i64::from(y0.midpoint(y1));
    let outside = |x: u16| !lens.contains(i64::from(x), middle, percent);
    let touches = |low: u16, high: u16, size: u32| low < BORDER || u32::from(high) + u32::from(BORDER) > size;
    outside(x0) || outside(x1) || touches(x0, x1, image.width()) || touches(y0, y1, image.height())
}

/// Whether more than `percent` percent of the samples of a box are red.
fn too_red(colour: &RgbImage<'_>, window: &ImageWindow, percent: u8) -> bool {
    let (mut red, mut points) = (0_u32, 0_u32);
    for y in grid(window.y0, window.y1) {
        for x in grid(window.x0, window.x1) {
            points += 1;
            red += u32::from(is_red(colour.pixel(x, y)));
        }
    }
    100 * red > u32::from(percent) * points
}

/// Whether intersection over union of two boxes is above `percent` percent.
fn overlap(a: &ImageWindow, b: &ImageWindow, percent: u8) -> bool {
    let area = |w: &ImageWindow| u64::from(w.x1.saturating_sub(w.x0)) * u64::from(w.y1.saturating_sub(w.y0));
    let common = ImageWindow {
        x0: a.x0.max(b.x0),
        y0: a.y0.max(b.y0),
        x1: a.x1.min(b.x1),
        y1: a.y1.min(b.y1),
        score: 0,
    };
    let shared = area(&common);
    100 * shared > u64::from(percent) * (area(a) + area(b) - shared)
}
