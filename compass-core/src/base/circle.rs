//! Values of all directions, and arithmetic of bins around the circle.

use super::num::BINS;
use bytemuck::TransparentWrapper;

/// One value per bin of 1 degree, counter-clockwise; bin 360 is bin 0 again.
///
/// A bin is any `usize`, so that no caller takes a remainder: bins before bin 0 are written as `bin + BINS - offset`.
/// Loops over all bins in their order use the [array](Self::bins).
#[derive(Debug, Clone, Copy, PartialEq, Eq, TransparentWrapper)]
#[repr(transparent)]
pub struct Circle<T>([T; BINS]);

impl<T> Circle<T> {
    /// From the values of bins 0 to 359.
    #[must_use]
    pub const fn new(bins: [T; BINS]) -> Self {
        Self(bins)
    }

    /// An array seen as a circle.
    #[must_use]
    #[inline]
    pub fn of(bins: &[T; BINS]) -> &Self {
        Self::wrap_ref(bins)
    }

    /// From a function of the bin.
    #[must_use]
    #[inline]
    pub fn from_fn(value: impl FnMut(usize) -> T) -> Self {
        Self(core::array::from_fn(value))
    }

    /// The values of bins 0 to 359.
    #[must_use]
    pub const fn bins(&self) -> &[T; BINS] {
        &self.0
    }
}

impl<T: Copy> Circle<T> {
    /// The value of a bin.
    #[must_use]
    #[inline]
    pub const fn get(&self, bin: usize) -> T {
        self.0[bin % BINS]
    }
}

/// The bins before and after a bin, each below 360.
#[must_use]
#[inline]
pub const fn beside(bin: usize) -> [usize; 2] {
    [(bin + BINS - 1) % BINS, (bin + 1) % BINS]
}

/// The bins from one bin to another the shorter way round, at most 180.
#[must_use]
#[inline]
pub const fn distance(a: usize, b: usize) -> usize {
    let bins = a.abs_diff(b) % BINS;
    if bins < BINS - bins { bins } else { BINS - bins }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bins_wrap(bin in 0_usize..3 * BINS) {
            let circle = Circle::from_fn(|bin| bin);
            prop_assert_eq!(circle.get(bin), bin % BINS);
            prop_assert_eq!(beside(bin).map(|bin| circle.get(bin)), [(bin + 359) % 360, (bin + 1) % 360]);
        }

        #[test]
        fn distances_go_the_shorter_way(a in 0_usize..BINS, b in 0_usize..BINS) {
            let around = distance(a, b);
            prop_assert!(around <= 180 && ((a + around) % BINS == b || (b + around) % BINS == a));
            prop_assert_eq!(around, distance(b + BINS, a));
        }
    }
}
