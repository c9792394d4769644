//! Rejection of candidates by the distance of their transition signature.

use crate::descriptor::signature::Signature;
use crate::map::site_map::SiteMap;

/// Bin width of the histogram of distances.
const STEP: usize = 16;
/// Number of bins, up to the largest distance of two signatures: 16 x 255.
const STEPS: usize = 16 * 255 / STEP + 1;

/// The largest signature distance of the `keep` candidates nearest to the query, for [`shortlist`](super::shortlist()) and
/// [`exhaustive`](super::exhaustive()).
///
/// # Formats
/// Rounded up to a multiple of 16 less one, so that more than `keep` candidates can lie within it. `keep` of 0 counts as 1.
///
/// # Cost
/// One pass over the map, reading 16 bytes per candidate.
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
/// use compass_core::descriptor::matching::nearest_signatures;
///
/// // The scan of candidate 7 has its signature: distance 0.
/// let signature = Signature::new(&scan);
/// assert_eq!(nearest_signatures(map, &signature, 1), 15);
/// assert!(nearest_signatures(map, &signature, map.len()) > 15);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "at most 16 * 257 - 1")]
pub fn nearest_signatures(map: &SiteMap<'_>, query: &Signature, keep: usize) -> u16 {
    let mut counts = [0_u32; STEPS];
    for record in map.iter() {
        let step = usize::from(Signature::stored(&record.plan_layer()).distance(query)) / STEP;
        if let Some(count) = counts.get_mut(step) {
            *count += 1;
        }
    }
    let mut kept = 0_usize;
    let enough = |count: &u32| {
        kept += *count as usize;
        kept >= keep.max(1)
    };
    let step = counts.iter().position(enough).unwrap_or(STEPS);
    ((step + 1) * STEP - 1) as u16
}
