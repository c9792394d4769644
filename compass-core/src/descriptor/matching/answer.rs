//! The best matches that lie apart.

use crate::base::circle;
use crate::base::num::{Point, Score, Turn};
use crate::base::order;
pub use crate::base::pose::MAX_ALTERNATIVES;
use crate::base::pose::Separation;
use crate::descriptor::similarity::Peak;
use crate::map::site_map::SiteMap;

/// How far alternatives are apart at least.
const APART: Separation = Separation::ALTERNATIVES;

/// One candidate at one heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Match {
    /// Number of the candidate in its map.
    pub candidate: u32,
    /// Heading shift and score.
    pub peak: Peak,
}

impl Match {
    /// A place-holder below every score.
    pub const NONE: Self = Self { candidate: u32::MAX, peak: Peak { shift: 0, score_bits: i32::MIN } };

    /// The heading of the query on the map.
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

/// What a search found.
#[derive(Debug, Clone)]
pub struct Answer {
    matches: heapless::Vec<Match, MAX_ALTERNATIVES>,
    /// Candidates that were scored exactly, at one shift or more.
    pub scored: u32,
    /// Whether nothing that was left out could have won.
    pub exhaustive: bool,
}

impl Answer {
    /// Sorts the pool and keeps the best matches that lie apart.
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

    /// The best match and its alternatives, best first, at least 1 m or 20 degrees apart.
    #[must_use]
    pub fn matches(&self) -> &[Match] {
        &self.matches
    }

    /// The best match.
    #[must_use]
    pub fn best(&self) -> Option<&Match> {
        self.matches.first()
    }

    /// By how much the best score exceeds the best one elsewhere; the best score itself when there is
    /// no other.
    #[must_use]
    pub fn margin(&self) -> Score {
        let score = |at: usize| self.matches.get(at).map_or(Score::ZERO, |m| m.peak.score());
        score(0).saturating_sub(score(1))
    }
}

/// A bounded pool of matches that keeps the best when it is full.
pub(super) struct Pool<'a> {
    slots: &'a mut [Match],
    used: usize,
}

impl<'a> Pool<'a> {
    pub(super) const fn new(slots: &'a mut [Match]) -> Self {
        Self { slots, used: 0 }
    }

    pub(super) fn offer(&mut self, found: Match) {
        if let Some(slot) = self.slots.get_mut(self.used) {
            *slot = found;
            self.used += 1;
        } else if let Some(worst) = self.slots.iter_mut().max_by_key(|m| m.order())
            && found.order() < worst.order()
        {
            *worst = found;
        }
    }

    /// Replaces the pool's matches by those that lie apart and returns the answer so far.
    pub(super) fn select(&mut self, map: &SiteMap<'_>, scored: u32, exhaustive: bool) -> Answer {
        Answer::select(self.slots.get_mut(..self.used).unwrap_or_default(), map, scored, exhaustive)
    }
}
