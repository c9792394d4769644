//! Site maps with the index for the paper's matching.

use compass_core::base::confidence::Confidence;
use compass_core::base::num::Score;
use compass_core::base::scan::Scan;
use compass_core::descriptor::Descriptor;
use compass_core::descriptor::matching::{
    Answer, Exact, Group, Index, MAX_ALTERNATIVES, Match, exhaustive, nearest_signatures,
};
use compass_core::descriptor::signature::Signature;
use compass_core::descriptor::similarity::{Query, Similarity, Weights};
use compass_core::map::site_map::SiteMap;
use rayon::prelude::*;
use std::cmp::Reverse;

/// Matches kept by the search, from which the alternatives are selected.
const POOL: usize = 512;

/// Options of the matching.
#[derive(Debug, Clone, Copy, Default)]
pub struct MatchOptions {
    /// Plain or centred cosine.
    pub similarity: Similarity,
    /// Channel weights.
    pub weights: Weights,
    /// Keep about this many candidates of a map: those with the nearest transition signatures.
    pub prefilter: Option<u32>,
}

/// A site map with the index of the exact search.
pub struct Localizer<'a> {
    map: SiteMap<'a>,
    groups: Vec<Group>,
    query: Box<Query>,
    work: Box<Exact>,
    bounds: Vec<i32>,
    pool: Vec<Match>,
}

impl std::fmt::Debug for Localizer<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Localizer").field("map", self.map.header()).finish_non_exhaustive()
    }
}

impl<'a> Localizer<'a> {
    /// Indexes a map on all cores.
    #[must_use]
    pub fn new(map: SiteMap<'a>) -> Self {
        let mut groups = vec![Group::EMPTY; Index::groups(&map)];
        groups.par_iter_mut().enumerate().for_each(|(number, group)| group.fill(&map, number));
        Self {
            map,
            groups,
            query: Box::new(Query::EMPTY),
            work: Box::default(),
            bounds: vec![0; map.len()],
            pool: vec![Match::NONE; POOL],
        }
    }

    /// The map.
    #[must_use]
    pub const fn map(&self) -> &SiteMap<'a> {
        &self.map
    }

    /// Finds the candidates and headings that match a scan best.
    ///
    /// # Panics
    /// Never: the index is that of the map.
    pub fn locate(&mut self, scan: &Scan, options: &MatchOptions) -> Answer {
        self.locate_masked(scan, &Confidence::CERTAIN, options)
    }

    /// [`Localizer::locate`] for a scan with a confidence per bin.
    ///
    /// # Panics
    /// As [`Localizer::locate`].
    pub fn locate_masked(&mut self, scan: &Scan, confidence: &Confidence, options: &MatchOptions) -> Answer {
        let descriptor = Descriptor::from(scan);
        self.query.set(&descriptor, confidence, options.weights, options.similarity);
        let signature = options.prefilter.map(|keep| {
            let signature = Signature::new(scan);
            (signature, nearest_signatures(&self.map, &signature, keep as usize))
        });
        let index = Index::new(&self.groups, &self.map).expect("the groups are of this map");
        exhaustive(
            &index,
            &self.map,
            &self.query,
            signature.as_ref().map(|(s, limit)| (s, *limit)),
            &mut self.work,
            &mut self.bounds,
            &mut self.pool,
        )
        .expect("the index is of this map")
    }
}

/// The maps of all floors of a site.
#[derive(Debug)]
pub struct SiteLocalizer<'a> {
    floors: Vec<Localizer<'a>>,
}

/// The result of a search over all floors.
#[derive(Debug, Clone)]
pub struct SiteAnswer {
    /// Index of the floor and match on it, best first; on one floor at least 1 m or 20 degrees apart. Of equal scores
    /// the lower index comes first. At most [`MAX_ALTERNATIVES`].
    pub matches: Vec<(usize, Match)>,
    /// Candidates whose score was computed exactly at one shift or more.
    pub scored: u32,
    /// Whether no pruned candidate can have a higher score.
    pub exhaustive: bool,
}

impl<'a> SiteLocalizer<'a> {
    /// Indexes the map of each floor on all cores.
    #[must_use]
    pub fn new(maps: impl IntoIterator<Item = SiteMap<'a>>) -> Self {
        Self { floors: maps.into_iter().map(Localizer::new).collect() }
    }

    /// Finds the floors, candidates and headings that match a scan best.
    ///
    /// # Panics
    /// As [`Localizer::locate`].
    pub fn locate(&mut self, scan: &Scan, options: &MatchOptions) -> SiteAnswer {
        let mut all = SiteAnswer { matches: Vec::new(), scored: 0, exhaustive: true };
        for (number, floor) in self.floors.iter_mut().enumerate() {
            let answer = floor.locate(scan, options);
            all.matches.extend(answer.matches().iter().map(|&found| (number, found)));
            all.scored += answer.scored;
            all.exhaustive &= answer.exhaustive;
        }
        all.matches.sort_by_key(|(_, found)| Reverse(found.peak.score_bits));
        all.matches.truncate(MAX_ALTERNATIVES);
        all
    }
}

impl SiteAnswer {
    /// By how much the best score exceeds the best one elsewhere, another floor included; the best score itself
    /// without another one.
    #[must_use]
    pub fn margin(&self) -> Score {
        let score = |at: usize| self.matches.get(at).map_or(Score::ZERO, |(_, found)| found.peak.score());
        score(0).saturating_sub(score(1))
    }
}
