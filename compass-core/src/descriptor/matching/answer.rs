//! Selection of the best matches that are separated: non-maximum suppression.

use crate::base::circle;
use crate::base::num::{Point, Score, Turn};
use crate::base::order;
pub use crate::base::pose::MAX_ALTERNATIVES;
use crate::base::pose::Separation;
use crate::descriptor::similarity::Peak;
use crate::map::site_map::SiteMap;

/// Separation of alternatives.
const APART: Separation = Separation::ALTERNATIVES;

/// A candidate at a heading, with its score.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Match {
    /// Index of the candidate in the site map.
    pub candidate: u32,
    /// Heading shift and score.
    pub peak: Peak,
}

impl Match {
    /// A place-holder below every score.
    pub const NONE: Self = Self { candidate: u32::MAX, peak: Peak { shift: 0, score_bits: i32::MIN } };

    /// Heading of the query on the floor, counter-clockwise from +x.
    #[must_use]
    pub const fn heading(&self) -> Turn {
        Turn::from_bin(self.peak.shift as usize)
    }

    /// Higher score first; of equal ones the smaller candidate, then the smaller shift.
    fn order(&self) -> (core::cmp::Reverse<i32>, u32, u16) {
        (core::cmp::Reverse(self.peak.score_bits), self.candidate, self.peak.shift)
    }

    fn is_apart(&self, other: &Self, at: impl Fn(u32) -> Point) -> bool {
        let turn = circle::distance(self.peak.shift.into(), other.peak.shift.into());
        turn >= APART.turn.to_bin() || !at(self.candidate).within(at(other.candidate), APART.distance)
    }
}

/// The result of a search.
#[derive(Debug, Clone)]
pub struct Answer {
    matches: heapless::Vec<Match, MAX_ALTERNATIVES>,
    /// Number of candidates that were scored exactly at one shift or more.
    pub scored: u32,
    /// Whether no rejected candidate can have a better score than the best match.
    pub exhaustive: bool,
}

impl Answer {
    /// Sorts the pool and keeps the best matches that are separated.
    pub(super) fn select(pool: &mut [Match], map: &SiteMap<'_>, scored: u32, exhaustive: bool) -> Self {
        let at = |candidate: u32| map.position(candidate as usize).unwrap_or_default();
        order::sort_by_key(pool, Match::order);
        let mut matches: heapless::Vec<Match, MAX_ALTERNATIVES> = heapless::Vec::new();
        for found in pool.iter().filter(|m| m.candidate != u32::MAX) {
            if matches.iter().all(|kept| found.is_apart(kept, at)) && matches.push(*found).is_err() {
                break;
            }
        }
        Self { matches, scored, exhaustive }
    }

    /// The best match and its alternatives, by descending score; any two at least 1 m or 20 degrees apart.
    #[must_use]
    pub fn matches(&self) -> &[Match] {
        &self.matches
    }

    /// The best match.
    #[must_use]
    pub fn best(&self) -> Option<&Match> {
        self.matches.first()
    }

    /// Difference of the best and the second best score; the best score itself without a second match.
    #[must_use]
    pub fn margin(&self) -> Score {
        let score = |at: usize| self.matches.get(at).map_or(Score::ZERO, |m| m.peak.score());
        score(0).saturating_sub(score(1))
    }
}

/// A pool of matches in a lent slice; when full it keeps the best.
pub(super) struct Pool<'a> {
    slots: &'a mut [Match],
    used: usize,
}

impl<'a> Pool<'a> {
    pub(super) const fn new(slots: &'a mut [Match]) -> Self {
        Self { slots, used: 0 }
    }

    pub(super) fn insert_if_better(&mut self, found: Match) {
        if let Some(slot) = self.slots.get_mut(self.used) {
            *slot = found;
            self.used += 1;
        } else if let Some(worst) = self.slots.iter_mut().max_by_key(|m| m.order())
            && found.order() < worst.order()
        {
            *worst = found;
        }
    }

    /// Selects the matches that are separated.
    pub(super) fn select(&mut self, map: &SiteMap<'_>, scored: u32, exhaustive: bool) -> Answer {
        Answer::select(self.slots.get_mut(..self.used).unwrap_or_default(), map, scored, exhaustive)
    }
}
