//! Leaving out candidates whose transition signature is far from the query's.

use crate::descriptor::signature::Signature;
use crate::map::site_map::SiteMap;

/// Distances are counted in steps of this.
const STEP: usize = 16;
/// Steps up to the largest distance of two signatures, 16 x 255.
const STEPS: usize = 16 * 255 / STEP + 1;

/// The signature distance that keeps the `keep` nearest candidates; candidates above it may be left
/// out. It is a multiple of 16 less one, so some more may be kept. One pass over the map, 16 bytes a candidate.
#[must_use]
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
