//! From what is seen to a pose: camera height, search, refinement, answer.

use crate::boundary::Ranges;
use crate::likelihood::{Answer, Mode, Rows, Sheet, Table, answer, refine, search};
use crate::sight;
use crate::windows::level::Sighting;
use heapless::Vec;

/// Headings that heights of the camera are compared at.
const COARSE: usize = 90;
/// Most modes that are refined, of all heights together.
pub const MAX_MODES: usize = 48;
/// Most heights that are searched at all headings.
const MAX_HEIGHTS: usize = 3;

/// How much work to spend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Effort {
    /// Camera heights that are searched at all headings when the height is not known, 1 to 3.
    pub heights: u8,
    /// Modes that are refined for each of them, 1 to 16.
    pub modes: u8,
}

impl Default for Effort {
    fn default() -> Self {
        Self { heights: 2, modes: 16 }
    }
}

/// Memory lent for the search; what it holds before does not matter. N is the number of headings.
#[derive(Debug)]
pub struct Work<'a, const N: usize> {
    /// The evidence, and afterwards that for the answer's height.
    pub table: &'a mut Table,
    /// For heights: used when the height is not known.
    pub coarse: &'a mut Rows<COARSE>,
    /// For the search.
    pub rows: &'a mut Rows<N>,
    /// 64 to 512 places.
    pub pool: &'a mut [Mode],
}

/// Where the cameras are.
#[derive(Debug, Clone)]
pub struct Fix {
    /// The best pose and its alternatives, refined.
    pub answer: Answer,
    /// The camera's height in [rungs](crate::boundary::height_rungs): that given, or that found.
    pub height: i8,
}

/// Finds the pose that explains best what was seen, on all sheets; `height` is that of the camera in
/// [rungs](crate::boundary::height_rungs), and is searched for where it is not known.
///
/// # Cost
/// Known height: one [`search`] and `modes` [refinements](refine). Unknown: one more search at 90 headings per height
/// that a room allows, about 14, and the rest for each of [`Effort::heights`].
#[inline]
pub fn locate<const N: usize>(
    ranges: &Ranges,
    height: Option<i8>,
    sighting: &Sighting,
    sheets: &[Sheet<'_>],
    effort: Effort,
    work: &mut Work<'_, N>,
) -> Fix {
    let heights = height.map_or_else(
        || likely_heights(ranges, sighting, sheets, effort, work),
        |known| Vec::from_iter([known]),
    );
    let mut modes: Vec<Mode, MAX_MODES> = Vec::new();
    let mut best = (i32::MIN, height.unwrap_or(0));
    for &height in &heights {
        sight::evidence(ranges, height, sighting, work.table);
        work.rows.set(work.table);
        let found = search(work.rows, sheets, |_, _| true, work.pool);
        let per_height = usize::from(effort.modes).min(MAX_MODES / MAX_HEIGHTS);
        for mode in work.pool.iter().take(found.min(per_height)) {
            let Some(sheet) = sheets.get(usize::from(mode.sheet)) else { continue };
            let refined = refine(work.table, sheet, *mode);
            if refined.score > best.0 {
                best = (refined.score, height);
            }
            // Never full: both factors are bounded.
            let _ = modes.push(refined);
        }
    }
    if heights.last() != Some(&best.1) {
        sight::evidence(ranges, best.1, sighting, work.table);
    }
    Fix { answer: answer(sheets, &mut modes), height: best.1 }
}

/// The heights at which the best candidates score best, best first.
fn likely_heights<const N: usize>(
    ranges: &Ranges,
    sighting: &Sighting,
    sheets: &[Sheet<'_>],
    effort: Effort,
    work: &mut Work<'_, N>,
) -> Vec<i8, MAX_HEIGHTS> {
    let wanted = usize::from(effort.heights).clamp(1, MAX_HEIGHTS);
    let mut likely: Vec<(i32, i8), MAX_HEIGHTS> = Vec::new();
    for height in ranges.heights() {
        sight::evidence(ranges, height, sighting, work.table);
        work.coarse.set(work.table);
        let pool = work.pool.get_mut(..1).unwrap_or_default();
        let found = search(work.coarse, sheets, |_, _| true, pool);
        let score = pool.first().filter(|_| found > 0).map_or(i32::MIN, |mode| mode.score);
        let at = likely.iter().position(|other| score > other.0).unwrap_or(likely.len());
        if likely.len() == wanted && at < wanted {
            likely.pop();
        }
        if likely.len() < wanted {
            let _ = likely.insert(at, (score, height));
        }
    }
    likely.iter().map(|(_, height)| *height).collect()
}
