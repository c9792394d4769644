//! The approximate search: sketches rank the candidates, the best are scored exactly.

use super::answer::{Answer, Match, Pool};
use crate::base::circle::Circle;
use crate::base::num::{BINS, Score};
use crate::base::scan::Scan;
use crate::descriptor::Descriptor;
use crate::descriptor::signature::Signature;
use crate::descriptor::similarity::{Candidate, Peak, Query};
use crate::descriptor::sketch::{Sketch, SketchQuery};
use crate::descriptor::spectrum::Correlator;
use crate::map::site_map::{Record, SiteMap};

/// Largest number of headings per candidate in the pool.
const PEAKS: usize = 4;

/// Workspace of [`shortlist`]: about 50 KiB, suited for a static.
#[derive(Debug)]
pub struct Board {
    correlator: Correlator,
    candidate: Candidate,
    scan: Scan,
    descriptor: Descriptor,
    scores: [Score; BINS],
}

impl Board {
    /// An empty workspace.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            correlator: Correlator::new(),
            candidate: Candidate::ZERO,
            scan: Scan::BLANK,
            descriptor: Descriptor::ZERO,
            scores: [Score::ZERO; BINS],
        }
    }

    /// The scores of a candidate at 360 heading shifts. The query must have been [loaded](Board::load). For an index that
    /// does not exist, the former scores remain.
    ///
    /// # Accuracy
    /// [`SCORE_ERROR`](crate::descriptor::similarity::SCORE_ERROR); exact for a masked query.
    pub fn scores(&mut self, query: &Query, map: &SiteMap<'_>, index: usize) -> &[Score; BINS] {
        if let Some(record) = map.get(index) {
            record.scan(&mut self.scan);
            self.descriptor.fill(&self.scan);
            self.candidate.fill(&self.descriptor);
            query.scores(&self.candidate, &mut self.correlator, &mut self.scores);
        }
        &self.scores
    }

    /// Loads the spectra of a query.
    pub fn load(&mut self, query: &Query) {
        query.load(&mut self.correlator);
    }

    /// Inserts the highest local maxima of a candidate, scored exactly, into the pool.
    #[expect(clippy::cast_possible_truncation, reason = "indices of candidates have 32 bits")]
    fn insert_peaks(&mut self, query: &Query, map: &SiteMap<'_>, index: usize, pool: &mut Pool<'_>) {
        let _ = self.scores(query, map, index);
        for shift in local_peaks(&self.scores) {
            let score_bits = query.score(&self.candidate, usize::from(shift)).to_bits();
            pool.insert_if_better(Match { candidate: index as u32, peak: Peak { shift, score_bits } });
        }
    }
}

impl Default for Board {
    fn default() -> Self {
        Self::new()
    }
}

/// The highest local maxima around the circle, at most [`PEAKS`], in no order.
#[expect(clippy::cast_possible_truncation, reason = "shifts are below 360")]
pub(super) fn local_peaks(scores: &[Score; BINS]) -> impl Iterator<Item = u16> {
    let scores = Circle::of(scores);
    let mut best = [(Score::MIN, 0_u16); PEAKS];
    for shift in 0..BINS {
        let here = scores.get(shift);
        if here < scores.get(shift + 1) || here <= scores.get(shift + BINS - 1) {
            continue;
        }
        if let Some(worst) = best.iter_mut().min_by_key(|b| b.0)
            && here > worst.0
        {
            *worst = (here, shift as u16);
        }
    }
    // Constant scores have no local maximum.
    if best.iter().all(|b| b.0 == Score::MIN) {
        best[0] = (scores.get(0), 0);
    }
    best.into_iter().filter(|b| b.0 > Score::MIN).map(|b| b.1)
}

/// Ranks all candidates by their sketches and scores the best `ranked.len()` exactly.
///
/// `ranked` is the shortlist (48 entries suffice), `pool` the matches from which alternatives are selected (four per entry
/// of the shortlist). With `signature`, candidates whose signature is farther from it than the given distance are rejected:
/// see [`nearest_signatures`](super::nearest_signatures()).
///
/// # Accuracy
/// Scores of the result are exact ([`Query::score`]). A match is missed if its sketch ranks below the shortlist;
/// [`Answer::exhaustive`] is true only if the shortlist holds all candidates.
///
/// # Cost
/// One [`SketchQuery::rank`] per candidate, and `ranked.len()` candidates scored at all headings. Cortex-M7: `localize` in
/// `targets/budget.txt`.
///
/// ```
/// # use compass_core::Site;
/// # let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/sample.site"))?;
/// # let site = Site::new(&bytes)?;
/// # let floor = site.floor(0).unwrap();
/// # use compass_core::descriptor::Descriptor;
/// # use compass_core::descriptor::signature::Signature;
/// # use compass_core::descriptor::similarity::{Confidence, Query, Similarity, Weights};
/// # use compass_core::Scan;
/// # let map = floor.map();
/// # let mut scan = Scan::OPEN;
/// # map.get(7).unwrap().scan(&mut scan);
/// # let mut query = Query::EMPTY;
/// # query.set(&Descriptor::from(&scan), &Confidence::CERTAIN, Weights::EQUAL, Similarity::Centred);
/// use compass_core::descriptor::matching::{Board, Match, shortlist};
///
/// // `query` is the scan of candidate 7.
/// let (mut board, mut ranked, mut pool) = (Box::new(Board::new()), [(0, 0); 16], [Match::NONE; 64]);
/// let answer = shortlist(map, &query, None, &mut board, &mut ranked, &mut pool);
/// assert_eq!(answer.best().map(|best| (best.candidate, best.peak.shift)), Some((7, 0)));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[expect(clippy::cast_possible_truncation, reason = "the number of candidates of a map has 32 bits")]
pub fn shortlist(
    map: &SiteMap<'_>,
    query: &Query,
    signature: Option<(&Signature, u16)>,
    board: &mut Board,
    ranked: &mut [(i32, u32)],
    pool: &mut [Match],
) -> Answer {
    let sketch = SketchQuery::new(query);
    let near = |record: &Record<'_>| {
        signature.is_none_or(|(s, limit)| Signature::stored(&record.plan_layer()).distance(s) <= limit)
    };
    let candidates = (0..).zip(map.iter()).filter(|(_, record)| near(record));
    let used = top_candidates(
        ranked,
        candidates.map(|(index, record)| (sketch.rank(&Sketch::stored(&record.plan_layer())), index)),
    );
    board.load(query);
    let mut pool = Pool::new(pool);
    for &(_, index) in ranked.iter().take(used) {
        board.insert_peaks(query, map, index as usize, &mut pool);
    }
    pool.select(map, used as u32, used == map.len())
}

/// Collects the candidates of highest rank, best first; returns their number.
pub(super) fn top_candidates(
    ranked: &mut [(i32, u32)],
    candidates: impl Iterator<Item = (i32, u32)>,
) -> usize {
    candidates.fold(0, |used, entry| insert(ranked, used, entry))
}

/// Keeps `ranked[..used]` sorted, best first; of equal ranks the earlier candidate stays ahead.
fn insert(ranked: &mut [(i32, u32)], used: usize, entry: (i32, u32)) -> usize {
    let place = ranked.get(..used).unwrap_or_default().partition_point(|kept| kept.0 >= entry.0);
    if place >= ranked.len() {
        return used;
    }
    let used = (used + 1).min(ranked.len());
    if let Some(tail) = ranked.get_mut(place..used) {
        tail.iter_mut().fold(entry, |moved, slot| core::mem::replace(slot, moved));
    }
    used
}
