//! Step 3: pairs of edges, tested for brightness, contrast to the adjacent wall, and texture.

use super::band::Lens;
use super::edges::Edge;
use super::parameters::{BLACK, Parameters};
use super::proposal::{ImageWindow, Proposal, Rejection};
use super::sample::{Area, BINS, Samples, percentile, pixel, rows_around};
use crate::base::raster::GrayImage;

/// Approximate number of rows and of columns of the band that are sampled for its levels.
const PLACES: usize = 256;
/// Bin width of the brightness histogram, gray levels.
const LEVELS_PER_BIN: u8 = 4;
/// Score of two edges that support the whole height.
const SUPPORT: u32 = 64;

/// Thresholds of the frame, in 1/16 gray level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Levels {
    /// Brightness that a window must exceed.
    bright: u32,
    /// Median texture, in whole gray levels.
    texture: u32,
}

impl Levels {
    /// The thresholds of the scene pixels in the band.
    #[expect(clippy::cast_possible_truncation, reason = "gradients are counted in 64 bins")]
    pub(super) fn new(image: &GrayImage<'_>, lens: &Lens, band: (u16, u16), parameters: &Parameters) -> Self {
        let mut brightness = [0_u32; BINS];
        let mut texture = [0_u32; BINS];
        let (left, right) = lens.columns;
        let across = usize::from(right.saturating_sub(left)) / PLACES + 1;
        let down = usize::from(band.1.saturating_sub(band.0)) / PLACES + 1;
        for y in (band.0..band.1).step_by(down) {
            let rows = rows_around(image, u32::from(y));
            for x in (left..right).step_by(across) {
                let Some((level, gradient)) = pixel(rows, usize::from(x)) else { continue };
                if level <= BLACK {
                    continue;
                }
                if let Some(count) = brightness.get_mut(usize::from(level / LEVELS_PER_BIN)) {
                    *count += 1;
                }
                if let Some(count) = texture.get_mut(gradient.min(BINS as u32 - 1) as usize) {
                    *count += 1;
                }
            }
        }
        let bright = percentile(&brightness, parameters.brightness_percentile);
        Self { bright: 16 * u32::from(LEVELS_PER_BIN) * bright, texture: 16 * percentile(&texture, 50) }
    }
}

/// The proposals: first those that passed, then as many rejected ones as fit.
#[derive(Debug)]
pub(super) struct List<'a> {
    proposals: &'a mut [Proposal],
    passed: usize,
    len: usize,
    /// Whether a proposal that passed did not fit.
    truncated: bool,
}

impl<'a> List<'a> {
    pub(super) fn new(proposals: &'a mut [Proposal]) -> Self {
        Self { proposals, passed: 0, len: 0, truncated: false }
    }

    /// The proposals that passed.
    pub(super) fn passed(&mut self) -> &mut [Proposal] {
        self.proposals.get_mut(..self.passed).unwrap_or(&mut [])
    }

    /// Number of all proposals, and whether one that passed did not fit.
    pub(super) fn end(&self) -> (usize, bool) {
        (self.len, self.truncated)
    }

    fn push(&mut self, mut proposal: Proposal) {
        if proposal.rejection.is_none() {
            let Some(slot) = self.proposals.get_mut(self.passed) else {
                self.truncated = true;
                return;
            };
            core::mem::swap(slot, &mut proposal);
            self.passed += 1;
            if self.passed > self.len {
                self.len = self.passed;
                return;
            }
        }
        // A rejected proposal, new or displaced.
        if let Some(slot) = self.proposals.get_mut(self.len) {
            *slot = proposal;
            self.len += 1;
        }
    }
}

/// Lists the pairs of edges whose width and common height are within the limits. Edges are sorted from left to right.
pub(super) fn pair(
    image: &GrayImage<'_>,
    edges: &[Edge],
    levels: &Levels,
    parameters: &Parameters,
    list: &mut List<'_>,
) {
    let widths = 16 * u32::from(parameters.min_width)..=16 * u32::from(parameters.max_width);
    for (i, left) in (1..).zip(edges) {
        for right in edges.get(i..).unwrap_or(&[]) {
            let width = right.x.saturating_sub(left.x);
            if width > *widths.end() {
                break;
            }
            if let Some(window) = window(image, left, right, parameters).filter(|_| widths.contains(&width)) {
                list.push(check(image, window, levels, parameters));
            }
        }
    }
}

/// The box between two edges over their common rows, with the support of the edges as score; `None` if they share too
/// little height.
#[expect(
    clippy::cast_possible_truncation,
    reason = "columns and rows are bounded by the image, supports are at most 64"
)]
fn window(image: &GrayImage<'_>, left: &Edge, right: &Edge, parameters: &Parameters) -> Option<ImageWindow> {
    let (y0, y1) = left.shared(right)?;
    let y1 = u32::from(y1).min(image.height()) as u16;
    let height = u32::from(y1.checked_sub(y0)?);
    let shorter = u32::from(left.height().min(right.height()));
    if 100 * height < u32::from(parameters.shared_percent) * shorter {
        return None;
    }
    let column = |edge: &Edge| ((edge.x + 8) / 16).min(image.width()) as u16;
    let (x0, x1) = (column(left), column(right));
    let seen = left.length.saturating_add(right.length) / 16;
    let support = SUPPORT * seen.min(2 * height) / (2 * height).max(1);
    (x0 < x1 && y0 < y1).then_some(ImageWindow { x0, y0, x1, y1, score: support as i16 })
}

/// Tests a box for brightness, contrast and texture, and completes its score.
#[expect(clippy::cast_possible_truncation, reason = "at most 255 + 510")]
fn check(image: &GrayImage<'_>, window: ImageWindow, levels: &Levels, parameters: &Parameters) -> Proposal {
    let ImageWindow { x0, y0, x1, y1, score } = window;
    let reject = |reason| Proposal { window: ImageWindow { score: 0, ..window }, rejection: Some(reason) };
    let inside = Samples::take(image, Area { x0, y0, x1, y1 });
    if !inside.mostly_lit() || inside.brightness_16() <= levels.bright {
        return reject(Rejection::Dark);
    }
    let strip = ((x1 - x0) / 4).max(parameters.min_flank);
    let flanks = [
        Area { x0: x0.saturating_sub(strip), y0, x1: x0, y1 },
        Area { x0: x1, y0, x1: x1.saturating_add(strip), y1 },
    ];
    let Some((wall, wall_texture)) = mean_of_walls(image, flanks) else {
        return reject(Rejection::LowContrast);
    };
    if 100 * inside.brightness_16() < (100 + u32::from(parameters.contrast_percent)) * wall {
        return reject(Rejection::LowContrast);
    }
    if inside.texture_16() <= wall_texture.min(levels.texture) {
        return reject(Rejection::Texture);
    }
    let contrast = (inside.brightness_16() - wall.min(inside.brightness_16())) / 16;
    // At most 255 + 510 + 64.
    let score = score + (contrast + inside.texture_16() / 16) as i16;
    Proposal { window: ImageWindow { score, ..window }, rejection: None }
}

/// Mean brightness and texture, in 1/16 gray level, of the strips that are mostly scene.
fn mean_of_walls(image: &GrayImage<'_>, flanks: [Area; 2]) -> Option<(u32, u32)> {
    let [left, right] = flanks.map(|area| Samples::take(image, area));
    let of = |s: Samples| s.mostly_lit().then(|| (s.brightness_16(), s.texture_16()));
    match (of(left), of(right)) {
        (Some(a), Some(b)) => Some((a.0.midpoint(b.0), a.1.midpoint(b.1))),
        (a, b) => a.or(b),
    }
}
