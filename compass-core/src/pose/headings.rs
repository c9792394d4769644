//! The number of headings of the search, chosen at run time.

use super::rows::Rows;
use super::search::{FloorLayer, PoolEntry, Query, search};
use core::fmt;

/// Searches all candidates of all layers; returns the number of poses at the front of the pool.
type Search = fn(&Query<'_>, &mut [u32], &[FloorLayer<'_>], &mut [PoolEntry]) -> usize;

/// Number of headings at which the search scores each candidate.
///
/// [`search`] is generic over that number; this type selects an instance at run time. A program contains the instances
/// of the constants that it names, and no others.
#[derive(Clone, Copy)]
pub struct Headings {
    count: u16,
    words: usize,
    search: Search,
}

impl Headings {
    /// Every 9 degrees.
    pub const N40: Self = Self::of::<40>();
    /// Every 4 degrees.
    pub const N90: Self = Self::of::<90>();
    /// Every 2 degrees.
    pub const N180: Self = Self::of::<180>();
    /// Every degree.
    pub const N360: Self = Self::of::<360>();

    #[expect(clippy::cast_possible_truncation, reason = "at most 360")]
    const fn of<const N: usize>() -> Self {
        Self { count: N as u16, words: size_of::<Rows<N>>().div_ceil(size_of::<u32>()), search: run::<N> }
    }

    /// Number of headings.
    #[must_use]
    pub const fn count(&self) -> u16 {
        self.count
    }

    /// Words of 32 bits that [`Headings::search`] needs.
    #[must_use]
    pub const fn words(&self) -> usize {
        self.words
    }

    /// Searches all candidates of all layers at these headings: see [`search`].
    ///
    /// Returns the number of poses at the front of `pool`, by descending score; 0 if `words` is shorter than
    /// [`Headings::words`].
    #[must_use]
    pub fn search(
        &self,
        query: &Query<'_>,
        words: &mut [u32],
        layers: &[FloorLayer<'_>],
        pool: &mut [PoolEntry],
    ) -> usize {
        (self.search)(query, words, layers, pool)
    }
}

fn run<const N: usize>(
    query: &Query<'_>,
    words: &mut [u32],
    layers: &[FloorLayer<'_>],
    pool: &mut [PoolEntry],
) -> usize {
    let bytes: &mut [u8] = bytemuck::must_cast_slice_mut(words);
    let bytes = bytes.get_mut(..size_of::<Rows<N>>()).unwrap_or_default();
    let Ok(rows) = bytemuck::try_from_bytes_mut::<Rows<N>>(bytes) else { return 0 };
    let spacing_mm = layers.iter().map(|layer| layer.map.header().spacing_mm).max().unwrap_or(0);
    rows.set(&query.boundaries, query.hits, spacing_mm as f32 / 1000.0);
    search(rows, query.heights, layers, query.within, pool)
}

impl PartialEq for Headings {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count
    }
}

impl Eq for Headings {}

impl fmt::Debug for Headings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Headings({})", self.count)
    }
}
