//! Leaving out candidates whose transition signature is far from the query's.

use crate::signature::Signature;
use crate::site_map::SiteMap;

/// Largest distance of two signatures.
const FARTHEST: usize = 16 * 255;

/// The signature distance that keeps the `keep` nearest candidates (more when several are equally
/// far); candidates above it may be left out. One pass over the map and one over 4081 counters.
///
/// Reads 16 bytes a candidate. Returns the largest possible distance when `keep` covers the map.
#[must_use]
pub fn nearest_signatures(map: &SiteMap<'_>, query: &Signature, keep: usize) -> u16 {
    let mut counts = [0_u32; FARTHEST + 1];
    for record in map.iter() {
        let distance = usize::from(record.signature().distance(query));
        if let Some(count) = counts.get_mut(distance) {
            *count += 1;
        }
    }
    let mut kept = 0_usize;
    for (distance, count) in counts.iter().enumerate() {
        kept += *count as usize;
        if kept >= keep.max(1) {
            return distance as u16;
        }
    }
    FARTHEST as u16
}
