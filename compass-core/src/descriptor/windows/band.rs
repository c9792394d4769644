//! Step 1: the image circle of the lens, and the band of rows that can contain windows.

use super::edges::Edge;
use super::parameters::{BLACK, Parameters};
use super::sample::{BINS, percentile};
use crate::base::raster::GrayImage;
use crate::vision::segments::Segment;

/// Smallest share of scene pixels in a row or column of the image circle: one in 8.
const LIT_SHARE: u32 = 8;
/// Largest score of the density of a row; that of its brightness is half of it.
const DENSITY_SCALE: i64 = 1024;
/// Bin width of the histogram of scores, whose maximum 1536 is in bin 61.
const BIN: u16 = 25;
/// Half width of the moving average of scores: height of the image / 50.
const BLUR_SHARE: usize = 50;

/// Statistics of a row of the image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Row {
    /// Sum of the lengths of the upright segments across the row, 1/16 px; at first, its difference to the row above.
    density: i64,
    /// Mean of the scene pixels of the row, 1/16 gray level; later, the score of the row.
    brightness: u16,
    /// Moving average of the score.
    score: u16,
}

/// The bounding box of the image circle, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    /// First row and one past the last.
    pub(super) rows: (u16, u16),
    /// First column and one past the last.
    pub(super) columns: (u16, u16),
    /// Whether the scene fills the bounding box, not a circle.
    full: bool,
}

impl Lens {
    /// Whether a pixel is within `percent` percent of the radius; always true without a circle.
    pub(super) fn contains(&self, x: i64, y: i64, percent: u8) -> bool {
        let ((top, bottom), (left, right)) = (self.rows, self.columns);
        let twice = |low: u16, high: u16| i64::from(low) + i64::from(high);
        let (dx, dy) = (2 * x - twice(left, right), 2 * y - twice(top, bottom));
        let diameter = i64::from(right.saturating_sub(left).max(bottom.saturating_sub(top)));
        let reach = diameter * i64::from(percent);
        self.full || 10_000 * (dx * dx + dy * dy) <= reach * reach
    }
}

/// Finds the image circle and the mean brightness of every row.
#[expect(clippy::cast_possible_truncation, reason = "means of 8-bit levels in 1/16, and columns below 2^16")]
pub(super) fn lens(image: &GrayImage<'_>, rows: &mut [Row], columns: &mut [u16]) -> Lens {
    columns.fill(0);
    let mut lit = 0_u64;
    let (mut first, mut last) = (u16::MAX, 0_u16);
    for (y, row) in (0_u16..).zip(rows.iter_mut()) {
        let (mut count, mut sum) = (0_u32, 0_u32);
        for (&level, column) in image.row(usize::from(y)).iter().zip(columns.iter_mut()) {
            let scene = level > BLACK;
            *column += u16::from(scene);
            count += u32::from(scene);
            sum += if scene { u32::from(level) } else { 0 };
        }
        *row = Row { brightness: (16 * sum / count.max(1)) as u16, ..Row::default() };
        lit += u64::from(count);
        if count > 0 && LIT_SHARE * count >= image.width() {
            first = first.min(y);
            last = y + 1;
        }
    }
    let bright = |&n: &u16| n > 0 && LIT_SHARE * u32::from(n) >= image.height();
    let left = columns.iter().position(bright).unwrap_or(0) as u16;
    let right = columns.iter().rposition(bright).map_or(left, |x| x as u16 + 1);
    let area = u64::from(right - left) * u64::from(last.saturating_sub(first));
    // A circle fills 79 % of its square.
    Lens { rows: (first.min(last), last), columns: (left, right), full: 10 * lit > 9 * area }
}

/// The band: first row and one past the last.
///
/// The score of a row is the density of upright segments, weighted by their lengths, plus half its mean brightness, each
/// relative to the range of the frame. The band is the run of rows above a percentile of the scores with the largest sum.
#[expect(clippy::cast_possible_truncation, reason = "rows are below 2^16")]
pub(super) fn find(
    lens: &Lens,
    segments: &[Segment],
    parameters: &Parameters,
    rows: &mut [Row],
) -> (u16, u16) {
    let height = rows.len() as u16;
    for edge in segments.iter().filter_map(|s| Edge::upright(s, parameters)) {
        let length = i64::from(edge.length);
        if edge.y0 >= height {
            continue;
        }
        if let Some(row) = rows.get_mut(usize::from(edge.y0)) {
            row.density += length;
        }
        if let Some(row) = rows.get_mut(usize::from(edge.y1)) {
            row.density -= length;
        }
    }
    let mut density = 0;
    for row in rows.iter_mut() {
        density += row.density;
        row.density = density;
    }
    let top = usize::from(lens.rows.0);
    let Some(rows) = rows.get_mut(top..usize::from(lens.rows.1)) else { return (0, 0) };
    let blur = usize::from(height) / BLUR_SHARE;
    score(rows);
    average(rows, blur);
    let (start, end) = best_run(rows, parameters.band_percentile);
    ((top + start) as u16, (top + end) as u16)
}

/// Replaces the brightness of every row by its score, at most 1536.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "scores are 0 to 1536")]
fn score(rows: &mut [Row]) {
    let most = rows.iter().map(|r| r.density).max().unwrap_or(0).max(1);
    let low = rows.iter().map(|r| r.brightness).min().unwrap_or(0);
    let high = rows.iter().map(|r| r.brightness).max().unwrap_or(0);
    let range = i64::from(high - low).max(1);
    for row in rows {
        let bright = i64::from(row.brightness - low) * DENSITY_SCALE / (2 * range);
        row.brightness = (row.density * DENSITY_SCALE / most + bright) as u16;
    }
}

/// Moving average of the scores over `reach` rows to either side, shortened at the ends.
#[expect(
    clippy::cast_possible_truncation,
    reason = "means of scores, which are at most 1536, over fewer than 2^16 rows"
)]
fn average(rows: &mut [Row], reach: usize) {
    let at = |rows: &[Row], y: usize| rows.get(y).map_or(0, |r| u32::from(r.brightness));
    let mut sum: u32 = (0..reach).map(|y| at(rows, y)).sum();
    let height = rows.len();
    for y in 0..height {
        sum += at(rows, y + reach);
        if let Some(left) = y.checked_sub(reach + 1) {
            sum -= at(rows, left);
        }
        let count = (y + reach + 1).min(height) - y.saturating_sub(reach);
        if let Some(row) = rows.get_mut(y) {
            row.score = (sum / count.max(1) as u32) as u16;
        }
    }
}

/// The run of rows at or above the percentile with the largest sum of scores.
fn best_run(rows: &[Row], percent: u8) -> (usize, usize) {
    let bin = |row: &Row| usize::from(row.score / BIN);
    let mut bins = [0_u32; BINS];
    for row in rows {
        if let Some(count) = bins.get_mut(bin(row)) {
            *count += 1;
        }
    }
    let threshold = percentile(&bins, percent) as usize;
    let (mut best, mut best_sum) = ((0, 0), 0);
    let (mut start, mut sum) = (0, 0_u64);
    for (y, row) in rows.iter().enumerate() {
        if bin(row) < threshold {
            (start, sum) = (y + 1, 0);
            continue;
        }
        // 1 is added so that rows of score 0 count.
        sum += u64::from(row.score) + 1;
        if sum > best_sum {
            (best, best_sum) = ((start, y + 1), sum);
        }
    }
    best
}
