//! A site map with its index, ready to answer.

use anyhow::{Result, anyhow};
use compass_core::descriptor::Descriptor;
use compass_core::matching::{Answer, Exact, Group, Index, Match, exhaustive, nearest_signatures};
use compass_core::scan::Scan;
use compass_core::signature::Signature;
use compass_core::similarity::{Confidence, Query, Similarity, Weights};
use compass_core::site_map::SiteMap;
use rayon::prelude::*;

/// Matches that the search may choose its alternatives from.
const POOL: usize = 512;

/// How to match.
#[derive(Debug, Clone, Copy, Default)]
pub struct MatchOptions {
    /// Plain or centred cosine.
    pub similarity: Similarity,
    /// Channel weights.
    pub weights: Weights,
    /// Keep about this many candidates of the nearest transition signatures.
    pub prefilter: Option<u32>,
}

/// A site map and what the exact search needs beside it.
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

    /// Finds the candidates and headings that fit a scan best.
    ///
    /// # Errors
    /// Never for a localizer made by [`Localizer::new`].
    pub fn locate(&mut self, scan: &Scan, options: &MatchOptions) -> Result<Answer> {
        let descriptor = Descriptor::from(scan);
        self.query.set(&descriptor, &Confidence::CERTAIN, options.weights, options.similarity);
        let signature = options.prefilter.map(|keep| {
            let signature = Signature::new(scan);
            (signature, nearest_signatures(&self.map, &signature, keep as usize))
        });
        let index = Index::new(&self.groups, &self.map).ok_or_else(|| anyhow!("index of another map"))?;
        exhaustive(
            &index,
            &self.map,
            &self.query,
            signature.as_ref().map(|(s, limit)| (s, *limit)),
            &mut self.work,
            &mut self.bounds,
            &mut self.pool,
        )
        .ok_or_else(|| anyhow!("index of another map"))
    }
}
