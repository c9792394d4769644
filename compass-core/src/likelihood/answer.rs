//! The best poses that lie apart.

use super::search::{Mode, Sheet};
use crate::matching::MAX_ALTERNATIVES;
use crate::num::{Metres, Turn};
use crate::order;

/// Alternatives are at least this far apart...
const APART: Metres = Metres::ONE;
/// ...or this much.
const APART_TURN: Turn = Turn::from_ratio(20, 360);

/// What was found, best first.
#[derive(Debug, Clone)]
pub struct Answer {
    modes: heapless::Vec<Mode, MAX_ALTERNATIVES>,
}

impl Answer {
    /// No pose.
    pub(crate) const fn nothing() -> Self {
        Self { modes: heapless::Vec::new() }
    }

    /// The best pose and its alternatives: on other floors, or at least 1 m or 20 degrees apart.
    #[must_use]
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The best pose.
    #[must_use]
    pub fn best(&self) -> Option<&Mode> {
        self.modes.first()
    }

    /// The best score; below all others without a pose.
    pub(crate) fn score(&self) -> i32 {
        self.best().map_or(i32::MIN, |mode| mode.score)
    }

    /// By how much the best score exceeds the best one elsewhere, in 1/16 nat; the best score itself,
    /// which is relative to "nothing known", when there is no other.
    #[must_use]
    pub fn margin(&self) -> i32 {
        let score = |at: usize| self.modes.get(at).map_or(0, |mode| mode.score);
        score(0).saturating_sub(score(1))
    }
}

/// Sorts [refined](super::refine()) modes and keeps the best that lie apart. The same pose on two layers of one floor
/// counts once, by its better layer; modes of sheets that do not exist do not count.
#[must_use]
pub fn answer(sheets: &[Sheet<'_>], modes: &mut [Mode]) -> Answer {
    let floor = |mode: &Mode| sheets.get(usize::from(mode.sheet)).map(|sheet| sheet.floor);
    order::sort_by_key(modes, Mode::order);
    let mut kept: heapless::Vec<Mode, MAX_ALTERNATIVES> = heapless::Vec::new();
    for mode in modes.iter().filter(|mode| floor(mode).is_some() && mode.score > i32::MIN) {
        let is_near = |other: &Mode| floor(other) == floor(mode) && mode.is_near(other, APART, APART_TURN);
        if !kept.iter().any(is_near) && kept.push(*mode).is_err() {
            break;
        }
    }
    Answer { modes: kept }
}
