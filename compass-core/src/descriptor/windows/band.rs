//! Step 1: the lens's image and the rows that may hold windows.

use super::edges::Edge;
use super::parameters::{BLACK, Parameters};
use super::sample::{BINS, percentile};
use crate::base::raster::GrayImage;
use crate::vision::segments::Segment;

/// Rows and columns of the lens's image have at least one pixel of scene in as many.
const LIT_SHARE: u32 = 8;
/// Highest score of a row's density and, half of it, of its brightness.
const DENSITY_SCALE: i64 = 1024;
/// Scores to a bin of their histogram: 1536 take 62 bins.
const BIN: u16 = 25;
/// The scores are averaged over one row in as many of the image, to either side.
const BLUR_SHARE: usize = 50;

/// What is known of a row of the image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Row {
    /// Summed length of the upright segments across the row, 1/16 px; at first, its change from the row above.
    density: i64,
    /// Mean of the row's scene, 1/16 levels; later, the row's score.
    brightness: u16,
    /// The score averaged over rows.
    score: u16,
}

/// Where the lens's image lies, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    /// First row and one past the last, as for the columns.
    pub(super) rows: (u16, u16),
    pub(super) columns: (u16, u16),
    /// Whether the image fills its rectangle, not a circle.
    full: bool,
}

impl Lens {
    /// Whether column `x`, row `y` lies within `percent` percent of the radius; anywhere without a circle.
    pub(super) fn contains(&self, x: i64, y: i64, percent: u8) -> bool {
        let ((top, bottom), (left, right)) = (self.rows, self.columns);
        let twice = |low: u16, high: u16| i64::from(low) + i64::from(high);
        let (dx, dy) = (2 * x - twice(left, right), 2 * y - twice(top, bottom));
        let diameter = i64::from(right.saturating_sub(left).max(bottom.saturating_sub(top)));
        let reach = diameter * i64::from(percent);
        self.full || 10_000 * (dx * dx + dy * dy) <= reach * reach
    }
}

/// Finds the lens's image, and the mean brightness of every row.
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
/// A row's score is the density of upright segments, weighted by their lengths, and half as much its mean
/// brightness, each as a share of the frame's range. Of the runs of rows above a percentile of the scores the
/// one with the highest sum is the band.
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

/// Puts a score of at most 1536 in place of every row's brightness.
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

/// Averages the scores over `reach` rows to either side, as far as there are.
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

/// The run of rows at or above the percentile that has the highest sum of scores.
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
        // A row without any score counts too.
        sum += u64::from(row.score) + 1;
        if sum > best_sum {
            (best, best_sum) = ((start, y + 1), sum);
        }
    }
    best
}
